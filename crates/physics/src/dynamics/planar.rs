//! The chain in the plane: x forward, z up.                           theory: docs/theory/dynamics/equations_of_motion.md

use super::equations_of_motion::{Inertia, RigidChain};
use super::space::Planar;
use super::Mechanics;
use crate::geometry::chain::ChainPose;
use hydrocrane_num::{Real, Vec2};

impl<T: Real, const N: usize> RigidChain<T, N> for Mechanics<T, N> {
    type Space = Planar;
    type Pose = ChainPose<T, N>;

    #[inline(always)]
    fn origin(pose: &ChainPose<T, N>, j: usize) -> Vec2<T> {
        pose.links[j].origin
    }
    #[inline(always)]
    fn turn(pose: &ChainPose<T, N>, j: usize) -> T {
        pose.joints[j].turn
    }
    #[inline(always)]
    fn slide(pose: &ChainPose<T, N>, j: usize) -> Vec2<T> {
        pose.slides[j]
    }
    #[inline(always)]
    fn upwards(&self) -> Vec2<T> {
        self.gravity
    }

    /// Thesis (34).
    #[inline(always)]
    fn tip_position(&self, pose: &ChainPose<T, N>) -> Vec2<T> {
        pose.links[N - 1].point(self.tip)
    }

    fn masses(&self, pose: &ChainPose<T, N>, payload: T, mut visit: impl FnMut(T, Vec2<T>)) {
        for (body, link) in self.bodies.iter().zip(&pose.links) {
            visit(body.mass, link.point(body.centre_of_gravity()));
        }
        visit(payload, self.tip_position(pose));
    }

    #[inline(always)]
    fn inertia(&self, pose: &ChainPose<T, N>, j: usize, payload: T) -> Inertia<T, Planar> {
        let body = &self.bodies[j];
        let mut local = Inertia { second: body.inertia, ..Inertia::default() };
        local.add(&Inertia::of_point(body.mass, body.centre_of_gravity()));
        if j == N - 1 {
            local.add(&Inertia::of_point(payload, self.tip));
        }
        Inertia { moment: pose.links[j].vector(local.moment), ..local }
    }
}
