//! Cylinders with the same laws, side by side: one cylinder per lane.

use crate::cylinders::axis_derivatives::{
    Lifted, OpeningDerivatives, Piston, RateDerivatives, SupplyDerivatives, TankDerivatives,
};
use crate::cylinders::hydraulic_axis::{HydraulicAxis, SupplyPressures};
use crate::cylinders::ledger::{
    crossover_power, leak_power, line_power, port_valve_powers, powers, LEDGER_PER_CYLINDER, PORT_VALVE_TERMS,
};
use crate::cylinders::local::{LocalRates, LocalState, StateRates};
use crate::layout::Layout;
use hydrocrane_num::{lanes::register::WIDEST, Pack, Real};
use hydrocrane_ode::AxisStates;
use hydrocrane_physics::hydraulics::edge_flows::PortPressures;
use hydrocrane_physics::hydraulics::fluid::{ElasticEnergy, Fluid};
use hydrocrane_physics::hydraulics::parts::{AnyParts, NoParts, Parts};

/// Up to as many cylinders as the type `L` has lanes. Unused lanes repeat the last cylinder.
#[derive(Debug, Clone)]
pub struct AxisGroup<L> {
    members: [Member; WIDEST],
    count: usize,
    /// Whether its cylinders have optional parts.
    has_parts: bool,
    pub unit: HydraulicAxis<L>,
    pub fluid: Fluid<L>,
    pub lifted: Lifted<L>,
}

/// Powers of the ledger, W, and the flows drawn from the supply and returned to the tank, m^3/s.
#[derive(Debug, Clone, Copy)]
pub struct AxisPowers<L> {
    pub own: [L; LEDGER_PER_CYLINDER],
    pub compensators: L,
    pub port_valves: [L; PORT_VALVE_TERMS.len()],
    pub crossover: L,
    pub priority: L,
    pub lines: L,
    pub leaks: L,
    pub drawn: L,
    pub returned: L,
}

/// A cylinder and the indices of its states.
#[derive(Debug, Clone, Copy)]
pub struct Member {
    pub cylinder: usize,
    pub at: AxisStates,
}

impl<L: Real> AxisGroup<L> {
    /// All cylinders of a plant, in as few groups as possible.
    pub fn all<T: Real>(cylinders: &[HydraulicAxis<T>], fluid: &Fluid<T>, layout: &Layout) -> Vec<Self>
    where
        L: Pack<T>,
    {
        let mut kinds: Vec<Vec<usize>> = Vec::new();
        for c in 0..cylinders.len() {
            match kinds.iter_mut().find(|kind| cylinders[kind[0]].same_laws(&cylinders[c])) {
                Some(kind) => kind.push(c),
                None => kinds.push(vec![c]),
            }
        }
        kinds
            .iter()
            .flat_map(|kind| kind.chunks(L::WIDTH))
            .map(|chunk| Self::new(cylinders, fluid, layout, chunk))
            .collect()
    }

    fn new<T: Real>(cylinders: &[HydraulicAxis<T>], fluid: &Fluid<T>, layout: &Layout, chosen: &[usize]) -> Self
    where
        L: Pack<T>,
    {
        let count = chosen.len();
        let in_lane = |lane: usize| chosen[lane.min(count - 1)];
        let numbers = |c: usize| {
            let mut all = Vec::new();
            cylinders[c].map(&mut |number| all.push(*number));
            all
        };
        let numbers: Vec<Vec<T>> = (0..L::WIDTH).map(|lane| numbers(in_lane(lane))).collect();
        let mut next = 0;
        let unit = cylinders[chosen[0]].map(&mut |_| {
            next += 1;
            L::gather(|lane| numbers[lane][next - 1])
        });
        let everywhere = &mut |number: &T| L::gather(|_| *number);
        let fluid = fluid.map(everywhere);
        AxisGroup {
            members: hydrocrane_num::array::from_fn(|lane| Member {
                cylinder: in_lane(lane),
                at: layout.own(in_lane(lane)),
            }),
            count,
            has_parts: unit.has_parts(),
            unit,
            fluid,
            lifted: Lifted::new(&unit, &fluid),
        }
    }

    /// Every number that its laws read; `fed`: by a supply of variable pressure.
    pub fn each<'a>(&'a self, fed: bool, f: &mut dyn FnMut(&'a L)) {
        self.unit.map(f);
        self.fluid.map(f);
        self.lifted.each(fed, f);
    }

    /// The cylinder in a lane, if the lane is in use.
    #[inline(always)]
    pub fn member(&self, lane: usize) -> Option<&Member> {
        if lane < self.count {
            Some(&self.members[lane])
        } else {
            None
        }
    }

    /// `of` of each cylinder, lane by lane.
    #[inline(always)]
    pub fn gather<T: Real>(&self, of: impl Fn(&Member) -> T) -> L
    where
        L: Pack<T>,
    {
        L::gather(|lane| of(&self.members[lane]))
    }

    /// The local states: pistons' positions and velocities by cylinder, the rest from the state `x`.
    #[inline(always)]
    pub fn local<T: Real>(&self, positions: &[T], velocities: &[T], x: &[T]) -> LocalState<L>
    where
        L: Pack<T>,
    {
        LocalState {
            x: self.gather(|m| positions[m.cylinder]),
            v: self.gather(|m| velocities[m.cylinder]),
            p1: self.gather(|m| x[m.at.p1]),
            p2: self.gather(|m| x[m.at.p2]),
            spool: self.gather(|m| x[m.at.xs]),
            z: self.gather(|m| m.at.z.map_or(T::c(0.0), |z| x[z])),
            opening: self.unit.compensator_lag().map(|_| self.gather(|m| m.at.opening.map_or(T::c(1.0), |at| x[at]))),
        }
    }

    /// Evaluates the laws.
    #[inline(always)]
    pub fn rates(&self, supply_pressures: &SupplyPressures<L>, s: &LocalState<L>) -> LocalRates<L> {
        L::outlined(
            #[inline(always)]
            || self.unit.rates::<AnyParts>(&self.fluid, supply_pressures, s),
        )
    }

    /// Evaluates the laws for the state derivative.
    #[inline(always)]
    pub fn state_rates(&self, supply_pressures: &SupplyPressures<L>, s: &LocalState<L>) -> StateRates<L> {
        if self.expects_parts() {
            self.state_rates_with::<AnyParts>(supply_pressures, s)
        } else {
            self.state_rates_with::<NoParts>(supply_pressures, s)
        }
    }

    #[inline(always)]
    fn state_rates_with<P: Parts>(&self, supply_pressures: &SupplyPressures<L>, s: &LocalState<L>) -> StateRates<L> {
        L::outlined(
            #[inline(always)]
            || self.unit.rates::<P>(&self.fluid, supply_pressures, s).of_states(),
        )
    }

    /// Whether the laws have to expect optional parts.
    #[inline(always)]
    fn expects_parts(&self) -> bool {
        AnyParts::EXPECTED && self.has_parts
    }

    /// Evaluates the laws with their derivatives by states.
    #[inline(always)]
    pub fn linearised(
        &self,
        supply_pressures: &SupplyPressures<L>,
        s: &LocalState<L>,
        piston: &Piston<L>,
    ) -> RateDerivatives<L> {
        if self.expects_parts() {
            self.linearised_with::<AnyParts>(supply_pressures, s, piston)
        } else {
            self.linearised_with::<NoParts>(supply_pressures, s, piston)
        }
    }

    #[inline(always)]
    fn linearised_with<P: Parts>(
        &self,
        supply_pressures: &SupplyPressures<L>,
        s: &LocalState<L>,
        piston: &Piston<L>,
    ) -> RateDerivatives<L> {
        L::outlined(
            #[inline(always)]
            || self.lifted.derivatives::<P>(supply_pressures, s, piston),
        )
    }

    /// The same on mains of variable pressure, with the derivatives of and by the supply.
    #[inline(always)]
    pub fn linearised_on_mains(
        &self,
        supply_pressures: &SupplyPressures<L>,
        s: &LocalState<L>,
        piston: &Piston<L>,
    ) -> (RateDerivatives<L>, SupplyDerivatives<L>) {
        L::outlined(
            #[inline(always)]
            || self.lifted.derivatives_on_mains(supply_pressures, s, piston),
        )
    }

    /// Evaluates the derivatives of and by the opening of a compensator that follows late; `None` if it follows at once.
    #[inline(always)]
    pub fn by_opening(
        &self,
        supply_pressures: &SupplyPressures<L>,
        s: &LocalState<L>,
        piston: &Piston<L>,
    ) -> Option<OpeningDerivatives<L>> {
        let opening = s.opening?;
        Some(L::outlined(
            #[inline(always)]
            || self.lifted.by_opening(supply_pressures, s, opening, piston),
        ))
    }

    /// Evaluates the derivatives by the pressure of the tank line, and those of what returns to it.
    #[inline(always)]
    pub fn by_tank(
        &self,
        supply_pressures: &SupplyPressures<L>,
        s: &LocalState<L>,
        piston: &Piston<L>,
    ) -> TankDerivatives<L> {
        L::outlined(
            #[inline(always)]
            || self.lifted.by_tank(supply_pressures, s, piston),
        )
    }

    /// Signals of the valves to the load-sensing line, Pa.
    #[inline(always)]
    pub fn signals(&self, spool: L, ports: &PortPressures<L>) -> L {
        self.unit.valve.connection.signal(spool, [ports.a, ports.b], ports.tank)
    }

    /// Powers of the ledger.
    #[inline(always)]
    pub fn powers(
        &self,
        oil: &impl ElasticEnergy,
        supply_pressures: &SupplyPressures<L>,
        s: &LocalState<L>,
    ) -> AxisPowers<L> {
        let rates = self.rates(supply_pressures, s);
        L::outlined(
            #[inline(always)]
            || {
                let lost = self.unit.valve.compensator_losses(&rates.at_valve(), &rates.edges);
                let given = self.unit.priority_losses(&rates.at_valve(), &rates.edges);
                let stored = [oil.energy_density(s.p1), oil.energy_density(s.p2)];
                let through = self.unit.chambers.taken_through(s.v);
                AxisPowers {
                    own: powers(stored, through, s, &rates, &[lost[0] + given[0], lost[1] + given[1]]),
                    compensators: lost[0] + lost[1],
                    port_valves: port_valve_powers(&rates),
                    crossover: crossover_power(&rates),
                    priority: given[0] + given[1],
                    lines: line_power(&rates),
                    leaks: if cfg!(feature = "chains") { leak_power(&rates) } else { L::c(0.0) },
                    drawn: rates.edges.supply(),
                    returned: rates.returned(),
                }
            },
        )
    }
}
