//! What of the model is likely wrong where the tip leaves its path.  theory: docs/theory/control/estimate.md
//!
//! The valve gives v_found beyond what the oil gives way; r = v_found - v_model. A piston of which another force is needed than the
//! model knows lacks u = (F/k)' - w, with w for the speed that winds the oil. What is left, r + u, is held against what single errors make of it:
//!     c v_model            the flow is 1 + c times the model's
//!     -c v_model'          the valve answers later by the time c
//!     -c (F/k)'            the oil gives way 1 + c times as far under the force F
//! each alone, by least squares over the last seconds of motion, all behind the same lags. A further lag makes ways of
//! the speeds: what has become a distance is what the tip is off by.

use hydrocrane_num::{Real, Vec3};

/// Time over which ways are summed, s, and over which they count, s: a start, a stop or a turn lies within it.
const TIME: f64 = 0.5;
const MEMORY: f64 = 2.0;
/// Share of the squared distances that an error alone explains where it counts as the likely one.
const EXPLAINED: f64 = 0.5;
/// Share of its speed that the flow of a valve differs by in good order. A crane that swings on soft oil leaves its path without more.
const TOLERANCE: f64 = 0.05;

/// The single error that the model is likely to have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Likely {
    /// The flow is this many times the model's.
    Flow(f64),
    /// The valve answers later than its model by this time, s.
    Late(f64),
    /// The oil gives way this many times as far.
    Soft(f64),
    /// The cylinder needs another force.
    Force,
    /// None of them alone.
    Unknown,
}

/// How far the tip has been off its path in one motion.
#[derive(Debug, Clone, Copy, Default)]
pub struct Straying {
    /// Direction of the path; none before the set-point has moved.
    along: Vec3<f64>,
    /// m
    off: f64,
    /// Since it was off by more than it may, s.
    since: f64,
    reported: bool,
}

impl Straying {
    /// How far the tip has been off its path (m) if that was more than `most`; once, when the motion is `over` or has told for long enough of
    /// its causes. `lag`: from the tip to its set-point, m, which moves with `velocity`, m/s, if at all.
    pub fn watch(
        &mut self,
        lag: Vec3<f64>,
        velocity: Option<Vec3<f64>>,
        most: f64,
        over: bool,
        period: f64,
    ) -> Option<f64> {
        if let Some(velocity) = velocity {
            let speed = velocity.norm();
            self.along = Vec3 { x: velocity.x / speed, y: velocity.y / speed, z: velocity.z / speed };
        }
        let off = lag.cross(self.along).norm();
        if off > most {
            self.off = self.off.max(off);
        }
        self.since += if self.off > 0.0 { period } else { 0.0 };
        if self.off == 0.0 || self.reported || !(over || self.since >= MEMORY) {
            return None;
        }
        self.reported = true;
        Some(self.off)
    }
}

/// Speeds of a piston (m/s) at one sample and the travel that its oil gives, F/k (m), behind the same lags.
#[derive(Debug, Clone, Copy)]
pub struct Compared {
    pub found: f64,
    pub model: f64,
    pub compression: f64,
    pub given: f64,
}

/// What motion tells of the errors of one cylinder.
#[derive(Debug, Clone, Copy)]
pub struct ModelError {
    /// r, v_model, w and F/k behind the further lag.
    slow: [f64; 4],
    /// Shares by which that lag goes on in a period, and by which what is known is forgotten.
    share: f64,
    forgotten: f64,
    /// Means of r^2 and of (r + u)^2; of r + u times what each single error makes of it and of the square of that, m^2/s^2.
    squares: [f64; 2],
    products: [f64; 3],
    own: [f64; 3],
}

impl ModelError {
    /// Nothing known; `period` in s.
    pub fn new(period: f64) -> Self {
        ModelError {
            slow: [0.0; 4],
            share: (period / TIME).min(1.0),
            forgotten: (period / MEMORY).min(1.0),
            squares: [0.0; 2],
            products: [0.0; 3],
            own: [0.0; 3],
        }
    }

    /// Takes in a sample; `usable`: the law holds in it.
    pub fn compare(&mut self, now: &Compared, usable: bool) {
        let signals = [now.found - now.model, now.model, now.compression, now.given];
        for (slow, now) in self.slow.iter_mut().zip(signals) {
            *slow += self.share * (now - *slow);
        }
        if !usable {
            return;
        }
        let [error, model, compression, _] = self.slow;
        let growing = |i: usize| (signals[i] - self.slow[i]) / TIME;
        let left = error + growing(3) - compression;
        let towards = |mean: &mut f64, now: f64| *mean += self.forgotten * (now - *mean);
        towards(&mut self.squares[0], error.square());
        towards(&mut self.squares[1], left.square());
        for (i, makes) in [model, -growing(1), -growing(3)].into_iter().enumerate() {
            towards(&mut self.products[i], left * makes);
            towards(&mut self.own[i], makes.square());
        }
    }

    /// Mean square of the speed that the model does not explain, m^2/s^2; zero where it is within the tolerance of a valve.
    pub fn square(&self) -> f64 {
        if self.squares[0] > TOLERANCE.square() * self.own[0] {
            self.squares[0]
        } else {
            0.0
        }
    }

    /// The single error that explains most.
    pub fn likely(&self) -> Likely {
        let [all, left] = self.squares;
        if left < (1.0 - EXPLAINED) * all {
            return Likely::Force;
        }
        let (mut likely, mut most) = (Likely::Unknown, EXPLAINED * left);
        let errors: [fn(f64) -> Likely; 3] = [|c| Likely::Flow(1.0 + c), Likely::Late, |c| Likely::Soft(1.0 + c)];
        for (i, error) in errors.into_iter().enumerate() {
            let c = self.products[i] / self.own[i];
            let explained = c * self.products[i];
            if explained > most && !matches!(error(c), Likely::Late(..=0.0)) {
                (likely, most) = (error(c), explained);
            }
        }
        likely
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: f64 = 0.01;

    fn speed(t: f64) -> f64 {
        0.1 * ((1.7 * t).sin() + 0.4 * (3.1 * t).cos())
    }

    /// F/k as the model has it.
    fn travel(t: f64) -> f64 {
        2e-3 * (2.3 * t).sin()
    }

    fn slope(f: impl Fn(f64) -> f64, t: f64) -> f64 {
        (f(t + 1e-5) - f(t - 1e-5)) / 2e-5
    }

    /// What is reported of a motion with this speed of the valve, `given` of the oil and speed beyond what winds it, at each time.
    fn likely(found: impl Fn(f64) -> f64, given: impl Fn(f64) -> f64) -> Likely {
        let mut error = ModelError::new(PERIOD);
        for k in 0..300 {
            let t = PERIOD * f64::from(k);
            let now = Compared { found: found(t), model: speed(t), compression: slope(travel, t), given: given(t) };
            error.compare(&now, true);
        }
        error.likely()
    }

    #[test]
    fn each_single_error_is_named_with_its_size() {
        let near = |found: f64, size: f64| (found / size - 1.0).abs() < 0.1;
        let flow = likely(|t| 0.7 * speed(t), travel);
        assert!(matches!(flow, Likely::Flow(c) if near(c, 0.7)), "{flow:?}");
        let late = likely(|t| speed(t - 0.03), travel);
        assert!(matches!(late, Likely::Late(time) if near(time, 0.03)), "{late:?}");
        let soft = likely(|t| speed(t) - 1.5 * slope(travel, t), travel);
        assert!(matches!(soft, Likely::Soft(c) if near(c, 2.5)), "{soft:?}");
        let more = |t: f64| 5e-3 * (1.1 * t).cos();
        assert_eq!(likely(|t| speed(t) - slope(more, t), |t| travel(t) + more(t)), Likely::Force);
    }

    #[test]
    fn a_tip_beside_its_path_is_reported_once_when_its_motion_is_over() {
        let (mut straying, along) = (Straying::default(), Some(Vec3::c([0.2, 0.0, 0.0])));
        let mut watch =
            |lag: [f64; 2], over: bool| straying.watch(Vec3::c([lag[0], 0.0, lag[1]]), along, 0.01, over, PERIOD);
        assert_eq!(watch([0.5, 0.009], false), None);
        assert_eq!((watch([0.5, -0.02], false), watch([0.5, 0.0], false)), (None, None));
        assert_eq!((watch([0.0, 0.0], true), watch([0.0, 0.03], true)), (Some(0.02), None));
        let (mut going_on, long) = (Straying::default(), (2.0 / PERIOD) as usize + 2);
        let reported =
            (0..long).filter_map(|_| going_on.watch(Vec3::c([0.0, 0.0, 0.03]), along, 0.01, false, PERIOD)).count();
        assert_eq!(reported, 1);
    }

    #[test]
    fn what_no_single_error_explains_is_not_named() {
        assert_eq!(likely(|t| speed(t) + 0.05 * (9.0 * t).sin(), travel), Likely::Unknown);
        let unmoved = ModelError::new(PERIOD);
        assert_eq!(unmoved.likely(), Likely::Unknown);
    }

    #[test]
    fn a_valve_within_its_tolerance_makes_no_error() {
        let square = |gain: f64| {
            let mut error = ModelError::new(PERIOD);
            for k in 0..300 {
                let v = speed(PERIOD * f64::from(k));
                error.compare(&Compared { found: gain * v, model: v, compression: 0.0, given: 0.0 }, true);
            }
            error.square()
        };
        assert!(square(1.04) == 0.0 && square(0.93) > 0.0);
    }

    #[test]
    fn motion_in_which_the_law_does_not_hold_tells_nothing() {
        let mut error = ModelError::new(PERIOD);
        error.compare(&Compared { found: 0.1, model: 0.2, compression: 0.0, given: 0.0 }, false);
        assert_eq!((error.square(), error.likely()), (0.0, Likely::Unknown));
    }
}
