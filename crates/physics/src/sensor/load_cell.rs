//! Load cell in the rod.                            theory: docs/theory/sensor/load_cell.md
//!
//! Tension and compression up to the nominal force        thesis (2.2.3.2, Figures 91 and 92)

use super::analogue::{Analogue, Quality};
use super::Converter;
use hydrocrane_num::{Archive, RandomStream};

#[derive(Debug, Clone, PartialEq)]
pub struct LoadCell {
    sensor: Analogue,
}

impl LoadCell {
    /// Nominal force in N. Data sheets refer errors to it, while the range goes both ways: half of each is a share
    /// of the whole range.
    pub fn new(nominal: f64, bits: Option<u32>, quality: Quality, random: RandomStream) -> Self {
        let converter = Converter { low: -nominal, high: nominal, bits };
        LoadCell { sensor: Analogue::new(converter, quality.scaled(0.5), random) }
    }

    /// What changes while it measures.
    pub fn archive(&mut self, archive: &mut Archive) {
        self.sensor.random.archive(archive);
    }

    pub fn read(&mut self, force: f64) -> f64 {
        self.sensor.read(force)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_is_a_share_of_the_nominal_force() {
        let quality = Quality { accuracy: 0.005, ..Quality::default() };
        let mut largest: f64 = 0.0;
        for seed in 0..300 {
            let mut cell = LoadCell::new(50e3, None, quality, RandomStream::new(seed, "lift"));
            for force in [-50e3, -10e3, 0.0, 30e3, 49e3] {
                largest = largest.max((cell.read(force) - force).abs());
            }
        }
        assert!(largest <= 0.005 * 50e3 && largest > 0.6 * 0.005 * 50e3, "{largest}");
    }
}
