//! Numbers that differ from crane to crane, exchanged in the laws of a register when its lanes get other cranes.

use hydrocrane_num::lanes::register::Register;
use hydrocrane_num::{Field, Lanes};
use hydrocrane_plant::equations::plant::Plant;
use hydrocrane_plant::equations::rhs::Evaluator;
use hydrocrane_plant::layout::Layout;
use hydrocrane_plant::precision::Precision;
use std::ptr::from_ref;

/// Number of cranes of a group, that of the lanes of the widest register; of a group of lanes a narrower register has the first.
pub const WIDTH: usize = 8;
/// One number per crane.
pub type Group = [f64; WIDTH];

/// All that a step in one register reads, with the numbers of the crane of each lane.
pub struct Bank<R, const N: usize> {
    pub evaluator: Evaluator<Lanes<R>, Lanes<R>, N>,
    pub precision: Precision<Lanes<R>>,
}

/// Number of blocks of memory of a bank: the evaluator, its groups of cylinders, the weights.
const BLOCKS: usize = 3;

/// Where a copy of an own number stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    /// Index among the own numbers.
    number: u32,
    /// Bytes from the start of its block.
    offset: u32,
}

/// The places of the own numbers in a bank, in the order of the numbers, so that these are read as they lie in memory.
pub struct Places {
    /// Of so many own numbers.
    count: usize,
    /// Of those that the tip depends on, of all others; block by block.
    parts: [[Vec<Place>; BLOCKS]; 2],
}

/// What of a bank is needed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Needed {
    /// For the place of the tip.
    Tip,
    All,
}

impl<R: Register, const N: usize> Bank<R, N> {
    /// With the same numbers in all lanes.
    pub fn new(plant: &Plant<f64, N>, layout: &Layout, precision: &Precision) -> Self {
        let plant = plant.map(&mut |number| Lanes::c(*number));
        Bank { evaluator: Evaluator::new(&plant, layout), precision: precision.lift() }
    }

    /// Puts what is `needed` of the `own` numbers of `count` cranes, which stand from `first` on in their group, in the lanes from `lane` on.
    #[inline(always)]
    pub fn put(&mut self, places: &Places, needed: Needed, own: &[Group], first: usize, [lane, count]: [usize; 2]) {
        assert!(own.len() == places.count, "as many own numbers as there are places for");
        assert!(lane + count <= R::WIDTH && first + count <= WIDTH, "lanes of a register, cranes of a group");
        let Bank { evaluator, precision } = self;
        let (groups, weights) = (evaluator.groups.as_mut_ptr(), precision.weights.as_mut_ptr());
        let blocks: [*mut u8; BLOCKS] = [(&raw mut *evaluator).cast(), groups.cast(), weights.cast()];
        let own = own.as_flattened().as_ptr();
        for part in &places.parts[..if needed == Needed::All { 2 } else { 1 }] {
            for (block, places) in blocks.into_iter().zip(part) {
                for Place { number, offset } in places {
                    // SAFETY: `Places::new` found a number of type `Lanes<R>`, which is `R::WIDTH` times an `f64`, so many bytes from the
                    // start of this block of this bank, whose parts and variants never change, and `self` is borrowed alone. `own` has
                    // `places.count` groups of `WIDTH` numbers, and every `number` is less than that.
                    unsafe {
                        let from = own.add(*number as usize * WIDTH + first);
                        from.copy_to_nonoverlapping(block.add(*offset as usize).cast::<f64>().add(lane), count);
                    }
                }
            }
        }
    }

    /// Block and offset of one of its numbers.
    fn place(&self, number: &Lanes<R>) -> (usize, usize) {
        let Bank { evaluator, precision } = self;
        let groups = (evaluator.groups.as_ptr() as usize, size_of_val(&evaluator.groups[..]));
        let weights = (precision.weights.as_ptr() as usize, size_of_val(&precision.weights[..]));
        let blocks = [(from_ref(evaluator) as usize, size_of_val(evaluator)), groups, weights];
        let offsets =
            blocks.map(|(start, size)| (from_ref(number) as usize).checked_sub(start).filter(|at| *at < size));
        let block = offsets.iter().position(Option::is_some).expect("a number of the bank");
        (block, offsets[block].unwrap_or_default())
    }

    /// Every number, with the weights of the precision after those of the laws, in the order of those of [`indices`].
    fn each<'a>(&'a self, layout: &Layout, f: &mut dyn FnMut(&'a Lanes<R>)) {
        self.evaluator.each(layout, f);
        self.precision.weights.iter().for_each(f);
    }
}

impl Places {
    /// Those of the `own` numbers, counted as in [`InLanes`](crate::InLanes), which are in ascending order.
    pub fn new<R: Register, const N: usize>(
        plant: &Plant<f64, N>,
        layout: &Layout,
        bank: &Bank<R, N>,
        own: &[usize],
    ) -> Self {
        let mut indices = indices(plant, layout).into_iter();
        let mut parts = <[[Vec<Place>; BLOCKS]; 2]>::default();
        let at_tip: Vec<bool> = own.iter().map(|index| moves_tip(plant, *index)).collect();
        bank.each(layout, &mut |copy| {
            let index = indices.next().expect("as many indices as numbers");
            if let Ok(number) = own.binary_search(&index) {
                let (block, offset) = bank.place(copy);
                let place = [number, offset].map(|n| u32::try_from(n).expect("a bank of some kilobytes"));
                parts[usize::from(!at_tip[number])][block].push(Place { number: place[0], offset: place[1] });
            }
        });
        parts.iter_mut().flatten().for_each(|places| places.sort_unstable());
        Places { count: own.len(), parts }
    }
}

/// Whether the place of the tip depends on the number `index` of a plant: without it there is none. A weight is none of its numbers.
fn moves_tip<const N: usize>(plant: &Plant<f64, N>, index: usize) -> bool {
    let mut at = 0;
    let without = plant.map(&mut |_| {
        at += 1;
        if at - 1 == index {
            f64::NAN
        } else {
            1.0
        }
    });
    let tip = without.tip_position(&without.mechanics.pose(&[1.0; N]));
    [tip.x, tip.y, tip.z].iter().any(|r| r.is_nan())
}

/// Which number of a plant, or which weight after these, each number of a bank is a copy of.
fn indices<const N: usize>(plant: &Plant<f64, N>, layout: &Layout) -> Vec<usize> {
    // Those in an evaluator of indices in place of numbers.
    let mut count = 0;
    let numbered = plant.map(&mut |_| {
        count += 1;
        (count - 1) as f64
    });
    let mut indices = Vec::new();
    Evaluator::<f64, f64, N>::new(&numbered, layout).each(layout, &mut |index| indices.push(*index as usize));
    indices.extend(count..count + layout.len());
    indices
}
