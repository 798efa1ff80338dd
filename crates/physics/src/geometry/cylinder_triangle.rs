//! A cylinder between two pins.                      theory: docs/theory/geometry/cylinder_triangle.md
//!
//! length^2 = |r_moving - r_fixed|^2 + aside^2, the law of cosines of the triangle joint - pin - pin      thesis (9), (12)
//! d length / dq = u . d r_moving / dq, with u the unit vector from the fixed to the moving pin
//!
//! slope = atan2(u_z, u_x)                                                                   thesis (15), (28)
//!
//! The thesis builds its cylinder frames (13), (16), (29) on the slope angles; forces here need only u itself.

use super::MovingPoint;
use hydrocrane_num::{portable, Real, Vec2, Vec3};

/// Pin-to-pin length (m) and its derivative with respect to the joint coordinate; the pins lie `aside` of each other, m, along the axis.
#[inline(always)]
pub fn pin_distance<T: Real>(fixed: Vec2<T>, moving: MovingPoint<T>, aside: T) -> (T, T) {
    let d = moving.position - fixed;
    let between = Vec3::of(d, aside);
    let length = between.norm();
    // The root and the quotient do not wait for each other.
    (length, d.dot(moving.rate) / between.dot(between) * length)
}

/// Direction from one pin to the other, rad from x towards z.
pub fn slope_angle(from: Vec2<f64>, to: Vec2<f64>) -> f64 {
    let d = to - from;
    portable::atan2(d.z, d.x)
}

/// Angle at the joint between the two pins, from the two arms and the cylinder length: psi_0 of thesis (9).
/// `None` where no such triangle exists.
pub fn included_angle(arm_a: f64, arm_b: f64, length: f64) -> Option<f64> {
    let cosine = (arm_a * arm_a + arm_b * arm_b - length * length) / (2.0 * arm_a * arm_b);
    (cosine.abs() <= 1.0).then(|| portable::acos(cosine))
}
