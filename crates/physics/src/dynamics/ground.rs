//! Contact of the tip, or of the load below it, with the ground.        theory: docs/theory/dynamics/ground.md
//!
//! d  = h(x - n_x hang(m)) - (z - n_z hang(m)),    d' = h' v_x - v_z,    s' = v_x + h' v_z
//! N  = k D(d) R(1 + c d')                       Hunt and Crossley (1975), exponent 1, never negative
//! F  = N (-h', 1) - mu N tanh(s' / v_s) (1, h'),     J^T F joins the forces Q of thesis (62)
//!
//! | symbol | meaning | unit |
//! | h, h'  | height of what lies below: the ground and flat supports with smooth edges; its slope | m, 1 |
//! | hang   | from the tip down to the underside of the load, a + b sqrt(m); 0 without load | m |
//! | n      | unit vector against gravity, (0, 1) on level ground | 1 |
//! | D      | positive part of the depth, rounded over its first 2 mm | m |
//! | R      | positive part, rounded between 1/2 and -1/2 | 1 |
//! | k, c   | stiffness, damping | N/m, s/m |
//! | mu, v_s | friction, speed over which it changes its sign | 1, m/s |
//!
//! The spring's energy is k times the integral of D; what damping and friction take becomes heat.

use super::derivatives::ForceDerivatives;
use super::equations_of_motion::RigidChain;
use super::Mechanics;
use crate::geometry::chain::ChainPose;
use hydrocrane_num::{functions::smooth, Dual, Real, Vec2};

/// Supports that stand on the ground at most.
pub const MOST_SUPPORTS: usize = 4;
/// Half the depth over which the spring begins, m.
const SOFT: f64 = 1e-3;
/// Half the range of 1 + c d' over which the contact ends.
const LEAVING: f64 = 0.5;
/// Speed over which friction changes its sign, m/s.
const SLIDING: f64 = 0.02;
/// Mass above which a load's size grows with the root of its mass, kg; below it the root is rounded.
const SMALL_LOAD: f64 = 1.0;

parameters! {
    /// A flat support above the ground.
    pub struct Support {
        /// m
        height,
        /// Full height between these, m.
        from,
        to,
        /// Length over which the surface rises on either side of that, m.
        edge,
    }
}

parameters! {
    /// What the ground is made of and what hangs at the tip.
    pub struct Soil {
        /// m
        height,
        /// N/m
        stiffness,
        /// s/m
        damping,
        friction,
        /// From the tip to the underside of a load, m, and its growth with the root of the mass, m/kg^(1/2).
        hang,
        hang_growth,
    }
}

/// The ground with its supports.
#[derive(Debug, Clone, Copy)]
pub struct Ground<T> {
    pub soil: Soil<T>,
    /// Unit vector against gravity.
    pub up: Vec2<T>,
    /// The first `count` stand, the lowest first, none below the ground.
    pub supports: [Support<T>; MOST_SUPPORTS],
    pub count: usize,
}

/// What the ground does at one instant.
#[derive(Debug, Clone, Copy)]
pub struct Contact<T> {
    /// On the tip or its load, N.
    pub force: Vec2<T>,
    /// Power that becomes heat, W; zero or more.
    pub heat: T,
}

impl<T: Copy> Ground<T> {
    /// The same ground with `f` of every number.
    pub fn map<'a, U>(&'a self, f: &mut dyn FnMut(&'a T) -> U) -> Ground<U> {
        Ground {
            soil: self.soil.map(f),
            up: self.up.map(f),
            supports: self.supports.each_ref().map(|s| s.map(f)),
            count: self.count,
        }
    }
}

impl<T: Real> Ground<T> {
    /// From the tip down to the underside of a load of this mass (kg), m.
    #[inline(always)]
    pub fn hang(&self, payload: T) -> T {
        let root = smooth::signed_root(payload, T::c(SMALL_LOAD), T::c(smooth::root_curvature(SMALL_LOAD)));
        T::select(T::c(0.0).lt(payload), self.soil.hang + self.soil.hang_growth * root, T::c(0.0))
    }

    /// Coordinate x of the underside of a load (kg) that hangs at the tip, and how far it lies below the tip along z, m.
    #[inline(always)]
    pub fn underside(&self, tip: Vec2<T>, payload: T) -> (T, T) {
        let hang = self.hang(payload);
        (tip.x - self.up.x * hang, self.up.z * hang)
    }

    /// Height (m) and slope of what lies below `x`.
    #[inline(always)]
    pub fn surface(&self, x: T) -> (T, T) {
        let (mut height, mut slope) = (self.soil.height, T::c(0.0));
        for support in &self.supports[..self.count] {
            let per_edge = T::c(1.0) / support.edge;
            let (up, up_slope) = smooth::step((x - support.from) * per_edge + 1.0);
            let (down, down_slope) = smooth::step((support.to - x) * per_edge + 1.0);
            let (share, share_slope) = (up * down, (up_slope * down - up * down_slope) * per_edge);
            let above = support.height - height;
            slope = slope * (T::c(1.0) - share) + above * share_slope;
            height += above * share;
        }
        (height, slope)
    }

    /// The contact with the tip at `tip` (m) with the velocity `v` (m/s), which carries `payload` (kg).
    #[inline(always)]
    pub fn contact(&self, tip: Vec2<T>, v: Vec2<T>, payload: T) -> Contact<T> {
        let (x, drop) = self.underside(tip, payload);
        let (height, slope) = self.surface(x);
        let depth = height + drop - tip.z;
        let (sinking, sliding) = (slope * v.x - v.z, v.x + slope * v.z);
        let spring = self.soil.stiffness * smooth::rounded_positive_part(depth - SOFT, SOFT);
        let normal = spring * smooth::rounded_positive_part(self.soil.damping * sinking + 1.0, LEAVING);
        let friction = self.soil.friction * normal * smooth::soft_sign(sliding, T::c(SLIDING));
        Contact {
            force: Vec2::new(-(normal * slope) - friction, normal - friction * slope),
            heat: (normal - spring) * sinking + friction * sliding,
        }
    }

    /// Energy in the spring, J.
    pub fn energy(&self, tip: Vec2<T>, payload: T) -> T {
        let (x, drop) = self.underside(tip, payload);
        let depth = self.surface(x).0 + drop - tip.z;
        self.soil.stiffness * smooth::rounded_positive_integral(depth - SOFT, SOFT)
    }
}

impl<T: Real, const N: usize> Mechanics<T, N> {
    /// Contact of the chain's tip.
    #[inline(always)]
    pub fn contact(&self, ground: &Ground<T>, pose: &ChainPose<T, N>, qd: &[T; N], payload: T) -> Contact<T> {
        ground.contact(self.tip_position(pose), self.tip_velocity(pose, qd), payload)
    }

    /// Forces along the joints, J^T F, from a force at the tip.
    #[inline(always)]
    pub fn along_joints(&self, pose: &ChainPose<T, N>, force: Vec2<T>) -> [T; N] {
        let tip = self.tip_position(pose);
        let mut out = [T::c(0.0); N];
        for j in 0..N {
            out[j] = self.column(pose, j, tip).dot(force);
        }
        out
    }

    /// Derivatives of the forces along the joints that the ground exerts.
    ///
    /// The tip's second derivative by joints a <= b is the column of b turned by a: turn_a perp(J_b).
    #[inline(always)]
    pub fn contact_derivatives(
        &self,
        ground: &Ground<Dual<T, 4>>,
        pose: &ChainPose<T, N>,
        qd: &[T; N],
        payload: T,
    ) -> ForceDerivatives<T, N> {
        let (tip, v) = (self.tip_position(pose), self.tip_velocity(pose, qd));
        let place = Vec2::new(Dual::variable(tip.x, 0), Dual::variable(tip.z, 1));
        let velocity = Vec2::new(Dual::variable(v.x, 2), Dual::variable(v.z, 3));
        let force = ground.contact(place, velocity, Dual::constant(payload)).force;
        let by = |k: usize| Vec2::new(force.x.derivative[k], force.z.derivative[k]);
        let along = |column: Vec2<T>, first: usize| by(first) * column.x + by(first + 1) * column.z;
        let value = Vec2::new(force.x.value, force.z.value);

        let mut columns = [Vec2::default(); N];
        for j in 0..N {
            columns[j] = self.column(pose, j, tip);
        }
        let zero = [[T::c(0.0); N]; N];
        let mut out = ForceDerivatives { by_q: zero, by_qd: zero };
        for j in 0..N {
            let mut velocity_slope = Vec2::default();
            for k in 0..N {
                let second = columns[j.max(k)].perp() * pose.joints[j.min(k)].turn;
                velocity_slope = velocity_slope + second * qd[k];
                out.by_q[k][j] = second.dot(value);
            }
            let (by_q, by_qd) = (along(columns[j], 0) + along(velocity_slope, 2), along(columns[j], 2));
            for i in 0..N {
                out.by_q[i][j] += columns[i].dot(by_q);
                out.by_qd[i][j] = columns[i].dot(by_qd);
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::Body;
    use crate::geometry::frames::Joint;
    use hydrocrane_num::{Field, Lanes};

    const STILL: [f64; 2] = [0.0; 2];

    /// Ground at -1.2 m with a bunk between 2 m and 2.6 m and a box on one end of it.
    fn ground() -> Ground<f64> {
        let support = |height, from, to| Support { height, from, to, edge: 0.1 };
        let none = support(0.0, 0.0, 0.0);
        let soil = Soil { height: -1.2, stiffness: 2e5, damping: 5.0, friction: 0.5, hang: 0.32, hang_growth: 0.044 };
        let up = Vec2::c([0.0, 1.0]);
        Ground { soil, up, supports: [support(-0.85, 2.0, 2.6), support(-0.5, 2.5, 3.0), none, none], count: 2 }
    }

    fn at(x: f64, z: f64, v: [f64; 2], payload: f64) -> Contact<f64> {
        ground().contact(Vec2::c([x, z]), Vec2::c(v), payload)
    }

    #[test]
    fn the_upper_support_counts_and_edges_are_smooth() {
        let height = |x: f64| ground().surface(x).0;
        assert_eq!([0.0, 1.9, 2.0, 2.3, 2.5, 3.0, 3.1].map(height), [-1.2, -1.2, -0.85, -0.85, -0.5, -0.5, -1.2]);
        assert!((height(1.95) + 1.025).abs() < 1e-12, "half way up in the middle of an edge");
        for x in [1.9, 1.93, 2.0, 2.43, 2.6, 2.65, 3.02] {
            let (value, slope) = ground().map(&mut |x| Dual::<f64, 1>::constant(*x)).surface(Dual::variable(x, 0));
            assert!((value.derivative[0] - slope.value).abs() < 1e-11, "{x}");
        }
    }

    #[test]
    fn a_load_hangs_below_the_tip_by_the_root_of_its_mass() {
        assert_eq!(ground().hang(0.0), 0.0);
        assert!((ground().hang(100.0) - 0.76).abs() < 1e-12);
        let small = ground().map(&mut |x| Dual::<f64, 1>::constant(*x)).hang(Dual::variable(0.0, 0));
        assert!(small.derivative[0].is_finite());
        // The load touches where the tip does not.
        assert_eq!(at(0.0, -0.7, STILL, 0.0).force.z, 0.0);
        assert!((at(0.0, -0.7, STILL, 100.0).force.z - 2e5 * 0.259).abs() < 1e-6);
        // On a slope it hangs behind the tip, here over the bunk, and less far below it.
        let raised = Ground { up: Vec2::c([0.6, 0.8]), ..ground() };
        let hang = raised.hang(100.0);
        assert_eq!(raised.underside(Vec2::c([2.7, 0.0]), 100.0), (2.7 - 0.6 * hang, 0.8 * hang));
        let force = |z: f64| raised.contact(Vec2::c([2.7, z]), Vec2::c(STILL), 100.0).force.z;
        assert!((force(-0.85 + 0.8 * 0.76 - 0.01) - 2e5 * 0.009).abs() < 1e-6 && force(-0.85 + 0.76 - 0.01) == 0.0);
    }

    #[test]
    fn the_ground_never_pulls_and_never_gives_energy() {
        for x in [0.0, 1.95, 2.3, 2.55, 3.05] {
            for z in [-1.5, -1.2, -0.9, -0.6, 0.0] {
                for vx in [-2.0, -0.01, 0.0, 0.3] {
                    for vz in [-3.0, -0.1, 0.0, 0.15, 3.0] {
                        let here = at(x, z, [vx, vz], 0.0);
                        let (_, slope) = ground().surface(x);
                        let outward = Vec2::c([-slope, 1.0]).dot(here.force);
                        assert!(outward >= 0.0 && here.heat >= 0.0, "{x} {z} {vx} {vz}: {here:?}");
                    }
                }
            }
        }
        // Leaving fast, nothing holds it.
        assert_eq!(at(0.0, -1.25, [0.0, 0.5], 0.0).force.z, 0.0);
        let above = at(0.0, -1.1, [0.4, -1.0], 0.0).force;
        assert_eq!((above.x, above.z), (0.0, 0.0));
    }

    #[test]
    fn at_rest_the_force_is_that_of_the_spring_and_minus_the_slope_of_its_energy() {
        for (x, z) in [(0.0, -1.23), (0.0, -1.2005), (1.94, -1.2), (2.3, -0.86), (3.06, -0.9)] {
            let place = Vec2::new(Dual::<f64, 2>::variable(x, 0), Dual::variable(z, 1));
            let energy = ground().map(&mut |x| Dual::constant(*x)).energy(place, Dual::c(0.0));
            let force = at(x, z, STILL, 0.0).force;
            let scale = force.z.abs().max(1.0);
            assert!((force.x + energy.derivative[0]).abs() < 1e-10 * scale, "{x} {z}");
            assert!((force.z + energy.derivative[1]).abs() < 1e-10 * scale, "{x} {z}");
        }
        assert!((at(0.0, -1.23, STILL, 0.0).force.z - 2e5 * 0.029).abs() < 1e-6);
    }

    #[test]
    fn power_is_that_of_the_spring_and_of_the_heat() {
        for (x, z, v) in [(0.0, -1.22, [0.4, -0.3]), (1.95, -1.1, [0.3, 0.1]), (2.3, -0.87, [-0.2, 0.15])] {
            let along =
                Vec2::new(Dual::<f64, 1> { value: x, derivative: [v[0]] }, Dual { value: z, derivative: [v[1]] });
            let stored = ground().map(&mut |x| Dual::constant(*x)).energy(along, Dual::c(0.0)).derivative[0];
            let here = at(x, z, v, 0.0);
            let power = here.force.dot(Vec2::c(v));
            assert!((power + stored + here.heat).abs() < 1e-9 * power.abs().max(1.0), "{x} {z} {v:?}");
        }
    }

    #[test]
    fn friction_is_coulombs_where_it_slides_and_nothing_where_it_stands() {
        let force = at(0.0, -1.22, [0.5, 0.0], 0.0).force;
        assert!((force.x + 0.5 * force.z).abs() < 1e-9 * force.z);
        assert_eq!(at(0.0, -1.22, STILL, 0.0).force.x, 0.0);
    }

    #[test]
    fn values_and_slopes_are_finite_at_every_kink() {
        let lifted = ground().map(&mut |x| Dual::<f64, 4>::constant(*x));
        for x in [-1e6, 1.9, 2.0, 2.4, 2.5, 2.7, 3.1, 1e6] {
            for z in [-50.0, -1.202, -1.2, -0.85, -0.5, 1e6] {
                for v in [-1e3, -0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3, 1e3] {
                    let place = Vec2::new(Dual::variable(x, 0), Dual::variable(z, 1));
                    let velocity = Vec2::new(Dual::variable(v, 2), Dual::variable(v, 3));
                    let here = lifted.contact(place, velocity, Dual::constant(0.0));
                    for part in [here.force.x, here.force.z, here.heat] {
                        let finite = part.value.is_finite() && part.derivative.iter().all(|d| d.is_finite());
                        assert!(finite, "{x} {z} {v}: {part:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn lanes_give_the_same_bits() {
        type Wide = Lanes<f64>;
        let wide = ground().map(&mut |x| Wide::c(*x));
        for (x, z) in [(0.0, -1.22), (1.95, -1.1), (2.3, 0.0)] {
            let one = at(x, z, [0.3, -0.2], 40.0);
            let all = wide.contact(Vec2::c([x, z]), Vec2::c([0.3, -0.2]), Wide::c(40.0));
            let mut out = [0.0; 8];
            all.force.z.store(&mut out);
            assert_eq!(out[0], one.force.z);
        }
    }

    /// A turn, a slide that it carries, a turn of the other sense.
    fn chain() -> Mechanics<f64, 3> {
        let joint = |at, direction, sense: f64| {
            let revolute = sense != 0.0;
            Joint { at: Vec2::c(at), direction: Vec2::c(direction), offset: 0.3, zero: 0.1, sense, revolute }
        };
        let body = Body { mass: 50.0, x: 0.5, z: 0.0, inertia: 5.0 };
        Mechanics {
            joints: [
                joint([0.0, 0.7], [0.0, 0.0], 1.0),
                joint([1.1, 0.2], [0.8, 0.6], 0.0),
                joint([0.6, 0.0], [0.0, 0.0], -1.0),
            ],
            bodies: [body; 3],
            tip: Vec2::c([1.2, -0.1]),
            gravity: Vec2::c([0.0, 9.81]),
        }
    }

    #[test]
    fn derivatives_along_the_joints_are_those_of_dual_numbers() {
        type Moving = Dual<f64, 6>;
        let (chain, lifted) = (chain(), chain().map(&mut |x| Moving::constant(*x)));
        let (q, qd, payload) = ([-0.6, 0.5, 0.4], [-0.05, -0.1, 0.1], 30.0);
        let tip = chain.tip_position(&chain.pose(&q));
        // Just so deep that the contact bears, on the flat and on an edge.
        for (above, from) in [(-0.02, 50.0), (-0.06, tip.x + 0.05), (0.3, 50.0)] {
            let mut ground = ground();
            ground.soil.height = tip.z - ground.hang(payload) - above;
            ground.supports[0] = Support { height: ground.soil.height + 0.1, from, to: from + 1.0, edge: 0.1 };
            ground.count = 1;
            let moving = hydrocrane_num::array::from_fn(|i| Moving::variable(q[i], i));
            let rates = hydrocrane_num::array::from_fn(|i| Moving::variable(qd[i], 3 + i));
            let pose = lifted.pose(&moving);
            let force =
                lifted.contact(&ground.map(&mut |x| Moving::constant(*x)), &pose, &rates, Moving::c(payload)).force;
            let exact = lifted.along_joints(&pose, force);
            let found =
                chain.contact_derivatives(&ground.map(&mut |x| Dual::constant(*x)), &chain.pose(&q), &qd, payload);
            assert_eq!(exact[0].value != 0.0, above < 0.0);
            for i in 0..3 {
                for j in 0..3 {
                    for (found, exact) in
                        [(found.by_q[i][j], exact[i].derivative[j]), (found.by_qd[i][j], exact[i].derivative[3 + j])]
                    {
                        assert!((found - exact).abs() <= 1e-11 * exact.abs().max(1e4), "{i} {j}: {found} {exact}");
                    }
                }
            }
        }
    }
}
