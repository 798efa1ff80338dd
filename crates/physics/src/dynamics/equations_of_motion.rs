//! Equations of motion.                              theory: docs/theory/dynamics/equations_of_motion.md
//!
//! M(q) q'' + b(q, q') = Q,                                                      thesis (58)-(62), h = Q - b
//! M_jk = sum_i m_i J_ij . J_ik + I_i turn_j turn_k                              thesis (50), (59)
//! b_j  = sum_i m_i J_ij . (a_i + g e_z)
//!
//! with J_ij the column of the centre of gravity i for joint j and a_i its acceleration at q'' = 0.
//! In the plane angular velocities add up, so rotation contributes nothing to b. Departs from the source:
//! gravity acts along -z (E1) and inertias are about the centre of gravity after conversion (E2).

use super::Mechanics;
use crate::geometry::chain::ChainPose;
use hydrocrane_num::{Real, Vec2};

/// Mass matrix and bias force at one state.
#[derive(Debug, Clone, Copy)]
pub struct Equations<T, const N: usize> {
    /// kg m^2, kg m, kg by the units of the joints.
    pub mass_matrix: [[T; N]; N],
    /// Coriolis, centrifugal and gravity: `M q'' + bias = Q`.
    pub bias: [T; N],
}

impl<T: Real, const N: usize> Mechanics<T, N> {
    /// `payload`: kg, a point mass at the tip.
    pub fn equations(&self, pose: &ChainPose<T, N>, qd: &[T; N], payload: T) -> Equations<T, N> {
        let drift = self.accelerations_at_rest_of_rates(pose, qd);
        let zero = T::c(0.0);
        let mut mass_matrix = [[zero; N]; N];
        let mut bias = [zero; N];
        self.masses(pose, payload, |i, mass, inertia, r| {
            let (origin_acceleration, rate) = drift[i];
            let arm = r - pose.links[i].origin;
            let pull = origin_acceleration - arm * rate.square() + Vec2::new(zero, self.gravity);
            let columns: [Vec2<T>; N] = std::array::from_fn(|j| pose.column(j, r));
            for j in 0..=i {
                let momentum = columns[j] * mass;
                bias[j] += momentum.dot(pull);
                let spin = inertia * pose.joints[j].turn;
                for k in 0..=j {
                    mass_matrix[j][k] += momentum.dot(columns[k]) + spin * pose.joints[k].turn;
                }
            }
        });
        for j in 0..N {
            for k in 0..j {
                mass_matrix[k][j] = mass_matrix[j][k];
            }
        }
        Equations { mass_matrix, bias }
    }

    /// Per link: acceleration of its origin at q'' = 0 (m/s^2) and its angular rate (rad/s).
    fn accelerations_at_rest_of_rates(&self, pose: &ChainPose<T, N>, qd: &[T; N]) -> [(Vec2<T>, T); N] {
        let mut out = [(Vec2::default(), T::c(0.0)); N];
        let mut parent_origin = Vec2::default();
        let (mut a, mut rate) = out[0];
        for i in 0..N {
            let r = pose.links[i].origin - parent_origin;
            // Centripetal part of the parent's turning, Coriolis part of a sliding joint on a turning parent.
            a = a - r * rate.square() + pose.slides[i].perp() * (rate * qd[i] * 2.0);
            rate += pose.joints[i].turn * qd[i];
            parent_origin = pose.links[i].origin;
            out[i] = (a, rate);
        }
        out
    }
}
