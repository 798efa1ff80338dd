//! The velocity that takes the tip to a goal on a straight line.          theory: docs/theory/control/reference.md
//!
//! w = min(speed, last w + a T, brake(d)) towards the goal,   d = |goal - place where the set-point stops on release|
//!
//! It is handed on in the place of the stick's velocity: everything behind the stick is the same. That place moves with w itself,
//! whatever the two lags of the stick hold, so that w is chosen as for a set-point without lags.

use crate::interface::controller::Goal;
use hydrocrane_num::{portable, Vec2};

/// The way to a goal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Travel {
    pub goal: Goal,
    /// Speed asked for at the last sample, m/s.
    speed: f64,
    /// Whether nothing is left to be asked for.
    pub over: bool,
    /// Since then, s.
    pub waited: f64,
}

/// What a sample says of the way.
#[derive(Debug, Clone, Copy)]
pub struct Stretch {
    /// From where the set-point stops on release to the goal, m.
    pub left: [f64; 2],
    /// Speed of the way, m/s.
    pub speed: f64,
    /// Bandwidth of the stick's lags, rad/s: at most the lowest natural frequency of the crane on its oil.
    pub bandwidth: f64,
    /// How far the tip may be behind a set-point that accelerates, m.
    pub behind: f64,
    /// s
    pub period: f64,
}

impl Travel {
    /// Begins while `velocity` (m/s) is asked for.
    pub fn to(goal: Goal, velocity: [f64; 2]) -> Self {
        Travel { goal, speed: Vec2::<f64>::c(velocity).norm(), over: false, waited: 0.0 }
    }

    /// The velocity to ask for, m/s.
    pub fn velocity(&mut self, now: &Stretch) -> [f64; 2] {
        let left = Vec2::<f64>::c(now.left).norm();
        let acceleration = acceleration(now);
        let sooner = self.speed + acceleration * now.period;
        self.speed = now.speed.min(sooner).min(braking(left, acceleration, final_rate(now)));
        if self.over || left <= 0.0 {
            self.speed = 0.0;
        }
        let share = if left > 0.0 { self.speed / left } else { 0.0 };
        now.left.map(|left| left * share)
    }
}

/// Time of the ramp from rest to the speed of the way, in time constants of the stick's lags.
const RAMP: f64 = 4.0;
/// Share of what is left that may be gone in a period, at most: more than all of it would overshoot.
const MOST_IN_A_PERIOD: f64 = 0.5;

/// A ramp of some time constants of the lags; less where it would wind the oil, on which a mass that accelerates by a hangs back
/// by a / omega^2.
fn acceleration(now: &Stretch) -> f64 {
    (now.speed * now.bandwidth / RAMP).min(now.behind * now.bandwidth * now.bandwidth)
}

/// Rate of the exponential end of the way, 1/s.
fn final_rate(now: &Stretch) -> f64 {
    now.bandwidth.min(MOST_IN_A_PERIOD / now.period)
}

/// Speed from which `acceleration` stops within `left` (m), with an exponential end of `rate` (1/s): the parabola
/// v^2 = 2 a (d - a / 2 k^2) and its tangent v = k d through zero.
fn braking(left: f64, acceleration: f64, rate: f64) -> f64 {
    let end = acceleration / (rate * rate);
    if left <= end {
        rate * left
    } else {
        portable::sqrt(2.0 * acceleration * (left - 0.5 * end))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPEED: f64 = 0.3;
    const BEHIND: f64 = 0.01;

    fn goal(place: [f64; 2]) -> Goal {
        Goal { place, speed: None, share: 1.0, given: 0.0, until: f64::INFINITY }
    }

    /// Place, velocity and acceleration of a set-point behind two lags on its way over `length` (m), sample by sample.
    fn travelled(length: f64, bandwidth: f64, period: f64) -> Vec<[f64; 3]> {
        let mut travel = Travel::to(goal([length, 0.0]), [0.0; 2]);
        let (mut place, mut lags, mut rows) = (0.0, [0.0; 2], Vec::new());
        let kept = (-bandwidth * period).exp();
        let stretch = Stretch { left: [0.0; 2], speed: SPEED, bandwidth, behind: BEHIND, period };
        for _ in 0..(30.0 / period) as usize {
            let stop = place + kept * (lags[0] + lags[1]) * period / (1.0 - kept);
            let stretch = Stretch { left: [length - stop, 0.0], ..stretch };
            let request = travel.velocity(&stretch)[0];
            let before = lags[1];
            lags[0] += (1.0 - kept) * (request - lags[0]);
            lags[1] += (1.0 - kept) * (lags[0] - lags[1]);
            place += lags[1] * period;
            rows.push([place, lags[1], (lags[1] - before) / period]);
        }
        rows
    }

    #[test]
    fn comes_to_rest_at_the_goal_without_passing_it_within_speed_and_acceleration() {
        for length in [1e-3, 0.02, 0.3, 3.0] {
            for bandwidth in [2.0, 15.0] {
                for period in [1e-3, 0.01, 0.1] {
                    let rows = travelled(length, bandwidth, period);
                    let what = format!("{length} m, {bandwidth} rad/s, {period} s");
                    let [end, speed, _] = rows[rows.len() - 1];
                    assert!((end - length).abs() < 1e-6 && speed.abs() < 1e-6, "{what}: {end} m, {speed} m/s");
                    let most = |i: usize| rows.iter().map(|row| row[i].abs()).fold(0.0, f64::max);
                    let acceleration = (SPEED * bandwidth / RAMP).min(BEHIND * bandwidth * bandwidth);
                    // Over a sample the parabola grows steeper.
                    let steeper = 1.0 + bandwidth.min(MOST_IN_A_PERIOD / period) * period;
                    assert!(most(2) <= steeper * acceleration, "{what}: {} m/s^2", most(2));
                    assert!(
                        most(1) <= SPEED * (1.0 + 1e-12) && most(0) <= length * (1.0 + 1e-9),
                        "{what}: {} m",
                        most(0)
                    );
                    assert!(rows.iter().all(|row| row[1] >= -1e-12), "{what}: turned back");
                }
            }
        }
    }

    #[test]
    fn the_acceleration_has_no_jumps() {
        let (bandwidth, period) = (15.0, 1e-3);
        let rows = travelled(0.5, bandwidth, period);
        let jerk = rows.windows(2).map(|pair| (pair[1][2] - pair[0][2]).abs() / period).fold(0.0, f64::max);
        let acceleration = (SPEED * bandwidth / RAMP).min(BEHIND * bandwidth * bandwidth);
        assert!(jerk <= 1.02 * acceleration * bandwidth, "{jerk} m/s^3");
    }
}
