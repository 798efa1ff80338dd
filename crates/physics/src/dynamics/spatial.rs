//! The chain in space, and the derivatives of the forces that move it.    theory: docs/theory/dynamics/spatial.md
//!
//! With motions V = (omega, v) and forces F = (torque, force) taken at the inertial origin, S_j the motion at unit rate of joint j, and
//! parent V_p, A_p of joint j before it, the force on link k behind the joint changes by
//!     by q_j:   S_j x* F_k - I_k (S_j x A_p - w x V_p) - B_k(w)              w = S_j x V_p
//!     by q_j':  B_k(S_j) - 2 I_k w
//!     B_k(y)  = I_k (y x V_k) + y x* (I_k V_k) + V_k x* (I_k y)
//! The first part turns with the joint's own axis, so that no joint behind j feels it.
//!
//! Featherstone (2008), Rigid Body Dynamics Algorithms, chapters 2 and 5, for x and x*.

use super::derivatives::ForceDerivatives;
use super::equations_of_motion::{Inertia, RigidChain};
use super::space::{Spatial, Tensor};
use crate::geometry::frames::JointPose;
use crate::geometry::spatial_chain::{SpatialPose, Stance};
use core::ops::{Add, Sub};
use hydrocrane_num::{Real, Vec3};

/// Inertia of one moving link.
#[derive(Debug, Clone, Copy)]
pub struct Solid<T> {
    /// kg
    pub mass: T,
    /// In the link frame, m.
    pub centre_of_gravity: Vec3<T>,
    /// About the centre of gravity, kg m^2.
    pub inertia: Tensor<T>,
}

/// The rigid chain in space. What turns and slides its joints, and the pins of their cylinders, is that of the joints in their own planes.
#[derive(Debug, Clone, Copy)]
pub struct SpatialMechanics<T, const N: usize> {
    pub stances: [Stance<T>; N],
    pub solids: [Solid<T>; N],
    /// The tip in the frame of the last link, m.
    pub tip: Vec3<T>,
    /// Acceleration at which free fall is at rest, m/s^2: gravity with the opposite sign.
    pub gravity: Vec3<T>,
}

hydrocrane_num::stored!([] Solid<f64> { mass: f64, centre_of_gravity: Vec3<f64>, inertia: Tensor<f64> });
hydrocrane_num::stored!([const N: usize] SpatialMechanics<f64, N> {
    stances: [Stance<f64>; N],
    solids: [Solid<f64>; N],
    tip: Vec3<f64>,
    gravity: Vec3<f64>,
});

impl<T: Copy, const N: usize> SpatialMechanics<T, N> {
    /// The same chain with `f` of every number.
    pub fn map<'a, U>(&'a self, f: &mut dyn FnMut(&'a T) -> U) -> SpatialMechanics<U, N> {
        SpatialMechanics {
            stances: self.stances.each_ref().map(|stance| stance.map(f)),
            solids: self.solids.each_ref().map(|solid| Solid {
                mass: f(&solid.mass),
                centre_of_gravity: solid.centre_of_gravity.map(f),
                inertia: solid.inertia.map(f),
            }),
            tip: self.tip.map(f),
            gravity: self.gravity.map(f),
        }
    }
}

impl<T: Real, const N: usize> RigidChain<T, N> for SpatialMechanics<T, N> {
    type Space = Spatial;
    type Pose = SpatialPose<T, N>;

    #[inline(always)]
    fn origin(pose: &SpatialPose<T, N>, j: usize) -> Vec3<T> {
        pose.links[j].origin
    }
    #[inline(always)]
    fn turn(pose: &SpatialPose<T, N>, j: usize) -> Vec3<T> {
        pose.turns[j]
    }
    #[inline(always)]
    fn slide(pose: &SpatialPose<T, N>, j: usize) -> Vec3<T> {
        pose.slides[j]
    }
    #[inline(always)]
    fn upwards(&self) -> Vec3<T> {
        self.gravity
    }
    #[inline(always)]
    fn tip_position(&self, pose: &SpatialPose<T, N>) -> Vec3<T> {
        pose.links[N - 1].point(self.tip)
    }

    fn masses(&self, pose: &SpatialPose<T, N>, payload: T, mut visit: impl FnMut(T, Vec3<T>)) {
        for (solid, link) in self.solids.iter().zip(&pose.links) {
            visit(solid.mass, link.point(solid.centre_of_gravity));
        }
        visit(payload, self.tip_position(pose));
    }

    #[inline(always)]
    fn inertia(&self, pose: &SpatialPose<T, N>, j: usize, payload: T) -> Inertia<T, Spatial> {
        let solid = &self.solids[j];
        let mut local = Inertia::<T, Spatial> { second: solid.inertia, ..Inertia::default() };
        local.add(&Inertia::of_point(solid.mass, solid.centre_of_gravity));
        if j == N - 1 {
            local.add(&Inertia::of_point(payload, self.tip));
        }
        let link = &pose.links[j];
        Inertia { mass: local.mass, moment: link.vector(local.moment), second: local.second.turned(&link.axes) }
    }
}

/// A motion, or a force on a body: the part that turns and, at the inertial origin, the part that shifts.
#[derive(Debug, Clone, Copy, Default)]
struct Screw<T> {
    turning: Vec3<T>,
    shifting: Vec3<T>,
}

impl<T: Real> Screw<T> {
    /// Of a force about a motion: power.
    #[inline(always)]
    fn dot(self, o: Self) -> T {
        self.turning.dot(o.turning) + self.shifting.dot(o.shifting)
    }

    #[inline(always)]
    fn times(self, factor: T) -> Self {
        Screw { turning: self.turning * factor, shifting: self.shifting * factor }
    }

    /// How the motion `o` changes that is carried along with this one.
    #[inline(always)]
    fn carries(self, o: Self) -> Self {
        Screw {
            turning: self.turning.cross(o.turning),
            shifting: self.turning.cross(o.shifting) + self.shifting.cross(o.turning),
        }
    }

    /// The same of a force.
    #[inline(always)]
    fn carries_force(self, o: Self) -> Self {
        Screw {
            turning: self.turning.cross(o.turning) + self.shifting.cross(o.shifting),
            shifting: self.turning.cross(o.shifting),
        }
    }
}

impl<T: Real> Add for Screw<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Screw { turning: self.turning + o.turning, shifting: self.shifting + o.shifting }
    }
}

impl<T: Real> Sub for Screw<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Screw { turning: self.turning - o.turning, shifting: self.shifting - o.shifting }
    }
}

/// A link with its motion.
#[derive(Debug, Clone, Copy)]
struct Moving<T: Real> {
    inertia: Inertia<T, Spatial>,
    motion: Screw<T>,
    momentum: Screw<T>,
    force: Screw<T>,
}

impl<T: Real> Inertia<T, Spatial> {
    /// Momentum of a motion.
    #[inline(always)]
    fn of(&self, motion: Screw<T>) -> Screw<T> {
        Screw {
            turning: self.second.times(motion.turning) + self.moment.cross(motion.shifting),
            shifting: motion.shifting * self.mass - self.moment.cross(motion.turning),
        }
    }
}

impl<T: Real> Moving<T> {
    /// B(y).
    #[inline(always)]
    fn under(&self, y: Screw<T>) -> Screw<T> {
        self.inertia.of(y.carries(self.motion))
            + y.carries_force(self.momentum)
            + self.motion.carries_force(self.inertia.of(y))
    }
}

impl<T: Real, const N: usize> SpatialMechanics<T, N> {
    #[inline(always)]
    pub fn pose(&self, joints: &[JointPose<T>; N]) -> SpatialPose<T, N> {
        SpatialPose::new(&self.stances, joints)
    }

    /// Derivatives of the inverse dynamics by coordinates and rates at the accelerations `qdd`; `payload` in kg at the tip.
    #[inline(always)]
    pub fn force_derivatives(
        &self,
        pose: &SpatialPose<T, N>,
        qd: &[T; N],
        qdd: &[T; N],
        payload: T,
    ) -> ForceDerivatives<T, N> {
        let axes: [Screw<T>; N] = hydrocrane_num::array::from_fn(
            #[inline(always)]
            |j| {
                let turning = pose.turns[j];
                Screw { turning, shifting: pose.slides[j] + pose.links[j].origin.cross(turning) }
            },
        );
        let mut before = [(Screw::default(), Screw::default()); N];
        let mut motion = Screw::default();
        let mut acceleration = Screw { turning: Vec3::default(), shifting: self.gravity };
        let links: [Moving<T>; N] = hydrocrane_num::array::from_fn(
            #[inline(always)]
            |j| {
                before[j] = (motion, acceleration);
                let own = axes[j].times(qd[j]);
                acceleration = acceleration + axes[j].times(qdd[j]) + motion.carries(own);
                motion = motion + own;
                let mut inertia = self.inertia(pose, j, payload);
                inertia.shift(pose.links[j].origin);
                let momentum = inertia.of(motion);
                Moving { inertia, motion, momentum, force: inertia.of(acceleration) + motion.carries_force(momentum) }
            },
        );
        let zero = [[T::c(0.0); N]; N];
        let mut out = ForceDerivatives { by_q: zero, by_qd: zero };
        for j in 0..N {
            let (parent, parent_acceleration) = before[j];
            let w = axes[j].carries(parent);
            let uniform = axes[j].carries(parent_acceleration) - w.carries(parent);
            let (mut carried, mut by_q, mut by_qd) = (Screw::default(), Screw::default(), Screw::default());
            for k in (j..N).rev() {
                let link = &links[k];
                carried = carried + link.force;
                by_q = by_q - link.inertia.of(uniform) - link.under(w);
                by_qd = by_qd + link.under(axes[j]) - link.inertia.of(w + w);
                out.by_q[k][j] = axes[k].dot(by_q);
                out.by_qd[k][j] = axes[k].dot(by_qd);
            }
            by_q = by_q + axes[j].carries_force(carried);
            for i in 0..j {
                out.by_q[i][j] = axes[i].dot(by_q);
                out.by_qd[i][j] = axes[i].dot(by_qd);
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::{energy, Body, Mechanics};
    use crate::geometry::frames::Joint;
    use hydrocrane_num::{Dual, Vec2};

    type Moved = Dual<f64, 10>;
    const PAYLOAD: f64 = 70.0;

    fn joint(at: [f64; 2], direction: [f64; 2], sense: f64) -> Joint<f64> {
        let revolute = sense != 0.0;
        Joint { at: Vec2::c(at), direction: Vec2::c(direction), offset: 0.0, zero: 0.1, sense, revolute }
    }

    fn stance(at: [f64; 3], axis: [f64; 3], direction: [f64; 3]) -> Stance<f64> {
        Stance { at: Vec3::c(at), axis: Vec3::c(axis), direction: Vec3::c(direction), leaves_plane: true }
    }

    fn solid(mass: f64, x: f64, inertia: f64) -> Solid<f64> {
        let tensor = Tensor { xx: 0.3 * inertia, yy: inertia, zz: 0.8 * inertia, xy: 0.1, xz: -0.2, yz: 0.15 };
        Solid { mass, centre_of_gravity: Vec3::c([x, 0.07 * x, 0.05 - 0.1 * x]), inertia: tensor }
    }

    /// Slew, boom, a joint about a skew axis, a telescope aside of the plane, a rotator.
    fn chain() -> ([Joint<f64>; 5], SpatialMechanics<f64, 5>) {
        let joints = [
            joint([0.0; 2], [0.0; 2], 1.0),
            joint([0.0; 2], [0.0; 2], -1.0),
            joint([0.0; 2], [0.0; 2], 1.0),
            joint([0.0; 2], [0.8, 0.6], 0.0),
            joint([0.0; 2], [0.0; 2], 1.0),
        ];
        let still = [0.0; 3];
        let stances = [
            stance([0.0, 0.1, 0.7], [0.0, 0.0, 1.0], still),
            stance([0.3, 0.0, 1.2], [0.0, -1.0, 0.0], still),
            stance([2.3, 0.1, 0.1], [0.6, 0.0, 0.8], still),
            stance([0.4, 0.0, 0.2], [0.0, -1.0, 0.0], [0.64, 0.6, 0.48]),
            stance([0.9, 0.0, -0.1], [1.0, 0.0, 0.0], still),
        ];
        let solids = [
            solid(300.0, 0.1, 50.0),
            solid(120.0, 1.1, 38.0),
            solid(80.0, 0.7, 15.0),
            solid(60.0, 0.5, 9.0),
            solid(25.0, 0.6, 4.0),
        ];
        let mechanics =
            SpatialMechanics { stances, solids, tip: Vec3::c([1.2, 0.3, -0.1]), gravity: Vec3::c([1.1, -0.4, 9.7]) };
        (joints, mechanics)
    }

    const Q: [f64; 5] = [0.4, 0.5, -1.1, 0.3, 0.8];
    const QD: [f64; 5] = [0.7, -0.9, 1.3, 0.6, -1.1];
    const QDD: [f64; 5] = [-1.5, 2.0, 0.8, -0.4, 3.0];

    fn lifted() -> ([Joint<Moved>; 5], SpatialMechanics<Moved, 5>) {
        let (joints, chain) = chain();
        (joints.map(|j| j.map(&mut |x| Moved::constant(*x))), chain.map(&mut |x| Moved::constant(*x)))
    }

    fn posed(q: &[f64; 5]) -> SpatialPose<f64, 5> {
        let (joints, chain) = chain();
        chain.pose(&hydrocrane_num::array::from_fn(|i| joints[i].pose(q[i])))
    }

    #[test]
    fn what_carries_the_chain_at_rest_is_its_bias_and_slope() {
        let ((_, chain), rest) = (chain(), [0.0; 5]);
        let bias = chain.inverse_dynamics(&posed(&Q), &rest, None, PAYLOAD);
        let by_q = chain.force_derivatives(&posed(&Q), &rest, &rest, PAYLOAD).by_q;
        let [torques, slopes] = chain.at_rest(&posed(&Q), PAYLOAD);
        for i in 0..5 {
            assert!((torques[i] - bias[i]).abs() < 1e-9, "{i}: {} {}", torques[i], bias[i]);
            assert!((slopes[i] - by_q[i][i]).abs() < 1e-9, "{i}: {} {}", slopes[i], by_q[i][i]);
        }
    }

    #[test]
    fn derivatives_are_those_of_dual_numbers() {
        let (joints, moved) = lifted();
        let poses = hydrocrane_num::array::from_fn(|i| joints[i].pose(Moved::variable(Q[i], i)));
        let rates = hydrocrane_num::array::from_fn(|i| Moved::variable(QD[i], 5 + i));
        let qdd = QDD.map(Moved::constant);
        let exact = moved.inverse_dynamics(&moved.pose(&poses), &rates, Some(&qdd), Moved::constant(PAYLOAD));
        let (_, chain) = chain();
        let found = chain.force_derivatives(&posed(&Q), &QD, &QDD, PAYLOAD);
        for i in 0..5 {
            for j in 0..5 {
                for (found, exact) in
                    [(found.by_q[i][j], exact[i].derivative[j]), (found.by_qd[i][j], exact[i].derivative[5 + j])]
                {
                    assert!((found - exact).abs() < 1e-12 * exact.abs().max(1000.0), "{i} {j}: {found} {exact}");
                }
            }
        }
    }

    /// Lagrange's equations, d/dt dT/dq' - dT/dq + dV/dq, from the places and turns of the links alone.
    #[test]
    fn inverse_dynamics_are_lagranges_equations() {
        type Nested = Dual<Moved, 5>;
        let (joints, chain) = chain();
        // q + t q' + t^2 q''/2 as an outer direction is not needed: M q'' + (dM/dt q') - dT/dq + dV/dq.
        let inner: [Moved; 5] = hydrocrane_num::array::from_fn(|i| Moved::variable(Q[i], i));
        let (moved_joints, moved) = lifted();
        let poses = hydrocrane_num::array::from_fn(|i| moved_joints[i].pose(inner[i]));
        // M from the velocities of the bodies, J^T m J + W^T I W, with J by dual numbers around each place.
        let outer: [Nested; 5] = hydrocrane_num::array::from_fn(|i| Nested::variable(inner[i], i));
        let lift = |x: &f64| Nested::constant(Moved::constant(*x));
        let nested_joints = joints.map(|j| j.map(&mut |x| lift(x)));
        let nested = chain.map(&mut |x| lift(x));
        let nested_pose = nested.pose(&hydrocrane_num::array::from_fn(|i| nested_joints[i].pose(outer[i])));
        let mut mass = [[Moved::constant(0.0); 5]; 5];
        let mut places = Vec::new();
        nested.masses(&nested_pose, Nested::constant(Moved::constant(PAYLOAD)), |m, r| places.push((m.value, r)));
        for (m, r) in &places {
            for a in 0..5 {
                for b in 0..5 {
                    for c in [r.x, r.y, r.z] {
                        mass[a][b] += *m * c.derivative[a] * c.derivative[b];
                    }
                }
            }
        }
        let pose = moved.pose(&poses);
        for i in 0..5 {
            let tensor = moved.solids[i].inertia.turned(&pose.links[i].axes);
            for a in 0..=i {
                for b in 0..=i {
                    mass[a][b] += pose.turns[a].dot(tensor.times(pose.turns[b]));
                }
            }
        }
        let own = chain.mass_matrix(&posed(&Q), PAYLOAD);
        let mut potential = Moved::constant(0.0);
        for (m, r) in &places {
            potential += *m * moved.gravity.dot(Vec3::new(r.x.value, r.y.value, r.z.value));
        }
        let found = chain.inverse_dynamics(&posed(&Q), &QD, Some(&QDD), PAYLOAD);
        for i in 0..5 {
            let mut expected = potential.derivative[i];
            for a in 0..5 {
                assert!((own[i][a] - mass[i][a].value).abs() < 1e-10, "{i} {a}");
                expected += mass[i][a].value * QDD[a];
                for b in 0..5 {
                    expected += mass[i][a].derivative[b] * QD[a] * QD[b];
                    expected -= 0.5 * mass[a][b].derivative[i] * QD[a] * QD[b];
                }
            }
            assert!((found[i] - expected).abs() < 1e-9 * expected.abs().max(100.0), "{i}: {} {expected}", found[i]);
        }
    }

    #[test]
    fn a_chain_in_the_plane_is_that_of_the_plane() {
        let joints =
            [joint([0.0, 0.7], [0.0; 2], 1.0), joint([1.1, 0.2], [0.8, 0.6], 0.0), joint([2.3, 0.1], [0.0; 2], -1.0)];
        let bodies = [(120.0, 1.1, 38.0), (80.0, 0.7, 15.0), (60.0, 0.5, 9.0)];
        let (tip, gravity) = (Vec2::c([1.2, -0.1]), Vec2::c([1.5, 9.7]));
        let plane = Mechanics {
            joints,
            bodies: bodies.map(|(mass, x, inertia)| Body { mass, x, z: 0.05 - 0.1 * x, inertia }),
            tip,
            gravity,
        };
        let space = SpatialMechanics {
            stances: joints.map(|j| Stance {
                at: Vec3::of(j.at, 0.0),
                axis: Vec3::c([0.0, -1.0, 0.0]),
                direction: Vec3::of(j.direction, 0.0),
                leaves_plane: false,
            }),
            solids: bodies.map(|(mass, x, yy)| Solid {
                mass,
                centre_of_gravity: Vec3::c([x, 0.0, 0.05 - 0.1 * x]),
                inertia: Tensor { xx: 0.2 * yy, yy, zz: 0.9 * yy, ..Tensor::default() },
            }),
            tip: Vec3::of(tip, 0.0),
            gravity: Vec3::of(gravity, 0.0),
        };
        let (q, qd, qdd) = ([0.4, 0.5, -1.1], [0.7, -0.9, 1.3], [-1.5, 2.0, 0.8]);
        let (flat, deep) = (plane.pose(&q), space.pose(&plane.pose(&q).joints));
        let close = |a: f64, b: f64, what: &str| assert!((a - b).abs() < 1e-12 * a.abs().max(100.0), "{what}: {a} {b}");
        let (a, b) = (plane.equations(&flat, &qd, PAYLOAD), space.equations(&deep, &qd, PAYLOAD));
        let (da, db) =
            (plane.force_derivatives(&flat, &qd, &qdd, PAYLOAD), space.force_derivatives(&deep, &qd, &qdd, PAYLOAD));
        for i in 0..3 {
            close(a.bias[i], b.bias[i], "bias");
            for j in 0..3 {
                close(a.mass_matrix[i][j], b.mass_matrix[i][j], "mass matrix");
                close(da.by_q[i][j], db.by_q[i][j], "by q");
                close(da.by_qd[i][j], db.by_qd[i][j], "by q'");
            }
        }
        close(energy::potential(&plane, &flat, PAYLOAD), energy::potential(&space, &deep, PAYLOAD), "potential energy");
    }

    /// A disk that spins fast about its own axis, x, on a slewing base: the torque that keeps it level is I omega Omega about y.
    #[test]
    fn a_spinning_disk_is_a_gyroscope() {
        let still = [0.0; 3];
        let thin = Tensor { xx: 4.0, yy: 2.0, zz: 2.0, ..Tensor::default() };
        let none = Solid { mass: 0.0, centre_of_gravity: Vec3::c(still), inertia: Tensor::default() };
        let chain = SpatialMechanics {
            stances: [
                stance(still, [0.0, 0.0, 1.0], still),
                stance(still, [0.0, -1.0, 0.0], still),
                stance(still, [1.0, 0.0, 0.0], still),
            ],
            solids: [none, none, Solid { mass: 10.0, centre_of_gravity: Vec3::c(still), inertia: thin }],
            tip: Vec3::c(still),
            gravity: Vec3::c([0.0, 0.0, 9.81]),
        };
        let joints = [joint([0.0; 2], [0.0; 2], 1.0); 3];
        let pose = chain.pose(&joints.map(|j| j.pose(0.1)));
        let [slew, tilt, spin] = chain.inverse_dynamics(&pose, &[0.5, 0.0, 30.0], None, 0.0);
        // dL/dt = Omega z x I omega x = I omega Omega y; the joint turns about -y.
        assert!(
            (tilt + 4.0 * 30.0 * 0.5).abs() < 1e-12 && slew.abs() < 1e-12 && spin.abs() < 1e-12,
            "{slew} {tilt} {spin}"
        );
    }
}
