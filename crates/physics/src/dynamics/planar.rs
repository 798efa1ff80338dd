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

impl<T: Real, const N: usize> Mechanics<T, N> {
    /// Torques that carry the chain at rest, and the slope of each over its own coordinate: turn_j perp(m) . g and -turn_j^2 m . g with
    /// the first moment m of all that the joint carries; the force at a joint that slides, and no slope.
    #[inline(always)]
    pub fn at_rest(&self, pose: &ChainPose<T, N>, payload: T) -> [[T; N]; 2] {
        let mut out = [[T::c(0.0); N]; 2];
        let mut carried = Inertia::<T, Planar>::default();
        for j in (0..N).rev() {
            carried.add(&self.inertia(pose, j, payload));
            let (turn, weight) = (pose.joints[j].turn, self.gravity * carried.mass);
            out[0][j] = turn * carried.moment.perp().dot(self.gravity) + pose.slides[j].dot(weight);
            out[1][j] = -(turn.square() * carried.moment.dot(self.gravity));
            if j > 0 {
                carried.shift(pose.links[j].origin - pose.links[j - 1].origin);
            }
        }
        out
    }
}
