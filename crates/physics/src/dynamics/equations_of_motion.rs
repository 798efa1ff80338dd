//! Equations of motion.                              theory: docs/theory/dynamics/equations_of_motion.md
//!
//! M(q) q'' + b(q, q') = Q,                                                      thesis (58)-(62), h = Q - b
//! M_jk = sum_i m_i J_ij . J_ik + I_i turn_j turn_k                              thesis (50), (59)
//! b_j  = sum_i m_i J_ij . (a_i + g)
//!
//! with J_ij the column of the centre of gravity i for joint j, a_i its acceleration at q'' = 0 and g the vector of gravity with the
//! opposite sign, which points upwards: along z on level ground.
//! Both sums are gathered from the tip inwards: mass, first and second moment of all that a joint carries give the momentum
//! at unit rate of that joint, and with it M_jk; the force and torque that move it give M q'' + b.
//! In the plane angular velocities add up, so rotation contributes nothing to b. Departs from the source:
//! gravity acts downwards (E1) and inertias are about the centre of gravity after conversion (E2).

use super::Mechanics;
use crate::geometry::chain::ChainPose;
use hydrocrane_num::{Real, Vec2};

/// Mass matrix and bias force at one state.
#[derive(Debug, Clone, Copy)]
pub struct Equations<T, const N: usize> {
    /// kg m^2, kg m, kg by the units of the joints.
    pub mass_matrix: [[T; N]; N],
    /// Coriolis, centrifugal and gravity: `M q'' + bias = Q`.
    pub bias: [T; N],
}

impl<T: Real, const N: usize> Mechanics<T, N> {
    /// `payload`: kg, a point mass at the tip.
    #[inline(always)]
    pub fn equations(&self, pose: &ChainPose<T, N>, qd: &[T; N], payload: T) -> Equations<T, N> {
        Equations { mass_matrix: self.mass_matrix(pose, payload), bias: self.inverse_dynamics(pose, qd, None, payload) }
    }

    /// M(q), kg m^2, kg m, kg by the units of the joints.
    #[inline(always)]
    pub fn mass_matrix(&self, pose: &ChainPose<T, N>, payload: T) -> [[T; N]; N] {
        let mut out = [[T::c(0.0); N]; N];
        let mut carried = Inertia::default();
        for j in (0..N).rev() {
            let link = &pose.links[j];
            carried.add(&self.inertia(pose, j, payload));
            // Linear momentum at unit rate of joint j, and angular momentum about its origin.
            let (turn, slide) = (pose.joints[j].turn, pose.slides[j]);
            let momentum = carried.moment.perp() * turn + slide * carried.mass;
            let spin = carried.second * turn + carried.moment.perp().dot(slide);
            for k in 0..=j {
                let lever = link.origin - pose.links[k].origin;
                out[j][k] = pose.joints[k].turn * (spin + lever.perp().dot(momentum)) + pose.slides[k].dot(momentum);
                out[k][j] = out[j][k];
            }
            if j > 0 {
                carried.shift(link.origin - pose.links[j - 1].origin);
            }
        }
        out
    }

    /// Inverse dynamics by the recursive Newton-Euler algorithm (Luh, Walker and Paul 1980): generalized forces
    /// M q'' + b for the accelerations `qdd`; `None`: those at q'' = 0, the bias.
    #[inline(always)]
    pub fn inverse_dynamics(&self, pose: &ChainPose<T, N>, qd: &[T; N], qdd: Option<&[T; N]>, payload: T) -> [T; N] {
        let motion = self.motion(pose, qd, qdd);
        let mut out = [T::c(0.0); N];
        // Force and torque on all that a joint carries, about the origin of its link.
        let (mut force, mut torque) = (Vec2::default(), T::c(0.0));
        for j in (0..N).rev() {
            let (link, own) = (&pose.links[j], self.inertia(pose, j, payload));
            force = force + motion[j].force(&own, qdd.is_some());
            torque += own.moment.perp().dot(motion[j].acceleration);
            if qdd.is_some() {
                torque += own.second * motion[j].angular_acceleration;
            }
            out[j] = pose.joints[j].turn * torque + pose.slides[j].dot(force);
            if j > 0 {
                torque += (link.origin - pose.links[j - 1].origin).perp().dot(force);
            }
        }
        out
    }

    /// Torques that carry the chain at rest, and the slope of each over its own coordinate: turn_j perp(m) . g and -turn_j^2 m . g with
    /// the first moment m of all that the joint carries; the force at a joint that slides, and no slope.
    #[inline(always)]
    pub fn at_rest(&self, pose: &ChainPose<T, N>, payload: T) -> [[T; N]; 2] {
        let mut out = [[T::c(0.0); N]; 2];
        let mut carried = Inertia::default();
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

    /// Inertia of link `j` about its origin, that of the last one with the payload at the tip.
    #[inline(always)]
    pub(super) fn inertia(&self, pose: &ChainPose<T, N>, j: usize, payload: T) -> Inertia<T> {
        let body = &self.bodies[j];
        let mut local = Inertia { second: body.inertia, ..Inertia::default() };
        local.add(&Inertia::of_point(body.mass, body.centre_of_gravity()));
        if j == N - 1 {
            local.add(&Inertia::of_point(payload, self.tip));
        }
        Inertia { moment: pose.links[j].vector(local.moment), ..local }
    }

    #[inline(always)]
    pub(super) fn motion(&self, pose: &ChainPose<T, N>, qd: &[T; N], qdd: Option<&[T; N]>) -> [LinkMotion<T>; N] {
        let mut out = [LinkMotion::<T>::default(); N];
        let mut parent_origin = Vec2::default();
        let mut m = LinkMotion { acceleration: self.gravity, ..LinkMotion::default() };
        for i in 0..N {
            let (joint, slide, r) = (&pose.joints[i], pose.slides[i], pose.links[i].origin - parent_origin);
            // Centripetal part of the parent's turning, Coriolis part of a sliding joint on a turning parent.
            m.acceleration = m.acceleration - r * m.rate.square() + slide.perp() * (m.rate * qd[i] * 2.0);
            if let Some(qdd) = qdd {
                m.acceleration = m.acceleration + r.perp() * m.angular_acceleration + slide * qdd[i];
                m.angular_acceleration += joint.turn * qdd[i];
            }
            m.rate += joint.turn * qd[i];
            parent_origin = pose.links[i].origin;
            out[i] = m;
        }
        out
    }
}

/// How a link moves: acceleration of its origin less that of gravity (m/s^2), angular rate (rad/s) and angular
/// acceleration (rad/s^2).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LinkMotion<T> {
    pub acceleration: Vec2<T>,
    pub rate: T,
    pub angular_acceleration: T,
}

impl<T: Real> LinkMotion<T> {
    /// Force that moves a link of this inertia, N; `accelerated`: with its angular acceleration.
    #[inline(always)]
    pub fn force(&self, own: &Inertia<T>, accelerated: bool) -> Vec2<T> {
        let still = self.acceleration * own.mass - own.moment * self.rate.square();
        if accelerated {
            still + own.moment.perp() * self.angular_acceleration
        } else {
            still
        }
    }
}

/// Mass of a part of the chain with its first and second moment about a point.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Inertia<T> {
    pub mass: T,
    /// kg m
    pub moment: Vec2<T>,
    /// kg m^2
    pub second: T,
}

impl<T: Real> Inertia<T> {
    #[inline(always)]
    fn of_point(mass: T, arm: Vec2<T>) -> Self {
        let moment = arm * mass;
        Inertia { mass, moment, second: moment.dot(arm) }
    }

    #[inline(always)]
    pub fn add(&mut self, other: &Self) {
        self.mass += other.mass;
        self.moment = self.moment + other.moment;
        self.second += other.second;
    }

    /// Seen from an origin from which the present one is at `step`.
    #[inline(always)]
    pub fn shift(&mut self, step: Vec2<T>) {
        let moment = step * self.mass;
        self.second += step.dot(self.moment + self.moment + moment);
        self.moment = self.moment + moment;
    }
}
