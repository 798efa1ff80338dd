//! Inverse kinematics of the crane tip.             theory: docs/theory/geometry/inverse_kinematics.md
//!
//! With all joints but the first two revolute ones held, the chain is two rods: r_2 from the first pivot to the
//! second, r_3 from there to the tip, and the law of cosines gives the angle between them      thesis (35)-(39)
//!     cos(theta_hat) = (r_2^2 + r_3^2 - r_diag^2) / (2 r_2 r_3),    r_diag = |tip - first pivot|
//! in both signs: elbow up and elbow down. The direction of the diagonal is atan2 over all quadrants; the thesis
//! takes an unsigned acos, right only for a tip in front of the pillar (E23).

use core::f64::consts::PI;
use hydrocrane_num::{portable, Vec2};
use hydrocrane_physics::dynamics::equations_of_motion::RigidChain;
use hydrocrane_physics::dynamics::Mechanics;

/// The thesis's choices, for reproduction; all `false`: corrected.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Printed {
    /// Fold the diagonal's direction into the half-plane in front of the pillar (E23).
    pub quadrant: bool,
    /// Carry on with the nearest tip where the target is out of reach (E24).
    pub unreachable: bool,
    /// Solve for a held extension of zero, whatever it is (E25).
    pub extension: bool,
}

hydrocrane_num::stored!([] Printed { quadrant: bool, unreachable: bool, extension: bool });

/// The chain lacks the two revolute joints that inverse kinematics solves for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("inverse kinematics needs two revolute joints; this chain has {0}")]
pub struct TooFewRevolute(pub usize);

/// All joint vectors that put the tip on `target`, inside `limits`, the one farthest from its limits first.
///
/// `held`: coordinates of the joints that are not solved for. Empty where nothing reaches.
#[cfg(feature = "std")]
pub fn solve<const N: usize>(
    mechanics: &Mechanics<f64, N>,
    limits: &[[f64; 2]; N],
    target: [f64; 2],
    held: &[f64; N],
    printed: Printed,
) -> Result<Vec<[f64; N]>, TooFewRevolute> {
    let mut solutions: Vec<[f64; N]> =
        branches(mechanics, limits, target, held, printed)?.into_iter().flatten().collect();
    // Two at most.
    let nearer = |a: &[f64; N], b: &[f64; N]| clearance(limits, a) < clearance(limits, b);
    if matches!(solutions.as_slice(), [a, b] if nearer(a, b)) {
        solutions.reverse();
    }
    Ok(solutions)
}

/// The two branches of [`solve`] without a list: elbow on the one side and on the other.
pub fn branches<const N: usize>(
    mechanics: &Mechanics<f64, N>,
    limits: &[[f64; 2]; N],
    target: [f64; 2],
    held: &[f64; N],
    printed: Printed,
) -> Result<[Option<[f64; N]>; 2], TooFewRevolute> {
    let mut revolute = (0..N).filter(|&i| mechanics.joints[i].revolute);
    let (Some(first), Some(second)) = (revolute.next(), revolute.next()) else {
        return Err(TooFewRevolute((0..N).filter(|&i| mechanics.joints[i].revolute).count()));
    };
    let mut posture = *held;
    if printed.extension {
        (0..N).filter(|&i| !mechanics.joints[i].revolute).for_each(|i| posture[i] = 0.0);
    }
    let (neutral, rods) = rods(mechanics, first, second, posture);
    let pivot = mechanics.pose(&neutral).links[first].origin;
    let reach = Vec2::c(target) - pivot;
    let Some(bend) = bend(&rods, reach.norm(), printed.unreachable) else { return Ok([None; 2]) };

    let mut direction = portable::atan2(reach.z, reach.x);
    if printed.quadrant && reach.x < 0.0 {
        direction = PI - direction;
    }
    let solution = |bend| posture_for(mechanics, limits, &neutral, (first, second), &rods, direction, bend);
    let straight = bend == 0.0 || bend == PI;
    Ok([solution(bend), if straight { None } else { solution(-bend) }])
}

/// The two rods seen from the frames of their links: length and angle.
struct Rods {
    inner: Vec2<f64>,
    outer: Vec2<f64>,
}

/// The posture with both solved joints at their zero, and the rods of the chain there.
fn rods<const N: usize>(
    mechanics: &Mechanics<f64, N>,
    first: usize,
    second: usize,
    held: [f64; N],
) -> ([f64; N], Rods) {
    let mut neutral = held;
    neutral[first] = mechanics.joints[first].zero;
    neutral[second] = mechanics.joints[second].zero;
    let pose = mechanics.pose(&neutral);
    let elbow = pose.links[second].origin;
    let inner = elbow - pose.links[first].origin;
    let outer = mechanics.tip_position(&pose) - elbow;
    (neutral, Rods { inner, outer })
}

/// Magnitude of the angle from the inner to the outer rod; `None` out of reach.
fn bend(rods: &Rods, diagonal: f64, carry_on: bool) -> Option<f64> {
    let (r2, r3) = (rods.inner.norm(), rods.outer.norm());
    let cosine = (diagonal * diagonal - r2 * r2 - r3 * r3) / (2.0 * r2 * r3);
    // Rounding at full stretch is forgiven.
    (carry_on || cosine.abs() <= 1.0 + 1e-12).then(|| portable::acos(cosine.clamp(-1.0, 1.0)))
}

fn posture_for<const N: usize>(
    mechanics: &Mechanics<f64, N>,
    limits: &[[f64; 2]; N],
    neutral: &[f64; N],
    (first, second): (usize, usize),
    rods: &Rods,
    direction: f64,
    bend: f64,
) -> Option<[f64; N]> {
    let (r2, r3) = (rods.inner.norm(), rods.outer.norm());
    let angle = |v: Vec2<f64>| portable::atan2(v.z, v.x);
    // The diagonal leans from the inner rod towards the outer one.
    let (sin, cos) = portable::sin_cos(bend);
    let lean = portable::atan2(r3 * sin, r2 + r3 * cos);
    let turn_inner = direction - lean - angle(rods.inner);
    let turn_outer = bend - (angle(rods.outer) - angle(rods.inner));
    let mut q = *neutral;
    for (joint, turn) in [(first, turn_inner), (second, turn_outer)] {
        let [low, high] = limits[joint];
        q[joint] = into_limits(neutral[joint] + turn * mechanics.joints[joint].sense, low, high)?;
    }
    let held_inside = (0..N).all(|i| q[i] >= limits[i][0] - SLACK && q[i] <= limits[i][1] + SLACK);
    held_inside.then_some(q)
}

/// Rounding allowed at a joint limit, rad or m.
const SLACK: f64 = 1e-9;

/// The angle plus whole turns that lies inside the limits.
fn into_limits(angle: f64, low: f64, high: f64) -> Option<f64> {
    let turns = portable::round((0.5 * (low + high) - angle) / (2.0 * PI));
    let inside = angle + turns * 2.0 * PI;
    (inside >= low - SLACK && inside <= high + SLACK).then_some(inside)
}

/// Smallest relative distance to a joint limit.
#[cfg(feature = "std")]
fn clearance<const N: usize>(limits: &[[f64; 2]; N], q: &[f64; N]) -> f64 {
    (0..N).map(|i| (q[i] - limits[i][0]).min(limits[i][1] - q[i]) / (limits[i][1] - limits[i][0])).fold(1.0, f64::min)
}
