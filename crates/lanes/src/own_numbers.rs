//! Numbers that differ from crane to crane, exchanged in the laws of a register when its lanes get other cranes.

use crate::kernel::Group;
use hydrocrane_num::register::Register;
use hydrocrane_num::{Field, Lanes};
use hydrocrane_plant::layout::Layout;
use hydrocrane_plant::plant::Plant;
use hydrocrane_plant::precision::Precision;
use hydrocrane_plant::rhs::Evaluator;
use std::ops::Range;
use std::ptr::from_ref;

/// All that a step in one register reads, with the numbers of the crane of each lane.
#[derive(Clone)]
pub struct Bank<R, const N: usize> {
    pub evaluator: Evaluator<Lanes<R>, Lanes<R>, N>,
    pub precision: Precision<Lanes<R>>,
}

/// Where a copy of an own number stands.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    /// Counted among the own numbers.
    number: usize,
    copy: Copied,
}

#[derive(Debug, Clone, Copy)]
enum Copied {
    /// So many bytes from the start of the evaluator.
    Evaluator(usize),
    /// So many bytes from the start of a group of cylinders.
    Group(usize, usize),
    /// Weight of the error of a state.
    Weight(usize),
}

impl<R: Register, const N: usize> Bank<R, N> {
    /// With the same numbers in all lanes.
    pub fn new(plant: &Plant<f64, N>, layout: &Layout, precision: &Precision) -> Self {
        let plant = plant.map(&mut |number| Lanes::c(*number));
        Bank { evaluator: Evaluator::new(&plant, layout), precision: precision.lift() }
    }

    /// Puts the own numbers of the lanes from `first` on in their places.
    #[inline(always)]
    pub fn put(&mut self, places: &[Place], own: &[Group], first: usize) {
        for Place { number, copy } in places {
            let value = Lanes::<R>::load(&own[*number][first..]);
            match *copy {
                Copied::Weight(i) => self.precision.weights[i] = value,
                // SAFETY: `places_of` found a number of this type so many bytes from the start of the same part of a bank of the
                // same plant. Parts and variants of a bank never change, so that it stands there in every one, and `&mut self` lets
                // nobody else read it.
                Copied::Evaluator(offset) => unsafe { (&raw mut self.evaluator).byte_add(offset).cast::<Lanes<R>>().write(value) },
                // SAFETY: likewise.
                Copied::Group(group, offset) => unsafe {
                    (&raw mut self.evaluator.groups[group]).byte_add(offset).cast::<Lanes<R>>().write(value);
                },
            }
        }
    }

    /// Where one of its numbers stands.
    fn place(&self, number: &Lanes<R>) -> Copied {
        let address = from_ref(number) as usize;
        let within = |range: Range<usize>| range.contains(&address).then(|| address - range.start);
        let mut groups = self.evaluator.groups.iter().enumerate();
        match groups.find_map(|(i, group)| Some((i, within(bytes(group))?))) {
            Some((i, offset)) => Copied::Group(i, offset),
            None => Copied::Evaluator(within(bytes(&self.evaluator)).expect("no number stands elsewhere")),
        }
    }
}

/// The addresses of a value.
fn bytes<T>(value: &T) -> Range<usize> {
    let start = from_ref(value) as usize;
    start..start + size_of::<T>()
}

/// The places of the `own` numbers, in their order, counted as in [`InLanes`](crate::InLanes).
pub fn places_of<R: Register, const N: usize>(
    plant: &Plant<f64, N>,
    layout: &Layout,
    bank: &Bank<R, N>,
    own: &[usize],
) -> Vec<Place> {
    // Which number of the plant each number of an evaluator is, in the order of both, by an evaluator of their indices.
    let (mut count, mut indices, mut copies) = (0.0, Vec::new(), Vec::new());
    let numbered = plant.map(&mut |_| {
        count += 1.0;
        count - 1.0
    });
    Evaluator::<f64, f64, N>::new(&numbered, layout).each(&mut |index| indices.push(*index as usize));
    bank.evaluator.each(&mut |number| copies.push(bank.place(number)));
    let mut places = Vec::new();
    for (number, own) in own.iter().enumerate() {
        let copies = indices.iter().zip(&copies).filter(|(index, _)| *index == own).map(|(_, copy)| *copy);
        let weight = own.checked_sub(count as usize).map(Copied::Weight);
        places.extend(copies.chain(weight).map(|copy| Place { number, copy }));
    }
    places
}
