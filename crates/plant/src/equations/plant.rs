//! The plant: all parameters of the laws, immutable, generic over the number type.

use crate::cylinders::hydraulic_axis::{HydraulicAxis, SupplyPressures};
use crate::cylinders::in_chains::in_chains;
use crate::cylinders::supply::Supply;
use crate::layout::Layout;
use hydrocrane_num::{Dual, Real, Vec2};
use hydrocrane_physics::dynamics::equations_of_motion::RigidChain;
use hydrocrane_physics::dynamics::ground::Ground;
use hydrocrane_physics::dynamics::spatial::SpatialMechanics;
use hydrocrane_physics::dynamics::Mechanics;
use hydrocrane_physics::geometry::chain::ChainPose;
use hydrocrane_physics::geometry::frames::JointPose;
use hydrocrane_physics::geometry::stroke::Actuation;
use hydrocrane_physics::hydraulics::compensator::Compensator;
use hydrocrane_physics::hydraulics::fluid::Fluid;
use hydrocrane_physics::hydraulics::parts::AnyParts;
use hydrocrane_physics::hydraulics::priority::Priority;

/// A crane of `N` joints, each moved by the cylinder of the same index.
#[derive(Debug, Clone, Copy)]
pub struct Plant<T, const N: usize> {
    /// The joints in their own planes, and the chain where all of these are one.
    pub mechanics: Mechanics<T, N>,
    /// The chain in space; `None` where it moves in the plane.
    pub(crate) space: Option<SpatialMechanics<T, N>>,
    pub actuations: [Actuation<T>; N],
    pub cylinders: [HydraulicAxis<T>; N],
    pub fluid: Fluid<T>,
    /// Constant pressure, or set pressure of the pump.
    pub supply_pressures: SupplyPressures<T>,
    /// `None`: the supply pressure is constant.
    pub(crate) supply: Option<Supply<T>>,
    /// `None`: no ground.
    pub ground: Option<Ground<T>>,
}

impl<T: Copy, const N: usize> Plant<T, N> {
    /// The same plant with `f` of every number, always in the same order.
    pub fn map<'a, U>(&'a self, f: &mut dyn FnMut(&'a T) -> U) -> Plant<U, N> {
        Plant {
            mechanics: self.mechanics.map(f),
            space: in_chains(self.space.as_ref()).map(|space| space.map(f)),
            actuations: self.actuations.each_ref().map(|a| a.map(f)),
            cylinders: self.cylinders.each_ref().map(|c| c.map(f)),
            fluid: self.fluid.map(f),
            supply_pressures: self.supply_pressures.map(f),
            supply: in_chains(self.supply.as_ref()).map(|s| s.map(f)),
            ground: self.ground.as_ref().map(|g| g.map(f)),
        }
    }

    /// All numbers, always in the same order.
    pub fn numbers(&self) -> Vec<T> {
        let mut all = Vec::new();
        self.map(&mut |number| all.push(*number));
        all
    }

    /// The same plant with other numbers, in that order.
    pub fn with(&self, numbers: &[T]) -> Self {
        let mut others = numbers.iter();
        self.map(&mut |own| *others.next().unwrap_or(own))
    }

    /// What it has besides numbers, as text: parts, laws, switches and curves.
    pub fn structure(&self) -> String {
        format!("{:?}", self.map(&mut |_| ()))
    }
}

impl<T: Real, const N: usize> Plant<T, N> {
    /// The pumps with their mains; `None` where the pressure is constant or measured.
    pub fn supply(&self) -> Option<&Supply<T>> {
        in_chains(self.supply.as_ref())
    }

    /// Piston positions (m) and lever arms, their derivatives by their joint's coordinate.
    pub fn strokes(&self, pose: &ChainPose<T, N>) -> [(T, T); N] {
        hydrocrane_num::array::from_fn(|c| stroke(&self.actuations[c], &pose.joints[c]))
    }

    /// Whether every piston is inside its cylinder and every linkage closes.
    #[inline(always)]
    pub fn admissible(&self, pose: &ChainPose<T, N>) -> T::Mask {
        let zero = T::c(0.0);
        let mut inside = zero.le(zero);
        for c in 0..N {
            let (position, _) = self.actuations[c].stroke(&pose.joints[c]);
            let (v1, v2) = self.cylinders[c].chambers.volumes::<AnyParts>(position);
            inside = inside & zero.lt(v1) & zero.lt(v2) & zero.lt(self.actuations[c].closure(&pose.joints[c]));
        }
        inside
    }

    /// Time derivative of the state derivative for commands `u` (m) that change at `rate` (m/s).
    pub fn command_derivative(&self, layout: &Layout, x: &[T], u: &[T], rate: &[T], dfdt: &mut [T]) {
        dfdt.fill(T::c(0.0));
        for (c, unit) in self.cylinders.iter().enumerate() {
            let (position, velocity) = (x[layout.xs(c)], x[layout.vs(c)]);
            dfdt[layout.vs(c)] = unit.spool.acceleration_by_command(position, velocity, u[c]) * rate[c];
        }
    }

    /// Whether a valve has a pressure compensator.
    pub fn is_compensated(&self) -> bool {
        cfg!(feature = "chains") && self.cylinders.iter().any(|c| !matches!(c.valve.compensator, Compensator::None))
    }

    /// Whether a port of a cylinder has valves of its own to the tank.
    pub fn has_port_valves(&self) -> bool {
        cfg!(feature = "chains")
            && self.cylinders.iter().any(|c| c.port_valves.iter().any(|valves| valves.kinds() != [false; 2]))
    }

    /// Whether a cylinder has cross-over relief valves.
    pub fn has_crossover_relief(&self) -> bool {
        cfg!(feature = "chains") && self.cylinders.iter().any(|c| !c.crossover.is_none())
    }

    /// What the sections that give way to another one have before their spools.
    pub fn priority(&self) -> Option<&Priority<T>> {
        in_chains(self.cylinders.iter().find_map(|c| c.priority.as_ref()))
    }

    /// Whether a hose may leak.
    pub fn has_hose_leak(&self) -> bool {
        cfg!(feature = "chains") && self.cylinders.iter().any(|c| c.leaks.iter().any(Option::is_some))
    }

    /// Whether a line has a resistance.
    pub fn has_line_resistance(&self) -> bool {
        cfg!(feature = "chains") && self.cylinders.iter().any(|c| c.valve.lines.iter().any(Option::is_some))
    }

    /// Adds the forces of the ground to those that drive the joints.
    #[inline(always)]
    pub fn add_contact(&self, pose: &ChainPose<T, N>, rates: &[T; N], payload: T, driving: &mut [T; N]) {
        let Some(ground) = &self.ground else { return };
        let force =
            contact_force(ground, self.mechanics.tip_position(pose), self.mechanics.tip_velocity(pose, rates), payload);
        let along = self.mechanics.along_joints(pose, force);
        for j in 0..N {
            driving[j] += along[j];
        }
    }

    /// Net cylinder forces that hold the crane at rest, N, less the load carried by the ground.
    pub fn static_force(&self, q: &[T; N], payload: T) -> [T; N] {
        self.resting_force(q, payload, true)
    }

    /// The same with or without the ground.
    pub(crate) fn resting_force(&self, q: &[T; N], payload: T, grounded: bool) -> [T; N] {
        let (pose, still) = (self.mechanics.pose(q), [T::c(0.0); N]);
        let mut bias = self.equations(&pose, &still, payload).bias;
        if grounded && self.ground.is_some() {
            let mut carried = still;
            self.add_contact(&pose, &still, payload, &mut carried);
            (0..N).for_each(|j| bias[j] -= carried[j]);
        }
        let strokes = self.strokes(&pose);
        hydrocrane_num::array::from_fn(|j| bias[j] / strokes[j].1)
    }
}

// For dual numbers separate functions, common to all lengths of chains.

/// Piston position (m) and lever arm of a cylinder.
#[inline(always)]
pub fn stroke<T: Real>(actuation: &Actuation<T>, pose: &JointPose<T>) -> (T, T) {
    T::outlined_if_dual(
        #[inline(always)]
        || actuation.stroke(pose),
    )
}

/// The same with their derivatives by the joint.
#[inline(always)]
pub fn moving_stroke<T: Real>(actuation: &Actuation<Dual<T, 1>>, pose: &JointPose<T>) -> (Dual<T, 1>, Dual<T, 1>) {
    T::outlined_if_dual(
        #[inline(always)]
        || actuation.stroke(&pose.moving()),
    )
}

/// Force of the ground, N.
#[inline(always)]
fn contact_force<T: Real>(ground: &Ground<T>, tip: Vec2<T>, v: Vec2<T>, payload: T) -> Vec2<T> {
    T::outlined_if_dual(
        #[inline(always)]
        || ground.contact(tip, v, payload).force,
    )
}
