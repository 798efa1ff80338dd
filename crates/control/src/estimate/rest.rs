//! Holds a piston at rest against creep.                                theory: docs/theory/control/regulate.md
//!
//! T_f v' = k (x_h - y) - v,     b' = -v/(9 T_f),     k = 1/(3 T_f)
//!
//! y is the measured position, x_h the place to hold, b the creep; the piston is given v - b. The low-pass lets so little of the modes
//! on the oil pass that their own damping outweighs it, however small.
//!
//! Fast creep that was observed before rest is made up for from the first sample on. b begins with half of what is left of it.
//!
//! A count that is coarse at the tip tells nothing of creep within it. There x_h is the boundary of the count that is nearest to the
//! observed position: a reading that changes there tells the place as finely as the piston moves.

use hydrocrane_num::portable;

/// Corner 1/T_f of the low-pass in lowest natural frequencies of the crane on its oil, and the highest, rad/s.
const CORNER_PER_MODE: f64 = 0.15;
const FASTEST: f64 = 1.0;
/// Shares of the corner that the gain k and the rate of b are: three equal poles.
const GAIN: f64 = 1.0 / 3.0;
const LEARNING: f64 = 1.0 / 9.0;
/// Share of the creep found at first that is taken to last: what is left of a swing dies out.
const LASTING: f64 = 0.5;
/// Speeds of the tip up to which creep is held, by the position and at the boundary of a count, which says no more than on which
/// side of it the piston is, m/s.
const MOST: [f64; 2] = [3e-4, 1e-4];
/// Speed of the tip from which on observed creep counts as creep, m/s: less can be the rest of a swing.
const SWING: f64 = 1e-3;
/// Time after which a piston is held where it is, and over which that place and its creep are averaged, s.
const COMING: f64 = 2.0;
const AVERAGED: f64 = 0.5;
/// Travel of the tip in a count from which on the boundary of the count is held, m.
const COARSE: f64 = 1e-3;
/// Time in which a piston goes half a count, s, and after which it no longer looks for the boundary so fast, s.
const APPROACH: f64 = 2.5;
const PATIENCE: f64 = 5.0;
/// Travel of the tip by which a piston that is not held has sunk, m: half of what is promised for one that is.
const SUNK: f64 = 5e-4;

/// A piston at rest at one sample.
#[derive(Debug, Clone, Copy)]
pub struct Resting {
    /// Where it shall stop, and where it is as observed and as measured, m.
    pub stroke: f64,
    pub observed: f64,
    pub measured: f64,
    /// Resolution of the measurement, m.
    pub count: f64,
    /// Travel of the tip per travel of the piston.
    pub tip_per_stroke: f64,
    /// Lowest natural frequency of the crane on its oil, rad/s.
    pub slowest: f64,
}

impl Resting {
    /// A piston's `speed`, m/s, but no more than moves the tip at `most`, m/s.
    fn bounded(&self, speed: f64, most: f64) -> f64 {
        let most = most / self.tip_per_stroke;
        // At a dead centre `most` can be no number.
        speed.max(-most).min(most)
    }
}

/// What a piston at rest is held at.
#[derive(Debug, Clone, Copy)]
enum Place {
    /// Where it is (m), creeping (m/s), once this time (s) is over.
    Own { place: f64, creep: f64, left: f64 },
    /// The boundary of a count (m), the sense in which the piston goes there, and for how long it still looks for it, s; zero
    /// where it has been there.
    Boundary { place: f64, sense: f64, left: f64 },
}

/// What holds a piston as long as it rests.
#[derive(Debug, Clone, Copy)]
pub struct Rest {
    place: Place,
    /// m/s
    speed: f64,
    /// Speed that makes up for what the piston was known to creep, m/s.
    known: f64,
    /// The last sample.
    now: Resting,
}

impl Rest {
    /// From the first sample at rest on, of a piston that has been observed to `creep`, m/s.
    pub fn at(now: Resting, creep: f64) -> Self {
        if now.count * now.tip_per_stroke > COARSE {
            let sense = (now.observed - now.measured).signum();
            let place = Place::Boundary { place: now.measured + 0.5 * sense * now.count, sense, left: PATIENCE };
            return Rest { place, speed: 0.0, known: 0.0, now };
        }
        let known = now.bounded(creep, SWING) - creep;
        Rest { place: Place::Own { place: now.measured, creep: 0.0, left: COMING }, speed: 0.0, known, now }
    }

    /// Place that the piston is held at, m.
    pub fn place(&self) -> f64 {
        match self.place {
            _ if self.coming() => self.now.stroke,
            Place::Own { place, .. } | Place::Boundary { place, .. } => place,
        }
    }

    /// Whether the piston still comes to where it shall stop.
    pub fn coming(&self) -> bool {
        matches!(self.place, Place::Own { left, .. } if left > 0.0)
    }

    /// Sense in which a piston that has sunk would have to go back.
    pub fn sunk(&self) -> Option<f64> {
        let off = self.place() - self.now.measured;
        let sunk = off.abs() > self.now.count.max(SUNK / self.now.tip_per_stroke);
        (sunk && !self.coming()).then(|| off.signum())
    }

    /// Holds the piston where it is now.
    pub fn stay(&mut self) {
        let creep = if let Place::Own { creep, .. } = self.place { creep } else { 0.0 };
        self.place = Place::Own { place: self.now.measured, creep, left: 0.0 };
    }

    /// Takes in a sample; speed of the piston over the coming `period` (s), m/s.
    pub fn step(&mut self, now: Resting, period: f64) -> f64 {
        self.now = now;
        let (off, most) = match &mut self.place {
            Place::Own { place, creep, left } if *left > 0.0 => {
                let (share, behind) = ((period / AVERAGED).min(1.0), now.measured - *place);
                *creep += share * (behind / AVERAGED - *creep);
                *place += share * behind;
                *left -= period;
                if *left <= 0.0 {
                    *creep = now.bounded(LASTING * *creep, MOST[0]);
                }
                return self.known;
            }
            Place::Own { place, .. } => (*place - now.measured, MOST[0]),
            Place::Boundary { place, sense, left } => {
                let off = *place - now.measured;
                *left = if off * *sense > 0.0 { (*left - period).max(0.0) } else { 0.0 };
                if *left > 0.0 {
                    return off / APPROACH;
                }
                (off, MOST[1])
            }
        };
        let corner = (CORNER_PER_MODE * now.slowest).min(FASTEST);
        let wanted = now.bounded(GAIN * corner * off, most);
        self.speed += (1.0 - portable::exp(-corner * period)) * (wanted - self.speed);
        let Place::Own { creep, .. } = &mut self.place else { return self.speed };
        *creep = now.bounded(*creep - LEARNING * corner * period * self.speed, SWING);
        self.known + self.speed - *creep
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: f64 = 0.01;

    fn resting(measured: f64) -> Resting {
        Resting { stroke: 0.0, observed: measured, measured, count: 0.0, tip_per_stroke: 10.0, slowest: 25.0 }
    }

    #[test]
    fn creep_is_held_where_the_piston_has_come_to() {
        let (creep, mut y) = (4e-6, 1e-4);
        let mut rest = Rest::at(resting(y), 0.0);
        let mut farthest = 0.0f64;
        for k in 0..6000 {
            let speed = rest.step(resting(y), PERIOD);
            assert!(rest.coming() == (k < 199) && (speed == 0.0 || k >= 199), "{k}");
            y += PERIOD * (creep + speed);
            farthest = if k < 200 { 0.0 } else { farthest.max(y - rest.place()) };
        }
        // Of the creep, two averages have seen a part in 2 s. Three poles p: e = b (t + p t^2) exp(-p t), the most at p t = (1 + 5^0.5)/2; at
        // first the average of the place is behind by the travel of half a second.
        let (times, most) = (COMING / AVERAGED, 0.5 * (1.0 + 5f64.sqrt()));
        let left = 1.0 - LASTING * (1.0 - (1.0 + times) * (-times).exp());
        let foreseen = left * creep * most * (1.0 + most) * (-most).exp() / (FASTEST / 3.0) + AVERAGED * creep;
        assert!((0.7..1.0).contains(&(farthest / foreseen)), "{farthest} {foreseen}");
        assert!((y - rest.place()).abs() < 1e-9 && (rest.place() - 1e-4 - COMING * creep).abs() < 3e-6, "{y}");
        assert_eq!(rest.sunk(), None);
    }

    #[test]
    fn fast_creep_that_was_observed_is_made_up_for_at_once() {
        let swing = SWING / resting(0.0).tip_per_stroke;
        for creep in [2e-3, -2e-3, 0.5 * swing] {
            let speed = Rest::at(resting(0.0), creep).step(resting(0.0), PERIOD);
            assert!((creep + speed - creep.clamp(-swing, swing)).abs() < 1e-12, "{creep} {speed}");
        }
    }

    #[test]
    fn a_mode_with_hardly_any_damping_is_not_excited() {
        let (omega, ratio) = (2.0, 2e-3);
        let mut rest = Rest::at(Resting { slowest: omega, ..resting(0.0) }, 0.0);
        rest.stay();
        // y'' = omega^2 (x - y) - 2 ratio omega y', x' = speed, in small steps.
        let (mut x, mut y, mut rate) = (0.0, 1e-5, 0.0);
        let mut largest = [0.0f64; 2];
        for k in 0..12_000 {
            let speed = rest.step(Resting { slowest: omega, ..resting(y) }, PERIOD);
            for _ in 0..100 {
                rate += 1e-4 * (omega * omega * (x - y) - 2.0 * ratio * omega * rate);
                (x, y) = (x + 1e-4 * speed, y + 1e-4 * rate);
            }
            largest[usize::from(k >= 6000)] = largest[usize::from(k >= 6000)].max(y.abs());
        }
        assert!(largest[1] < 0.9 * largest[0], "{largest:?}");
    }

    #[test]
    fn coarse_counts_are_held_at_their_boundary() {
        let (count, creep) = (3e-4, 1e-6);
        let read = |y: f64| Resting { count, ..resting((y / count).round() * count) };
        for start in [0.1e-4, 1.2e-4, -1.0e-4] {
            let mut y = start;
            let mut rest = Rest::at(Resting { observed: y, ..read(y) }, 1e-3);
            let mut reached = f64::INFINITY;
            for k in 0..60_000 {
                y += PERIOD * (creep + rest.step(read(y), PERIOD));
                if (y - rest.place()).abs() < 0.02 * count && reached.is_infinite() {
                    reached = PERIOD * f64::from(k);
                }
                assert!(PERIOD * f64::from(k) < PATIENCE || (y - rest.place()).abs() < 0.1 * count, "{k} {y}");
            }
            assert!(reached < PATIENCE && (rest.place() - start).abs() <= 0.5 * count + 1e-12);
        }
    }

    #[test]
    fn a_piston_that_is_not_held_has_sunk() {
        let mut rest = Rest::at(resting(0.0), 0.0);
        for _ in 0..300 {
            rest.step(resting(0.0), PERIOD);
        }
        rest.step(resting(-4.5e-5), PERIOD);
        assert_eq!(rest.sunk(), None);
        rest.step(resting(-5.5e-5), PERIOD);
        assert_eq!(rest.sunk(), Some(1.0));
        rest.stay();
        assert!(rest.sunk().is_none() && rest.place() == -5.5e-5);
    }
}
