//! Vectors and rotations in the crane's plane: x forward, z up, angles from x towards z.

use crate::Real;
use core::ops::{Add, Mul, Neg, Sub};

#[derive(Debug, Clone, Copy, Default)]
pub struct Vec2<T> {
    pub x: T,
    pub z: T,
}

impl<T: Real> Vec2<T> {
    #[inline(always)]
    pub fn new(x: T, z: T) -> Self {
        Vec2 { x, z }
    }
    #[inline(always)]
    pub fn c(p: [f64; 2]) -> Self {
        Vec2 { x: T::c(p[0]), z: T::c(p[1]) }
    }
    #[inline(always)]
    pub fn dot(self, o: Self) -> T {
        self.x * o.x + self.z * o.z
    }
    #[inline(always)]
    pub fn norm(self) -> T {
        self.dot(self).sqrt()
    }
    /// Turned by a quarter from x towards z: the derivative of a rotation with respect to its angle.
    #[inline(always)]
    pub fn perp(self) -> Self {
        Vec2 { x: -self.z, z: self.x }
    }
    /// Turned by the angle with the given cosine and sine.
    #[inline(always)]
    pub fn rotate(self, cos: T, sin: T) -> Self {
        Vec2 { x: self.x * cos - self.z * sin, z: self.x * sin + self.z * cos }
    }
}

impl<T: Copy> Vec2<T> {
    /// The same vector with `f` of both components.
    pub fn map<'a, U>(&'a self, f: &mut dyn FnMut(&'a T) -> U) -> Vec2<U> {
        Vec2 { x: f(&self.x), z: f(&self.z) }
    }
}

impl<T: Real> Add for Vec2<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Vec2 { x: self.x + o.x, z: self.z + o.z }
    }
}

impl<T: Real> Sub for Vec2<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Vec2 { x: self.x - o.x, z: self.z - o.z }
    }
}

impl<T: Real> Neg for Vec2<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Vec2 { x: -self.x, z: -self.z }
    }
}

impl<T: Real> Mul<T> for Vec2<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: T) -> Self {
        Vec2 { x: self.x * o, z: self.z * o }
    }
}
