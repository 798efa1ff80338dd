//! The plane and space, so that the equations of motion are written once.
//!
//! In the plane an angular rate, a torque and a moment of inertia are numbers, and turning links have no gyroscopic torque.

use core::ops::{Add, Mul, Sub};
use hydrocrane_num::{Real, Vec2, Vec3};

/// Vectors and what turns them.
pub trait Space<T: Real>: Copy + Default {
    /// Whether all links turn about one direction.
    const PLANAR: bool;
    /// Places, velocities, forces.
    type Vector: Copy
        + Default
        + Add<Output = Self::Vector>
        + Sub<Output = Self::Vector>
        + Mul<T, Output = Self::Vector>;
    /// Angular rates, torques.
    type Spin: Copy + Default + Add<Output = Self::Spin> + Mul<T, Output = Self::Spin>;
    /// Second moments of mass about a point.
    type Second: Copy + Default + Add<Output = Self::Second>;

    fn dot(a: Self::Vector, b: Self::Vector) -> T;
    /// The part of `b` about `a`, times `a`.
    fn about(a: Self::Spin, b: Self::Spin) -> T;
    /// Velocity of the end of `arm` that turns at the rate `spin`.
    fn turned(arm: Self::Vector, spin: Self::Spin) -> Self::Vector;
    /// Torque of `force` at the end of `arm`.
    fn torque(arm: Self::Vector, force: Self::Vector) -> Self::Spin;
    fn twice(spin: Self::Spin) -> Self::Spin;
    /// Acceleration of the end of `arm` towards its origin while it turns at the rate `spin`.
    fn centripetal(arm: Self::Vector, spin: Self::Spin) -> Self::Vector;
    /// Derivative of `spin`, fixed in a frame that turns at the rate `rate`.
    fn carried_round(spin: Self::Spin, rate: Self::Spin) -> Self::Spin;
    /// Angular momentum at the rate `spin`.
    fn momentum(second: Self::Second, spin: Self::Spin) -> Self::Spin;
    /// Second moment of a mass at the end of `arm` with the first moment `moment`.
    fn second_moment(moment: Self::Vector, arm: Self::Vector) -> Self::Second;
    /// What is added to a second moment when the first one changes by `added` as the origin moves by -`step`.
    fn shifted(step: Self::Vector, moment: Self::Vector, added: Self::Vector) -> Self::Second;
}

/// The plane of x and z.
#[derive(Debug, Clone, Copy, Default)]
pub struct Planar;
/// Space with x, y and z.
#[derive(Debug, Clone, Copy, Default)]
pub struct Spatial;

impl<T: Real> Space<T> for Planar {
    const PLANAR: bool = true;
    type Vector = Vec2<T>;
    type Spin = T;
    type Second = T;

    #[inline(always)]
    fn dot(a: Vec2<T>, b: Vec2<T>) -> T {
        a.dot(b)
    }
    #[inline(always)]
    fn about(a: T, b: T) -> T {
        a * b
    }
    #[inline(always)]
    fn turned(arm: Vec2<T>, spin: T) -> Vec2<T> {
        arm.perp() * spin
    }
    #[inline(always)]
    fn torque(arm: Vec2<T>, force: Vec2<T>) -> T {
        arm.perp().dot(force)
    }
    #[inline(always)]
    fn twice(spin: T) -> T {
        spin * 2.0
    }
    #[inline(always)]
    fn centripetal(arm: Vec2<T>, spin: T) -> Vec2<T> {
        arm * spin.square()
    }
    #[inline(always)]
    fn carried_round(_spin: T, _rate: T) -> T {
        T::c(0.0)
    }
    #[inline(always)]
    fn momentum(second: T, spin: T) -> T {
        second * spin
    }
    #[inline(always)]
    fn second_moment(moment: Vec2<T>, arm: Vec2<T>) -> T {
        moment.dot(arm)
    }
    #[inline(always)]
    fn shifted(step: Vec2<T>, moment: Vec2<T>, added: Vec2<T>) -> T {
        step.dot(moment + moment + added)
    }
}

/// A symmetric tensor of inertia, kg m^2: its elements, so that off the diagonal it has the negative products of inertia.
#[derive(Debug, Clone, Copy, Default)]
pub struct Tensor<T> {
    pub xx: T,
    pub yy: T,
    pub zz: T,
    pub xy: T,
    pub xz: T,
    pub yz: T,
}

hydrocrane_num::stored!([] Tensor<f64> { xx: f64, yy: f64, zz: f64, xy: f64, xz: f64, yz: f64 });

impl<T: Copy> Tensor<T> {
    /// The same with `f` of every number.
    pub fn map<'a, U>(&'a self, f: &mut dyn FnMut(&'a T) -> U) -> Tensor<U> {
        let Tensor { xx, yy, zz, xy, xz, yz } = self;
        Tensor { xx: f(xx), yy: f(yy), zz: f(zz), xy: f(xy), xz: f(xz), yz: f(yz) }
    }
}

impl<T: Real> Tensor<T> {
    #[inline(always)]
    pub fn times(&self, v: Vec3<T>) -> Vec3<T> {
        Vec3 {
            x: self.xx * v.x + self.xy * v.y + self.xz * v.z,
            y: self.xy * v.x + self.yy * v.y + self.yz * v.z,
            z: self.xz * v.x + self.yz * v.y + self.zz * v.z,
        }
    }

    /// (a . b) 1 - (a b^T + b a^T) / 2.
    #[inline(always)]
    fn across(a: Vec3<T>, b: Vec3<T>) -> Self {
        let (x, y, z) = (a.x * b.x, a.y * b.y, a.z * b.z);
        let mean = |first: T, second: T| -((first + second) * 0.5);
        Tensor {
            xx: y + z,
            yy: x + z,
            zz: x + y,
            xy: mean(a.x * b.y, a.y * b.x),
            xz: mean(a.x * b.z, a.z * b.x),
            yz: mean(a.y * b.z, a.z * b.y),
        }
    }

    /// The same tensor seen from the frame in which these are the `axes` of the one it is given in.
    #[inline(always)]
    pub fn turned(&self, axes: &[Vec3<T>; 3]) -> Self {
        let [x, y, z] = axes;
        // Columns of R S, then the products with the rows of R.
        let columns = [
            *x * self.xx + *y * self.xy + *z * self.xz,
            *x * self.xy + *y * self.yy + *z * self.yz,
            *x * self.xz + *y * self.yz + *z * self.zz,
        ];
        let of = |row: [T; 3], column: [T; 3]| row[0] * column[0] + row[1] * column[1] + row[2] * column[2];
        let [a, b, c] = columns;
        let rows = [[a.x, b.x, c.x], [a.y, b.y, c.y], [a.z, b.z, c.z]];
        let own = [[x.x, y.x, z.x], [x.y, y.y, z.y], [x.z, y.z, z.z]];
        Tensor {
            xx: of(rows[0], own[0]),
            yy: of(rows[1], own[1]),
            zz: of(rows[2], own[2]),
            xy: of(rows[0], own[1]),
            xz: of(rows[0], own[2]),
            yz: of(rows[1], own[2]),
        }
    }
}

impl<T: Real> Add for Tensor<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Tensor {
            xx: self.xx + o.xx,
            yy: self.yy + o.yy,
            zz: self.zz + o.zz,
            xy: self.xy + o.xy,
            xz: self.xz + o.xz,
            yz: self.yz + o.yz,
        }
    }
}

impl<T: Real> Space<T> for Spatial {
    const PLANAR: bool = false;
    type Vector = Vec3<T>;
    type Spin = Vec3<T>;
    type Second = Tensor<T>;

    #[inline(always)]
    fn dot(a: Vec3<T>, b: Vec3<T>) -> T {
        a.dot(b)
    }
    #[inline(always)]
    fn about(a: Vec3<T>, b: Vec3<T>) -> T {
        a.dot(b)
    }
    #[inline(always)]
    fn turned(arm: Vec3<T>, spin: Vec3<T>) -> Vec3<T> {
        spin.cross(arm)
    }
    #[inline(always)]
    fn torque(arm: Vec3<T>, force: Vec3<T>) -> Vec3<T> {
        arm.cross(force)
    }
    #[inline(always)]
    fn twice(spin: Vec3<T>) -> Vec3<T> {
        spin + spin
    }
    #[inline(always)]
    fn centripetal(arm: Vec3<T>, spin: Vec3<T>) -> Vec3<T> {
        spin.cross(arm.cross(spin))
    }
    #[inline(always)]
    fn carried_round(spin: Vec3<T>, rate: Vec3<T>) -> Vec3<T> {
        rate.cross(spin)
    }
    #[inline(always)]
    fn momentum(second: Tensor<T>, spin: Vec3<T>) -> Vec3<T> {
        second.times(spin)
    }
    #[inline(always)]
    fn second_moment(moment: Vec3<T>, arm: Vec3<T>) -> Tensor<T> {
        Tensor::across(moment, arm)
    }
    #[inline(always)]
    fn shifted(step: Vec3<T>, moment: Vec3<T>, added: Vec3<T>) -> Tensor<T> {
        Tensor::across(step, moment + moment + added)
    }
}
