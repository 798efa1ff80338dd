//! Cranes that slew.                                                       theory: docs/theory/control/tip.md
//!
//! The first joint turns about the vertical axis of the machine's frame, and all others move in one plane that it turns. With that joint
//! turned back to zero, the others alone say where in the plane the tip is: (x, z) and the angle of the slewing joint are
//! the coordinates in which tip control reckons. Forces and inertias are those of the chain in space.

use hydrocrane_num::{portable, Vec2, Vec3};
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
    /// Travel of the tip across the plane per angle of the slewing joint, m.
    pub across: f64,
}

/// The tip in the plane of the crane.
pub(crate) fn in_plane<const N: usize>(space: &SpatialMechanics<f64, N>, pose: &ChainPose<f64, N>) -> InPlane<N> {
    let pose = turned_back(space, pose);
    let tip = space.tip_position(&pose);
    let mut columns: [Vec3<f64>; N] = hydrocrane_num::array::from_fn(|j| space.column(&pose, j, tip));
    let Vec3 { x, y, .. } = core::mem::take(&mut columns[SLEW]);
    InPlane { tip: tip.in_plane(), columns: columns.map(Vec3::in_plane), across: portable::hypot(x, y) }
}

/// The `place` (x, z) in the plane of the crane, m, seen from outside: (x, y, z).
pub(crate) fn in_space<const N: usize>(
    space: &SpatialMechanics<f64, N>,
    pose: &ChainPose<f64, N>,
    [x, z]: [f64; 2],
) -> [f64; 3] {
    let aside = space.tip_position(&turned_back(space, pose)).y;
    // With the slewing joint at zero the frame of what it turns is parallel to the inertial one.
    let place = space.pose(&pose.joints).links[SLEW].point(Vec3::new(x, aside, z) - space.stances[SLEW].at);
    [place.x, place.y, place.z]
}

/// The chain with the slewing joint at zero.
fn turned_back<const N: usize>(space: &SpatialMechanics<f64, N>, pose: &ChainPose<f64, N>) -> SpatialPose<f64, N> {
    let mut joints = pose.joints;
    joints[SLEW] = JointPose { cos: 1.0, sin: 0.0, ..joints[SLEW] };
    space.pose(&joints)
}
