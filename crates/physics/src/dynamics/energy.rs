//! Mechanical energy.                                              theory: docs/theory/dynamics/energy.md
//!
//! T = 1/2 q'^T M q'                              thesis (45), (50)
//! V = sum_i m_i g . r_i                          thesis (51), (52), with the sign corrected (E1); g points upwards

use super::Mechanics;
use crate::geometry::chain::ChainPose;
use hydrocrane_num::Real;

impl<T: Real, const N: usize> Mechanics<T, N> {
    /// J
    pub fn kinetic_energy(&self, pose: &ChainPose<T, N>, qd: &[T; N], payload: T) -> T {
        let m = self.equations(pose, qd, payload).mass_matrix;
        let mut twice = T::c(0.0);
        for j in 0..N {
            for k in 0..N {
                twice += qd[j] * m[j][k] * qd[k];
            }
        }
        twice * 0.5
    }

    /// J, zero with every mass at the height of the base frame's origin.
    pub fn potential_energy(&self, pose: &ChainPose<T, N>, payload: T) -> T {
        let mut energy = T::c(0.0);
        self.masses(pose, payload, |mass, r| energy += (self.gravity * mass).dot(r));
        energy
    }
}
