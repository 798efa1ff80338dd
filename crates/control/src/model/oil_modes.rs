//! Natural modes of the crane on the oil between closed valves.       theory: docs/theory/control/regulate.md
//!
//! M dq'' + G^2 K dq = 0 with the mass matrix M, the lever arms G = dx/dq and the stiffness K of the oil of each cylinder. With
//! shapes Phi, Phi' M Phi = I: Phi' G^2 K Phi = diag(omega^2).

use crate::model::controller_model::{At, ControllerModel, Posture};
use crate::model::slewing::SLEW;
use hydrocrane_num::linear::symmetric::{cholesky, eigen};
use hydrocrane_num::{portable, Real};

/// Modes of a pose; the first index of a matrix is the joint, the second the mode.
#[derive(Debug, Clone, Copy)]
pub struct OilModes<const N: usize> {
    /// omega, rad/s
    pub frequency: [f64; N],
    /// Share by which bristles that hold the pistons make a mode faster.
    pub faster: [f64; N],
    /// Phi
    shapes: [[f64; N]; N],
    /// M Phi, whose transpose is the inverse of Phi.
    momenta: [[f64; N]; N],
}

impl<const N: usize> OilModes<N> {
    /// Lowest frequency above zero, rad/s; infinite where there is none.
    pub fn slowest(&self) -> f64 {
        self.frequency.iter().copied().filter(|&omega| omega > 0.0).fold(f64::INFINITY, f64::min)
    }

    /// Modal amounts of the joint motion `q`.
    pub fn of_motion(&self, q: &[f64; N]) -> [f64; N] {
        hydrocrane_num::array::from_fn(|m| (0..N).map(|i| self.momenta[i][m] * q[i]).sum())
    }

    /// Joint motion of modal amounts `s`.
    pub fn motion(&self, s: &[f64; N]) -> [f64; N] {
        hydrocrane_num::array::from_fn(|i| (0..N).map(|m| self.shapes[i][m] * s[m]).sum())
    }

    /// Modal amounts of the torques `tau`.
    pub fn of_torque(&self, tau: &[f64; N]) -> [f64; N] {
        hydrocrane_num::array::from_fn(|m| (0..N).map(|i| self.shapes[i][m] * tau[i]).sum())
    }

    /// Torques of modal amounts `s`.
    pub fn torque(&self, s: &[f64; N]) -> [f64; N] {
        hydrocrane_num::array::from_fn(|i| (0..N).map(|m| self.momenta[i][m] * s[m]).sum())
    }

    /// Of mode `m` for each joint: its amount per motion of the joint, and what it gives to itself by that joint; these sum to one.
    pub fn of_each_joint(&self, m: usize) -> ([f64; N], [f64; N]) {
        let of_motion = hydrocrane_num::array::from_fn(|i| self.momenta[i][m]);
        (of_motion, hydrocrane_num::array::from_fn(|i| self.momenta[i][m] * self.shapes[i][m]))
    }

    /// Length of the travel of the tip per modal amount.
    pub fn reach(&self, posture: &Posture<N>) -> [f64; N] {
        hydrocrane_num::array::from_fn(|m| {
            let moved = |r: usize| (0..N).map(|i| posture.jacobian[r][i] * self.shapes[i][m]).sum::<f64>();
            posture.velocity([moved(0), moved(1)], self.shapes[SLEW][m]).norm()
        })
    }
}

impl<const N: usize> ControllerModel<N> {
    /// The modes of a crane of this `mass` matrix, whose cylinders have these lever arms and oil of this `stiffness` (N/m); not finite
    /// where the mass matrix is singular.
    pub fn oil_modes(&self, mass: &[[f64; N]; N], lever_arm: &[f64; N], stiffness: &[f64; N]) -> OilModes<N> {
        let spring: [f64; N] = hydrocrane_num::array::from_fn(|i| stiffness[i] * lever_arm[i].square());
        let l = cholesky(mass);
        // L^-1, by columns of the unit matrix.
        let mut inverse = [[0.0; N]; N];
        for j in 0..N {
            for i in j..N {
                let sum: f64 = (j..i).map(|k| l[i][k] * inverse[k][j]).sum();
                inverse[i][j] = (f64::from(u8::from(i == j)) - sum) / l[i][i];
            }
        }
        let scaled = hydrocrane_num::array::from_fn(|i| {
            hydrocrane_num::array::from_fn(|j| (0..N).map(|k| inverse[i][k] * spring[k] * inverse[j][k]).sum())
        });
        let (squares, v) = eigen(scaled);
        let shapes = hydrocrane_num::array::from_fn(|i| {
            hydrocrane_num::array::from_fn(|m| (i..N).map(|k| inverse[k][i] * v[k][m]).sum())
        });
        let momenta = hydrocrane_num::array::from_fn(|i| {
            hydrocrane_num::array::from_fn(|m| (0..=i).map(|k| l[i][k] * v[k][m]).sum())
        });
        let frequency = squares.map(|square: f64| portable::sqrt(square.max(0.0)));
        let mut modes = OilModes { frequency, faster: [0.0; N], shapes, momenta };
        let bristles: [f64; N] =
            hydrocrane_num::array::from_fn(|i| self.cylinders[i].bristle_stiffness.unwrap_or(0.0) / stiffness[i]);
        modes.faster = hydrocrane_num::array::from_fn(|m| {
            // Each cylinder has its share in the energy of the oil; its bristles are a spring beside it.
            let (_, shares) = modes.of_each_joint(m);
            portable::sqrt(1.0 + (0..N).map(|i| shares[i] * bristles[i]).sum::<f64>()) - 1.0
        });
        modes
    }

    /// Mass at the tip (kg) that explains the cylinder forces (N) best, zero at least; `None` where no joint feels it.
    pub fn payload_of(&self, at: &At<N>, force: &[f64; N]) -> Option<f64> {
        let rest = [0.0; N];
        let [empty, laden] = [0.0, 1.0].map(|payload| self.inverse_dynamics(&at.pose, &rest, None, payload));
        let (mut product, mut square) = (0.0, 0.0);
        for i in 0..N {
            let own = laden[i] - empty[i];
            product += own * (at.lever_arm[i] * force[i] - empty[i]);
            square += own * own;
        }
        (square > 0.0).then(|| (product / square).max(0.0))
    }
}
