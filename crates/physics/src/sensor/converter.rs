//! Analogue-to-digital converter.                   theory: docs/theory/sensor/converter.md
//!
//! The sensors end in the inputs of a sampled computer        thesis (2.2.4.3)
//!     code = round((y - low) / lsb),   lsb = (high - low) / (2^bits - 1)
//! and codes below zero or above full scale do not exist.

/// A converter whose input span matches a sensor's output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Converter {
    pub low: f64,
    pub high: f64,
    /// `None`: as fine as a double, but with the same ends.
    pub bits: Option<u32>,
}

impl Converter {
    /// Difference between neighbouring codes, in the unit of what is measured; zero where nothing is rounded.
    pub fn step(&self) -> f64 {
        self.bits.map_or(0.0, |bits| (self.high - self.low) / ((1u64 << bits.min(52)) - 1) as f64)
    }

    pub fn read(&self, y: f64) -> f64 {
        let y = y.clamp(self.low, self.high);
        let step = self.step();
        if step > 0.0 {
            self.low + hydrocrane_num::portable::round((y - self.low) / step) * step
        } else {
            y
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reading_is_a_code_within_half_a_step() {
        let converter = Converter { low: 0.0, high: 400e5, bits: Some(12) };
        assert_eq!(converter.step(), 400e5 / 4095.0);
        for i in 0..=1000 {
            let y = 400e5 * f64::from(i) / 1000.0;
            let read = converter.read(y);
            assert!((read - y).abs() <= 0.5 * converter.step() * (1.0 + 1e-12));
            let code = read / converter.step();
            assert!((code - code.round()).abs() < 1e-9);
        }
    }

    #[test]
    fn a_reading_never_leaves_the_range() {
        for bits in [None, Some(8)] {
            let converter = Converter { low: -1.0, high: 1.0, bits };
            assert_eq!(converter.read(3.0), 1.0);
            assert_eq!(converter.read(-3.0), -1.0);
        }
    }
}
