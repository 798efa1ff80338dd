//! Wire potentiometer.                              theory: docs/theory/sensor/wire_potentiometer.md
//!
//! A wire turns a potentiometer: 1250 mm, linear within 0.25 %, repeatable within 0.03 %        thesis (2.2.3.3, Figure 94)
//! Where its range lies, whoever mounts it decides: `middle`.
//!     w = clamp(w, x - |h|, x + |h|),   y = x + sign(h) (w - x)
//! Where a reading depends on the way it was reached, it is off by h once the drum has followed; h is drawn once, within
//! the repeatability of the data sheet: it lags where h > 0 and leads where h < 0.

use super::analogue::{Analogue, Quality};
use super::Converter;
use hydrocrane_num::{Archive, RandomStream};

#[derive(Debug, Clone, PartialEq)]
pub struct WirePotentiometer {
    sensor: Analogue,
    /// h, m.
    hysteresis: f64,
    /// w, m: where the drum stands; `None` before the first reading, which finds it in the middle of its play.
    drum: Option<f64>,
}

impl WirePotentiometer {
    /// Range and the position in its middle, m.
    pub fn new(range: f64, middle: f64, bits: Option<u32>, quality: Quality, random: RandomStream) -> Self {
        let converter = Converter { low: middle - 0.5 * range, high: middle + 0.5 * range, bits };
        let mut sensor = Analogue::new(converter, Quality { repeatability: 0.0, ..quality }, random);
        let hysteresis = range * quality.repeatability * sensor.random.symmetric();
        WirePotentiometer { sensor, hysteresis, drum: None }
    }

    /// Forgets where it came from.
    pub fn settle(&mut self) {
        self.drum = None;
    }

    /// What changes while it measures.
    pub fn archive(&mut self, archive: &mut Archive) {
        archive.option(&mut self.drum, Archive::number);
        self.sensor.random.archive(archive);
    }

    pub fn read(&mut self, x: f64) -> f64 {
        let play = self.hysteresis.abs();
        let drum = self.drum.unwrap_or(x).clamp(x - play, x + play);
        self.drum = Some(drum);
        let off = if self.hysteresis < 0.0 { x - drum } else { drum - x };
        self.sensor.read(x + off)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUALITY: Quality = Quality { accuracy: 0.0, linearity: 0.0025, repeatability: 0.0003, noise: 0.0 };
    const HYSTERESIS: Quality = Quality { linearity: 0.0, ..QUALITY };

    #[test]
    fn the_error_stays_within_linearity_and_repeatability() {
        let bound = 1.25 * (0.0025 + 0.0003);
        let mut largest: f64 = 0.0;
        for seed in 0..200 {
            let middle = if seed % 2 == 0 { 0.0 } else { 0.6 };
            let mut sensor = WirePotentiometer::new(1.25, middle, None, QUALITY, RandomStream::new(seed, "x"));
            for i in 0..=40 {
                let x = middle - 0.6 + 0.03 * f64::from(i);
                largest = largest.max((sensor.read(x) - x).abs());
            }
        }
        assert!(largest <= bound && largest > 0.7 * bound, "{largest} of {bound}");
    }

    /// Readings at the middle, reached from below and from above.
    fn both_ways(seed: u64) -> [f64; 2] {
        let mut sensor = WirePotentiometer::new(1.25, 0.0, None, HYSTERESIS, RandomStream::new(seed, "x"));
        let mut middle = |from: f64| {
            sensor.read(from);
            sensor.read(0.0)
        };
        [middle(-0.1), middle(0.1)]
    }

    #[test]
    fn a_place_reads_differently_from_either_side_by_up_to_the_repeatability_and_always_the_same() {
        let (mut lags, mut largest) = (0, 0.0f64);
        for seed in 0..200 {
            let [rising, falling] = both_ways(seed);
            assert_eq!(rising, -falling);
            assert_eq!(both_ways(seed), [rising, falling], "no scatter");
            lags += u32::from(rising < 0.0);
            largest = largest.max(rising.abs());
        }
        assert!((60..140).contains(&lags), "{lags} of 200 lag");
        assert!(largest <= 0.0003 * 1.25 && largest > 0.95 * 0.0003 * 1.25, "{largest}");
    }

    #[test]
    fn a_motion_within_the_play_moves_a_lagging_reading_not_at_all() {
        let seed = (0..).find(|&seed| both_ways(seed)[0] < -0.5 * 0.0003 * 1.25).expect("a lagging one");
        let play = both_ways(seed)[1];
        let mut sensor = WirePotentiometer::new(1.25, 0.0, None, HYSTERESIS, RandomStream::new(seed, "x"));
        sensor.read(-0.1);
        let start = sensor.read(0.0);
        assert_eq!(sensor.read(-1.9 * play), start);
        assert!(sensor.read(-2.1 * play) < start);
        sensor.settle();
        assert_eq!(sensor.read(0.0), 0.0, "found in the middle of its play");
    }
}
