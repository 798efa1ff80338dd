//! Wire potentiometer.                              theory: docs/theory/sensor/wire_potentiometer.md
//!
//! A wire turns a potentiometer: 1250 mm, linear within 0.25 %, repeatable within 0.03 %        thesis (2.2.3.3, Figure 94)
//! The middle of its range sits at the middle of what it measures.

use super::analogue::{Analogue, Quality};
use super::Converter;
use hydrocrane_num::Draws;

#[derive(Debug, Clone, PartialEq)]
pub struct WirePotentiometer {
    sensor: Analogue,
}

impl WirePotentiometer {
    /// Range in m.
    pub fn new(range: f64, bits: Option<u32>, quality: Quality, draws: Draws) -> Self {
        let converter = Converter { low: -0.5 * range, high: 0.5 * range, bits };
        WirePotentiometer { sensor: Analogue::new(converter, quality, draws) }
    }

    pub fn read(&mut self, x: f64) -> f64 {
        self.sensor.read(x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_stays_within_linearity_and_repeatability() {
        let quality = Quality { linearity: 0.0025, repeatability: 0.0003, ..Quality::default() };
        let bound = 1.25 * (0.0025 + 0.0003);
        let mut largest: f64 = 0.0;
        for seed in 0..200 {
            let mut sensor = WirePotentiometer::new(1.25, None, quality, Draws::new(seed, "x"));
            for i in 0..=40 {
                let x = -0.6 + 0.03 * f64::from(i);
                largest = largest.max((sensor.read(x) - x).abs());
            }
        }
        assert!(largest <= bound && largest > 0.7 * bound, "{largest} of {bound}");
    }
}
