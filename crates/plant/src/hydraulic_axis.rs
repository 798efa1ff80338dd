//! One cylinder with its valve: the laws of `physics`, from its local state to force and rates.

use crate::in_chains::in_chains;
use hydrocrane_num::Real;
use hydrocrane_physics::friction::lugre::{Friction, LuGre};
use hydrocrane_physics::friction::{static_map, StaticParameters};
use hydrocrane_physics::hydraulics::chamber::Chambers;
use hydrocrane_physics::hydraulics::compensator::CompensatorLag;
use hydrocrane_physics::hydraulics::connector::Connector;
use hydrocrane_physics::hydraulics::crossover_relief::CrossoverRelief;
use hydrocrane_physics::hydraulics::end_stop::EndStop;
use hydrocrane_physics::hydraulics::fluid::Fluid;
use hydrocrane_physics::hydraulics::hose_leak::{HoseLeak, Leaking, Spill};
use hydrocrane_physics::hydraulics::leakage::Leakage;
use hydrocrane_physics::hydraulics::port_valves::PortValves;
use hydrocrane_physics::hydraulics::priority::Priority;
use hydrocrane_physics::hydraulics::spool::Spool;
use hydrocrane_physics::hydraulics::spool_valve::{EdgeFlows, PortFlows, PortPressures, SpoolValve};

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

/// Local state: what the laws of a cylinder depend on besides its spool velocity.
#[derive(Debug, Clone, Copy, Default)]
pub struct LocalState<T> {
    /// Piston position (m) and velocity (m/s).
    pub x: T,
    pub v: T,
    pub p1: T,
    pub p2: T,
    /// Spool position, m.
    pub spool: T,
    /// Bristle deflection, m (zero without LuGre).
    pub z: T,
    /// Opening of the compensator, if it follows late.
    pub opening: Option<T>,
}

impl<T: Copy> LocalState<T> {
    /// The same with `f` of every number.
    #[inline(always)]
    pub fn map<U>(&self, f: impl Fn(T) -> U) -> LocalState<U> {
        let LocalState { x, v, p1, p2, spool, z, opening } = *self;
        let opening = in_chains(opening).map(&f);
        LocalState { x: f(x), v: f(v), p1: f(p1), p2: f(p2), spool: f(spool), z: f(z), opening }
    }
}

/// All results of the laws of a cylinder at one state.
#[derive(Debug, Clone, Copy, Default)]
pub struct LocalRates<T> {
    /// Net force on the rod, N, positive outward: pressures and end stops less friction.
    pub force: T,
    /// N, positive against positive velocity
    pub friction: T,
    /// Pa/s
    pub p1_rate: T,
    pub p2_rate: T,
    /// m/s
    pub z_rate: T,
    pub edges: EdgeFlows<T>,
    /// From each port through its own valves to the tank, m^3/s.
    pub relieved: [T; 2],
    /// From the piston-side port through a cross-over relief valve to the rod-side port, m^3/s.
    pub crossed: T,
    /// From the hose of each port to the outside, m^3/s.
    pub lost: [T; 2],
    /// Leakage from chamber 1 to 2 and from chamber 2 outside, m^3/s.
    pub internal_leakage: T,
    pub external_leakage: T,
    /// Pressures at the valve's ports, behind the lines, Pa, and those before them above that.
    pub ports: PortPressures<T>,
    pub line_drops: [T; 2],
    /// Of the hoses below those of the chambers, Pa: where they leak behind a valve that holds the load.
    pub hose_drops: [T; 2],
    /// Damping force of the end stops, N, positive outward.
    pub stop_damping: T,
    /// Power stored in the bristles, W.
    pub bristle_power: T,
}

impl<T: Copy> LocalRates<T> {
    /// The same with `f` of every number.
    #[inline(always)]
    pub fn map<U>(&self, f: impl Fn(T) -> U) -> LocalRates<U> {
        let (e, p) = (&self.edges, &self.ports);
        LocalRates {
            force: f(self.force),
            friction: f(self.friction),
            p1_rate: f(self.p1_rate),
            p2_rate: f(self.p2_rate),
            z_rate: f(self.z_rate),
            edges: EdgeFlows {
                supply_to_a: f(e.supply_to_a),
                a_to_tank: f(e.a_to_tank),
                supply_to_b: f(e.supply_to_b),
                b_to_tank: f(e.b_to_tank),
            },
            relieved: [f(self.relieved[0]), f(self.relieved[1])],
            crossed: f(self.crossed),
            lost: [f(self.lost[0]), f(self.lost[1])],
            internal_leakage: f(self.internal_leakage),
            external_leakage: f(self.external_leakage),
            ports: PortPressures {
                supply: f(p.supply),
                load: f(p.load),
                tank: f(p.tank),
                a: f(p.a),
                b: f(p.b),
                opening: in_chains(p.opening).map(&f),
            },
            line_drops: [f(self.line_drops[0]), f(self.line_drops[1])],
            hose_drops: [f(self.hose_drops[0]), f(self.hose_drops[1])],
            stop_damping: f(self.stop_damping),
            bristle_power: f(self.bristle_power),
        }
    }
}

impl<T: Real> LocalRates<T> {
    /// Flow into the piston side and out of the rod side, m^3/s: that of the spool valve less that of the ports' own valves, from
    /// port to port, and out of hoses that leak.
    #[inline(always)]
    pub fn through_ports(&self) -> (T, T) {
        let (a, b) = (self.edges.port_a() - self.relieved[0], self.edges.port_b() + self.relieved[1]);
        if cfg!(feature = "chains") {
            (a - self.crossed - self.lost[0], b - self.crossed + self.lost[1])
        } else {
            (a - self.crossed, b - self.crossed)
        }
    }

    /// Flow to the tank, m^3/s: through the spool valve, the ports' own valves, and past the rod.
    #[inline(always)]
    pub fn returned(&self) -> T {
        self.edges.tank() + self.relieved[0] + self.relieved[1] + self.external_leakage
    }

    /// Pressures around the valve, those of its ports before the lines to the cylinder.
    #[inline(always)]
    pub fn at_valve(&self) -> PortPressures<T> {
        let before = |port: usize, behind: T| behind + self.line_drops[port] - self.hose_drops[port];
        PortPressures { a: before(0, self.ports.a), b: before(1, self.ports.b), ..self.ports }
    }
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
    #[inline(always)]
    pub fn rates(&self, fluid: &Fluid<T>, supply_pressures: &SupplyPressures<T>, s: &LocalState<T>) -> LocalRates<T> {
        let ports = self.ports(supply_pressures, s.v, [s.p1, s.p2], s.opening);
        let outputs = LawOutputs {
            port_a: self.port_a(&ports, s.spool),
            port_b: self.port_b(&ports, s.spool),
            crossed: self.crossover.flow(ports.a, ports.b),
            bulk: (fluid.bulk_modulus(s.p1), fluid.bulk_modulus(s.p2)),
            friction: self.friction.evaluate(s.v, s.z),
            stops: self.end_stop.force(s.x, s.v),
        };
        self.assemble(supply_pressures, s, &outputs)
    }

    /// Flows of port A; the pressure of port B counts if it opens the load-holding valve of port A.
    #[inline(always)]
    pub fn port_a(&self, ports: &PortPressures<T>, spool: T) -> Port<T> {
        self.port(0, ports.a, ports, self.valve.flows_at_a(spool, ports, self.leak(0)))
    }

    /// Flows of port B, likewise.
    #[inline(always)]
    pub fn port_b(&self, ports: &PortPressures<T>, spool: T) -> Port<T> {
        self.port(1, ports.b, ports, self.valve.flows_at_b(spool, ports, self.leak(1)))
    }

    /// What a section that gives way gets of the flow `fed` from the supply, m^3/s.
    #[inline(always)]
    fn left_by_priority(&self, ports: &PortPressures<T>, fed: T) -> T {
        match self.gives_way() {
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
    pub fn edge_flows(&self, spool: T, ports: &PortPressures<T>) -> EdgeFlows<T> {
        let flows = self.valve.flows(spool, ports);
        EdgeFlows {
            supply_to_a: self.left_by_priority(ports, flows.supply_to_a),
            supply_to_b: self.left_by_priority(ports, flows.supply_to_b),
            ..flows
        }
    }

    /// Losses of the priority element at the edges to port A and to port B, W, at the pressures `p` at the valve.
    #[inline(always)]
    pub fn priority_losses(&self, p: &PortPressures<T>, edges: &EdgeFlows<T>) -> [T; 2] {
        let Some(priority) = self.gives_way() else { return [T::c(0.0); 2] };
        let drop = |port: T| self.valve.compensated(p, port);
        [(p.a, edges.supply_to_a), (p.b, edges.supply_to_b)]
            .map(|(port, flow)| priority.loss(p.supply, p.load, drop(port), flow))
    }

    /// The leak of the hose of a port, if it may leak. Builds for the smallest chains only have none.
    #[inline(always)]
    fn leak(&self, port: usize) -> Option<&HoseLeak<T>> {
        in_chains(self.leaks[port].as_ref())
    }

    #[inline(always)]
    fn port(&self, number: usize, pressure: T, ports: &PortPressures<T>, flows: PortFlows<T>) -> Port<T> {
        let (fed, drained) = (self.left_by_priority(ports, flows.fed), flows.drained);
        let Spill { fed, lost, drop } = match (self.leak(number), flows.leaking) {
            (Some(leak), Some(Leaking { outward, behind })) => {
                leak.spill(pressure, fed, &Leaking { outward: self.left_by_priority(ports, outward), behind })
            }
            _ => Spill { fed, lost: T::c(0.0), drop: T::c(0.0) },
        };
        Port {
            pressure,
            fed,
            drained,
            relieved: self.port_valves[number].flow(pressure, ports.tank),
            lost,
            line_drop: self.valve.line_drop(number, fed - drained),
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

    /// Assembles force and rates from the outputs of the laws by sums and products.
    #[inline(always)]
    pub fn assemble(
        &self,
        supply_pressures: &SupplyPressures<T>,
        s: &LocalState<T>,
        outputs: &LawOutputs<T>,
    ) -> LocalRates<T> {
        let LawOutputs { port_a, port_b, crossed, friction, stops, .. } = outputs;
        let edges = EdgeFlows {
            supply_to_a: port_a.fed,
            a_to_tank: port_a.drained,
            supply_to_b: port_b.fed,
            b_to_tank: port_b.drained,
        };
        let (internal_leakage, external_leakage) = self.leakage.flows(s.p1, s.p2, supply_pressures.tank);
        let mut inflow = (
            edges.port_a() - internal_leakage - port_a.relieved,
            internal_leakage - external_leakage - edges.port_b() - port_b.relieved,
        );
        if !self.crossover.is_none() {
            inflow = (inflow.0 - *crossed, inflow.1 + *crossed);
        }
        if cfg!(feature = "chains") && self.leaks.iter().any(Option::is_some) {
            inflow = (inflow.0 - port_a.lost, inflow.1 - port_b.lost);
        }
        let (p1_rate, p2_rate) = self.chambers.pressure_rates(outputs.bulk, s.x, s.v, (s.p1, s.p2), inflow);
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
                opening: in_chains(s.opening),
            },
            line_drops: [port_a.line_drop, port_b.line_drop],
            hose_drops: [port_a.hose_drop, port_b.hose_drop],
            stop_damping: stops.1,
            bristle_power: friction.bristle_power,
        }
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
    pub fn map<U>(&self, f: &mut dyn FnMut(T) -> U) -> SupplyPressures<U> {
        SupplyPressures { supply: f(self.supply), load: f(self.load), tank: f(self.tank) }
    }
}

impl<T: Copy> HydraulicAxis<T> {
    /// The same cylinder with `f` of every number.
    pub fn map<U>(&self, f: &mut dyn FnMut(T) -> U) -> HydraulicAxis<U> {
        HydraulicAxis {
            chambers: self.chambers.map(f),
            valve: self.valve.map(f),
            compensator_lag: in_chains(self.compensator_lag).map(|lag| lag.map(f)),
            priority: in_chains(self.priority).map(|priority| priority.map(f)),
            port_valves: self.port_valves.map(|valves| valves.map(f)),
            crossover: self.crossover.map(f),
            leaks: self.leaks.map(|leak| in_chains(leak).map(|leak| leak.map(f))),
            spool: self.spool.map(f),
            leakage: self.leakage.map(f),
            connector: self.connector.map(f),
            end_stop: self.end_stop.map(f),
            friction: self.friction.map(f),
        }
    }
}

impl<T: Copy> FrictionLaw<T> {
    pub fn map<U>(&self, f: &mut dyn FnMut(T) -> U) -> FrictionLaw<U> {
        match self {
            FrictionLaw::Static { map, width } => FrictionLaw::Static { map: map.map(f), width: f(*width) },
            FrictionLaw::Printed { map, width } => FrictionLaw::Printed { map: map.map(f), width: width.map(f) },
            FrictionLaw::LuGre { map, bristle } => FrictionLaw::LuGre { map: map.map(f), bristle: bristle.map(f) },
        }
    }
}
