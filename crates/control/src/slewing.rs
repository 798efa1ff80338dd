//! Cranes that slew.                                                       theory: docs/theory/control/tip.md
//!
//! The first joint turns about the vertical axis of the machine's frame, and all others move in one plane that it turns. With that joint
//! turned back to zero, the others alone say where in the plane the tip is: (x, z) and the angle of the slewing joint are
//! the coordinates in which tip control reckons. Forces and inertias are those of the chain in space.

use crate::controller_model::{ControllerModel, Posture};
use hydrocrane_num::{portable, Real, Vec2, Vec3};
use hydrocrane_physics::dynamics::equations_of_motion::RigidChain;
use hydrocrane_physics::dynamics::spatial::SpatialMechanics;
use hydrocrane_physics::geometry::chain::ChainPose;
use hydrocrane_physics::geometry::frames::JointPose;
use hydrocrane_physics::geometry::spatial_chain::SpatialPose;

/// The joint that slews.
pub const SLEW: usize = 0;

/// What the joints make of the tip.
pub(crate) struct InPlane<const N: usize> {
    /// m
    pub tip: Vec2<f64>,
    /// Derivatives of the tip's place by the joints.
    pub columns: [Vec2<f64>; N],
    /// Way of the tip across the plane per angle of the slewing joint, m.
    pub across: f64,
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
    pub(crate) fn in_plane(&self, pose: &ChainPose<f64, N>) -> InPlane<N> {
        let Some(space) = self.slewing() else {
            let tip = self.mechanics.tip_position(pose);
            let columns = hydrocrane_num::array::from_fn(|j| self.mechanics.column(pose, j, tip));
            return InPlane { tip, columns, across: 0.0 };
        };
        let pose = turned_back(space, pose);
        let tip = space.tip_position(&pose);
        let mut columns: [Vec3<f64>; N] = hydrocrane_num::array::from_fn(|j| space.column(&pose, j, tip));
        let Vec3 { x, y, .. } = core::mem::take(&mut columns[SLEW]);
        InPlane { tip: tip.in_plane(), columns: columns.map(Vec3::in_plane), across: portable::hypot(x, y) }
    }

    /// The `place` (x, z) in the plane of the crane, m, seen from outside with the joints at `q`: (x, y, z).
    pub fn in_space(&self, [x, z]: [f64; 2], q: &[f64; N]) -> [f64; 3] {
        let Some(space) = self.slewing() else { return [x, 0.0, z] };
        let pose = self.mechanics.pose(q);
        let aside = space.tip_position(&turned_back(space, &pose)).y;
        // With the slewing joint at zero the frame of what it turns is parallel to the inertial one.
        let place = space.pose(&pose.joints).links[SLEW].point(Vec3::new(x, aside, z) - space.stances[SLEW].at);
        [place.x, place.y, place.z]
    }
}

impl<const N: usize> Posture<N> {
    /// The velocity in the plane (x, z) with that across it at this rate of the slewing joint, rad/s; m/s.
    pub fn velocity(&self, [x, z]: [f64; 2], slew: f64) -> Vec3<f64> {
        Vec3 { x, y: self.across * slew, z }
    }
}

/// The chain with the slewing joint at zero.
fn turned_back<const N: usize>(space: &SpatialMechanics<f64, N>, pose: &ChainPose<f64, N>) -> SpatialPose<f64, N> {
    let mut joints = pose.joints;
    joints[SLEW] = JointPose { cos: 1.0, sin: 0.0, ..joints[SLEW] };
    space.pose(&joints)
}
