//! Four-bar torque linkage, closed form.                     theory: docs/theory/geometry/four_bar.md
//!
//! The common pin p of rocker and coupler lies on two circles,
//!     |p - t_1| = r_1,   |p - t_3| = r_2,
//! with t_1 the rocker pivot on the parent and t_3 the coupler pivot on the child. With d = t_3 - t_1:
//!     p = t_1 + a d + side h perp(d),   a = (r_1^2 - r_2^2 + |d|^2) / (2 |d|^2),   h = sqrt(r_1^2/|d|^2 - a^2)
//! This is thesis (17)-(27) without inverse trigonometry; both agree to rounding (tests/geometry.rs).
//! Differentiating the two circles gives p' = lambda perp(p - t_1) with
//!     lambda = (p - t_3).t_3' / (p - t_3).perp(p - t_1).

use super::MovingPoint;
use hydrocrane_num::{functions::smooth, Real, Vec2};

/// Rocker on the parent link, coupler to the child link.
#[derive(Debug, Clone, Copy)]
pub struct FourBar<T> {
    /// t_1 in the parent frame, m.
    pub rocker_pivot: Vec2<T>,
    /// t_3 in the child frame, m.
    pub coupler_pivot: Vec2<T>,
    pub rocker_length: T,
    pub coupler_length: T,
    /// +1: p left of the line t_1 -> t_3 (x right, z up), -1: right.
    pub side: T,
}

hydrocrane_num::stored!([] FourBar<f64> {
    rocker_pivot: Vec2<f64>,
    coupler_pivot: Vec2<f64>,
    rocker_length: f64,
    coupler_length: f64,
    side: f64,
});

impl<T: Copy> FourBar<T> {
    /// The same linkage with `f` of every number.
    pub fn map<'a, U>(&'a self, f: &mut dyn FnMut(&'a T) -> U) -> FourBar<U> {
        FourBar {
            rocker_pivot: self.rocker_pivot.map(f),
            coupler_pivot: self.coupler_pivot.map(f),
            rocker_length: f(&self.rocker_length),
            coupler_length: f(&self.coupler_length),
            side: f(&self.side),
        }
    }
}

impl FourBar<f64> {
    /// The same linkage in constants of another number type.
    pub fn lift<U: Real>(&self) -> FourBar<U> {
        self.map(&mut |number| U::c(*number))
    }
}

impl<T: Real> FourBar<T> {
    /// h^2: positive where the linkage closes, zero at its dead centres.
    #[inline(always)]
    pub fn closure(&self, coupler_pivot: Vec2<T>) -> T {
        self.projection(coupler_pivot - self.rocker_pivot).1
    }

    /// The common pin in the parent frame, given the coupler pivot there.
    #[inline(always)]
    pub fn common_pin(&self, coupler_pivot: MovingPoint<T>) -> MovingPoint<T> {
        let d = coupler_pivot.position - self.rocker_pivot;
        let (a, h2) = self.projection(d);
        // Past a dead centre the linkage is torn; the root is held just above zero so that slopes stay finite.
        let h = (smooth::positive_part(h2) + 1e-18).sqrt();
        let rocker = d * a + d.perp() * (self.side * h);
        let position = self.rocker_pivot + rocker;

        let coupler = position - coupler_pivot.position;
        let lambda = coupler.dot(coupler_pivot.rate) / coupler.dot(rocker.perp());
        MovingPoint { position, rate: rocker.perp() * lambda }
    }

    /// a and h^2: the common pin along the diagonal and across it, relative to the diagonal (18).
    #[inline(always)]
    fn projection(&self, d: Vec2<T>) -> (T, T) {
        let per_d2 = T::c(1.0) / d.dot(d);
        let rocker = self.rocker_length.square();
        let a = ((rocker - self.coupler_length.square()) * per_d2 + 1.0) * 0.5;
        (a, rocker * per_d2 - a * a)
    }
}
