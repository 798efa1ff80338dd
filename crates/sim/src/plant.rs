//! The plant: all parameters of the laws, immutable, generic over the number type.

use crate::cylinder_unit::{CylinderUnit, Mains};
use hydrocrane_num::Real;
use hydrocrane_physics::dynamics::Mechanics;
use hydrocrane_physics::geometry::chain::ChainPose;
use hydrocrane_physics::geometry::stroke::Actuation;
use hydrocrane_physics::hydraulics::fluid::Fluid;

/// A crane of `N` joints, each moved by the cylinder of the same index.
#[derive(Debug, Clone, Copy)]
pub struct Plant<T, const N: usize> {
    pub mechanics: Mechanics<T, N>,
    pub actuations: [Actuation<T>; N],
    pub cylinders: [CylinderUnit<T>; N],
    pub fluid: Fluid<T>,
    pub mains: Mains<T>,
}

impl<const N: usize> Plant<f64, N> {
    /// The same plant with its parameters as constants of another number type.
    pub fn lift<U: Real>(&self) -> Plant<U, N> {
        Plant {
            mechanics: self.mechanics.lift(),
            actuations: self.actuations.map(|a| a.lift()),
            cylinders: self.cylinders.map(|c| c.lift()),
            fluid: self.fluid.lift(),
            mains: Mains { supply: U::c(self.mains.supply), tank: U::c(self.mains.tank) },
        }
    }
}

impl<T: Real, const N: usize> Plant<T, N> {
    /// Piston positions (m) and their derivatives with respect to the own joint's coordinate.
    pub fn strokes(&self, pose: &ChainPose<T, N>) -> [(T, T); N] {
        std::array::from_fn(|c| self.actuations[c].stroke(&pose.joints[c]))
    }

    /// Net cylinder forces that hold the crane at rest, N.
    pub fn static_force(&self, q: &[T; N], payload: T) -> [T; N] {
        let pose = self.mechanics.pose(q);
        let bias = self.mechanics.equations(&pose, &[T::c(0.0); N], payload).bias;
        let strokes = self.strokes(&pose);
        std::array::from_fn(|j| bias[j] / strokes[j].1)
    }
}
