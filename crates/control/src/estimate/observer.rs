//! Position and disturbance of a piston behind a coarse sensor.   theory: docs/theory/control/estimate.md
//!
//! x^ += T (v + d^ + 2 w (y - x^)),     d^ += T w^2 (y - x^)
//!
//! v is the speed that the commands should produce, y the measured position, d^ the speed that is missing: leakage, a wrong
//! load, a valve that gives more or less than the controller model says. One count of the encoder per period is more than the boom's
//! full speed, so a difference of positions tells nothing; the model supplies the motion, the sensor its slow correction.

use hydrocrane_num::{portable, Real};

/// State of the observer of one piston.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Observer {
    /// x^, m
    pub position: f64,
    /// d^, m/s
    pub disturbance: f64,
}

/// What a reading leaves unknown to either side, in counts: of a piston that hardly moves, and how much less of one that moves on.
const IN_A_COUNT: f64 = 0.5;
const IN_MOTION: f64 = 0.25;

/// How an observer learns from one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains {
    /// s
    period: f64,
    /// Share by which either of the two lags goes on in a period behind which the disturbance is found.
    pub lag_share: f64,
    position: f64,
    /// 1/s
    disturbance: f64,
}

impl Gains {
    /// The discrete gains of a double real pole at exp(-w T): stable for every `bandwidth` w (rad/s).
    pub fn new(bandwidth: f64, period: f64) -> Self {
        let pole = portable::exp(-bandwidth * period);
        Gains {
            period,
            lag_share: 1.0 - pole,
            position: 1.0 - pole * pole,
            disturbance: (1.0 - pole).square() / period,
        }
    }
}

impl Observer {
    /// Has its model explain `speed` (m/s) of what was missing.
    pub fn explain(&mut self, speed: f64) {
        self.disturbance -= speed;
    }

    pub fn at(position: f64) -> Self {
        Observer { position, disturbance: 0.0 }
    }

    /// Position after a period at `speed`, m.
    pub fn foreseen(&self, speed: f64, gains: &Gains) -> f64 {
        self.position + gains.period * (speed + self.disturbance)
    }

    /// `speed`: expected over the period that ends with the measurement; `learning`: share of the gain of d^ to learn with;
    /// `count`: resolution of the reading, m. A piston that crosses counts faster than the observer follows is found by the mean of the
    /// readings; of a slower one they tell on which side of a boundary it is, and nothing more.
    pub fn update(&mut self, measured: f64, speed: f64, gains: &Gains, learning: f64, count: f64) {
        let predicted = self.foreseen(speed, gains);
        let difference = measured - predicted;
        let crossed = (speed + self.disturbance).abs() * gains.period / gains.lag_share;
        let unknown = IN_A_COUNT * count - IN_MOTION * count.min(crossed);
        let innovation = difference - difference.clamp(-unknown, unknown);
        self.position = predicted + gains.position * innovation;
        self.disturbance += learning * gains.disturbance * innovation;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_a_missing_speed() {
        let mut o = Observer::at(0.0);
        for k in 1..=300 {
            o.update(0.02 * 0.01 * k as f64, 0.015, &Gains::new(10.0, 0.01), 1.0, 0.0);
        }
        assert!((o.disturbance - 0.005).abs() < 1e-6 && (o.position - 0.06).abs() < 1e-6);
    }

    #[test]
    fn a_reading_that_changes_puts_a_piston_that_hardly_moves_at_the_boundary_of_the_count() {
        let (count, gains) = (4e-4, Gains::new(5.0, 0.01));
        let mut o = Observer::at(0.3 * count);
        for _ in 0..300 {
            o.update(count, 0.0, &gains, 0.0, count);
        }
        assert!((o.position - 0.5 * count).abs() < 1e-3 * count, "{o:?}");
        // Within a count nothing is learnt.
        let before = o;
        o.update(0.0, 0.0, &gains, 1.0, count);
        assert_eq!(o, before);
    }

    #[test]
    fn counts_of_an_encoder_shake_the_position_by_less_than_half_a_count() {
        let (count, mut o) = (4e-4, Observer::at(0.0));
        let mut worst = 0.0f64;
        for k in 1..=500 {
            let x = 0.0102 * 0.01 * k as f64;
            o.update((x / count).round() * count, 0.0102, &Gains::new(5.0, 0.01), 1.0, count);
            worst = worst.max((o.position - x).abs());
        }
        assert!(worst < 0.25 * count, "{worst}");
    }
}
