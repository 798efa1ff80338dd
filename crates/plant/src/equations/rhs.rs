//! The right-hand side: geometry, cylinders, forces, accelerations.

use crate::cylinders::axis_group::{AxisGroup, Member};
use crate::cylinders::hydraulic_axis::SupplyPressures;
use crate::cylinders::in_chains::in_chains;
use crate::cylinders::ledger::{
    supply_powers, tank_line_powers, LEDGER_PER_CYLINDER, PORT_VALVE_TERMS, SUPPLY_TERMS, TANK_LINE_TERMS,
};
use crate::cylinders::local::{LocalRates, LocalState, StateRates};
use crate::equations::plant::{stroke, Plant};
use crate::layout::Layout;
use hydrocrane_num::linear::small::Spd;
use hydrocrane_num::{Dual, Pack, Real};
use hydrocrane_ode::AxisStates;
use hydrocrane_physics::dynamics::ground::Ground;
use hydrocrane_physics::geometry::chain::ChainPose;
use hydrocrane_physics::geometry::frames::JointPose;
use hydrocrane_physics::geometry::stroke::Actuation;
use hydrocrane_physics::hydraulics::fluid::ElasticEnergy;

/// A plant ready to be evaluated, its cylinders side by side in the lanes of `L`.
#[derive(Debug, Clone)]
pub struct Evaluator<T, L, const N: usize> {
    pub plant: Plant<T, N>,
    pub groups: Vec<AxisGroup<L>>,
    /// Piston kinematics with derivatives by the joints.
    pub pistons: [Actuation<Dual<T, 1>>; N],
    /// The ground with its derivatives by place and velocity of the tip.
    pub ground: Option<Ground<Dual<T, 4>>>,
}

/// Positions and velocities at one state. Pistons by cylinder: position (m), lever arm d(position)/d(joint coordinate),
/// velocity (m/s).
#[derive(Debug, Clone, Copy)]
pub struct Placed<T, const N: usize> {
    pub pose: ChainPose<T, N>,
    pub rates: [T; N],
    pub positions: [T; N],
    pub lever_arms: [T; N],
    pub velocities: [T; N],
}

impl<T: Real, const N: usize> Placed<T, N> {
    /// The local state of a cylinder.
    pub fn local(&self, layout: &Layout, x: &[T], c: usize) -> LocalState<T> {
        let AxisStates { p1, p2, xs, z, opening, .. } = layout.own(c);
        let (z, opening) = (z.map_or(T::c(0.0), |z| x[z]), opening.map(|at| x[at]));
        LocalState { x: self.positions[c], v: self.velocities[c], p1: x[p1], p2: x[p2], spool: x[xs], z, opening }
    }
}

/// A state with positions and laws evaluated.
pub struct Evaluated<'a, T, const N: usize> {
    pub layout: &'a Layout,
    pub x: &'a [T],
    pub placed: Placed<T, N>,
    /// By cylinder.
    pub rates: [LocalRates<T>; N],
    /// At the tip, kg.
    pub payload: T,
}

/// The mass matrix, factored, and the accelerations, rad/s^2 or m/s^2.
#[derive(Debug, Clone, Copy)]
pub struct Accelerated<T, const N: usize> {
    pub mass: Spd<T, N>,
    pub qdd: [T; N],
}

/// Joint part of the state.
#[inline(always)]
pub fn joint_state<T: Real, const N: usize>(layout: &Layout, x: &[T]) -> ([T; N], [T; N]) {
    let (mut q, mut qd) = ([T::c(0.0); N], [T::c(0.0); N]);
    for i in 0..N {
        (q[i], qd[i]) = (x[layout.q(i)], x[layout.qd(i)]);
    }
    (q, qd)
}

impl<T: Real, const N: usize> Plant<T, N> {
    #[inline(always)]
    fn place_at(&self, pose: ChainPose<T, N>, rates: [T; N]) -> Placed<T, N> {
        let (mut positions, mut lever_arms, mut velocities) = ([T::c(0.0); N], [T::c(0.0); N], [T::c(0.0); N]);
        for c in 0..N {
            (positions[c], lever_arms[c]) = stroke(&self.actuations[c], &pose.joints[c]);
            velocities[c] = lever_arms[c] * rates[c];
        }
        Placed { pose, rates, positions, lever_arms, velocities }
    }

    /// Accelerations of the chain under net cylinder forces (N).
    #[inline(always)]
    pub fn accelerate(&self, placed: &Placed<T, N>, forces: &[T; N], payload: T) -> Accelerated<T, N> {
        T::outlined_if_dual(
            #[inline(always)]
            || {
                let equations = self.equations(&placed.pose, &placed.rates, payload);
                let mut driving = [T::c(0.0); N];
                for c in 0..N {
                    driving[c] = placed.lever_arms[c] * forces[c] - equations.bias[c];
                }
                self.add_contact(&placed.pose, &placed.rates, payload, &mut driving);
                let mass = Spd::new(&equations.mass_matrix);
                Accelerated { mass, qdd: mass.solve(&driving) }
            },
        )
    }
}

impl<T: Real, L: Pack<T>, const N: usize> Evaluator<T, L, N> {
    pub fn new(plant: &Plant<T, N>, layout: &Layout) -> Self {
        Evaluator {
            plant: *plant,
            groups: AxisGroup::all(&plant.cylinders, &plant.fluid, layout),
            pistons: plant.actuations.map(|actuation| actuation.map(&mut |number| Dual::constant(*number))),
            ground: plant.ground.map(|ground| ground.map(&mut |number| Dual::constant(*number))),
        }
    }

    /// Positions and velocities, with the sines and cosines of the joints side by side.
    #[inline(always)]
    fn place(&self, layout: &Layout, x: &[T]) -> Placed<T, N> {
        T::outlined_if_dual(
            #[inline(always)]
            || {
                let (q, rates) = joint_state::<T, N>(layout, x);
                self.plant.place_at(self.pose(&q), rates)
            },
        )
    }

    /// The pose of the chain, likewise.
    #[inline(always)]
    pub fn pose(&self, q: &[T; N]) -> ChainPose<T, N> {
        let joints = &self.plant.mechanics.joints;
        let mut poses = [JointPose::default(); N];
        for first in (0..N).step_by(L::WIDTH) {
            let angle = L::gather(
                #[inline(always)]
                |lane| {
                    let i = (first + lane).min(N - 1);
                    joints[i].angle(q[i])
                },
            );
            let (sin, cos) = angle.sin_cos();
            for i in first..N.min(first + L::WIDTH) {
                poses[i] = joints[i].posed(q[i], (sin.lane(i - first), cos.lane(i - first)));
            }
        }
        ChainPose::of(poses)
    }

    /// The pressures of the supply in every lane.
    #[inline(always)]
    pub fn pressures(&self, layout: &Layout, x: &[T]) -> SupplyPressures<L> {
        let everywhere = &mut |number: &T| {
            L::gather(
                #[inline(always)]
                |_| *number,
            )
        };
        self.plant.pressures_at(layout, x).map(everywhere)
    }

    /// Writes the state derivative for the spool commands `u` (m) with `payload` kg at the tip.
    #[inline(always)]
    pub fn derivative(&self, layout: &Layout, x: &[T], u: &[T], payload: T, dx: &mut [T]) {
        let placed = self.place(layout, x);
        let (pressures, mains) = (self.pressures(layout, x), self.plant.mains(layout).is_some());
        let returns = self.plant.tank_line(layout).is_some();
        let tank = self.plant.pressures_at(layout, x).tank;
        let (mut forces, mut demand) = ([T::c(0.0); N], self.plant.no_demand(tank));
        for group in &self.groups {
            let local = group.local(&placed.positions, &placed.velocities, x);
            let rates = if mains || group.unit.compensator_lag().is_some() {
                let all = group.rates(&pressures, &local);
                let at_valve = all.at_valve();
                demand.signal = group.fold(group.signals(local.spool, &at_valve), demand.signal, T::max);
                if let Some(rate) = group.unit.opening_rate(local.spool, &at_valve) {
                    group.write_openings(rate, dx);
                }
                all.of_states()
            } else {
                group.state_rates(&pressures, &local)
            };
            group.write_rates(&rates, &mut forces, dx);
            group.write_spools(x, u, dx);
            if mains {
                demand.drawn += group.sum(rates.drawn);
            }
            if returns {
                demand.returned += group.sum(rates.returned);
            }
        }
        self.plant.write_supply(layout, x, demand, dx);
        let Accelerated { qdd, .. } = self.plant.accelerate(&placed, &forces, payload);
        write_joints(layout, &placed.rates, &qdd, dx);
    }

    /// Positions and laws at a state.
    #[inline(always)]
    pub fn evaluated<'a>(&self, layout: &'a Layout, x: &'a [T], payload: T) -> Evaluated<'a, T, N> {
        let (placed, pressures) = (self.place(layout, x), self.pressures(layout, x));
        let mut rates = [LocalRates::default(); N];
        for group in &self.groups {
            let of_group = group.rates(&pressures, &group.local(&placed.positions, &placed.velocities, x));
            for lane in 0..L::WIDTH {
                let Some(Member { cylinder, .. }) = group.member(lane) else { break };
                rates[*cylinder] = of_group.map(
                    #[inline(always)]
                    |number| number.lane(lane),
                );
            }
        }
        Evaluated { layout, x, placed, rates, payload }
    }

    /// Writes the powers of the ledger (W), cylinder by cylinder, then that of the ground and those of the supply.
    #[inline(always)]
    pub fn powers(&self, layout: &Layout, oil: &impl ElasticEnergy, x: &[T], payload: T, out: &mut [T]) {
        let placed = self.place(layout, x);
        if let Some(ground) = &self.plant.ground {
            let contact = self.plant.mechanics.contact(ground, &placed.pose, &placed.rates, payload);
            out[N * LEDGER_PER_CYLINDER] = contact.heat;
        }
        let tank = self.plant.pressures_at(layout, x).tank;
        let (pressures, mut demand, mut compensated) =
            (self.pressures(layout, x), self.plant.no_demand(tank), T::c(0.0));
        let (mut at_ports, mut in_lines) = ([T::c(0.0); PORT_VALVE_TERMS.len()], T::c(0.0));
        let (mut crossing, mut given_way, mut leaking) = (T::c(0.0), T::c(0.0), T::c(0.0));
        for group in &self.groups {
            let local = group.local(&placed.positions, &placed.velocities, x);
            let powers = group.powers(oil, &pressures, &local);
            group.write_powers(&powers.own, out);
            compensated += group.sum(powers.compensators);
            in_lines += group.sum(powers.lines);
            crossing += group.sum(powers.crossover);
            given_way += group.sum(powers.priority);
            if self.plant.has_hose_leak() {
                leaking += group.sum(powers.leaks);
            }
            demand.drawn += group.sum(powers.drawn);
            demand.returned += group.sum(powers.returned);
            for (sum, power) in at_ports.iter_mut().zip(powers.port_valves) {
                *sum += group.sum(power);
            }
        }
        let mut first = N * LEDGER_PER_CYLINDER + usize::from(self.plant.ground.is_some());
        if self.plant.is_compensated() {
            out[first] = compensated;
            first += 1;
        }
        if self.plant.has_port_valves() {
            out[first..][..at_ports.len()].copy_from_slice(&at_ports);
            first += at_ports.len();
        }
        if self.plant.has_crossover_relief() {
            out[first] = crossing;
            first += 1;
        }
        if self.plant.priority().is_some() {
            out[first] = given_way;
            first += 1;
        }
        if self.plant.has_line_resistance() {
            out[first] = in_lines;
            first += 1;
        }
        if self.plant.has_hose_leak() {
            out[first] = leaking;
            first += 1;
        }
        let Some((supply, pressures, e)) = self.plant.supply_at(layout, x) else { return };
        let rates = supply.rates(&self.plant.fluid, &pressures, &e, demand);
        let (stored, drawn) = (oil.energy_density(pressures.supply), demand.drawn);
        out[first..][..SUPPLY_TERMS.len()]
            .copy_from_slice(&supply_powers(stored, &pressures, &e, drawn, supply, &rates));
        if let Some(line) = &supply.tank_line {
            let (stored, inflows) = (oil.energy_density(pressures.tank), [demand.returned, rates.relief_flow]);
            out[first + SUPPLY_TERMS.len()..][..TANK_LINE_TERMS.len()].copy_from_slice(&tank_line_powers(
                stored,
                pressures.tank,
                inflows,
                line,
            ));
        }
    }
}

impl<T: Real, const N: usize> Evaluator<T, T, N> {
    /// Every number that is read, a copy of one of the plant's, always in the same order.
    pub fn each<'a>(&'a self, layout: &Layout, f: &mut dyn FnMut(&'a T)) {
        let Plant { mechanics, space, actuations, cylinders, fluid, supply_pressures, supply, ground } = &self.plant;
        mechanics.map(f);
        in_chains(space.as_ref()).map(|space| space.map(f));
        actuations.iter().for_each(|actuation| _ = actuation.map(f));
        // The laws of cylinders read the groups' copies.
        cylinders.iter().for_each(|cylinder| _ = cylinder.chambers.map(f));
        fluid.map(f);
        supply_pressures.map(f);
        in_chains(supply.as_ref()).map(|supply| supply.map(f));
        ground.as_ref().map(|ground| ground.map(f));
        self.groups.iter().for_each(|group| group.each(layout.mains().is_some(), f));
        for piston in &self.pistons {
            piston.map(&mut |number| f(&number.value));
        }
        if let Some(ground) = &self.ground {
            ground.map(&mut |number| f(&number.value));
        }
    }
}

#[inline(always)]
pub fn write_joints<T: Real, const N: usize>(layout: &Layout, qd: &[T; N], qdd: &[T; N], dx: &mut [T]) {
    for j in 0..N {
        dx[layout.q(j)] = qd[j];
        dx[layout.qd(j)] = qdd[j];
    }
}

impl<L: Real> AxisGroup<L> {
    /// Sum of a number over the cylinders.
    #[inline(always)]
    pub fn sum<T: Real>(&self, number: L) -> T
    where
        L: Pack<T>,
    {
        self.fold(number, T::c(0.0), |sum, number| sum + number)
    }

    /// A number of each cylinder, one after the other, `with` what has been found so far.
    #[inline(always)]
    pub fn fold<T: Real>(&self, number: L, start: T, with: impl Fn(T, T) -> T) -> T
    where
        L: Pack<T>,
    {
        let mut found = start;
        for lane in 0..L::WIDTH {
            if self.member(lane).is_none() {
                break;
            }
            found = with(found, number.lane(lane));
        }
        found
    }

    /// Net forces of the cylinders, and the rates of their pressures and bristles.
    #[inline(always)]
    pub fn write_rates<T: Real, const N: usize>(&self, rates: &StateRates<L>, forces: &mut [T; N], dx: &mut [T])
    where
        L: Pack<T>,
    {
        for lane in 0..L::WIDTH {
            let Some(Member { cylinder, at }) = self.member(lane) else { break };
            forces[*cylinder] = rates.force.lane(lane);
            dx[at.p1] = rates.p1_rate.lane(lane);
            dx[at.p2] = rates.p2_rate.lane(lane);
            if let Some(z) = at.z {
                dx[z] = rates.z_rate.lane(lane);
            }
        }
    }

    /// Rates (1/s) of the openings of compensators that follow late.
    #[inline(always)]
    pub fn write_openings<T: Real>(&self, rate: L, dx: &mut [T])
    where
        L: Pack<T>,
    {
        for lane in 0..L::WIDTH {
            let Some(at) = self.member(lane).and_then(|member| member.at.opening) else { break };
            dx[at] = rate.lane(lane);
        }
    }

    #[inline(always)]
    fn write_powers<T: Real>(&self, powers: &[L; LEDGER_PER_CYLINDER], out: &mut [T])
    where
        L: Pack<T>,
    {
        for lane in 0..L::WIDTH {
            let Some(Member { cylinder, .. }) = self.member(lane) else { break };
            let own = &mut out[cylinder * LEDGER_PER_CYLINDER..][..LEDGER_PER_CYLINDER];
            own.iter_mut().zip(powers).for_each(|(out, power)| *out = power.lane(lane));
        }
    }

    #[inline(always)]
    fn write_spools<T: Real>(&self, x: &[T], u: &[T], dx: &mut [T])
    where
        L: Pack<T>,
    {
        let (position, velocity) = (self.gather(|m| x[m.at.xs]), self.gather(|m| x[m.at.vs]));
        let (position_rate, velocity_rate) = self.unit.spool.rates(position, velocity, self.gather(|m| u[m.cylinder]));
        for lane in 0..L::WIDTH {
            let Some(Member { at, .. }) = self.member(lane) else { break };
            dx[at.xs] = position_rate.lane(lane);
            dx[at.vs] = velocity_rate.lane(lane);
        }
    }
}
