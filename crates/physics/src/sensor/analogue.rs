//! What analogue sensors have in common.            theory: docs/theory/sensor/analogue.md
//!
//! With s = 0 at the low and 1 at the high end of the range (width w; a converter may go beyond), a sensor of known quality reads
//!     y = u + w [ zero + gain (s - 1/2) + linearity_error (4 s (1 - s) - 1/2) + noise n ]
//! `zero`, `gain` and `linearity_error` are drawn once, as one would buy a sensor; n is drawn for each reading. The data sheets
//! give bounds of the sum, not of its parts: thesis (2.2.3, 9.1).

use super::Converter;
use hydrocrane_num::RandomStream;

/// Quality of an analogue sensor as its data sheet states it, as shares of the range.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Quality {
    /// Largest error of zero point and span together.
    pub accuracy: f64,
    /// Largest deviation from the straight line.
    pub linearity: f64,
    /// Largest difference between two readings of the same thing, from the middle.
    pub repeatability: f64,
    /// Standard deviation of the electrical noise.
    pub noise: f64,
}

impl Quality {
    /// The same quality as shares of a range `1/share` times as wide.
    pub fn scaled(self, share: f64) -> Self {
        Quality {
            accuracy: share * self.accuracy,
            linearity: share * self.linearity,
            repeatability: share * self.repeatability,
            noise: share * self.noise,
        }
    }
}

/// From `low` to `high`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    pub low: f64,
    pub high: f64,
}

/// One sensor, as bought.
#[derive(Debug, Clone, PartialEq)]
pub struct Analogue {
    /// What the quality speaks of.
    range: Range,
    converter: Converter,
    quality: Quality,
    zero: f64,
    gain: f64,
    linearity_error: f64,
    pub(super) random: RandomStream,
}

impl Analogue {
    /// A sensor whose converter spans just its range.
    pub fn new(converter: Converter, quality: Quality, random: RandomStream) -> Self {
        Self::within(Range { low: converter.low, high: converter.high }, converter, quality, random)
    }

    /// A sensor whose converter goes on beyond its range.
    pub fn within(range: Range, converter: Converter, quality: Quality, mut random: RandomStream) -> Self {
        // Half of the accuracy each: at the ends of the range, where both add, the whole is reached.
        let zero = 0.5 * quality.accuracy * random.symmetric();
        let gain = quality.accuracy * random.symmetric();
        let linearity_error = 2.0 * quality.linearity * random.symmetric();
        Analogue { range, converter, quality, zero, gain, linearity_error, random }
    }

    /// Error that every reading of `u` has, in its unit.
    pub fn bias(&self, u: f64) -> f64 {
        let width = self.width();
        let s = (u.clamp(self.converter.low, self.converter.high) - self.range.low) / width;
        width * (self.zero + self.gain * (s - 0.5) + self.linearity_error * (4.0 * s * (1.0 - s) - 0.5))
    }

    pub fn read(&mut self, u: f64) -> f64 {
        let scatter = self.quality.repeatability * self.random.symmetric() + self.quality.noise * self.random.normal();
        self.converter.read(u + self.bias(u) + self.width() * scatter)
    }

    fn width(&self) -> f64 {
        self.range.high - self.range.low
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUALITY: Quality = Quality { accuracy: 0.003, linearity: 0.0025, repeatability: 0.0, noise: 0.0 };

    #[test]
    fn the_bias_stays_within_the_data_sheet_and_uses_it() {
        let converter = Converter { low: -2.0, high: 3.0, bits: None };
        let bound = 5.0 * (QUALITY.accuracy + QUALITY.linearity);
        let mut largest: f64 = 0.0;
        for seed in 0..500 {
            let sensor = Analogue::new(converter, QUALITY, RandomStream::new(seed, "any"));
            for i in 0..=20 {
                largest = largest.max(sensor.bias(-2.0 + 0.25 * f64::from(i)).abs());
            }
        }
        assert!(largest <= bound, "{largest}");
        assert!(largest > 0.6 * bound, "{largest}: the bound is never approached");
    }

    #[test]
    fn noise_has_the_stated_deviation_and_a_seed_repeats_it() {
        let quality = Quality { noise: 0.01, ..Quality::default() };
        let converter = Converter { low: 0.0, high: 100.0, bits: None };
        let read = |seed| {
            let mut sensor = Analogue::new(converter, quality, RandomStream::new(seed, "any"));
            (0..4000).map(|_| sensor.read(50.0)).collect::<Vec<f64>>()
        };
        let readings = read(3);
        let variance = readings.iter().map(|y| (y - 50.0) * (y - 50.0)).sum::<f64>() / 4000.0;
        assert!((variance - 1.0).abs() < 0.1, "{variance}");
        assert_eq!(readings, read(3));
        assert_ne!(readings, read(4));
    }
}
