//! Incremental encoder.                             theory: docs/theory/sensor/encoder.md
//!
//! Four counts per pulse: the step is 2 pi / (4 pulses)        thesis (2.2.3.3)
//!     reading = step * round((q + division error(q)) / step + homing error)
//! An incremental encoder knows no absolute angle. Whoever sets it to zero does so within one count, and that error
//! stays. The marks of the disc stand where they should only within the division error, which changes over a turn.

use core::f64::consts::PI;
use hydrocrane_num::{portable, RandomStream};

/// Counts per pulse of two channels in quadrature.
const COUNTS_PER_PULSE: f64 = 4.0;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Encoder {
    /// Angle of one count, rad.
    pub step: f64,
    /// Counts, from -1 to 1.
    pub homing: f64,
    /// Amplitude of the division error, rad, and where in the turn it begins, rad.
    pub division: f64,
    pub phase: f64,
}

impl Encoder {
    /// An encoder with `pulses` per turn, its largest division error in electrical degrees (360 per pulse).
    pub fn new(pulses: f64, division_error: f64, random: &mut RandomStream) -> Self {
        let pitch = 2.0 * PI / pulses;
        Encoder {
            step: pitch / COUNTS_PER_PULSE,
            homing: random.symmetric(),
            division: pitch * division_error / 360.0 * random.uniform(),
            phase: PI * random.symmetric(),
        }
    }

    pub fn read(&self, q: f64) -> f64 {
        let marked = q + self.division * portable::sin(q + self.phase);
        portable::round(marked / self.step + self.homing) * self.step
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thousand_pulses_are_four_thousand_counts() {
        let encoder =
            Encoder { homing: 0.0, division: 0.0, ..Encoder::new(1000.0, 0.0, &mut RandomStream::new(0, "boom")) };
        assert!((encoder.step.to_degrees() - 0.09).abs() < 1e-12);
        let mut seen: Vec<i64> =
            (0..100_000).map(|i| (encoder.read(2.0 * PI * f64::from(i) / 1e5) / encoder.step).round() as i64).collect();
        seen.dedup();
        assert_eq!(seen.len(), 4001, "a turn and the first count of the next");
    }

    #[test]
    fn the_error_is_bounded_by_homing_rounding_and_division() {
        let mut farthest: f64 = 0.0;
        for seed in 0..300 {
            let encoder = Encoder::new(1000.0, 50.0, &mut RandomStream::new(seed, "boom"));
            let bound = 1.5 * encoder.step + 50.0 / 90.0 * encoder.step;
            for i in 0..200 {
                let q = -1.0 + f64::from(i) * 0.0123;
                let error = encoder.read(q) - q;
                assert!(error.abs() <= bound * (1.0 + 1e-9), "seed {seed}: {error}");
                farthest = farthest.max(error.abs() / bound);
            }
        }
        assert!(farthest > 0.8, "the bound is never approached: {farthest}");
    }
}
