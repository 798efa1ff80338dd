//! Whether the oil between closed valves holds a joint.            theory: docs/theory/control/regulate.md
//!
//! h = min(1 + (d tau/d q - F dg/dq) / (k g^2), |g / (dg/dq)| / 0.16 rad),   F = tau/g
//!
//! is the stiffness of a joint held by locked oil as a share of what the oil alone would give, or less near a dead centre, where a
//! balanced load would hold a joint that no valve moves: tau is the torque that carries the crane, g = dx/dq the leverage of its
//! cylinder, k the stiffness of its oil. Near a dead centre the leverage vanishes; where h
//! falls below zero the joint runs away though its valve is closed. Before that its natural frequency falls,
//!
//! omega^2 = h k g^2 / M,
//!
//! and a drive must correct the more gently the slower the joint swings.

use crate::model::controller_model::{At, ControllerModel};
use hydrocrane_num::Real;

/// How the oil holds a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hold {
    /// h
    pub share: f64,
    /// omega^2, 1/s^2; negative where the joint runs away.
    pub frequency: f64,
    /// Sense in which the leverage of the cylinder grows, +1 or -1; zero where it stays.
    pub away: f64,
}

/// Share h at which the reference stands.
const STANDING: f64 = 0.6;
/// Rate at which a joint is taken back per share that it lacks, rad/s or m/s, and the share h below which it is.
const RETREAT: f64 = 0.6;
const RETREATING: f64 = 0.5;
/// A gain is borne in full by joints with this many times its frequency.
const FREQUENCY_OVER_GAIN: f64 = 3.0;
/// Angle to the dead centre below which h is less than 1 under any load, rad.
const HOLDING: f64 = 0.16;
/// Step of the difference that gives dg/dq, rad or m.
const STEP: f64 = 1e-5;

/// What is left of a step of the reference so that it does not lead to where the oil cannot hold a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepLimit {
    pub share: f64,
    /// Joint that takes most of it.
    pub joint: usize,
}

impl Hold {
    /// Rate at which the joint is taken away from its dead centre, rad/s or m/s: not its reference, which it no longer follows.
    pub fn retreat(&self) -> f64 {
        self.away * RETREAT * (RETREATING - self.share).clamp(0.0, RETREATING)
    }

    /// Share of a gain (1/s) that this joint bears.
    pub fn bearable(&self, gain: f64) -> f64 {
        (self.frequency / (FREQUENCY_OVER_GAIN * gain).square()).clamp(0.0, 1.0)
    }
}

/// Stiffness of a joint, N m or N/m.
#[derive(Debug, Clone, Copy)]
struct Stiffness {
    /// k g^2, of the oil.
    oil: f64,
    /// d tau/d q - F dg/dq, of the load.
    load: f64,
    away: f64,
    /// |g / (dg/dq)|: angle to the dead centre, rad; infinite for a cylinder that is the joint.
    angle: f64,
}

impl Stiffness {
    /// h
    fn share(&self) -> f64 {
        let share = 1.0 + self.load / self.oil;
        // At the dead centre itself nothing holds.
        if share.is_finite() {
            share.min(self.angle / HOLDING)
        } else {
            f64::NEG_INFINITY
        }
    }
}

impl<const N: usize> ControllerModel<N> {
    /// How closed valves hold each joint of a crane of this `mass` matrix with `payload` (kg) at the tip and oil of these stiffnesses
    /// (N/m) at the cylinders.
    pub fn holding(&self, at: &At<N>, mass: &[[f64; N]; N], payload: f64, oil: &[f64; N]) -> [Hold; N] {
        let stiffness = self.stiffness(at, payload, oil);
        hydrocrane_num::array::from_fn(|i| Hold {
            share: stiffness[i].share(),
            frequency: (stiffness[i].oil + stiffness[i].load) / mass[i][i],
            away: stiffness[i].away,
        })
    }

    /// h of each joint.
    pub fn held(&self, at: &At<N>, payload: f64, oil: &[f64; N]) -> [f64; N] {
        self.stiffness(at, payload, oil).map(|stiffness| stiffness.share())
    }

    fn stiffness(&self, at: &At<N>, payload: f64, oil: &[f64; N]) -> [Stiffness; N] {
        let [load, slopes] = self.at_rest(&at.pose, payload);
        hydrocrane_num::array::from_fn(|i| {
            let here = at.lever_arm[i];
            let there = self.actuations[i].stroke(&self.mechanics.joints[i].pose(at.q[i] + STEP)).1;
            let away = if there.abs() == here.abs() { 0.0 } else { (there.abs() - here.abs()).signum() };
            let growth = (there - here) / STEP;
            Stiffness {
                oil: oil[i] * here.square(),
                load: slopes[i] - load[i] / here * growth,
                away,
                angle: (here / growth).abs(),
            }
        })
    }

    /// For a step of the reference from where it is `at` to `next`, on which h may fall by the share `most` of its way to where the reference
    /// stands. Of the reference's h and that of the crane itself, `held`, the lower one counts: a joint that is ahead of its
    /// reference must not be led on.
    pub fn step_limit(
        &self,
        [at, next]: [&At<N>; 2],
        held: &[f64; N],
        payload: f64,
        oil: &[f64; N],
        most: f64,
    ) -> StepLimit {
        let mut least = StepLimit { share: 1.0, joint: 0 };
        let [here, there] = [at, next].map(|at| self.held(at, payload, oil));
        for joint in (0..N).filter(|&i| there[i] < here[i]) {
            let share = most * (here[joint].min(held[joint]) - STANDING).max(0.0) / (here[joint] - there[joint]);
            if share < least.share {
                least = StepLimit { share, joint };
            }
        }
        least
    }
}
