//! Resolution of a position sensor, as its readings show it.           theory: docs/theory/control/estimate.md

/// The readings of one sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Readings {
    last: f64,
    /// Smallest change from one reading to the next that was not zero.
    least: f64,
}

impl Readings {
    /// Nothing known but a first reading.
    pub fn at(first: f64) -> Self {
        Readings { last: first, least: f64::INFINITY }
    }

    /// Takes in a reading; the resolution so far: one count of an encoder, next to nothing of a continuous sensor, zero as long as
    /// nothing has changed.
    pub fn resolution(&mut self, reading: f64) -> f64 {
        let change = (reading - self.last).abs();
        self.last = reading;
        if change > 0.0 {
            self.least = self.least.min(change);
        }
        self.known()
    }

    /// The resolution so far.
    pub fn known(&self) -> f64 {
        if self.least.is_finite() {
            self.least
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(readings: impl Iterator<Item = f64>) -> f64 {
        let mut sensor = Readings::at(0.0);
        readings.map(|reading| sensor.resolution(reading)).last().expect("readings")
    }

    #[test]
    fn counts_show_and_continuous_readings_have_none() {
        let course = |k: i32| 0.3 * (0.02 * f64::from(k)).sin();
        let count = 2e-3;
        let counted = found((0..400).map(|k| (course(k) / count).round() * count));
        assert!((counted / count - 1.0).abs() < 1e-9, "{counted}");
        assert!(found((0..400).map(course)) < 1e-4);
        assert_eq!(found([0.0; 5].into_iter()), 0.0);
    }
}
