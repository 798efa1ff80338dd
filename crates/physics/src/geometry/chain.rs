//! Forward kinematics of the chain.                                  theory: docs/theory/geometry/chain.md
//!
//! r = r_origin + A r_local, link by link from the base                              thesis (30)-(34)

use super::frames::{Joint, JointPose};
use hydrocrane_num::{Real, Vec2};

/// A link frame in the inertial frame.
#[derive(Debug, Clone, Copy)]
pub struct LinkPose<T> {
    pub origin: Vec2<T>,
    pub cos: T,
    pub sin: T,
}

impl<T: Real> LinkPose<T> {
    /// The base, whose frame is the inertial frame.
    #[inline(always)]
    pub fn base() -> Self {
        LinkPose { origin: Vec2::c([0.0, 0.0]), cos: T::c(1.0), sin: T::c(0.0) }
    }

    #[inline(always)]
    pub fn point(&self, local: Vec2<T>) -> Vec2<T> {
        self.origin + self.vector(local)
    }

    #[inline(always)]
    pub fn vector(&self, local: Vec2<T>) -> Vec2<T> {
        local.rotate(self.cos, self.sin)
    }

    #[inline(always)]
    fn child(&self, joint: &JointPose<T>) -> Self {
        LinkPose {
            origin: self.point(joint.origin),
            cos: self.cos * joint.cos - self.sin * joint.sin,
            sin: self.sin * joint.cos + self.cos * joint.sin,
        }
    }
}

/// The whole chain at one configuration. Index `i` is the joint `i` and the link it moves.
#[derive(Debug, Clone, Copy)]
pub struct ChainPose<T, const N: usize> {
    pub joints: [JointPose<T>; N],
    pub links: [LinkPose<T>; N],
    /// World vector of a prismatic joint's slide, zero for a revolute joint.
    pub slides: [Vec2<T>; N],
}

impl<T: Real, const N: usize> ChainPose<T, N> {
    #[inline(always)]
    pub fn new(joints: &[Joint<T>; N], q: &[T; N]) -> Self {
        let mut poses = [JointPose::default(); N];
        for i in 0..N {
            poses[i] = joints[i].pose(q[i]);
        }
        Self::of(poses)
    }

    /// The chain of joints that stand so.
    #[inline(always)]
    pub fn of(joints: [JointPose<T>; N]) -> Self {
        let mut links = [LinkPose::base(); N];
        let mut slides = [Vec2::default(); N];
        let mut parent = LinkPose::base();
        for i in 0..N {
            slides[i] = parent.vector(joints[i].slide);
            links[i] = parent.child(&joints[i]);
            parent = links[i];
        }
        ChainPose { joints, links, slides }
    }

    /// Frame of link `link` of the machine: 0 is the base, `i + 1` the link moved by joint `i`.
    pub fn link(&self, link: usize) -> LinkPose<T> {
        if link == 0 {
            LinkPose::base()
        } else {
            self.links[link - 1]
        }
    }
}
