//! Motion of the chain under forces (thesis 3.2).

pub mod attachment;
pub mod derivatives;
pub mod energy;
pub mod equations_of_motion;
pub mod ground;
pub mod planar;
pub mod space;
pub mod spatial;

use crate::geometry::chain::ChainPose;
use crate::geometry::frames::Joint;
use hydrocrane_num::{Real, Vec2};

parameters! {
    /// Inertia of one moving link.
    pub struct Body {
        /// kg
        mass,
        /// Centre of gravity in the link frame, m.
        x,
        z,
        /// About the centre of gravity, kg m^2.
        inertia,
    }
}

impl<T: Real> Body<T> {
    #[inline(always)]
    pub fn centre_of_gravity(&self) -> Vec2<T> {
        Vec2::new(self.x, self.z)
    }
}

/// The rigid chain: joints, bodies and the tip that may carry a payload.
#[derive(Debug, Clone, Copy)]
pub struct Mechanics<T, const N: usize> {
    pub joints: [Joint<T>; N],
    pub bodies: [Body<T>; N],
    /// The tip in the frame of the last link, m.
    pub tip: Vec2<T>,
    /// Acceleration at which free fall is at rest, m/s^2: gravity with the opposite sign, (0, g) on level ground. That of the printed
    /// program points downwards (E1).
    pub gravity: Vec2<T>,
}

hydrocrane_num::stored!([const N: usize] Mechanics<f64, N> {
    joints: [Joint<f64>; N],
    bodies: [Body<f64>; N],
    tip: Vec2<f64>,
    gravity: Vec2<f64>,
});

impl<T: Copy, const N: usize> Mechanics<T, N> {
    /// The same chain with `f` of every number.
    pub fn map<'a, U>(&'a self, f: &mut dyn FnMut(&'a T) -> U) -> Mechanics<U, N> {
        Mechanics {
            joints: self.joints.each_ref().map(|j| j.map(f)),
            bodies: self.bodies.each_ref().map(|b| b.map(f)),
            tip: self.tip.map(f),
            gravity: self.gravity.map(f),
        }
    }
}

impl<T: Real, const N: usize> Mechanics<T, N> {
    #[inline(always)]
    pub fn pose(&self, q: &[T; N]) -> ChainPose<T, N> {
        ChainPose::new(&self.joints, q)
    }
}
