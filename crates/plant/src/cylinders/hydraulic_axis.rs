//! One cylinder with its valve: the laws of `physics`, from its local state to force and rates.

use crate::cylinders::in_chains::in_chains;
use crate::cylinders::local::{LocalRates, LocalState};
use hydrocrane_num::Real;
use hydrocrane_physics::friction::lugre::{Friction, LuGre};
use hydrocrane_physics::friction::{static_map, StaticParameters};
use hydrocrane_physics::hydraulics::chamber::Chambers;
use hydrocrane_physics::hydraulics::compensator::CompensatorLag;
use hydrocrane_physics::hydraulics::connector::Connector;
use hydrocrane_physics::hydraulics::crossover_relief::CrossoverRelief;
use hydrocrane_physics::hydraulics::edge_flows::{EdgeFlows, PortFlows, PortPressures};
use hydrocrane_physics::hydraulics::end_stop::EndStop;
use hydrocrane_physics::hydraulics::fluid::Fluid;
use hydrocrane_physics::hydraulics::hose_leak::{HoseLeak, Leaking, Spill};
use hydrocrane_physics::hydraulics::leakage::Leakage;
use hydrocrane_physics::hydraulics::parts::{AnyParts, Parts};
use hydrocrane_physics::hydraulics::port_valves::PortValves;
use hydrocrane_physics::hydraulics::priority::Priority;
use hydrocrane_physics::hydraulics::spool::Spool;
use hydrocrane_physics::hydraulics::spool_valve::SpoolValve;

/// Which friction law acts, with its parameters.
#[derive(Debug, Clone, Copy)]
pub enum FrictionLaw<T> {
    Static {
        map: StaticParameters<T>,
        width: T,
    },
    /// Without a width the sign jumps, as in the thesis's program.
    Printed {
        map: StaticParameters<T>,
        width: Option<T>,
    },
    LuGre {
        map: StaticParameters<T>,
        bristle: LuGre<T>,
    },
}

/// Parameters of one cylinder and its valve.
#[derive(Debug, Clone, Copy)]
pub struct HydraulicAxis<T> {
    pub chambers: Chambers<T>,
    pub valve: SpoolValve<T>,
    /// `None`: the compensator, if there is one, follows at once.
    pub compensator_lag: Option<CompensatorLag<T>>,
    /// `None`: the section gives way to no other one.
    pub priority: Option<Priority<T>>,
    /// At the piston side and at the rod side.
    pub port_valves: [PortValves<T>; 2],
    pub crossover: CrossoverRelief<T>,
    /// Of the hoses to the piston side and to the rod side.
    pub leaks: [Option<HoseLeak<T>>; 2],
    pub spool: Spool<T>,
    pub leakage: Leakage<T>,
    pub connector: Connector<T>,
    pub end_stop: EndStop<T>,
    pub friction: FrictionLaw<T>,
}

/// Pressures that all valves share, Pa.
#[derive(Debug, Clone, Copy, Default)]
pub struct SupplyPressures<T> {
    pub supply: T,
    /// Of the load-sensing line; the tank pressure without one.
    pub load: T,
    pub tank: T,
}

impl<T: Real> FrictionLaw<T> {
    #[inline(always)]
    pub fn evaluate(&self, v: T, z: T) -> FrictionOutput<T> {
        let none = T::c(0.0);
        let static_force = |force| FrictionOutput { force, deflection_rate: none, bristle_power: none };
        match self {
            FrictionLaw::Static { map, width } => static_force(static_map::force(map, *width, v)),
            FrictionLaw::Printed { map, width } => static_force(static_map::printed(map, *width, v)),
            FrictionLaw::LuGre { map, bristle } => {
                let Friction { force, deflection_rate } = bristle.evaluate(map, v, z);
                FrictionOutput { force, deflection_rate, bristle_power: bristle.stiffness * z * deflection_rate }
            }
        }
    }

    /// Friction at constant velocity, N.
    pub fn steady(&self, v: T) -> T {
        match self {
            FrictionLaw::LuGre { map, .. } => {
                let sign = T::select(v.lt(T::c(0.0)), T::c(-1.0), T::c(1.0));
                map.stribeck(v) * sign + map.viscous(v)
            }
            _ => self.evaluate(v, T::c(0.0)).force,
        }
    }

    pub fn has_bristle(&self) -> bool {
        matches!(self, FrictionLaw::LuGre { .. })
    }

    /// Whether the same law acts, with the same short cuts.
    fn same_laws(&self, other: &Self) -> bool {
        let choices = |law: &Self| match law {
            FrictionLaw::Printed { map, width } => (map.gaussian, map.three_halves, width.is_some()),
            FrictionLaw::Static { map, .. } | FrictionLaw::LuGre { map, .. } => (map.gaussian, map.three_halves, true),
        };
        std::mem::discriminant(self) == std::mem::discriminant(other) && choices(self) == choices(other)
    }
}

/// Results of the single laws of a cylinder, each of which depends on few local numbers.
#[derive(Debug, Clone, Copy)]
pub struct LawOutputs<T> {
    pub port_a: Port<T>,
    pub port_b: Port<T>,
    /// From port to port, m^3/s.
    pub crossed: T,
    /// Bulk moduli of the oil in both chambers, Pa.
    pub bulk: (T, T),
    pub friction: FrictionOutput<T>,
    /// Forces of the end stops' springs and dampers, N, positive outward.
    pub stops: (T, T),
}

/// A port of the valve.
#[derive(Debug, Clone, Copy)]
pub struct Port<T> {
    /// Pa
    pub pressure: T,
    /// Flows from the supply and to the tank, m^3/s.
    pub fed: T,
    pub drained: T,
    /// Through the port's own valves to the tank, m^3/s.
    pub relieved: T,
    /// From its hose to the outside, m^3/s.
    pub lost: T,
    /// Drop from the valve over the line to the cylinder, Pa, and from the chamber to a hose that leaks.
    pub line_drop: T,
    pub hose_drop: T,
}

impl<T: Copy> Port<T> {
    #[inline(always)]
    pub fn map<U>(&self, f: impl Fn(T) -> U) -> Port<U> {
        Port {
            pressure: f(self.pressure),
            fed: f(self.fed),
            drained: f(self.drained),
            relieved: f(self.relieved),
            lost: f(self.lost),
            line_drop: f(self.line_drop),
            hose_drop: f(self.hose_drop),
        }
    }
}

impl<T: Real> Port<T> {
    /// Pressure at the valve, Pa.
    #[inline(always)]
    pub fn at_valve(&self) -> T {
        self.pressure + self.line_drop - self.hose_drop
    }

    /// Flow into the chamber through the valve and the hose, m^3/s.
    #[inline(always)]
    pub fn inflow(&self) -> T {
        self.fed - self.drained - self.lost
    }
}

/// Flows through the edges of a valve, from those of its ports.
#[inline(always)]
fn edges_of<T: Copy>(a: &Port<T>, b: &Port<T>) -> EdgeFlows<T> {
    EdgeFlows { supply_to_a: a.fed, a_to_tank: a.drained, supply_to_b: b.fed, b_to_tank: b.drained }
}

/// Friction of the seals.
#[derive(Debug, Clone, Copy)]
pub struct FrictionOutput<T> {
    /// N, positive against positive velocity
    pub force: T,
    /// m/s
    pub deflection_rate: T,
    /// Power stored in the bristles, W.
    pub bristle_power: T,
}

impl<T: Copy> FrictionOutput<T> {
    #[inline(always)]
    pub fn map<U>(&self, f: impl Fn(T) -> U) -> FrictionOutput<U> {
        FrictionOutput {
            force: f(self.force),
            deflection_rate: f(self.deflection_rate),
            bristle_power: f(self.bristle_power),
        }
    }
}

impl<T: Real> HydraulicAxis<T> {
    /// The laws at a local state. `P` may be [`NoParts`](hydrocrane_physics::hydraulics::parts::NoParts) where the axis
    /// [has none](HydraulicAxis::has_parts).
    #[inline(always)]
    pub fn rates<P: Parts>(
        &self,
        fluid: &Fluid<T>,
        supply_pressures: &SupplyPressures<T>,
        s: &LocalState<T>,
    ) -> LocalRates<T> {
        let ports = self.ports(supply_pressures, s.v, [s.p1, s.p2], P::part(s.opening));
        let outputs = LawOutputs {
            port_a: self.port_a::<P>(&ports, s.spool),
            port_b: self.port_b::<P>(&ports, s.spool),
            crossed: self.crossed::<P>(&ports),
            bulk: (fluid.bulk_modulus(s.p1), fluid.bulk_modulus(s.p2)),
            friction: self.friction.evaluate(s.v, s.z),
            stops: self.end_stop.force(s.x, s.v),
        };
        self.assemble::<P>(supply_pressures, s, &outputs)
    }

    /// Flows of port A; the pressure of port B counts if it opens the load-holding valve of port A.
    #[inline(always)]
    pub fn port_a<P: Parts>(&self, ports: &PortPressures<T>, spool: T) -> Port<T> {
        self.port::<P>(0, ports.a, ports, self.valve.flows_at_a::<P>(spool, ports, P::part(self.leak(0))))
    }

    /// Flows of port B, likewise.
    #[inline(always)]
    pub fn port_b<P: Parts>(&self, ports: &PortPressures<T>, spool: T) -> Port<T> {
        self.port::<P>(1, ports.b, ports, self.valve.flows_at_b::<P>(spool, ports, P::part(self.leak(1))))
    }

    /// Flow through the cross-over relief valves from port A to port B, m^3/s.
    #[inline(always)]
    pub fn crossed<P: Parts>(&self, ports: &PortPressures<T>) -> T {
        if P::EXPECTED {
            self.crossover.flow(ports.a, ports.b)
        } else {
            T::c(0.0)
        }
    }

    /// What a section that gives way gets of the flow `fed` from the supply, m^3/s.
    #[inline(always)]
    fn left_by_priority<P: Parts>(&self, ports: &PortPressures<T>, fed: T) -> T {
        match P::part(self.gives_way()) {
            Some(priority) => fed * priority.share(ports.supply, ports.load),
            None => fed,
        }
    }

    /// Where the section gives way to another one. Builds for the smallest chains only have none.
    #[inline(always)]
    fn gives_way(&self) -> Option<&Priority<T>> {
        in_chains(self.priority.as_ref())
    }

    /// Flows through the edges of the valve, m^3/s.
    #[inline(always)]
    pub fn edge_flows(&self, spool: T, ports: &PortPressures<T>) -> EdgeFlows<T> {
        let flows = self.valve.flows_with::<AnyParts>(spool, ports);
        EdgeFlows {
            supply_to_a: self.left_by_priority::<AnyParts>(ports, flows.supply_to_a),
            supply_to_b: self.left_by_priority::<AnyParts>(ports, flows.supply_to_b),
            ..flows
        }
    }

    /// Losses of the priority element at the edges to port A and to port B, W, at the pressures `p` at the valve.
    #[inline(always)]
    pub fn priority_losses(&self, p: &PortPressures<T>, edges: &EdgeFlows<T>) -> [T; 2] {
        let Some(priority) = self.gives_way() else { return [T::c(0.0); 2] };
        let (a, b) = (self.valve.compensated(p, p.a), self.valve.compensated(p, p.b));
        [priority.loss(p.supply, p.load, a, edges.supply_to_a), priority.loss(p.supply, p.load, b, edges.supply_to_b)]
    }

    /// The leak of the hose of a port, if it may leak. Builds for the smallest chains only have none.
    #[inline(always)]
    fn leak(&self, port: usize) -> Option<&HoseLeak<T>> {
        in_chains(self.leaks[port].as_ref())
    }

    #[inline(always)]
    fn port<P: Parts>(&self, number: usize, pressure: T, ports: &PortPressures<T>, flows: PortFlows<T>) -> Port<T> {
        let (fed, drained) = (self.left_by_priority::<P>(ports, flows.fed), flows.drained);
        let Spill { fed, lost, drop } = match (P::part(self.leak(number)), flows.leaking) {
            (Some(leak), Some(Leaking { outward, behind })) => {
                leak.spill(pressure, fed, &Leaking { outward: self.left_by_priority::<P>(ports, outward), behind })
            }
            _ => Spill { fed, lost: T::c(0.0), drop: T::c(0.0) },
        };
        Port {
            pressure,
            fed,
            drained,
            relieved: if P::EXPECTED { self.port_valves[number].flow(pressure, ports.tank) } else { T::c(0.0) },
            lost,
            line_drop: if P::EXPECTED { self.valve.line_drop(number, fed - drained) } else { T::c(0.0) },
            hose_drop: drop,
        }
    }

    /// Pressures around the valve, with those of both chambers and the `opening` of its compensator.
    #[inline(always)]
    pub fn ports(
        &self,
        supply_pressures: &SupplyPressures<T>,
        v: T,
        [p1, p2]: [T; 2],
        opening: Option<T>,
    ) -> PortPressures<T> {
        let SupplyPressures { supply, load, tank } = *supply_pressures;
        let dynamic = self.connector.dynamic_pressures(v);
        PortPressures { supply, load, tank, a: p1 - dynamic.0, b: p2 - dynamic.1, opening: in_chains(opening) }
    }

    /// How the compensator follows, if it does so late. Builds for the smallest chains only have none.
    #[inline(always)]
    pub fn compensator_lag(&self) -> Option<&CompensatorLag<T>> {
        in_chains(self.compensator_lag.as_ref())
    }

    /// Rate of the compensator's opening, 1/s, with the spool at `spool` (m) and the pressures `at_valve`; `None` if it follows at once.
    #[inline(always)]
    pub fn opening_rate(&self, spool: T, at_valve: &PortPressures<T>) -> Option<T> {
        let (lag, opening) = (self.compensator_lag()?, at_valve.opening?);
        Some(lag.rate(opening, self.valve.settled_opening(spool, at_valve)))
    }

    /// Flows into the piston-side and the rod-side chamber, m^3/s, with the internal and the external `leakage`.
    #[inline(always)]
    pub fn inflows<P: Parts>(&self, [port_a, port_b]: [&Port<T>; 2], crossed: T, leakage: (T, T)) -> (T, T) {
        let (edges, (internal, external)) = (edges_of(port_a, port_b), leakage);
        let mut inflow =
            (edges.port_a() - internal - port_a.relieved, internal - external - edges.port_b() - port_b.relieved);
        if P::EXPECTED && !self.crossover.is_none() {
            inflow = (inflow.0 - crossed, inflow.1 + crossed);
        }
        if P::EXPECTED && self.may_leak() {
            inflow = (inflow.0 - port_a.lost, inflow.1 - port_b.lost);
        }
        inflow
    }

    /// Assembles force and rates from the outputs of the laws by sums and products.
    #[inline(always)]
    pub fn assemble<P: Parts>(
        &self,
        supply_pressures: &SupplyPressures<T>,
        s: &LocalState<T>,
        outputs: &LawOutputs<T>,
    ) -> LocalRates<T> {
        let LawOutputs { port_a, port_b, crossed, friction, stops, .. } = outputs;
        let edges = edges_of(port_a, port_b);
        let (internal_leakage, external_leakage) = self.leakage.flows(s.p1, s.p2, supply_pressures.tank);
        let inflow = self.inflows::<P>([port_a, port_b], *crossed, (internal_leakage, external_leakage));
        let (p1_rate, p2_rate) = self.chambers.pressure_rates::<P>(outputs.bulk, s.x, s.v, (s.p1, s.p2), inflow);
        LocalRates {
            force: self.chambers.force(s.p1, s.p2) + stops.0 + stops.1 - friction.force,
            friction: friction.force,
            p1_rate,
            p2_rate,
            z_rate: friction.deflection_rate,
            edges,
            relieved: [port_a.relieved, port_b.relieved],
            crossed: *crossed,
            lost: [port_a.lost, port_b.lost],
            internal_leakage,
            external_leakage,
            ports: PortPressures {
                supply: supply_pressures.supply,
                load: supply_pressures.load,
                tank: supply_pressures.tank,
                a: port_a.pressure,
                b: port_b.pressure,
                opening: P::part(in_chains(s.opening)),
            },
            line_drops: [port_a.line_drop, port_b.line_drop],
            hose_drops: [port_a.hose_drop, port_b.hose_drop],
            stop_damping: stops.1,
            bristle_power: friction.bristle_power,
        }
    }

    /// Whether a hose may leak.
    #[inline(always)]
    fn may_leak(&self) -> bool {
        self.leak(0).is_some() || self.leak(1).is_some()
    }

    /// Whether it has any of the parts that [`Parts`] counts.
    pub fn has_parts(&self) -> bool {
        // Every field is named, so that none is forgotten when one is added.
        let HydraulicAxis {
            chambers,
            valve,
            compensator_lag: _,
            priority: _,
            port_valves,
            crossover,
            leaks: _,
            spool: _,
            leakage: _,
            connector: _,
            end_stop: _,
            friction: _,
        } = self;
        let at_ports = port_valves.iter().any(|valves| valves.kinds() != [false; 2]);
        let between = !crossover.is_none();
        let of_section = valve.has_parts() || self.gives_way().is_some();
        let of_chambers = chambers.elastic || chambers.motor || self.may_leak();
        AnyParts::EXPECTED && (of_section || at_ports || between || of_chambers)
    }

    /// Whether this cylinder has the same laws as another one, possibly with other parameters.
    pub fn same_laws(&self, other: &Self) -> bool {
        let edges = |unit: &Self| [unit.valve.edge_a.law, unit.valve.edge_b.law];
        let switches = |unit: &Self| {
            [
                unit.leakage.external_from_piston_side,
                unit.end_stop.printed,
                unit.valve.load_check,
                unit.chambers.elastic,
                unit.chambers.motor,
            ]
        };
        let compensator = |unit: &Self| std::mem::discriminant(&unit.valve.compensator);
        let held = |unit: &Self| unit.valve.holding.map(|valve| valve.map(|valve| std::mem::discriminant(&valve)));
        let at_ports = |unit: &Self| unit.port_valves.map(|valves| valves.kinds());
        let out = |unit: &Self| unit.valve.meter_out.map(|of| of.is_some());
        let lines = |unit: &Self| unit.valve.lines.map(|line| line.is_some());
        let leaks = |unit: &Self| unit.leaks.map(|leak| leak.is_some());
        let curves = |unit: &Self| unit.valve.metering().map(|metering| metering.curves);
        edges(self) == edges(other)
            && switches(self) == switches(other)
            && compensator(self) == compensator(other)
            && held(self) == held(other)
            && at_ports(self) == at_ports(other)
            && self.crossover.kinds() == other.crossover.kinds()
            && self.priority.is_some() == other.priority.is_some()
            && self.compensator_lag.is_some() == other.compensator_lag.is_some()
            && curves(self) == curves(other)
            && out(self) == out(other)
            && lines(self) == lines(other)
            && leaks(self) == leaks(other)
            && self.friction.same_laws(&other.friction)
    }
}

impl<T: Copy> SupplyPressures<T> {
    pub fn map<'a, U>(&'a self, f: &mut dyn FnMut(&'a T) -> U) -> SupplyPressures<U> {
        SupplyPressures { supply: f(&self.supply), load: f(&self.load), tank: f(&self.tank) }
    }
}

impl<T: Copy> HydraulicAxis<T> {
    /// `f` of every number that the flows at its ports depend on.
    pub fn each_at_ports<'a>(&'a self, f: &mut dyn FnMut(&'a T)) {
        self.valve.map(f);
        in_chains(self.priority.as_ref()).map(|priority| priority.map(f));
        self.port_valves.iter().for_each(|valves| _ = valves.map(f));
        self.crossover.map(f);
        self.leaks.iter().for_each(|leak| _ = in_chains(leak.as_ref()).map(|leak| leak.map(f)));
        self.connector.map(f);
    }

    /// The same cylinder with `f` of every number.
    pub fn map<'a, U>(&'a self, f: &mut dyn FnMut(&'a T) -> U) -> HydraulicAxis<U> {
        HydraulicAxis {
            chambers: self.chambers.map(f),
            valve: self.valve.map(f),
            compensator_lag: in_chains(self.compensator_lag.as_ref()).map(|lag| lag.map(f)),
            priority: in_chains(self.priority.as_ref()).map(|priority| priority.map(f)),
            port_valves: self.port_valves.each_ref().map(|valves| valves.map(f)),
            crossover: self.crossover.map(f),
            leaks: self.leaks.each_ref().map(|leak| in_chains(leak.as_ref()).map(|leak| leak.map(f))),
            spool: self.spool.map(f),
            leakage: self.leakage.map(f),
            connector: self.connector.map(f),
            end_stop: self.end_stop.map(f),
            friction: self.friction.map(f),
        }
    }
}

impl<T: Copy> FrictionLaw<T> {
    pub fn map<'a, U>(&'a self, f: &mut dyn FnMut(&'a T) -> U) -> FrictionLaw<U> {
        match self {
            FrictionLaw::Static { map, width } => FrictionLaw::Static { map: map.map(f), width: f(width) },
            FrictionLaw::Printed { map, width } => {
                FrictionLaw::Printed { map: map.map(f), width: width.as_ref().map(f) }
            }
            FrictionLaw::LuGre { map, bristle } => FrictionLaw::LuGre { map: map.map(f), bristle: bristle.map(f) },
        }
    }
}
