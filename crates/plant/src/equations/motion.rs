//! The equations of motion of a plant, whose chain moves in the plane or in space.
//!
//! The pose of the joints in their own planes serves both: pistons take it, and the chain in space finds its links from it. Places and
//! velocities are (x, y, z), with y = 0 in the plane.

use crate::cylinders::in_chains::in_chains;
use crate::equations::plant::Plant;
use hydrocrane_num::{Real, Vec3};
use hydrocrane_physics::dynamics::attachment::{attach, Attachment};
use hydrocrane_physics::dynamics::derivatives::ForceDerivatives;
use hydrocrane_physics::dynamics::energy;
use hydrocrane_physics::dynamics::equations_of_motion::{Equations, RigidChain};
use hydrocrane_physics::dynamics::spatial::SpatialMechanics;
use hydrocrane_physics::geometry::chain::ChainPose;

impl<T: Real, const N: usize> Plant<T, N> {
    /// The chain in space; `None` where it moves in the plane.
    #[inline(always)]
    pub fn space(&self) -> Option<&SpatialMechanics<T, N>> {
        in_chains(self.space.as_ref())
    }

    /// The chain seen from the side, each link turned into the crane's plane: for pictures.
    pub fn side_view(&self, q: &[T; N]) -> ChainPose<T, N> {
        let mut joints = self.mechanics.pose(q).joints;
        if let Some(space) = self.space() {
            for (joint, stance) in joints.iter_mut().zip(&space.stances).filter(|(_, stance)| stance.leaves_plane) {
                (joint.cos, joint.sin, joint.origin) = (T::c(1.0), T::c(0.0), stance.at.in_plane());
            }
        }
        ChainPose::of(joints)
    }

    /// (x, z) of the tip seen from the side, m: where a crane slews, in the plane of its boom.
    pub fn tip_in_plane(&self, q: &[T; N]) -> [T; 2] {
        let tip = self.mechanics.tip_position(&self.side_view(q));
        [tip.x, tip.z]
    }

    /// Mass matrix and bias force with `payload` kg at the tip.
    #[inline(always)]
    pub fn equations(&self, pose: &ChainPose<T, N>, rates: &[T; N], payload: T) -> Equations<T, N> {
        match self.space() {
            Some(space) => T::outlined(
                #[inline(always)]
                || space.equations(&space.pose(&pose.joints), rates, payload),
            ),
            None => self.mechanics.equations(pose, rates, payload),
        }
    }

    /// Derivatives of the inverse dynamics by coordinates and rates at the accelerations `qdd`.
    #[inline(always)]
    pub fn force_derivatives(
        &self,
        pose: &ChainPose<T, N>,
        rates: &[T; N],
        qdd: &[T; N],
        payload: T,
    ) -> ForceDerivatives<T, N> {
        match self.space() {
            Some(space) => T::outlined(
                #[inline(always)]
                || space.force_derivatives(&space.pose(&pose.joints), rates, qdd, payload),
            ),
            None => self.mechanics.force_derivatives(pose, rates, qdd, payload),
        }
    }

    /// World position of the tip, m.
    #[inline(always)]
    pub fn tip_position(&self, pose: &ChainPose<T, N>) -> Vec3<T> {
        match self.space() {
            Some(space) => space.tip_position(&space.pose(&pose.joints)),
            None => Vec3::of(self.mechanics.tip_position(pose), T::c(0.0)),
        }
    }

    /// Velocity of the tip, m/s.
    pub fn tip_velocity(&self, pose: &ChainPose<T, N>, rates: &[T; N]) -> Vec3<T> {
        match self.space() {
            Some(space) => space.tip_velocity(&space.pose(&pose.joints), rates),
            None => Vec3::of(self.mechanics.tip_velocity(pose, rates), T::c(0.0)),
        }
    }

    /// Derivatives of the tip's position by the joints.
    pub fn tip_columns(&self, pose: &ChainPose<T, N>) -> [Vec3<T>; N] {
        match self.space() {
            Some(space) => {
                let pose = space.pose(&pose.joints);
                let tip = space.tip_position(&pose);
                hydrocrane_num::array::from_fn(|j| space.column(&pose, j, tip))
            }
            None => {
                let tip = self.mechanics.tip_position(pose);
                hydrocrane_num::array::from_fn(|j| Vec3::of(self.mechanics.column(pose, j, tip), T::c(0.0)))
            }
        }
    }

    /// Centres of gravity of the moving links, m.
    pub fn centres_of_gravity(&self, pose: &ChainPose<T, N>) -> [Vec3<T>; N] {
        match self.space() {
            Some(space) => {
                let pose = space.pose(&pose.joints);
                hydrocrane_num::array::from_fn(|i| pose.links[i].point(space.solids[i].centre_of_gravity))
            }
            None => hydrocrane_num::array::from_fn(|i| {
                let centre = self.mechanics.bodies[i].centre_of_gravity();
                Vec3::of(pose.links[i].point(centre), T::c(0.0))
            }),
        }
    }

    /// J
    pub fn kinetic_energy(&self, pose: &ChainPose<T, N>, rates: &[T; N], payload: T) -> T {
        match self.space() {
            Some(space) => energy::kinetic(space, &space.pose(&pose.joints), rates, payload),
            None => energy::kinetic(&self.mechanics, pose, rates, payload),
        }
    }

    /// J, zero with every mass at the height of the base frame's origin.
    pub fn potential_energy(&self, pose: &ChainPose<T, N>, payload: T) -> T {
        match self.space() {
            Some(space) => energy::potential(space, &space.pose(&pose.joints), payload),
            None => energy::potential(&self.mechanics, pose, payload),
        }
    }

    /// The tip, which moves with joint `rates` and carries `payload` kg, takes up `load` kg more that lie still.
    pub fn attach(&self, pose: &ChainPose<T, N>, rates: &[T; N], payload: T, load: T) -> Attachment<T, N> {
        match self.space() {
            Some(space) => attach(space, &space.pose(&pose.joints), rates, payload, load),
            None => attach(&self.mechanics, pose, rates, payload, load),
        }
    }
}
