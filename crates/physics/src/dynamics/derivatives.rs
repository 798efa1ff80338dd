//! Derivatives of the forces that move the chain.          theory: docs/theory/dynamics/derivatives.md
//!
//! How Q = M q'' + b, thesis (62), changes with one coordinate or rate at given q''. Joint j turns or shifts all that it carries as one
//! body. Turned with its accelerations it needs the turned force; what is left is a uniform change c of the acceleration:
//!     by q_j:   c = perp(s_j) alpha - s_j omega^2 - t_j perp(a_j)                   rotating part t_j perp(F)
//!     by q_j':  c = 2 (omega perp(s_j) - t_j perp(v_j))                             rotating part 2 t_j perp(P)
//!
//! | symbol | meaning | unit |
//! | s_j, t_j     | slide and turn of the joint per coordinate                        | 1 |
//! | v_j, a_j     | velocity of the joint's origin; its acceleration less gravity     | m/s, m/s^2 |
//! | omega, alpha | angular rate and acceleration of the link before a sliding joint  | rad/s, rad/s^2 |
//! | F, P         | force on and momentum of all that the joint carries               | N, kg m/s |

use super::equations_of_motion::{Inertia, LinkMotion, RigidChain};
use super::space::Planar;
use super::Mechanics;
use crate::geometry::chain::ChainPose;
use hydrocrane_num::{Real, Vec2};

/// Derivatives of M q'' + b, `[row][variable]`.
#[derive(Debug, Clone, Copy)]
pub struct ForceDerivatives<T, const N: usize> {
    pub by_q: [[T; N]; N],
    pub by_qd: [[T; N]; N],
}

/// Sums over all that a joint carries, about the origin of its link.
#[derive(Clone, Copy, Default)]
struct Carried<T: Real> {
    inertia: Inertia<T, Planar>,
    /// N
    force: Vec2<T>,
    /// kg m/s
    momentum: Vec2<T>,
    /// Sum of m r . v, kg m^2/s
    moment_of_velocity: T,
}

/// A force and a torque about the origin of a link.
#[derive(Clone, Copy)]
struct Load<T> {
    force: Vec2<T>,
    torque: T,
}

impl<T: Real> Carried<T> {
    /// Load for a uniform change of all accelerations.
    #[inline(always)]
    fn under(&self, uniform: Vec2<T>) -> Load<T> {
        Load { force: uniform * self.inertia.mass, torque: self.inertia.moment.perp().dot(uniform) }
    }

    /// The same, plus the load for a turn of all velocities.
    #[inline(always)]
    fn under_turn(&self, uniform: Vec2<T>, turn: T) -> Load<T> {
        let Load { force, torque } = self.under(uniform);
        Load { force: force + self.momentum.perp() * turn, torque: torque + self.moment_of_velocity * turn }
    }
}

impl<T: Real, const N: usize> Mechanics<T, N> {
    /// Derivatives of the inverse dynamics by coordinates and rates at the accelerations `qdd`; `payload` in kg at the tip.
    #[inline(always)]
    pub fn force_derivatives(
        &self,
        pose: &ChainPose<T, N>,
        qd: &[T; N],
        qdd: &[T; N],
        payload: T,
    ) -> ForceDerivatives<T, N> {
        let motion = self.motion(pose, qd, Some(qdd));
        let velocity = pose.origin_velocities(qd);
        let carried = self.carried(pose, &motion, &velocity, payload);
        let zero = [[T::c(0.0); N]; N];
        let mut out = ForceDerivatives { by_q: zero, by_qd: zero };
        for j in 0..N {
            // A sliding joint turns as the link before it does; a turning joint has no slide.
            let LinkMotion { acceleration, rate, angular_acceleration } = motion[j];
            let (turn, slide) = (pose.joints[j].turn, pose.slides[j]);

            let uniform = slide.perp() * angular_acceleration - slide * rate.square() - acceleration.perp() * turn;
            for i in j..N {
                out.by_q[i][j] = pose.along(i, carried[i].under(uniform));
            }
            let mut load = carried[j].under(uniform);
            load.force = load.force + carried[j].force.perp() * turn;
            load.torque += slide.perp().dot(carried[j].force);
            pose.inwards(j, load, &mut out.by_q);

            let uniform = (slide.perp() * rate - velocity[j].perp() * turn) * T::c(2.0);
            let turn = turn * 2.0;
            for i in j..N {
                out.by_qd[i][j] = pose.along(i, carried[i].under_turn(uniform, turn));
            }
            pose.inwards(j, carried[j].under_turn(uniform, turn), &mut out.by_qd);
        }
        out
    }

    #[inline(always)]
    fn carried(
        &self,
        pose: &ChainPose<T, N>,
        motion: &[LinkMotion<T, Planar>; N],
        velocity: &[Vec2<T>; N],
        payload: T,
    ) -> [Carried<T>; N] {
        let mut out = [Carried::default(); N];
        let mut all = Carried::default();
        for i in (0..N).rev() {
            let own = self.inertia(pose, i, payload);
            all.inertia.add(&own);
            all.force = all.force + motion[i].force(&own, true);
            all.momentum = all.momentum + velocity[i] * own.mass + own.moment.perp() * motion[i].rate;
            all.moment_of_velocity += own.moment.dot(velocity[i]);
            out[i] = all;
            if i > 0 {
                let step = pose.links[i].origin - pose.links[i - 1].origin;
                all.inertia.shift(step);
                all.moment_of_velocity += step.dot(all.momentum);
            }
        }
        out
    }
}

impl<T: Real, const N: usize> ChainPose<T, N> {
    /// Velocities of the links' origins, m/s.
    #[inline(always)]
    fn origin_velocities(&self, qd: &[T; N]) -> [Vec2<T>; N] {
        let mut out = [Vec2::default(); N];
        let (mut velocity, mut rate, mut parent_origin) = (Vec2::default(), T::c(0.0), Vec2::default());
        for i in 0..N {
            velocity = velocity + (self.links[i].origin - parent_origin).perp() * rate + self.slides[i] * qd[i];
            rate += self.joints[i].turn * qd[i];
            parent_origin = self.links[i].origin;
            out[i] = velocity;
        }
        out
    }

    /// Generalized force of joint `i` from a load about the origin of its link.
    #[inline(always)]
    fn along(&self, i: usize, load: Load<T>) -> T {
        self.joints[i].turn * load.torque + self.slides[i].dot(load.force)
    }

    /// Writes, into column `j`, the generalized forces of the joints before `j` from a load about the origin of link `j`.
    #[inline(always)]
    fn inwards(&self, j: usize, load: Load<T>, columns: &mut [[T; N]; N]) {
        for i in 0..j {
            let lever = self.links[j].origin - self.links[i].origin;
            let torque = load.torque + lever.perp().dot(load.force);
            columns[i][j] = self.along(i, Load { torque, ..load });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::Body;
    use crate::geometry::frames::Joint;
    use hydrocrane_num::Dual;

    type Moving = Dual<f64, 8>;

    /// Sliding joints at either end and between turning ones, turns of both senses.
    fn chain() -> Mechanics<f64, 4> {
        let joint = |at, direction, sense: f64| {
            let revolute = sense != 0.0;
            Joint { at: Vec2::c(at), direction: Vec2::c(direction), offset: 0.3, zero: 0.1, sense, revolute }
        };
        let body = |mass, x, inertia| Body { mass, x, z: 0.05 - 0.1 * x, inertia };
        Mechanics {
            joints: [
                joint([0.0, 0.7], [0.0, 0.0], 1.0),
                joint([1.1, 0.2], [0.8, 0.6], 0.0),
                joint([2.3, 0.1], [0.0, 0.0], -1.0),
                joint([0.4, 0.0], [0.6, -0.8], 0.0),
            ],
            bodies: [body(120.0, 1.1, 38.0), body(80.0, 0.7, 15.0), body(60.0, 0.5, 9.0), body(25.0, 0.6, 4.0)],
            tip: Vec2::c([1.2, -0.1]),
            gravity: Vec2::c([0.0, 9.81]),
        }
    }

    #[test]
    fn derivatives_are_those_of_dual_numbers() {
        let (chain, payload) = (chain(), 70.0);
        let (q, qd, qdd) = ([0.4, 0.5, -1.1, 0.3], [0.7, -0.9, 1.3, 0.6], [-1.5, 2.0, 0.8, -0.4]);
        let lifted = chain.map(&mut |x| Moving::constant(*x));
        let moving = hydrocrane_num::array::from_fn(|i| Moving::variable(q[i], i));
        let rates = hydrocrane_num::array::from_fn(|i| Moving::variable(qd[i], 4 + i));
        let exact = lifted.inverse_dynamics(
            &lifted.pose(&moving),
            &rates,
            Some(&qdd.map(Moving::constant)),
            Moving::constant(payload),
        );
        let found = chain.force_derivatives(&chain.pose(&q), &qd, &qdd, payload);
        for i in 0..4 {
            for j in 0..4 {
                for (found, exact) in
                    [(found.by_q[i][j], exact[i].derivative[j]), (found.by_qd[i][j], exact[i].derivative[4 + j])]
                {
                    assert!((found - exact).abs() < 1e-12 * exact.abs().max(100.0), "{i} {j}: {found} {exact}");
                }
            }
        }
    }

    #[test]
    fn what_carries_the_chain_at_rest_is_its_bias_and_slope() {
        let (chain, rest, payload) = (chain(), [0.0; 4], 70.0);
        let pose = chain.pose(&[0.4, 0.5, -1.1, 0.3]);
        let bias = chain.inverse_dynamics(&pose, &rest, None, payload);
        let by_q = chain.force_derivatives(&pose, &rest, &rest, payload).by_q;
        let [torques, slopes] = chain.at_rest(&pose, payload);
        for i in 0..4 {
            assert!((torques[i] - bias[i]).abs() < 1e-9, "{i}: {} {}", torques[i], bias[i]);
            assert!((slopes[i] - by_q[i][i]).abs() < 1e-9, "{i}: {} {}", slopes[i], by_q[i][i]);
        }
    }
}
