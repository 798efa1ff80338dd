//! Which place within reach is nearest to a wanted one.                    theory: docs/theory/control/reference.md
//!
//! least |place - tip(q)|   with every joint inside its limits and every piston clear of its end stops
//!
//! by damped Gauss-Newton steps that leave out joints held at a bound, from several poses.

use crate::interface::controller::PlaceName;
use crate::model::controller_model::ControllerModel;
use crate::reference::keep_out::KeepOut;
use hydrocrane_num::{array::from_fn, bisect, linear::small::solve_spd, portable};

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
const WITHIN_REACH: f64 = 1e-4;

/// Why the tip cannot go to `place` (x, z), m, with this margin to keep-out regions; `None` where it can.
pub fn refusal<const N: usize>(
    model: &ControllerModel<N>,
    keep_out: &KeepOut,
    margin: f64,
    place: [f64; 2],
) -> Option<String> {
    if !place.iter().all(|r| r.is_finite()) {
        return Some("it is not a pair of finite numbers".to_string());
    }
    let bounds = from_fn(|i| bounds(model, i));
    let nearest = |place| {
        nearest(&bounds, place, |q| {
            let posture = model.posture(q);
            (posture.tip, posture.jacobian)
        })
    };
    let found = nearest(place);
    if distance(&off(&place, &found)) > WITHIN_REACH {
        let near = PlaceName(found);
        return Some(format!("it is out of reach of the tip; the nearest place within reach is {near}"));
    }
    (keep_out.distance(place) < margin - WITHIN_REACH).then(|| {
        let free =
            keep_out.outside(place, margin).filter(|place| distance(&off(place, &nearest(*place))) <= WITHIN_REACH);
        let outside = free.map(|place| format!("; {} is far enough", PlaceName(place)));
        format!(
            "it lies in a keep-out region, or nearer to it than the margin of {:.3} m{}",
            margin,
            outside.unwrap_or_default()
        )
    })
}

/// The place within reach that is nearest to `place`, m, with joints inside `bounds` (rad or m). `tip` gives the place of the
/// tip in a pose and its Jacobian, one row for each axis.
pub fn nearest<const N: usize, const AXES: usize>(
    bounds: &[[f64; 2]; N],
    place: [f64; AXES],
    tip: impl Fn(&[f64; N]) -> ([f64; AXES], [[f64; N]; AXES]),
) -> [f64; AXES] {
    let place = place.map(|r| r.clamp(-FAR, FAR));
    let mut best = ([0.0; AXES], f64::INFINITY);
    for start in 0..STARTS.len().pow(N as u32) {
        let q = from_fn(|i| {
            let share = STARTS[start / STARTS.len().pow(i as u32) % STARTS.len()];
            bounds[i][0] + share * (bounds[i][1] - bounds[i][0])
        });
        let found = descended(bounds, q, &place, &tip);
        if found.1 < best.1 {
            best = found;
        }
        if best.1 < REACHED {
            break;
        }
    }
    best.0
}

fn off<const AXES: usize>(place: &[f64; AXES], tip: &[f64; AXES]) -> [f64; AXES] {
    from_fn(|r| place[r] - tip[r])
}

fn distance<const AXES: usize>(off: &[f64; AXES]) -> f64 {
    portable::sqrt(off.iter().map(|r| r * r).sum())
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
fn descended<const N: usize, const AXES: usize>(
    bounds: &[[f64; 2]; N],
    mut q: [f64; N],
    place: &[f64; AXES],
    tip: impl Fn(&[f64; N]) -> ([f64; AXES], [[f64; N]; AXES]),
) -> ([f64; AXES], f64) {
    let (mut reached, mut jacobian) = tip(&q);
    let mut error = off(place, &reached);
    let mut damping = DAMPING;
    for _ in 0..STEPS {
        let per_joint = |v: &[f64; AXES], i: usize| -> f64 { (0..AXES).map(|r| jacobian[r][i] * v[r]).sum() };
        let free: [bool; N] = from_fn(|i| match per_joint(&error, i) > 0.0 {
            true => q[i] < bounds[i][1],
            false => q[i] > bounds[i][0],
        });
        let mut normal: [[f64; AXES]; AXES] =
            from_fn(|a| from_fn(|b| (0..N).filter(|&i| free[i]).map(|i| jacobian[a][i] * jacobian[b][i]).sum()));
        let trace: f64 = (0..AXES).map(|a| normal[a][a]).sum();
        if trace <= 0.0 || distance(&error) < REACHED {
            break;
        }
        (0..AXES).for_each(|a| normal[a][a] += damping * trace);
        let force = solve_spd(&normal, &error);
        let next = from_fn(|i| {
            let step = if free[i] { per_joint(&force, i) } else { 0.0 };
            (q[i] + step).clamp(bounds[i][0], bounds[i][1])
        });
        let tried = tip(&next);
        let nearer = off(place, &tried.0);
        if distance(&nearer) < distance(&error) {
            (q, error, (reached, jacobian)) = (next, nearer, tried);
            damping *= EASED;
        } else {
            damping *= STIFFENED;
        }
    }
    (reached, distance(&error))
}
