//! Mechanical energy.                                              theory: docs/theory/dynamics/energy.md
//!
//! T = 1/2 q'^T M q'                              thesis (45), (50)
//! V = sum_i m_i g . r_i                          thesis (51), (52), with the sign corrected (E1); g points upwards

use super::equations_of_motion::RigidChain;
use super::space::Space;
use hydrocrane_num::Real;

/// J
pub fn kinetic<T: Real, C: RigidChain<T, N>, const N: usize>(chain: &C, pose: &C::Pose, qd: &[T; N], payload: T) -> T {
    let m = chain.mass_matrix(pose, payload);
    let mut twice = T::c(0.0);
    for j in 0..N {
        for k in 0..N {
            twice += qd[j] * m[j][k] * qd[k];
        }
    }
    twice * 0.5
}

/// J, zero with every mass at the height of the base frame's origin.
pub fn potential<T: Real, C: RigidChain<T, N>, const N: usize>(chain: &C, pose: &C::Pose, payload: T) -> T {
    let mut energy = T::c(0.0);
    chain.masses(pose, payload, |mass, r| energy += C::Space::dot(chain.upwards() * mass, r));
    energy
}
