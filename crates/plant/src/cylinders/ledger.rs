//! Energy ledger: the powers whose integrals account for the work of the supply.
//!
//! With U the oil's elastic energy, T + V the mechanical energy, and the energies of end stops, bristles and ground:
//! ```text
//! d(U + T + V + stops + bristles + ground)/dt = supply - tank + elastic
//!     - edges - connectors - internal leakage - external leakage - friction - end stops - contact
//! ```
//! `elastic` is the strain energy that oil carries with it through the chamber boundaries (w q, with w the
//! energy density at the chamber's pressure). Compensators add their losses; the loss of an edge from the supply is
//! then that of its own drop. Relief and anti-cavitation valves of the ports are two more losses, cross-over relief valves, the
//! resistance of the lines, the priority elements of sections that give way and hoses that leak are others. With a pump, the energy of the mains is stored too:
//! ```text
//! d(mains)/dt = shaft + suction + elastic - mechanical loss - pump leakage - relief - delivered
//! ```
//! where `delivered` is the `supply` of all cylinders. A tank line stores energy as well:
//! ```text
//! d(tank line)/dt = returned + relieved + elastic - resistance - filter - bypass - into the tank
//! ```
//! where `returned` is the `tank` of all cylinders. `work` (net force times velocity) is a transfer within the sum.

use crate::cylinders::hydraulic_axis::SupplyPressures;

use crate::cylinders::local::{LocalRates, LocalState};
use crate::cylinders::supply::{Shares, Supply, SupplyRates};
use hydrocrane_machine::model::Cylinder;
use hydrocrane_machine::Machine;
use hydrocrane_num::{functions::smooth, Real};
use hydrocrane_physics::hydraulics::fluid::ElasticEnergy;
use hydrocrane_physics::hydraulics::tank_line::TankLine;

/// Name, meaning and sign in the balance.
pub type Term = (&'static str, &'static str, f64);

pub const LEDGER_PER_CYLINDER: usize = 13;

/// Name, meaning and sign in the balance of each term.
pub const LEDGER_TERMS: [Term; LEDGER_PER_CYLINDER] = [
    ("work", "work of the net cylinder force on the crane", 0.0),
    ("supply", "work of the supply", 1.0),
    ("tank", "work into the tank", -1.0),
    ("edge_pa", "loss of the metering edge supply to A", -1.0),
    ("edge_at", "loss of the metering edge A to tank", -1.0),
    ("edge_pb", "loss of the metering edge supply to B", -1.0),
    ("edge_bt", "loss of the metering edge B to tank", -1.0),
    ("connector", "work against the connector pressure rise", -1.0),
    ("internal_leakage", "loss of the leakage past the piston", -1.0),
    ("external_leakage", "loss of the leakage at the rod", -1.0),
    ("elastic", "elastic energy carried in with the oil", 1.0),
    ("friction", "heat of seal friction", -1.0),
    ("end_stop", "heat of end stop damping", -1.0),
];

/// The same for the ground.
pub const GROUND_TERMS: [Term; 1] = [("contact", "heat of the contact with the ground", -1.0)];

/// The same for pressure compensators.
pub const COMPENSATOR_TERMS: [Term; 1] = [("compensators", "loss of the pressure compensators of all valves", -1.0)];

/// The same for the valves between the cylinders' ports and the tank.
pub const PORT_VALVE_TERMS: [Term; 2] = [
    ("port_relief", "loss of the relief valves of all ports", -1.0),
    ("anti_cavitation", "loss of the anti-cavitation valves of all ports", -1.0),
];

/// The same for cross-over relief valves.
pub const CROSSOVER_TERMS: [Term; 1] =
    [("crossover_relief", "loss of the cross-over relief valves of all cylinders", -1.0)];

/// The same for sections that give way to another one.
pub const PRIORITY_TERMS: [Term; 1] =
    [("priority", "loss of the priority elements of all sections that give way", -1.0)];

/// The same for lines with a resistance.
pub const LINE_TERMS: [Term; 1] = [("resistance", "loss of the resistance of all lines to the cylinders", -1.0)];

/// The same for hoses that leak.
pub const LEAK_TERMS: [Term; 1] = [(
    "leaks",
    "loss of the oil that leaves through leaking hoses, and of the valves that hold a load before these",
    -1.0,
)];

/// The same for a pump with its mains, or for the sums over all pumps. What the mains deliver is the work of the supply on all cylinders.
pub const SUPPLY_TERMS: [Term; 7] = [
    ("shaft", "work of the shaft on the pump", 1.0),
    ("suction", "work of the tank on what the pump draws less what the relief valve returns", 1.0),
    ("mechanical_loss", "hydromechanical loss of the pump", -1.0),
    ("pump_leakage", "loss of the leakage of the pump", -1.0),
    ("relief", "loss of the relief valve", -1.0),
    ("delivered", "work of the mains on the valves", -1.0),
    ("carried", "elastic energy carried in with the oil", 1.0),
];

/// The same for a tank line: it takes up the work into the tank of all cylinders, and that of what the relief valve returns.
pub const TANK_LINE_TERMS: [Term; 7] = [
    ("returned", "work of what the sections return on the tank line", 1.0),
    ("relieved", "work of what the main relief valve returns on the tank line", 1.0),
    ("resistance", "loss of the resistance of the tank line", -1.0),
    ("filter", "loss of the return filter", -1.0),
    ("bypass", "loss of the bypass valve of the return filter", -1.0),
    ("into_tank", "work into the tank", -1.0),
    ("carried", "elastic energy carried in with the oil", 1.0),
];

/// Elastic energy that is not known: the powers of terms that need it are no numbers.
pub struct NoElasticEnergy;

impl ElasticEnergy for NoElasticEnergy {
    fn energy_density<T: Real>(&self, _: T) -> T {
        T::c(f64::NAN)
    }
}

/// All terms of the circuit in the order of the powers, each with its owner.
pub fn terms(machine: &Machine) -> Vec<(&str, &'static Term)> {
    let of_cylinders = machine.cylinders.iter().flat_map(|c| LEDGER_TERMS.iter().map(|term| (c.name.as_str(), term)));
    of_cylinders.chain(shared_terms(machine)).collect()
}

/// Terms after those of the cylinders, each with its owner: of ground, compensators, port valves, cross-over relief valves, priority,
/// lines, hoses that leak, supply and tank line, if the machine has them.
pub fn shared_terms(machine: &Machine) -> Vec<(&'static str, &'static Term)> {
    let ground = machine.ground.iter().flat_map(|_| GROUND_TERMS.iter().map(|term| ("ground", term)));
    let supply = machine.supply.mains.iter().flat_map(|_| SUPPLY_TERMS.iter().map(|term| ("mains", term)));
    let compensated = machine.cylinders.iter().any(|c| !c.valve.compensator.is_none());
    let valves = COMPENSATOR_TERMS.iter().filter(|_| compensated).map(|term| ("valves", term));
    let at_ports = machine.cylinders.iter().any(Cylinder::has_port_valves);
    let ports = PORT_VALVE_TERMS.iter().filter(|_| at_ports).map(|term| ("valves", term));
    let crossing = machine.cylinders.iter().any(Cylinder::has_crossover_relief);
    let crossover = CROSSOVER_TERMS.iter().filter(|_| crossing).map(|term| ("valves", term));
    let first = machine.supply.mains.as_ref().is_some_and(|mains| mains.priority.is_some());
    let priority = PRIORITY_TERMS.iter().filter(|_| first).map(|term| ("valves", term));
    let resisting = machine.cylinders.iter().any(Cylinder::has_line_resistance);
    let lines = LINE_TERMS.iter().filter(|_| resisting).map(|term| ("lines", term));
    let leaking = machine.cylinders.iter().any(Cylinder::has_hose_leak);
    let leaks = LEAK_TERMS.iter().filter(|_| leaking).map(|term| ("lines", term));
    let returns = machine.supply.mains.iter().filter(|mains| mains.tank_line.is_some());
    let tank_line = returns.flat_map(|_| TANK_LINE_TERMS.iter().map(|term| ("tank_line", term)));
    ground
        .chain(valves)
        .chain(ports)
        .chain(crossover)
        .chain(priority)
        .chain(lines)
        .chain(leaks)
        .chain(supply)
        .chain(tank_line)
        .collect()
}

/// Power lost in both lines, W.
#[inline(always)]
pub fn line_power<T: Real>(r: &LocalRates<T>) -> T {
    r.line_drops[0] * r.edges.port_a() - r.line_drops[1] * r.edges.port_b()
}

/// Power lost through hoses that leak, W: that of the oil that leaves, at the pressure of the hose, and of what comes out of the chamber
/// over the drop to it.
#[inline(always)]
pub fn leak_power<T: Real>(r: &LocalRates<T>) -> T {
    let (e, p) = (&r.edges, &r.ports);
    let port = |number: usize, pressure: T, inflow: T| {
        let (lost, drop) = (r.lost[number], r.hose_drops[number]);
        (pressure - drop) * lost + drop * (lost - inflow)
    };
    port(0, p.a, e.port_a()) + port(1, p.b, -e.port_b())
}

/// Powers (W) in the order of [`SUPPLY_TERMS`]; `stored` is the oil's energy density in the mains, J/m^3, `e` the shares of the
/// displacements, `drawn` the flow to the valves, m^3/s.
#[inline(always)]
pub fn supply_powers<T: Real>(
    stored: T,
    pressures: &SupplyPressures<T>,
    e: &Shares<T>,
    drawn: T,
    supply: &Supply<T>,
    rates: &SupplyRates<T>,
) -> [T; SUPPLY_TERMS.len()] {
    let SupplyPressures { supply: p, tank, .. } = *pressures;
    let reservoir = supply.reservoir(tank);
    let rise = p - reservoir;
    let (mut leaked, mut rubbed, mut shaft) = (T::c(0.0), T::c(0.0), T::c(0.0));
    for (of, e) in supply.pumps().zip(e) {
        let lost = of.pump.losses(*e, rise);
        (leaked, rubbed, shaft) = (leaked + lost.0, rubbed + lost.1, shaft + of.pump.shaft_power(*e, rise));
    }
    let suction = match supply.tank_line {
        Some(_) => reservoir * rates.pump_flow - tank * rates.relief_flow,
        None => tank * (rates.pump_flow - rates.relief_flow),
    };
    [
        shaft,
        suction,
        rubbed,
        leaked,
        (p - tank) * rates.relief_flow,
        p * drawn,
        stored * (rates.pump_flow - rates.relief_flow - drawn),
    ]
}

/// Powers (W) in the order of [`TANK_LINE_TERMS`]; `stored` is the oil's energy density in the line, J/m^3, `p` its pressure, Pa,
/// `returned` and `relieved` the flows of the sections and of the main relief valve into it, m^3/s.
#[inline(always)]
pub fn tank_line_powers<T: Real>(
    stored: T,
    p: T,
    [returned, relieved]: [T; 2],
    line: &TankLine<T>,
) -> [T; TANK_LINE_TERMS.len()] {
    let out = line.flow(p);
    [
        p * returned,
        p * relieved,
        line.resistance.drop(out.whole) * out.whole,
        out.filter_drop * (out.whole - out.bypassed),
        out.filter_drop * out.bypassed,
        line.tank * out.whole,
        stored * (returned + relieved - out.whole),
    ]
}

/// Powers (W) in the order of [`PORT_VALVE_TERMS`]: flow from a port is a loss of its relief valve, flow into it of its
/// anti-cavitation valve.
#[inline(always)]
pub fn port_valve_powers<T: Real>(r: &LocalRates<T>) -> [T; PORT_VALVE_TERMS.len()] {
    let (a, b) = (r.ports.a - r.ports.tank, r.ports.b - r.ports.tank);
    let [at_a, at_b] = r.relieved;
    [
        a * smooth::positive_part(at_a) + b * smooth::positive_part(at_b),
        -(a * smooth::positive_part(-at_a) + b * smooth::positive_part(-at_b)),
    ]
}

/// Power lost in the cross-over relief valves, W.
#[inline(always)]
pub fn crossover_power<T: Real>(r: &LocalRates<T>) -> T {
    (r.ports.a - r.ports.b) * r.crossed
}

/// Powers (W) in the order of [`LEDGER_TERMS`]; `stored` are the oil's energy densities in the two chambers, J/m^3, `through`
/// the flows of a motor from side to side, m^3/s, `compensated` the losses of compensators and priority elements before the two ports, W.
#[inline(always)]
pub fn powers<T: Real>(
    stored: [T; 2],
    through: (T, T),
    s: &LocalState<T>,
    r: &LocalRates<T>,
    compensated: &[T; 2],
) -> [T; LEDGER_PER_CYLINDER] {
    let (p, behind) = (&r.at_valve(), &r.ports);
    let e = &r.edges;
    let (q_a, q_b) = r.through_ports();
    let inflow_1 = q_a - r.internal_leakage - through.0;
    let inflow_2 = r.internal_leakage - r.external_leakage - q_b + through.1;
    [
        r.force * s.v,
        p.supply * e.supply(),
        p.tank * r.returned(),
        (p.supply - p.a) * e.supply_to_a - compensated[0],
        (p.a - p.tank) * e.a_to_tank,
        (p.supply - p.b) * e.supply_to_b - compensated[1],
        (p.b - p.tank) * e.b_to_tank,
        (behind.a - s.p1) * q_a + (s.p2 - behind.b) * q_b,
        (s.p1 - s.p2) * r.internal_leakage,
        (s.p2 - p.tank) * r.external_leakage,
        stored[0] * inflow_1 + stored[1] * inflow_2,
        r.friction * s.v - r.bristle_power,
        -(r.stop_damping * s.v),
    ]
}
