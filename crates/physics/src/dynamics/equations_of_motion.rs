//! Equations of motion.                              theory: docs/theory/dynamics/equations_of_motion.md
//!
//! M(q) q'' + b(q, q') = Q,                                                      thesis (58)-(62), h = Q - b
//! M_jk = sum_i m_i J_ij . J_ik + I_i turn_j turn_k                              thesis (50), (59)
//! b_j  = sum_i m_i J_ij . (a_i + g e_z)
//!
//! with J_ij the column of the centre of gravity i for joint j and a_i its acceleration at q'' = 0.
//! Both sums are gathered from the tip inwards: mass, first and second moment of all that a joint carries give the momentum
//! at unit rate of that joint, and with it M_jk; the force and torque that move it give M q'' + b.
//! In the plane angular velocities add up, so rotation contributes nothing to b. Departs from the source:
//! gravity acts along -z (E1) and inertias are about the centre of gravity after conversion (E2).

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
        Equations { mass_matrix: self.mass_matrix(pose, payload), bias: self.forces(pose, qd, None, payload) }
    }

    /// M(q), kg m^2, kg m, kg by the units of the joints.
    #[inline(always)]
    pub fn mass_matrix(&self, pose: &ChainPose<T, N>, payload: T) -> [[T; N]; N] {
        let mut out = [[T::c(0.0); N]; N];
        let mut carried = Carried::default();
        for j in (0..N).rev() {
            let (link, body) = (&pose.links[j], &self.bodies[j]);
            carried.add(body.mass, body.inertia, link.vector(body.centre_of_gravity()));
            if j == N - 1 {
                carried.add(payload, T::c(0.0), link.vector(self.tip));
            }
            // Linear momentum at unit rate of joint j, and angular momentum about its origin.
            let (turn, slide) = (pose.joints[j].turn, pose.slides[j]);
            let momentum = carried.moment.perp() * turn + slide * carried.mass;
            let spin = carried.inertia * turn + carried.moment.perp().dot(slide);
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

    /// Generalized forces M q'' + b that move the chain so; `None`: those at q'' = 0, the bias.
    #[inline(always)]
    pub fn forces(&self, pose: &ChainPose<T, N>, qd: &[T; N], qdd: Option<&[T; N]>, payload: T) -> [T; N] {
        let motion = self.motion(pose, qd, qdd);
        let mut out = [T::c(0.0); N];
        // What moves all that a joint carries, about the origin of its link.
        let (mut force, mut torque) = (Vec2::default(), T::c(0.0));
        for j in (0..N).rev() {
            let (link, body, m) = (&pose.links[j], &self.bodies[j], &motion[j]);
            let arm = link.vector(body.centre_of_gravity());
            let pull = self.pull(m, arm, qdd.is_some()) * body.mass;
            force = force + pull;
            torque += arm.perp().dot(pull);
            if j == N - 1 {
                let arm = link.vector(self.tip);
                let pull = self.pull(m, arm, qdd.is_some()) * payload;
                force = force + pull;
                torque += arm.perp().dot(pull);
            }
            if qdd.is_some() {
                torque += body.inertia * m.turning;
            }
            out[j] = pose.joints[j].turn * torque + pose.slides[j].dot(force);
            if j > 0 {
                torque += (link.origin - pose.links[j - 1].origin).perp().dot(force);
            }
        }
        out
    }

    /// Acceleration of a point at `arm` from the origin of a link, less that of gravity, m/s^2.
    #[inline(always)]
    fn pull(&self, m: &LinkMotion<T>, arm: Vec2<T>, turning: bool) -> Vec2<T> {
        let still = m.origin - arm * m.rate.square() + Vec2::new(T::c(0.0), self.gravity);
        if turning {
            still + arm.perp() * m.turning
        } else {
            still
        }
    }

    #[inline(always)]
    fn motion(&self, pose: &ChainPose<T, N>, qd: &[T; N], qdd: Option<&[T; N]>) -> [LinkMotion<T>; N] {
        let mut out = [LinkMotion::<T>::default(); N];
        let mut parent_origin = Vec2::default();
        let mut m = out[0];
        for i in 0..N {
            let (joint, slide, r) = (&pose.joints[i], pose.slides[i], pose.links[i].origin - parent_origin);
            // Centripetal part of the parent's turning, Coriolis part of a sliding joint on a turning parent.
            m.origin = m.origin - r * m.rate.square() + slide.perp() * (m.rate * qd[i] * 2.0);
            if let Some(qdd) = qdd {
                m.origin = m.origin + r.perp() * m.turning + slide * qdd[i];
                m.turning += joint.turn * qdd[i];
            }
            m.rate += joint.turn * qd[i];
            parent_origin = pose.links[i].origin;
            out[i] = m;
        }
        out
    }
}

/// How a link moves: acceleration of its origin (m/s^2), angular rate (rad/s) and angular acceleration (rad/s^2).
#[derive(Debug, Clone, Copy, Default)]
struct LinkMotion<T> {
    origin: Vec2<T>,
    rate: T,
    turning: T,
}

/// Mass of all that a joint carries, with its moments about the origin of the joint's link.
#[derive(Default)]
struct Carried<T> {
    mass: T,
    /// kg m
    moment: Vec2<T>,
    /// kg m^2
    inertia: T,
}

impl<T: Real> Carried<T> {
    #[inline(always)]
    fn add(&mut self, mass: T, inertia: T, arm: Vec2<T>) {
        let moment = arm * mass;
        self.mass += mass;
        self.moment = self.moment + moment;
        self.inertia += inertia + moment.dot(arm);
    }

    /// Seen from an origin from which the present one is at `step`.
    #[inline(always)]
    fn shift(&mut self, step: Vec2<T>) {
        let moment = step * self.mass;
        self.inertia += step.dot(self.moment + self.moment + moment);
        self.moment = self.moment + moment;
    }
}
