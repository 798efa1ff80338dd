//! Repeatable random numbers, counted rather than kept in a global.
//!
//! The n-th number of a stream depends on its key and n alone, by the finaliser of SplitMix64 (Steele, Lea, Flood:
//! Fast splittable pseudorandom number generators, OOPSLA 2014). Every platform draws the same bits.

use crate::Archive;

/// Step of the counter: 2^64 over the golden ratio, odd.
const STRIDE: u64 = 0x9E37_79B9_7F4A_7C15;

/// A stream of random numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RandomStream {
    key: u64,
    counter: u64,
}

impl RandomStream {
    /// The stream of `name` under `seed`. Streams of other names do not change when one is added.
    pub fn new(seed: u64, name: &str) -> Self {
        let key = name.bytes().fold(mix(seed.wrapping_add(STRIDE)), |key, byte| mix(key ^ u64::from(byte)));
        RandomStream { key, counter: 0 }
    }

    /// Where it is in its numbers.
    pub fn archive(&mut self, archive: &mut Archive) {
        archive.whole(&mut self.counter);
    }

    fn next(&mut self) -> u64 {
        self.counter = self.counter.wrapping_add(1);
        mix(self.key.wrapping_add(self.counter.wrapping_mul(STRIDE)))
    }

    /// Uniform in 0 (included) to 1 (excluded), in steps of 2^-53.
    pub fn uniform(&mut self) -> f64 {
        (self.next() >> 11) as f64 / 9_007_199_254_740_992.0
    }

    /// Uniform in -1 to 1.
    pub fn symmetric(&mut self) -> f64 {
        2.0 * self.uniform() - 1.0
    }

    /// Mean 0, variance 1: the sum of twelve uniform numbers less six. Near enough to normal for noise, and bounded:
    /// never beyond six standard deviations.
    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_finaliser_is_that_of_splitmix64() {
        // First outputs of the generator of the paper from state 0 (values of its reference implementation).
        let outputs: Vec<u64> = (1..=3u64).map(|n| mix(n.wrapping_mul(STRIDE))).collect();
        assert_eq!(outputs, [0xE220_A839_7B1D_CDAF, 0x6E78_9E6A_A1B9_65F4, 0x06C4_5D18_8009_454F]);
    }

    #[test]
    fn a_seed_repeats_and_another_differs() {
        let three = |seed, name| {
            let mut d = RandomStream::new(seed, name);
            [d.uniform(), d.uniform(), d.uniform()]
        };
        assert_eq!(three(1, "boom"), three(1, "boom"));
        assert_ne!(three(1, "boom"), three(2, "boom"));
        assert_ne!(three(1, "boom"), three(1, "jib"));
    }

    #[test]
    fn moments_are_those_of_the_distributions() {
        let mut d = RandomStream::new(7, "moments");
        let n = 100_000;
        let uniform: Vec<f64> = (0..n).map(|_| d.symmetric()).collect();
        let normal: Vec<f64> = (0..n).map(|_| d.normal()).collect();
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
        let variance = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>() / v.len() as f64;
        // Four standard errors of each estimate.
        assert!(mean(&uniform).abs() < 4.0 * (1.0 / 3.0 / n as f64).sqrt());
        assert!((variance(&uniform) - 1.0 / 3.0).abs() < 0.004);
        assert!(mean(&normal).abs() < 4.0 / (n as f64).sqrt());
        assert!((variance(&normal) - 1.0).abs() < 0.018);
        assert!(uniform.iter().all(|x| (-1.0..1.0).contains(x)));
    }
}
