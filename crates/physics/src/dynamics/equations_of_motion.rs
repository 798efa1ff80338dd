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
//! Written once for the plane and for space (`space.rs`). In the plane angular velocities add up, so rotation contributes nothing to b;
//! in space turning joints carry each other round, and turning links have gyroscopic torques. Departs from the source:
//! gravity acts downwards (E1) and inertias are about the centre of gravity after conversion (E2).

use super::space::Space;
use hydrocrane_num::Real;

/// Mass matrix and bias force at one state.
#[derive(Debug, Clone, Copy)]
pub struct Equations<T, const N: usize> {
    /// kg m^2, kg m, kg by the units of the joints.
    pub mass_matrix: [[T; N]; N],
    /// Coriolis, centrifugal and gravity: `M q'' + bias = Q`.
    pub bias: [T; N],
}

/// A chain of rigid links at a pose.
pub trait RigidChain<T: Real, const N: usize> {
    type Space: Space<T>;
    type Pose;

    /// Origin of link `j`, m.
    fn origin(pose: &Self::Pose, j: usize) -> Vector<T, Self::Space>;
    /// Angular rate and velocity that a unit rate of joint `j` gives to all it carries; one of them is zero.
    fn turn(pose: &Self::Pose, j: usize) -> Spin<T, Self::Space>;
    fn slide(pose: &Self::Pose, j: usize) -> Vector<T, Self::Space>;
    /// Acceleration at which free fall is at rest, m/s^2.
    fn upwards(&self) -> Vector<T, Self::Space>;
    /// Place of the tip, m.
    fn tip_position(&self, pose: &Self::Pose) -> Vector<T, Self::Space>;
    /// Masses of the chain with their places, payload last.
    fn masses(&self, pose: &Self::Pose, payload: T, visit: impl FnMut(T, Vector<T, Self::Space>));
    /// Inertia of link `j` about its origin, that of the last one with the payload at the tip.
    fn inertia(&self, pose: &Self::Pose, j: usize, payload: T) -> Inertia<T, Self::Space>;

    /// `payload`: kg, a point mass at the tip.
    #[inline(always)]
    fn equations(&self, pose: &Self::Pose, qd: &[T; N], payload: T) -> Equations<T, N> {
        Equations { mass_matrix: self.mass_matrix(pose, payload), bias: self.inverse_dynamics(pose, qd, None, payload) }
    }

    /// M(q), kg m^2, kg m, kg by the units of the joints.
    #[inline(always)]
    fn mass_matrix(&self, pose: &Self::Pose, payload: T) -> [[T; N]; N] {
        let mut out = [[T::c(0.0); N]; N];
        let mut carried = Inertia::<T, Self::Space>::default();
        for j in (0..N).rev() {
            let origin = Self::origin(pose, j);
            carried.add(&self.inertia(pose, j, payload));
            // Linear momentum at unit rate of joint j, and angular momentum about its origin.
            let (turn, slide) = (Self::turn(pose, j), Self::slide(pose, j));
            let momentum = Self::Space::turned(carried.moment, turn) + slide * carried.mass;
            let spin = Self::Space::momentum(carried.second, turn) + Self::Space::torque(carried.moment, slide);
            for k in 0..=j {
                let lever = origin - Self::origin(pose, k);
                out[j][k] = Self::Space::about(Self::turn(pose, k), spin + Self::Space::torque(lever, momentum))
                    + Self::Space::dot(Self::slide(pose, k), momentum);
                out[k][j] = out[j][k];
            }
            if j > 0 {
                carried.shift(origin - Self::origin(pose, j - 1));
            }
        }
        out
    }

    /// Inverse dynamics by the recursive Newton-Euler algorithm (Luh, Walker and Paul 1980): generalized forces
    /// M q'' + b for the accelerations `qdd`; `None`: those at q'' = 0, the bias.
    #[inline(always)]
    fn inverse_dynamics(&self, pose: &Self::Pose, qd: &[T; N], qdd: Option<&[T; N]>, payload: T) -> [T; N] {
        let motion = self.motion(pose, qd, qdd);
        let turning = qdd.is_some() || !Self::Space::PLANAR;
        let mut out = [T::c(0.0); N];
        // Force and torque on all that a joint carries, about the origin of its link.
        let (mut force, mut torque) = (Vector::<T, Self::Space>::default(), Spin::<T, Self::Space>::default());
        for j in (0..N).rev() {
            let (own, m) = (self.inertia(pose, j, payload), &motion[j]);
            force = force + m.force(&own, turning);
            torque = torque + Self::Space::torque(own.moment, m.acceleration);
            if turning {
                torque = torque + Self::Space::momentum(own.second, m.angular_acceleration);
            }
            if !Self::Space::PLANAR {
                let momentum = Self::Space::momentum(own.second, m.rate);
                torque = torque + Self::Space::carried_round(momentum, m.rate);
            }
            out[j] = Self::Space::about(Self::turn(pose, j), torque) + Self::Space::dot(Self::slide(pose, j), force);
            if j > 0 {
                torque = torque + Self::Space::torque(Self::origin(pose, j) - Self::origin(pose, j - 1), force);
            }
        }
        out
    }

    /// Torques that carry the chain at rest, and the slope of each over its own coordinate: t_j . (m x g) and t_j . ((t_j x m) x g) with
    /// the turn t_j of the joint and the first moment m of all that it carries; the force at a joint that slides, and no slope.
    #[inline(always)]
    fn at_rest(&self, pose: &Self::Pose, payload: T) -> [[T; N]; 2] {
        let (mut out, gravity) = ([[T::c(0.0); N]; 2], self.upwards());
        let mut carried = Inertia::<T, Self::Space>::default();
        for j in (0..N).rev() {
            carried.add(&self.inertia(pose, j, payload));
            let (turn, weight) = (Self::turn(pose, j), gravity * carried.mass);
            let about = |moment| Self::Space::about(turn, Self::Space::torque(moment, gravity));
            out[0][j] = about(carried.moment) + Self::Space::dot(Self::slide(pose, j), weight);
            out[1][j] = about(Self::Space::turned(carried.moment, turn));
            if j > 0 {
                carried.shift(Self::origin(pose, j) - Self::origin(pose, j - 1));
            }
        }
        out
    }

    /// How each link moves.
    #[inline(always)]
    fn motion(&self, pose: &Self::Pose, qd: &[T; N], qdd: Option<&[T; N]>) -> [LinkMotion<T, Self::Space>; N] {
        let mut out = [LinkMotion::default(); N];
        let mut parent_origin = Vector::<T, Self::Space>::default();
        let mut m = LinkMotion { acceleration: self.upwards(), ..LinkMotion::<T, Self::Space>::default() };
        for i in 0..N {
            let (turn, slide, origin) = (Self::turn(pose, i), Self::slide(pose, i), Self::origin(pose, i));
            let r = origin - parent_origin;
            // Centripetal part of the parent's turning, Coriolis part of a sliding joint on a turning parent.
            m.acceleration = m.acceleration - Self::Space::centripetal(r, m.rate)
                + Self::Space::turned(slide, Self::Space::twice(m.rate * qd[i]));
            if let Some(qdd) = qdd {
                m.acceleration = m.acceleration + Self::Space::turned(r, m.angular_acceleration) + slide * qdd[i];
                m.angular_acceleration = m.angular_acceleration + turn * qdd[i];
            } else if !Self::Space::PLANAR {
                m.acceleration = m.acceleration + Self::Space::turned(r, m.angular_acceleration);
            }
            if !Self::Space::PLANAR {
                m.angular_acceleration = m.angular_acceleration + Self::Space::carried_round(turn * qd[i], m.rate);
            }
            m.rate = m.rate + turn * qd[i];
            parent_origin = origin;
            out[i] = m;
        }
        out
    }

    /// Thesis (48): derivative, with respect to joint `j`, of the world position `r` of a point on a link that `j` moves.
    #[inline(always)]
    fn column(&self, pose: &Self::Pose, j: usize, r: Vector<T, Self::Space>) -> Vector<T, Self::Space> {
        Self::Space::turned(r - Self::origin(pose, j), Self::turn(pose, j)) + Self::slide(pose, j)
    }

    /// Velocity of the tip, m/s.
    #[inline(always)]
    fn tip_velocity(&self, pose: &Self::Pose, qd: &[T; N]) -> Vector<T, Self::Space> {
        let tip = self.tip_position(pose);
        let mut velocity = Vector::<T, Self::Space>::default();
        for j in 0..N {
            velocity = velocity + self.column(pose, j, tip) * qd[j];
        }
        velocity
    }
}

type Vector<T, S> = <S as Space<T>>::Vector;
type Spin<T, S> = <S as Space<T>>::Spin;

/// How a link moves: acceleration of its origin less that of gravity (m/s^2), angular rate (rad/s) and angular
/// acceleration (rad/s^2).
#[derive(Debug, Clone, Copy, Default)]
pub struct LinkMotion<T: Real, S: Space<T>> {
    pub acceleration: S::Vector,
    pub rate: S::Spin,
    pub angular_acceleration: S::Spin,
}

impl<T: Real, S: Space<T>> LinkMotion<T, S> {
    /// Force that moves a link of this inertia, N; `accelerated`: with its angular acceleration.
    #[inline(always)]
    pub(super) fn force(&self, own: &Inertia<T, S>, accelerated: bool) -> S::Vector {
        let still = self.acceleration * own.mass - S::centripetal(own.moment, self.rate);
        if accelerated {
            still + S::turned(own.moment, self.angular_acceleration)
        } else {
            still
        }
    }
}

/// Mass of a part of the chain with its first and second moment about a point.
#[derive(Debug, Clone, Copy, Default)]
pub struct Inertia<T: Real, S: Space<T>> {
    pub mass: T,
    /// kg m
    pub moment: S::Vector,
    /// kg m^2
    pub second: S::Second,
}

impl<T: Real, S: Space<T>> Inertia<T, S> {
    #[inline(always)]
    pub(super) fn of_point(mass: T, arm: S::Vector) -> Self {
        let moment = arm * mass;
        Inertia { mass, moment, second: S::second_moment(moment, arm) }
    }

    #[inline(always)]
    pub(super) fn add(&mut self, other: &Self) {
        self.mass += other.mass;
        self.moment = self.moment + other.moment;
        self.second = self.second + other.second;
    }

    /// Seen from an origin from which the present one is at `step`.
    #[inline(always)]
    pub(super) fn shift(&mut self, step: S::Vector) {
        let moment = step * self.mass;
        self.second = self.second + S::shifted(step, self.moment, moment);
        self.moment = self.moment + moment;
    }
}
