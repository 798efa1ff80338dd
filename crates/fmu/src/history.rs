//! The samples that a controller has had since its start, from which it can be computed again.

use std::sync::Arc;

/// Longest history that is kept, bytes: two hours of a crane with three joints at 10 ms.
const LONGEST: usize = 64 << 20;
/// Samples that copies of a history share as one block.
const BLOCK: usize = 1024;

#[derive(Debug, Clone)]
pub struct History {
    /// Numbers of a sample.
    width: usize,
    full: Vec<Arc<[f64]>>,
    last: Vec<f64>,
    count: usize,
}

impl History {
    pub fn new(width: usize) -> Self {
        History { width, full: Vec::new(), last: Vec::new(), count: 0 }
    }

    /// Adds a sample. A history that gets too long is forgotten.
    pub fn push(&mut self, sample: impl Iterator<Item = f64>) {
        self.count += 1;
        if !self.is_whole() {
            (self.full, self.last) = (Vec::new(), Vec::new());
            return;
        }
        self.last.extend(sample);
        if self.last.len() == BLOCK * self.width {
            self.full.push(std::mem::take(&mut self.last).into());
        }
    }

    /// Whether no sample was forgotten.
    pub fn is_whole(&self) -> bool {
        self.count * self.width * size_of::<f64>() <= LONGEST
    }

    /// All samples, those after which nothing was forgotten.
    pub fn samples(&self) -> impl Iterator<Item = &[f64]> {
        let blocks = self.full.iter().map(|block| &block[..]).chain([&self.last[..]]);
        blocks.flat_map(|block| block.chunks_exact(self.width))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_share_what_was_before_and_go_on_alone() {
        let mut one = History::new(2);
        let sample = |k: usize| [k as f64, -0.5].into_iter();
        (0..2500).for_each(|k| one.push(sample(k)));
        let mut two = one.clone();
        one.push([7.0, 7.0].into_iter());
        (2500..3000).for_each(|k| two.push(sample(k)));
        assert!(Arc::ptr_eq(&one.full[1], &two.full[1]));
        assert_eq!(one.samples().last(), Some(&[7.0, 7.0][..]));
        assert_eq!((one.samples().count(), two.samples().count()), (2501, 3000));
        assert!(two.samples().enumerate().all(|(k, sample)| sample == [k as f64, -0.5]));
    }

    #[test]
    fn one_that_gets_too_long_is_forgotten() {
        let width = LONGEST / size_of::<f64>() / 2;
        let mut history = History::new(width);
        (0..2).for_each(|_| history.push(std::iter::repeat_n(0.0, width)));
        assert!(history.is_whole());
        history.push(std::iter::repeat_n(0.0, width));
        assert!(!history.is_whole());
        assert_eq!(history.samples().count(), 0);
    }
}
