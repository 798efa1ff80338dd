//! The controller model: geometry, masses and cylinder parameters with which a controller computes, never a state.

use crate::model::bristles;
use crate::model::signal_chain::SignalChain;
use crate::model::slewing::{self, InPlane, SLEW};
use crate::model::valve_answer::ValveDynamics;
use hydrocrane_num::{portable, Real, Vec3};
use hydrocrane_physics::dynamics::equations_of_motion::RigidChain;
use hydrocrane_physics::dynamics::spatial::SpatialMechanics;
use hydrocrane_physics::dynamics::Mechanics;
use hydrocrane_physics::friction::StaticParameters;
use hydrocrane_physics::geometry::chain::ChainPose;
use hydrocrane_physics::geometry::stroke::Actuation;
use hydrocrane_physics::hydraulics::chamber::Chambers;
use hydrocrane_physics::hydraulics::fluid::Fluid;
use hydrocrane_physics::hydraulics::leakage::Leakage;
use hydrocrane_physics::hydraulics::pump::Pump;
use hydrocrane_physics::hydraulics::spool_valve::SpoolValve;

/// Steps that find a joint coordinate.
const NEWTON: usize = 2;

/// One cylinder with its valve.
#[derive(Debug, Clone, Copy)]
pub struct CylinderModel {
    pub chambers: Chambers<f64>,
    pub valve: SpoolValve<f64>,
    pub leakage: Leakage<f64>,
    pub friction: StaticParameters<f64>,
    /// sigma_0, N/m; `None` for a seal without bristles.
    pub bristle_stiffness: Option<f64>,
    /// Largest spool displacement and command, m.
    pub stroke: f64,
    /// From the command to the spool.
    pub chain: SignalChain,
    /// From a command to the spool's answer.
    pub dynamics: ValveDynamics,
    /// Piston positions between which no end stop acts, m.
    pub free: [f64; 2],
    /// Highest pressure of each chamber that no relief valve at its port lets out, the other chamber at that of the tank, Pa; infinite
    /// without one.
    pub tight_to: [f64; 2],
}

/// What a controller knows of the pump.
#[derive(Debug, Clone, Copy)]
pub struct PumpModel {
    pub pump: Pump<f64>,
    /// N m; infinite where nothing limits it.
    pub torque_limit: f64,
    /// What the pump keeps at most, Pa.
    pub highest: f64,
    /// Over the highest load, Pa; `None` where the pressure does not follow the load.
    pub margin: Option<f64>,
}

/// A crane of `N` joints, each moved by the cylinder of the same index.
#[derive(Debug, Clone, Copy)]
pub struct ControllerModel<const N: usize> {
    pub mechanics: Mechanics<f64, N>,
    /// The chain in space of a crane that slews.
    pub space: Option<SpatialMechanics<f64, N>>,
    pub actuations: [Actuation<f64>; N],
    pub cylinders: [CylinderModel; N],
    pub fluid: Fluid<f64>,
    /// Pa
    pub supply: f64,
    pub tank: f64,
    /// `None`: the supply gives any flow.
    pub pump: Option<PumpModel>,
    /// kg at the tip
    pub payload: f64,
    /// rad or m
    pub joint_limits: [[f64; 2]; N],
}

hydrocrane_num::stored!([] CylinderModel {
    chambers: Chambers<f64>,
    valve: SpoolValve<f64>,
    leakage: Leakage<f64>,
    friction: StaticParameters<f64>,
    bristle_stiffness: Option<f64>,
    stroke: f64,
    chain: SignalChain,
    dynamics: ValveDynamics,
    free: [f64; 2],
    tight_to: [f64; 2],
});
hydrocrane_num::stored!([] PumpModel { pump: Pump<f64>, torque_limit: f64, highest: f64, margin: Option<f64> });
hydrocrane_num::stored!([const N: usize] ControllerModel<N> {
    mechanics: Mechanics<f64, N>,
    space: Option<SpatialMechanics<f64, N>>,
    actuations: [Actuation<f64>; N],
    cylinders: [CylinderModel; N],
    fluid: Fluid<f64>,
    supply: f64,
    tank: f64,
    pump: Option<PumpModel>,
    payload: f64,
    joint_limits: [[f64; 2]; N],
});

/// Everything geometric at one posture.
#[derive(Debug, Clone, Copy)]
pub struct Posture<const N: usize> {
    /// (x, z), m; of a crane that slews with the slewing joint turned back to zero.
    pub tip: [f64; 2],
    /// Rows x and z.
    pub jacobian: [[f64; N]; 2],
    /// Travel of the tip across the plane per angle of the slewing joint, m; zero for a crane that moves in the plane.
    pub across: f64,
    /// Piston position per cylinder, m.
    pub stroke: [f64; N],
    /// dx/dq per cylinder.
    pub lever_arm: [f64; N],
}

impl<const N: usize> Posture<N> {
    /// Travel of the tip per travel of a joint, m/rad or m/m.
    pub fn tip_per_joint(&self, joint: usize) -> f64 {
        let [x, z] = self.jacobian;
        if cfg!(feature = "chains") && joint == SLEW && self.across > 0.0 {
            self.across
        } else {
            portable::hypot(x[joint], z[joint])
        }
    }

    /// Travel of the tip per travel of a piston.
    pub fn tip_per_stroke(&self, cylinder: usize) -> f64 {
        self.tip_per_joint(cylinder) / self.lever_arm[cylinder].abs()
    }

    /// Joint coordinates where the pistons stand at `strokes` (m), near those of this posture, `q`.
    pub fn joints_at(&self, q: &[f64; N], strokes: &[f64; N]) -> [f64; N] {
        hydrocrane_num::array::from_fn(|i| {
            let turned = (strokes[i] - self.stroke[i]) / self.lever_arm[i];
            if turned.is_finite() {
                q[i] + turned
            } else {
                q[i]
            }
        })
    }

    /// The velocity in the plane (x, z) with that across it at this rate of the slewing joint, rad/s; m/s.
    pub fn velocity(&self, [x, z]: [f64; 2], slew: f64) -> Vec3<f64> {
        Vec3 { x, y: if cfg!(feature = "chains") { self.across * slew } else { 0.0 }, z }
    }

    /// Place of the tip (m) with the joints at `there`, near those of this posture, `q`.
    pub fn tip_at(&self, q: &[f64; N], there: &[f64; N]) -> [f64; 2] {
        hydrocrane_num::array::from_fn(|r| {
            self.tip[r] + (0..N).map(|i| self.jacobian[r][i] * (there[i] - q[i])).sum::<f64>()
        })
    }
}

/// Where the joints stand, with what follows of it and is asked for again and again.
#[derive(Debug, Clone, Copy)]
pub struct At<const N: usize> {
    pub q: [f64; N],
    pub pose: ChainPose<f64, N>,
    /// dx/dq per cylinder.
    pub lever_arm: [f64; N],
}

impl<const N: usize> ControllerModel<N> {
    pub fn at(&self, q: &[f64; N]) -> At<N> {
        let pose = self.mechanics.pose(q);
        At { q: *q, pose, lever_arm: hydrocrane_num::array::from_fn(|c| self.lever_arm(&pose, c)) }
    }

    pub fn tip(&self, q: &[f64; N]) -> [f64; 2] {
        let tip = self.mechanics.tip_position(&self.mechanics.pose(q));
        [tip.x, tip.z]
    }

    pub fn posture(&self, q: &[f64; N]) -> Posture<N> {
        self.posture_at(q).0
    }

    /// The posture with where the joints stand in it.
    pub fn posture_at(&self, q: &[f64; N]) -> (Posture<N>, At<N>) {
        let pose = self.mechanics.pose(q);
        let InPlane { tip, columns, across } = self.in_plane(&pose);
        let jacobian = [columns.map(|column| column.x), columns.map(|column| column.z)];
        let strokes: [(f64, f64); N] = hydrocrane_num::array::from_fn(|c| self.actuations[c].stroke(&pose.joints[c]));
        let lever_arm = strokes.map(|s| s.1);
        (
            Posture { tip: [tip.x, tip.z], jacobian, across, stroke: strokes.map(|s| s.0), lever_arm },
            At { q: *q, pose, lever_arm },
        )
    }

    /// Piston position (m) per cylinder, and dx/dq.
    pub fn strokes(&self, q: &[f64; N]) -> [(f64, f64); N] {
        hydrocrane_num::array::from_fn(|c| self.actuations[c].stroke(&self.mechanics.joints[c].pose(q[c])))
    }

    /// Coordinate of joint `c` with its piston at `stroke` (m), not far from the coordinate `near`.
    pub fn joint_near(&self, c: usize, near: f64, stroke: f64) -> f64 {
        let [low, high] = self.joint_limits[c];
        // Few steps of Newton's method find it.
        (0..NEWTON).fold(near, |q, _| {
            let (there, lever_arm) = self.actuations[c].stroke(&self.mechanics.joints[c].pose(q));
            let turned = ((stroke - there) / lever_arm).clamp(-0.1 * (high - low), 0.1 * (high - low));
            q + if turned.is_finite() { turned } else { 0.0 }
        })
    }

    /// Cylinder forces, friction left out, that carry the crane with `payload` (kg) at the joint rates `qd` held constant, N.
    pub fn cylinder_force(&self, q: &[f64; N], qd: &[f64; N], payload: f64) -> [f64; N] {
        self.cylinder_force_at(&self.at(q), qd, payload)
    }

    /// The same where the joints are known to stand so.
    pub fn cylinder_force_at(&self, at: &At<N>, qd: &[f64; N], payload: f64) -> [f64; N] {
        let bias = self.inverse_dynamics(&at.pose, qd, None, payload);
        hydrocrane_num::array::from_fn(|j| bias[j] / at.lever_arm[j])
    }

    /// dx/dq of one cylinder.
    pub fn lever_arm(&self, pose: &ChainPose<f64, N>, cylinder: usize) -> f64 {
        self.actuations[cylinder].stroke(&pose.joints[cylinder]).1
    }
}

impl<const N: usize> ControllerModel<N> {
    /// The chain in space of a crane that slews; builds for the smallest chains only leave it out.
    fn slewing(&self) -> Option<&SpatialMechanics<f64, N>> {
        self.space.as_ref().filter(|_| cfg!(feature = "chains"))
    }

    pub fn slews(&self) -> bool {
        self.slewing().is_some()
    }

    /// M(q), kg m^2, kg m, kg by the units of the joints, with `payload` kg at the tip.
    pub fn mass_matrix(&self, pose: &ChainPose<f64, N>, payload: f64) -> [[f64; N]; N] {
        match self.slewing() {
            Some(space) => f64::outlined(
                #[inline(always)]
                || space.mass_matrix(&space.pose(&pose.joints), payload),
            ),
            None => self.mechanics.mass_matrix(pose, payload),
        }
    }

    /// Torques and forces of the joints for the accelerations `qdd`; `None`: those at constant rates.
    pub fn inverse_dynamics(
        &self,
        pose: &ChainPose<f64, N>,
        qd: &[f64; N],
        qdd: Option<&[f64; N]>,
        payload: f64,
    ) -> [f64; N] {
        match self.slewing() {
            Some(space) => f64::outlined(
                #[inline(always)]
                || space.inverse_dynamics(&space.pose(&pose.joints), qd, qdd, payload),
            ),
            None => self.mechanics.inverse_dynamics(pose, qd, qdd, payload),
        }
    }

    /// Torques that carry the chain at rest, and the slope of each over its own coordinate.
    pub fn at_rest(&self, pose: &ChainPose<f64, N>, payload: f64) -> [[f64; N]; 2] {
        match self.slewing() {
            Some(space) => f64::outlined(
                #[inline(always)]
                || space.at_rest(&space.pose(&pose.joints), payload),
            ),
            None => self.mechanics.at_rest(pose, payload),
        }
    }

    /// The tip in the plane of the crane.
    fn in_plane(&self, pose: &ChainPose<f64, N>) -> InPlane<N> {
        match self.slewing() {
            Some(space) => slewing::in_plane(space, pose),
            None => {
                let tip = self.mechanics.tip_position(pose);
                let columns = hydrocrane_num::array::from_fn(|j| self.mechanics.column(pose, j, tip));
                InPlane { tip, columns, across: 0.0 }
            }
        }
    }

    /// The `place` (x, z) in the plane of the crane, m, seen from outside with the joints at `q`: (x, y, z).
    pub fn in_space(&self, place: [f64; 2], q: &[f64; N]) -> [f64; 3] {
        match self.slewing() {
            Some(space) => slewing::in_space(space, &self.mechanics.pose(q), place),
            None => [place[0], 0.0, place[1]],
        }
    }
}

impl CylinderModel {
    /// Friction of Coulomb and Stribeck after a time `period` (s) at the velocity `v`, N, where it was `before`. Bristles keep it
    /// where the piston stands; without them it depends on the velocity alone.
    pub fn dry_friction(&self, v: f64, before: f64, period: f64) -> f64 {
        let sliding = self.friction.stribeck(v);
        match self.bristle_stiffness {
            Some(stiffness) if sliding > 0.0 => bristles::after(before, v, sliding, stiffness, period),
            Some(_) => 0.0,
            None => self.steady_friction(v) - self.friction.viscous(v),
        }
    }

    /// Friction at constant velocity, N: with bristles its sign changes at zero, without them it runs smoothly through zero within
    /// the Stribeck velocity.
    pub fn steady_friction(&self, v: f64) -> f64 {
        let p = &self.friction;
        let width = if v < 0.0 { p.stribeck_velocity_retracting } else { p.stribeck_velocity_extending };
        let sense = if self.bristle_stiffness.is_some() { v.signum() } else { Real::tanh(v / width) };
        p.stribeck(v) * sense + p.viscous(v)
    }
}
