//! Which place within reach is nearest to a wanted one.                    theory: docs/theory/control/point_to_point.md
//!
//! least |place - tip(q)|   with every joint inside its limits and every piston clear of its end stops
//!
//! by damped Gauss-Newton steps that leave out joints held at a bound, from several poses.

use crate::controller_model::ControllerModel;
#[cfg(feature = "std")]
use crate::{controller::PlaceName, keep_out::KeepOut};
use hydrocrane_num::{bisect, Vec2};

/// Poses along each joint to begin from, as shares of its range.
const STARTS: [f64; 3] = [0.1, 0.5, 0.9];
/// Steps from each of them.
const STEPS: usize = 60;
/// Distance that no further search is worth, m.
const REACHED: f64 = 1e-6;
/// Damping of the first step and the factor by which it changes, relative to the Jacobian.
const DAMPING: f64 = 1e-3;
const EASED: f64 = 0.2;
const STIFFENED: f64 = 5.0;
/// Whatever lies farther away is in the same direction, m: squares of larger numbers could overflow.
const FAR: f64 = 1e6;
/// Halvings that find where an end stop begins.
const HALVINGS: usize = 50;

/// Distance of a goal from the nearest place within reach that is none, m.
#[cfg(feature = "std")]
const WITHIN_REACH: f64 = 1e-4;

/// Why the tip cannot go to `place` (x, z), m, with this margin to keep-out regions; `None` where it can.
#[cfg(feature = "std")]
pub fn refusal<const N: usize>(
    model: &ControllerModel<N>,
    keep_out: &KeepOut,
    margin: f64,
    place: [f64; 2],
) -> Option<String> {
    if !place.iter().all(|r| r.is_finite()) {
        return Some("it is not a pair of finite numbers".to_string());
    }
    let off = |place: [f64; 2], nearest: [f64; 2]| (Vec2::<f64>::c(place) - Vec2::c(nearest)).norm();
    let found = nearest(model, place);
    if off(place, found) > WITHIN_REACH {
        let near = PlaceName(found);
        return Some(format!("it is out of reach of the tip; the nearest place within reach is {near}"));
    }
    (keep_out.distance(place) < margin - WITHIN_REACH).then(|| {
        let free = keep_out.outside(place, margin).filter(|place| off(*place, nearest(model, *place)) <= WITHIN_REACH);
        let outside = free.map(|place| format!("; {} is far enough", PlaceName(place)));
        format!(
            "it lies in a keep-out region, or nearer to it than the margin of {:.3} m{}",
            margin,
            outside.unwrap_or_default()
        )
    })
}

/// The place within reach nearest to `place` (x, z), m.
pub fn nearest<const N: usize>(model: &ControllerModel<N>, place: [f64; 2]) -> [f64; 2] {
    let place = place.map(|r| r.clamp(-FAR, FAR));
    let bounds: [[f64; 2]; N] = hydrocrane_num::array::from_fn(|i| bounds(model, i));
    let mut best = ([0.0; 2], f64::INFINITY);
    for start in 0..STARTS.len().pow(N as u32) {
        let q = hydrocrane_num::array::from_fn(|i| {
            let share = STARTS[start / STARTS.len().pow(i as u32) % STARTS.len()];
            bounds[i][0] + share * (bounds[i][1] - bounds[i][0])
        });
        let found = descended(model, &bounds, q, place);
        if found.1 < best.1 {
            best = found;
        }
        if best.1 < REACHED {
            break;
        }
    }
    best.0
}

/// Range of joint `i` inside its limits in which its piston is clear of the end stops.
fn bounds<const N: usize>(model: &ControllerModel<N>, i: usize) -> [f64; 2] {
    let [low, high] = model.joint_limits[i];
    let free = model.cylinders[i].free;
    let clear = |q: f64| {
        let mut pose = model.joint_limits.map(|[low, _]| low);
        pose[i] = q;
        let stroke = model.strokes(&pose)[i].0;
        free[0] <= stroke && stroke <= free[1]
    };
    let middle = 0.5 * (low + high);
    [low, high].map(|end| {
        if clear(end) || !clear(middle) {
            return end;
        }
        bisect(middle, end, HALVINGS, clear)
    })
}

/// Where the descent from `q` ends, and its distance from `place`.
fn descended<const N: usize>(
    model: &ControllerModel<N>,
    bounds: &[[f64; 2]; N],
    mut q: [f64; N],
    place: [f64; 2],
) -> ([f64; 2], f64) {
    let off = |tip: [f64; 2]| [place[0] - tip[0], place[1] - tip[1]];
    let mut posture = model.posture(&q);
    let mut distance = Vec2::<f64>::c(off(posture.tip)).norm();
    let mut damping = DAMPING;
    for _ in 0..STEPS {
        let error = off(posture.tip);
        let pull: [f64; N] =
            hydrocrane_num::array::from_fn(|i| posture.jacobian[0][i] * error[0] + posture.jacobian[1][i] * error[1]);
        let free: [bool; N] =
            hydrocrane_num::array::from_fn(|i| if pull[i] > 0.0 { q[i] < bounds[i][1] } else { q[i] > bounds[i][0] });
        let of = |a: usize, b: usize| -> f64 {
            (0..N).filter(|&i| free[i]).map(|i| posture.jacobian[a][i] * posture.jacobian[b][i]).sum()
        };
        let (xx, xz, zz) = (of(0, 0), of(0, 1), of(1, 1));
        let added = damping * (xx + zz);
        let determinant = (xx + added) * (zz + added) - xz * xz;
        if determinant <= 0.0 || distance < REACHED {
            break;
        }
        let force = [
            ((zz + added) * error[0] - xz * error[1]) / determinant,
            ((xx + added) * error[1] - xz * error[0]) / determinant,
        ];
        let next: [f64; N] = hydrocrane_num::array::from_fn(|i| {
            let step =
                if free[i] { posture.jacobian[0][i] * force[0] + posture.jacobian[1][i] * force[1] } else { 0.0 };
            (q[i] + step).clamp(bounds[i][0], bounds[i][1])
        });
        let tried = model.posture(&next);
        let nearer = Vec2::<f64>::c(off(tried.tip)).norm();
        if nearer < distance {
            (q, posture, distance) = (next, tried, nearer);
            damping *= EASED;
        } else {
            damping *= STIFFENED;
        }
    }
    (posture.tip, distance)
}
