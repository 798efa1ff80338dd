//! Vectors in space: x forward, y to the left, z up. The plane of [`crate::Vec2`] is that of x and z, whose angles, from x towards z,
//! turn about -y.

use crate::{Real, Vec2};
use core::ops::{Add, Mul, Sub};

#[derive(Debug, Clone, Copy, Default)]
pub struct Vec3<T> {
    pub x: T,
    pub y: T,
    pub z: T,
}

impl<T: Real> Vec3<T> {
    #[inline(always)]
    pub fn new(x: T, y: T, z: T) -> Self {
        Vec3 { x, y, z }
    }
    #[inline(always)]
    pub fn c(p: [f64; 3]) -> Self {
        Vec3 { x: T::c(p[0]), y: T::c(p[1]), z: T::c(p[2]) }
    }
    /// The vector at distance `y` from the plane.
    #[inline(always)]
    pub fn of(plane: Vec2<T>, y: T) -> Self {
        Vec3 { x: plane.x, y, z: plane.z }
    }
    /// Its part in the plane.
    #[inline(always)]
    pub fn in_plane(self) -> Vec2<T> {
        Vec2 { x: self.x, z: self.z }
    }
    #[inline(always)]
    pub fn dot(self, o: Self) -> T {
        self.x * o.x + self.y * o.y + self.z * o.z
    }
    #[inline(always)]
    pub fn norm(self) -> T {
        self.dot(self).sqrt()
    }
    /// The velocity of the arm `o` turning at the rate `self`.
    #[inline(always)]
    pub fn cross(self, o: Self) -> Self {
        Vec3 { x: self.y * o.z - self.z * o.y, y: self.z * o.x - self.x * o.z, z: self.x * o.y - self.y * o.x }
    }
}

impl<T: Copy> Vec3<T> {
    /// The same vector with `f` of every component.
    pub fn map<'a, U>(&'a self, f: &mut dyn FnMut(&'a T) -> U) -> Vec3<U> {
        Vec3 { x: f(&self.x), y: f(&self.y), z: f(&self.z) }
    }
}

impl<T: Real> Add for Vec3<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Vec3 { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }
}

impl<T: Real> Sub for Vec3<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Vec3 { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }
}

impl<T: Real> Mul<T> for Vec3<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: T) -> Self {
        Vec3 { x: self.x * o, y: self.y * o, z: self.z * o }
    }
}
