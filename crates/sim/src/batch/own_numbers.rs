//! The numbers in which the cranes of a batch differ.

use hydrocrane_lanes::{Group, WIDTH};

/// The numbers of the laws of all cranes: what they have in common, and what each has of its own.
#[derive(Default)]
pub struct OwnNumbers {
    common: Vec<f64>,
    /// Which numbers are not those in common in every crane, ascending.
    differing: Vec<usize>,
    /// These numbers, group by group: a register takes those of its cranes as they stand.
    rows: Vec<Group>,
    groups: usize,
}

impl OwnNumbers {
    /// Of so many groups of cranes that have them all in common.
    pub fn new(common: Vec<f64>, groups: usize) -> Self {
        OwnNumbers { common, groups, ..OwnNumbers::default() }
    }

    /// Gives a crane these numbers; returns whether others differ now than before.
    pub fn set(&mut self, crane: usize, numbers: &[f64]) -> bool {
        let differs = |i: &usize| numbers[*i].to_bits() != self.common[*i].to_bits();
        let new: Vec<usize> =
            (0..numbers.len()).filter(differs).filter(|i| self.differing.binary_search(i).is_err()).collect();
        if !new.is_empty() {
            self.add(&new);
        }
        let width = self.differing.len();
        for (own, i) in self.rows[crane / WIDTH * width..][..width].iter_mut().zip(&self.differing) {
            own[crane % WIDTH] = numbers[*i];
        }
        !new.is_empty()
    }

    /// Adds numbers in which cranes may differ.
    fn add(&mut self, new: &[usize]) {
        let mut differing = [&self.differing, new].concat();
        differing.sort_unstable();
        let rows = (0..self.groups).flat_map(|group| {
            let all: [Vec<f64>; WIDTH] = std::array::from_fn(|lane| self.all(group * WIDTH + lane));
            differing.iter().map(move |i| std::array::from_fn(|lane| all[lane][*i]))
        });
        self.rows = rows.collect();
        self.differing = differing;
    }

    /// Which numbers differ.
    pub fn differing(&self) -> &[usize] {
        &self.differing
    }

    /// Those of the group of a crane.
    pub fn of(&self, crane: usize) -> &[Group] {
        &self.rows[crane / WIDTH * self.differing.len()..][..self.differing.len()]
    }

    /// All numbers of a crane.
    pub fn all(&self, crane: usize) -> Vec<f64> {
        let mut all = self.common.clone();
        self.differing.iter().zip(self.of(crane)).for_each(|(i, own)| all[*i] = own[crane % WIDTH]);
        all
    }
}
