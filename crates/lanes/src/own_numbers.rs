//! Numbers that differ from crane to crane, exchanged in the laws of a register when its lanes get other cranes.

use hydrocrane_num::register::{Register, WIDEST};
use hydrocrane_num::{Field, Lanes};
use hydrocrane_plant::layout::Layout;
use hydrocrane_plant::plant::Plant;
use hydrocrane_plant::precision::Precision;
use hydrocrane_plant::rhs::Evaluator;
use std::ops::Range;
use std::ptr::from_ref;

/// All that a step in one register reads, with the numbers of the crane of each lane.
pub struct Bank<R, const N: usize> {
    pub evaluator: Evaluator<Lanes<R>, Lanes<R>, N>,
    pub precision: Precision<Lanes<R>>,
}

/// Where a copy of an own number stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// Index of the block of memory in a bank: the evaluator, its groups of cylinders, the weights.
    block: usize,
    /// Bytes from its start.
    offset: usize,
    /// Index among the own numbers.
    number: usize,
}

/// The places of the own numbers in a bank.
pub struct Places {
    /// In the mechanics; in all else.
    pub parts: [Vec<Place>; 2],
    /// So many of the numbers, the first ones, are in the mechanics; of so many.
    counts: [usize; 2],
}

/// What of a bank is needed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Needed {
    Mechanics,
    All,
}

impl<R: Register, const N: usize> Bank<R, N> {
    /// With the same numbers in all lanes.
    pub fn new(plant: &Plant<f64, N>, layout: &Layout, precision: &Precision) -> Self {
        let plant = plant.map(&mut |number| Lanes::c(*number));
        Bank { evaluator: Evaluator::new(&plant, layout), precision: precision.lift() }
    }

    /// Puts the own numbers of the lanes in these places.
    #[inline(always)]
    pub fn put(&mut self, places: &[Place], own: &[[f64; WIDEST]]) {
        let Bank { evaluator, precision } = self;
        let (groups, weights) = (evaluator.groups.as_mut_ptr(), precision.weights.as_mut_ptr());
        let blocks: [*mut u8; 3] = [(&raw mut *evaluator).cast(), groups.cast(), weights.cast()];
        for Place { block, offset, number } in places {
            let value = Lanes::<R>::load(&own[*number]);
            // SAFETY: `Places::new` found a number of this type so many bytes from the start of this block of this bank, whose parts
            // and variants never change, and `self` is borrowed alone.
            unsafe { blocks[*block].add(*offset).cast::<Lanes<R>>().write(value) };
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
        let (mut all, mut mechanics) = (Vec::new(), 0);
        plant.mechanics.map(&mut |_| mechanics += 1);
        bank.each(layout, &mut |copy| {
            let index = indices.next().expect("as many indices as numbers");
            if let Ok(number) = own.binary_search(&index) {
                let (block, offset) = bank.place(copy);
                all.push(Place { block, offset, number });
            }
        });
        // In the order of memory.
        all.sort_unstable();
        let counts = [own.partition_point(|index| *index < mechanics), own.len()];
        let parts: (Vec<Place>, Vec<Place>) = all.into_iter().partition(|place| place.number < counts[0]);
        Places { parts: parts.into(), counts }
    }

    /// Those of the numbers that are needed, in the mechanics and beyond.
    pub fn numbers(&self, needed: Needed) -> [Range<usize>; 2] {
        let [mechanics, all] = self.counts;
        [0..mechanics, mechanics..if needed == Needed::All { all } else { mechanics }]
    }
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
