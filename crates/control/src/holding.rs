//! Whether the oil between closed valves holds a joint.            theory: docs/theory/control/holding.md
//!
//! h = 1 + (d tau/d q - F dg/dq) / (k g^2),   F = tau/g
//!
//! is the stiffness of a joint held by locked oil as a share of what the oil alone would give: tau is the torque that carries
//! the crane, g = dx/dq the leverage of its cylinder, k the stiffness of its oil. Near a dead centre the leverage vanishes; where h
//! falls below zero the joint runs away though its valve is closed. Before that its natural frequency falls,
//!
//! omega^2 = h k g^2 / M,
//!
//! and a drive must correct the more gently the slower the joint swings.

use crate::controller_model::ControllerModel;
use hydrocrane_physics::geometry::chain::ChainPose;

/// The oil of one cylinder.
#[derive(Debug, Clone, Copy)]
pub struct Oil {
    /// k, N/m
    pub stiffness: f64,
    /// How many times the planned load the true one is.
    pub excess: f64,
}

/// How the oil holds a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hold {
    /// h
    pub share: f64,
    /// omega^2, 1/s^2; negative where the joint runs away.
    pub frequency: f64,
}

/// Shares h at which the reference begins to slow down and at which it stands.
const SLOWING: f64 = 0.85;
const STANDING: f64 = 0.6;
/// A gain is borne in full by joints with this many times its frequency.
const FREQUENCY_OVER_GAIN: f64 = 3.0;
/// Step of the differences, rad or m.
const STEP: f64 = 1e-5;

/// What is left of a step of the reference so that it does not lead to where the oil cannot hold a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leave {
    pub share: f64,
    /// Joint that takes most of it.
    pub joint: usize,
}

impl Hold {
    /// Share of a gain (1/s) that this joint bears.
    pub fn bearable(&self, gain: f64) -> f64 {
        (self.frequency / (FREQUENCY_OVER_GAIN * gain).powi(2)).clamp(0.0, 1.0)
    }
}

/// Stiffness of a joint, N m or N/m.
#[derive(Debug, Clone, Copy)]
struct Stiffness {
    /// k g^2, of the oil.
    oil: f64,
    /// d tau/d q - F dg/dq, of the load.
    load: f64,
}

impl Stiffness {
    /// h
    fn share(&self) -> f64 {
        let share = 1.0 + self.load / self.oil;
        // At the dead centre itself nothing holds.
        if share.is_finite() {
            share
        } else {
            f64::NEG_INFINITY
        }
    }
}

impl<const N: usize> ControllerModel<N> {
    /// How closed valves hold each joint.
    pub fn holding(&self, q: &[f64; N], oil: &[Oil; N]) -> [Hold; N] {
        let pose = self.mechanics.pose(q);
        let mass = self.mechanics.mass_matrix(&pose, self.payload);
        let stiffness = self.stiffness(&pose, q, oil);
        std::array::from_fn(|i| Hold {
            share: stiffness[i].share(),
            frequency: (stiffness[i].oil + stiffness[i].load) / (mass[i][i] * oil[i].excess),
        })
    }

    fn stiffness(&self, pose: &ChainPose<f64, N>, q: &[f64; N], oil: &[Oil; N]) -> [Stiffness; N] {
        let torque = |pose: &ChainPose<f64, N>| self.mechanics.inverse_dynamics(pose, &[0.0; N], None, self.payload);
        let load = torque(pose);
        std::array::from_fn(|i| {
            // One joint moves: the others stand as they do.
            let mut joints = pose.joints;
            joints[i] = self.mechanics.joints[i].pose(q[i] + STEP);
            let beside = ChainPose::of(joints);
            let (here, there) = (self.lever_arm(pose, i), self.lever_arm(&beside, i));
            let slope = (torque(&beside)[i] / there - load[i] / here) * there / STEP;
            Stiffness { oil: oil[i].stiffness * here.powi(2), load: oil[i].excess * slope }
        })
    }

    /// For a step of the reference from `q` to `next`.
    pub fn leave(&self, q: &[f64; N], next: &[f64; N], oil: &[Oil; N]) -> Leave {
        let mut least = Leave { share: 1.0, joint: 0 };
        let shares = |q: &[f64; N]| self.stiffness(&self.mechanics.pose(q), q, oil).map(|stiffness| stiffness.share());
        let here = shares(q);
        // Far from all dead centres nothing slows the step, wherever it leads.
        if here.iter().all(|&share| share >= SLOWING) {
            return least;
        }
        let there = shares(next);
        for joint in (0..N).filter(|&i| there[i] < here[i]) {
            let share = ((here[joint] - STANDING) / (SLOWING - STANDING)).clamp(0.0, 1.0);
            if share < least.share {
                least = Leave { share, joint };
            }
        }
        least
    }
}
