//! Speeds allowed on the way to a limit, and what a controller accepts as input.
//!                                                            theory: docs/theory/control/reference.md
//!
//! v <= k (upper - x),   v >= -k (x - lower)
//!
//! which brings a piston to rest at its limit exponentially, with the time constant 1/k. Beyond a limit only the
//! way back is open.

use crate::interface::controller::{Fault, Goal, Measurement, Reading, Stick};
use crate::model::controller_model::{ControllerModel, Posture};

/// Lowest and highest velocity allowed at `x` between the limits, both including zero.
pub fn allowed(x: f64, [lower, upper]: [f64; 2], rate: f64) -> [f64; 2] {
    [-rate * (x - lower).max(0.0), rate * (upper - x).max(0.0)]
}

/// Joint rates allowed by joint limits, end stop zones and the pistons' own limits of speed (m/s).
pub fn joint_rates<const N: usize>(
    model: &ControllerModel<N>,
    posture: &Posture<N>,
    q: &[f64; N],
    piston: &[[f64; 2]; N],
    rate: f64,
) -> [[f64; 2]; N] {
    hydrocrane_num::array::from_fn(|i| {
        let [stop_low, stop_high] = allowed(posture.stroke[i], model.cylinders[i].free, rate);
        let (low, high) = (piston[i][0].max(stop_low), piston[i][1].min(stop_high));
        let lever_arm = posture.lever_arm[i];
        let [from, to] =
            if lever_arm > 0.0 { [low / lever_arm, high / lever_arm] } else { [high / lever_arm, low / lever_arm] };
        let [joint_low, joint_high] = allowed(q[i], model.joint_limits[i], rate);
        // At a dead centre the lever arm is zero and the quotient not a number: max and min then take the other bound.
        [joint_low.max(from), joint_high.min(to)]
    })
}

/// Readings beyond that (rad, m or Pa) come from no sensor; squares of much larger ones would overflow.
pub const LARGEST_READING: f64 = 1e12;

/// Joint coordinates and pressures as arrays; the fault names the first that is missing, not finite or beyond [`LARGEST_READING`].
pub fn checked<const N: usize>(m: &Measurement) -> Result<([f64; N], [[f64; 2]; N]), Fault> {
    let bad = |reading| Err(Fault::BadMeasurement(reading));
    if !m.t.is_finite() {
        return bad(Reading::Time);
    }
    for i in 0..N {
        if !m.q.get(i).is_some_and(|q| q.abs() <= LARGEST_READING) {
            return bad(Reading::Joint(i));
        }
        if !m.p.get(i).is_some_and(|p| p.iter().all(|p| p.abs() <= LARGEST_READING)) {
            return bad(Reading::Pressures(i));
        }
    }
    Ok((hydrocrane_num::array::from_fn(|i| m.q[i]), hydrocrane_num::array::from_fn(|i| m.p[i])))
}

/// The tip's stick inside its range: forward, up, and across for a crane that `slews`.
pub fn checked_stick(stick: Stick, slews: bool) -> Result<[f64; 3], Fault> {
    match stick {
        Stick::Tip(axes) => {
            let stick = match *axes {
                [x, z] => [x, z, 0.0],
                [x, z, across] if slews => [x, z, across],
                _ => return Err(Fault::StickAxes(axes.len(), if slews { "x, z and slew" } else { "x and z" })),
            };
            if stick.iter().all(|s| s.abs() <= 1.0) {
                Ok(stick)
            } else {
                Err(Fault::BadStick)
            }
        }
        Stick::Lever(_) | Stick::Height(_) | Stick::Goal(_) => Err(Fault::WrongStick("tip")),
    }
}

/// One lever per cylinder inside its range.
pub fn checked_levers<const N: usize>(axes: &[f64]) -> Result<[f64; N], Fault> {
    let levers = axes.try_into().ok().filter(|levers: &[f64; N]| levers.iter().all(|d| d.abs() <= 1.0));
    levers.ok_or(Fault::BadStick)
}

/// A goal in numbers that a way can be made of.
pub fn checked_goal(goal: Goal) -> Result<Goal, Fault> {
    let speeds = [goal.speed.unwrap_or(0.0), goal.share];
    if goal.place.iter().all(|r| r.is_finite()) && speeds.iter().all(|v| v.is_finite() && *v >= 0.0) {
        return Ok(goal);
    }
    Err(Fault::BadGoal(goal))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comes_to_rest_at_the_limit_and_finds_the_way_back() {
        let (limits, rate, period) = ([-0.1, 0.2], 2.0, 0.01);
        let mut x = 0.0;
        for _ in 0..1000 {
            x += allowed(x, limits, rate)[1] * period;
            assert!(x <= limits[1]);
        }
        assert!(limits[1] - x < 1e-6);
        let beyond = allowed(0.21, limits, rate);
        assert!(beyond[1] == 0.0 && beyond[0] < 0.0);
    }

    #[test]
    fn input_that_is_not_finite_or_out_of_range_is_named() {
        let p = [[1e5, f64::NAN]];
        let m = Measurement { t: 0.0, q: &[0.0], p: &p };
        assert_eq!(checked::<1>(&m), Err(Fault::BadMeasurement(Reading::Pressures(0))));
        assert_eq!(checked::<2>(&m).map(|_| ()), Err(Fault::BadMeasurement(Reading::Pressures(0))));
        let far = Measurement { q: &[-1e300], p: &[[0.0; 2]], ..m };
        assert_eq!(checked::<1>(&far), Err(Fault::BadMeasurement(Reading::Joint(0))));
        assert_eq!(checked_stick(Stick::Tip(&[0.0, f64::NAN]), false), Err(Fault::BadStick));
        assert_eq!(checked_stick(Stick::Tip(&[0.0, 0.5]), true), Ok([0.0, 0.5, 0.0]));
        assert_eq!(checked_stick(Stick::Tip(&[0.0, 0.5, 0.1]), true), Ok([0.0, 0.5, 0.1]));
        assert_eq!(checked_stick(Stick::Tip(&[0.0, 0.5, 0.1]), false), Err(Fault::StickAxes(3, "x and z")));
        assert_eq!(checked_stick(Stick::Lever(&[0.0]), false), Err(Fault::WrongStick("tip")));
    }
}
