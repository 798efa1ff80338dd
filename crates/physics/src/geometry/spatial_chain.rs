//! Forward kinematics of a chain in space.                          theory: docs/theory/geometry/spatial_chain.md
//!
//! A joint turns about an axis n of its parent or slides along a direction of it:
//!     R_child = R_parent (cos 1 + sin [n] + (1 - cos) n n^T)                        Featherstone (2008), 2.8
//!     r_child = r_parent + R_parent (at + direction (q - zero))
//!
//! Where the joint stands at zero, the frames of parent and child are parallel. Angle and sliding way are those of the joint in
//! its own plane (`frames.rs`), which also has the pins of its cylinder.

use super::frames::JointPose;
use hydrocrane_num::{Real, Vec3};

/// How a joint stands in its parent link.
#[derive(Debug, Clone, Copy)]
pub struct Stance<T> {
    /// Place of the child's origin on the parent with the joint at zero, m.
    pub at: Vec3<T>,
    /// Unit vector about which a growing angle turns.
    pub axis: Vec3<T>,
    /// Prismatic: unit vector of growing `q`; zero for a revolute joint.
    pub direction: Vec3<T>,
    /// Whether the axis is another one than that across the plane of x and z.
    pub leaves_plane: bool,
}

hydrocrane_num::stored!([] Stance<f64> {
    at: Vec3<f64>,
    axis: Vec3<f64>,
    direction: Vec3<f64>,
    leaves_plane: bool,
});

impl<T: Copy> Stance<T> {
    /// The same with `f` of every number.
    pub fn map<'a, U>(&'a self, f: &mut dyn FnMut(&'a T) -> U) -> Stance<U> {
        let leaves_plane = self.leaves_plane;
        Stance { at: self.at.map(f), axis: self.axis.map(f), direction: self.direction.map(f), leaves_plane }
    }
}

/// A link frame in the inertial frame.
#[derive(Debug, Clone, Copy)]
pub struct SpatialLink<T> {
    pub origin: Vec3<T>,
    /// Its axes x, y and z.
    pub axes: [Vec3<T>; 3],
}

impl<T: Real> SpatialLink<T> {
    /// The base, whose frame is the inertial frame.
    #[inline(always)]
    pub fn base() -> Self {
        let axes = [Vec3::c([1.0, 0.0, 0.0]), Vec3::c([0.0, 1.0, 0.0]), Vec3::c([0.0, 0.0, 1.0])];
        SpatialLink { origin: Vec3::c([0.0; 3]), axes }
    }

    #[inline(always)]
    pub fn point(&self, local: Vec3<T>) -> Vec3<T> {
        self.origin + self.vector(local)
    }

    #[inline(always)]
    pub fn vector(&self, local: Vec3<T>) -> Vec3<T> {
        self.axes[0] * local.x + self.axes[1] * local.y + self.axes[2] * local.z
    }

    #[inline(always)]
    fn child(&self, stance: &Stance<T>, joint: &JointPose<T>) -> Self {
        let origin = self.point(stance.at + stance.direction * joint.travel);
        let ([x, y, z], n) = (SpatialLink::base().axes, stance.axis);
        let axes = [self.turned(n, joint, x, n.x), self.turned(n, joint, y, n.y), self.turned(n, joint, z, n.z)];
        SpatialLink { origin, axes }
    }

    /// A `unit` vector of this frame, with the part `along` the axis `n`, turned about it by the joint.
    #[inline(always)]
    fn turned(&self, n: Vec3<T>, joint: &JointPose<T>, unit: Vec3<T>, along: T) -> Vec3<T> {
        let rest = T::c(1.0) - joint.cos;
        self.vector(unit * joint.cos + n.cross(unit) * joint.sin + n * (along * rest))
    }
}

/// The whole chain at one configuration. Index `i` is the joint `i` and the link it moves.
#[derive(Debug, Clone, Copy)]
pub struct SpatialPose<T, const N: usize> {
    pub links: [SpatialLink<T>; N],
    /// World vector of a joint's angular rate per rate of its coordinate, zero for a prismatic joint.
    pub turns: [Vec3<T>; N],
    /// World vector of a prismatic joint's slide, zero for a revolute joint.
    pub slides: [Vec3<T>; N],
}

impl<T: Real, const N: usize> SpatialPose<T, N> {
    #[inline(always)]
    pub fn new(stances: &[Stance<T>; N], joints: &[JointPose<T>; N]) -> Self {
        let mut pose =
            SpatialPose { links: [SpatialLink::base(); N], turns: [Vec3::default(); N], slides: [Vec3::default(); N] };
        let mut parent = SpatialLink::base();
        for i in 0..N {
            pose.turns[i] = parent.vector(stances[i].axis) * joints[i].turn;
            pose.slides[i] = parent.vector(stances[i].direction);
            pose.links[i] = parent.child(&stances[i], &joints[i]);
            parent = pose.links[i];
        }
        pose
    }
}
