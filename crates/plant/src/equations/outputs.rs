//! Outputs of a run besides its states.

use crate::cylinders::hydraulic_axis::FrictionLaw;

use crate::cylinders::local::LocalState;
use crate::cylinders::supply::{Demand, SupplyRates};
use crate::equations::plant::Plant;
use crate::equations::rhs::Evaluated;
use hydrocrane_machine::model::{Cylinder, Mains};
use hydrocrane_machine::Machine;
use hydrocrane_num::Real;
use hydrocrane_physics::hydraulics::compensator::Compensator;
use hydrocrane_physics::hydraulics::tank_line::Return;

/// Name, unit and meaning of one output.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OutputInfo {
    pub name: String,
    pub unit: &'static str,
    pub long_name: String,
}

const PER_CYLINDER: [(&str, &str, &str); 6] = [
    ("x", "m", "piston position from mid-stroke"),
    ("v", "m/s", "piston velocity"),
    ("force", "N", "net force on the rod, positive outward"),
    ("friction", "N", "seal friction, positive against positive velocity"),
    ("q1", "m^3/s", "flow into the piston side"),
    ("q2", "m^3/s", "flow out of the rod side"),
];

/// Elastic energy of the oil, whose tables take longer to build than a run of a few seconds.
pub const OIL_ENERGY: &str = "energy.oil";

const GLOBAL: [(&str, &str, &str); 9] = [
    ("tip.x", "m", "crane tip, forward"),
    ("tip.z", "m", "crane tip, up"),
    ("supply.flow", "m^3/s", "flow drawn from the pump"),
    ("supply.power", "W", "power drawn from the pump"),
    ("energy.kinetic", "J", "kinetic energy of the links"),
    ("energy.potential", "J", "potential energy of the links"),
    (
        OIL_ENERGY,
        "J",
        "elastic energy of the oil in chambers, mains and tank line, of the hoses, and of the gas in an accumulator",
    ),
    ("energy.end_stops", "J", "energy in the springs of the end stops"),
    ("energy.bristles", "J", "energy in the bristles of LuGre friction"),
];

/// Further output of a machine in space.
const OF_SPACE: [(&str, &str, &str); 1] = [("tip.y", "m", "crane tip, to the left")];

/// Further outputs if there is a ground.
const OF_GROUND: [(&str, &str, &str); 3] = [
    ("energy.ground", "J", "energy in the spring of the ground"),
    ("tip.contact.x", "N", "force of the ground on the tip or its load, forward"),
    ("tip.contact.z", "N", "force of the ground on the tip or its load, up"),
];

/// Further outputs if there is a pump.
const OF_MAINS: [(&str, &str, &str); 4] = [
    ("mains.pump_flow", "m^3/s", "flow of all pumps into the mains"),
    ("mains.relief_flow", "m^3/s", "flow through the main relief valve"),
    ("mains.shaft_power", "W", "power of the shafts of all pumps"),
    ("mains.shaft_speed", "rad/s", "speed of the shaft of the first pump"),
];

/// Further outputs of each pump if there are several.
const OF_PUMPS: [(&str, &str, &str); 3] = [
    ("flow", "m^3/s", "flow into the mains"),
    ("shaft_power", "W", "power of the shaft"),
    ("shaft_speed", "rad/s", "speed of the shaft"),
];

/// Further outputs if a pump follows its pressure or the load.
const OF_CONTROL: [(&str, &str, &str); 2] = [
    ("mains.setting", "Pa", "pressure that the pump keeps without flow, or at which it is unloaded"),
    ("mains.shortfall", "Pa", "pressure that the mains lack; above zero while the pump cannot give what is asked for"),
];

/// Further output if a section is served first.
const OF_PRIORITY: [(&str, &str, &str); 1] =
    [("mains.priority", "1", "share of its flow that each section gets that gives way to the one served first")];

/// Further outputs if there is a tank line.
const OF_TANK_LINE: [(&str, &str, &str); 4] = [
    ("tank_line.returned", "m^3/s", "flow of valves, leakage and main relief valve into the tank line"),
    ("tank_line.flow", "m^3/s", "flow of the tank line into the tank"),
    ("tank_line.filter_drop", "Pa", "pressure drop over the return filter"),
    ("tank_line.bypass_flow", "m^3/s", "flow through the bypass valve of the return filter"),
];

/// Further output of each cylinder whose valve has a pressure compensator.
const COMPENSATOR_DROP: (&str, &str, &str) =
    ("compensator_drop", "Pa", "drop that the compensator takes before the port that is fed");

fn compensated(machine: &Machine) -> impl Iterator<Item = &str> {
    machine.cylinders.iter().filter(|c| !c.valve.compensator.is_none()).map(|c| c.name.as_str())
}

/// Further outputs of each cylinder if any has port valves.
const AT_PORTS: [(&str, &str, &str); 2] = [
    (
        "relieved1",
        "m^3/s",
        "flow from the piston-side port through its relief valve to the tank, negative through its anti-cavitation valve",
    ),
    ("relieved2", "m^3/s", "the same from the rod-side port"),
];

/// Further output of each cylinder if any has cross-over relief valves.
const CROSSED: [(&str, &str, &str); 1] = [(
    "crossed",
    "m^3/s",
    "flow from the piston-side port through its cross-over relief valve to the rod-side port, negative the other way",
)];

/// Further outputs of each cylinder if a hose of one may leak.
const LOST: [(&str, &str, &str); 2] = [
    ("lost1", "m^3/s", "flow from the hose of the piston side to the outside"),
    ("lost2", "m^3/s", "the same from the hose of the rod side"),
];

/// Further outputs of each cylinder if the line to one has a resistance.
const IN_LINES: [(&str, &str, &str); 2] = [
    ("line_drop1", "Pa", "pressure drop over the line to the piston side, positive while oil flows to the cylinder"),
    ("line_drop2", "Pa", "the same over the line to the rod side"),
];

/// Range of the stored energies among the outputs.
pub fn energies(machine: &Machine) -> std::ops::Range<usize> {
    // A machine in space has no ground.
    4..GLOBAL.len() + usize::from(machine.ground.is_some())
}

/// The outputs of a machine, in the order of [`write`].
pub fn info(machine: &Machine) -> Vec<OutputInfo> {
    let owned = |name: String, unit, long_name: String| OutputInfo { name, unit, long_name };
    let of_space = if machine.is_spatial() { &OF_SPACE[..] } else { &[] };
    let of_ground = if machine.ground.is_some() { &OF_GROUND[..] } else { &[] };
    let of_mains = if machine.supply.mains.is_some() { &OF_MAINS[..] } else { &[] };
    let controlled = |mains: &Mains| mains.pump.control.is_some() || mains.load_sensing.is_some();
    let of_control = if machine.supply.mains.as_ref().is_some_and(controlled) { &OF_CONTROL[..] } else { &[] };
    let first = machine.supply.mains.as_ref().is_some_and(|mains| mains.priority.is_some());
    let of_priority = if first { &OF_PRIORITY[..] } else { &[] };
    let returns = machine.supply.mains.as_ref().is_some_and(|mains| mains.tank_line.is_some());
    let of_tank_line = if returns { &OF_TANK_LINE[..] } else { &[] };
    let global = GLOBAL
        .iter()
        .chain(of_space)
        .chain(of_ground)
        .chain(of_mains)
        .chain(of_control)
        .chain(of_priority)
        .chain(of_tank_line);
    let mut all: Vec<OutputInfo> = global.map(|(n, u, l)| owned((*n).to_string(), *u, (*l).to_string())).collect();
    let pumps: Vec<_> = machine.supply.mains.iter().flat_map(Mains::pumps).collect();
    if pumps.len() > 1 {
        for pump in pumps {
            let own = OF_PUMPS.iter().map(|(name, unit, long_name)| {
                owned(format!("pump.{}.{name}", pump.name), *unit, format!("{} {long_name}", pump.name))
            });
            all.extend(own);
        }
    }
    let at_ports = machine.cylinders.iter().any(Cylinder::has_port_valves);
    let lines = machine.cylinders.iter().any(Cylinder::has_line_resistance);
    let crossing = machine.cylinders.iter().any(Cylinder::has_crossover_relief);
    let leaking = machine.cylinders.iter().any(Cylinder::has_hose_leak);
    let optional = [(at_ports, &AT_PORTS[..]), (crossing, &CROSSED[..]), (lines, &IN_LINES[..]), (leaking, &LOST[..])];
    let optional = optional.map(|(there, rows)| if there { rows } else { &[] });
    for rows in optional.into_iter().chain([&PER_CYLINDER[..]]) {
        for c in &machine.cylinders {
            for (name, unit, long_name) in rows {
                all.push(owned(format!("cylinder.{}.{name}", c.name), unit, format!("{} {long_name}", c.name)));
            }
        }
    }
    let (name, unit, long_name) = COMPENSATOR_DROP;
    all.extend(compensated(machine).map(|c| owned(format!("cylinder.{c}.{name}"), unit, format!("{c} {long_name}"))));
    all
}

/// Writes the outputs at one state; `energy_density` is that of the oil (Pa) as a function of pressure, `None` leaves NaN.
pub fn write<T: Real, const N: usize>(
    plant: &Plant<T, N>,
    energy_density: Option<impl Fn(T) -> T>,
    at: &Evaluated<T, N>,
    out: &mut [T],
) {
    let Evaluated { placed: e, rates, payload, .. } = at;
    let payload = *payload;
    let local: [LocalState<T>; N] = hydrocrane_num::array::from_fn(|c| e.local(at.layout, at.x, c));
    let tip = plant.tip_position(&e.pose);
    let mut drawn = T::c(0.0);
    rates.iter().for_each(|r| drawn += r.edges.supply());
    let (mut oil_energy, mut stops, mut bristles) = (T::c(0.0), T::c(0.0), T::c(0.0));
    for (unit, s) in plant.cylinders.iter().zip(&local) {
        oil_energy += match &energy_density {
            Some(energy_density) => {
                unit.chambers.energy((energy_density(s.p1), energy_density(s.p2)), s.x, (s.p1, s.p2))
            }
            None => T::c(f64::NAN),
        };
        stops += unit.end_stop.energy(s.x);
        if let FrictionLaw::LuGre { bristle, .. } = &unit.friction {
            bristles += bristle.energy(s.z);
        }
    }
    let supply = plant.supply_at(at.layout, at.x);
    if let (Some((unit, pressures, _)), Some(energy_density)) = (&supply, &energy_density) {
        oil_energy += unit.stored(energy_density, pressures);
    }
    let global = [
        tip.x,
        tip.z,
        drawn,
        drawn * plant.pressures_at(at.layout, at.x).supply,
        plant.kinetic_energy(&e.pose, &e.rates, payload),
        plant.potential_energy(&e.pose, payload),
        oil_energy,
        stops,
        bristles,
    ];
    let (first, mut rest) = out.split_at_mut(global.len());
    first.copy_from_slice(&global);
    if plant.space().is_some() {
        let (of_space, others) = rest.split_at_mut(OF_SPACE.len());
        of_space[0] = tip.y;
        rest = others;
    }
    if let Some(ground) = &plant.ground {
        let force = plant.mechanics.contact(ground, &e.pose, &e.rates, payload).force;
        let (of_ground, others) = rest.split_at_mut(OF_GROUND.len());
        of_ground.copy_from_slice(&[ground.energy(tip.in_plane(), payload), force.x, force.z]);
        rest = others;
    }
    if let Some((unit, pressures, e)) = supply {
        let SupplyRates { pump_flow, relief_flow, .. } =
            unit.rates(&plant.fluid, &pressures, &e, Demand { drawn, ..plant.no_demand(pressures.tank) });
        let (of_mains, others) = rest.split_at_mut(OF_MAINS.len());
        let rise = pressures.supply - unit.reservoir(pressures.tank);
        let pumps = || unit.pumps().map(|of| &of.pump).zip(&e);
        let mut shaft_power = T::c(0.0);
        pumps().for_each(|(pump, e)| shaft_power += pump.shaft_power(*e, rise));
        of_mains[..3].copy_from_slice(&[pump_flow, relief_flow, shaft_power]);
        pumps().take(1).for_each(|(pump, e)| of_mains[3] = pump.shaft_speed(*e, rise));
        rest = others;
        if unit.is_controlled() {
            let (setting, shortfall) = unit.setting_and_shortfall(&pressures, &e);
            let (of_control, others) = rest.split_at_mut(OF_CONTROL.len());
            of_control.copy_from_slice(&[setting, shortfall]);
            rest = others;
        }
        if let Some(priority) = plant.priority() {
            let (of_priority, others) = rest.split_at_mut(OF_PRIORITY.len());
            of_priority[0] = priority.share(pressures.supply, pressures.load);
            rest = others;
        }
        if let Some(Return { whole, bypassed, filter_drop }) = unit.into_tank(pressures.tank) {
            let mut returned = relief_flow;
            rates.iter().for_each(|r| returned += r.returned());
            let (of_tank_line, others) = rest.split_at_mut(OF_TANK_LINE.len());
            of_tank_line.copy_from_slice(&[returned, whole, filter_drop, bypassed]);
            rest = others;
        }
        let several = pumps().count() > 1;
        for (pump, e) in pumps().filter(|_| several) {
            let (of_pump, others) = rest.split_at_mut(OF_PUMPS.len());
            of_pump.copy_from_slice(&[pump.flow(*e, rise), pump.shaft_power(*e, rise), pump.shaft_speed(*e, rise)]);
            rest = others;
        }
    }
    if plant.has_port_valves() {
        let (relieved, others) = rest.split_at_mut(AT_PORTS.len() * N);
        relieved.iter_mut().zip(rates.iter().flat_map(|r| r.relieved)).for_each(|(out, flow)| *out = flow);
        rest = others;
    }
    if plant.has_crossover_relief() {
        let (crossed, others) = rest.split_at_mut(N);
        crossed.iter_mut().zip(rates).for_each(|(out, r)| *out = r.crossed);
        rest = others;
    }
    if plant.has_line_resistance() {
        let (drops, others) = rest.split_at_mut(IN_LINES.len() * N);
        drops.iter_mut().zip(rates.iter().flat_map(|r| r.line_drops)).for_each(|(out, drop)| *out = drop);
        rest = others;
    }
    if plant.has_hose_leak() {
        let (lost, others) = rest.split_at_mut(LOST.len() * N);
        lost.iter_mut().zip(rates.iter().flat_map(|r| r.lost)).for_each(|(out, flow)| *out = flow);
        rest = others;
    }
    let (of_cylinders, drops) = rest.split_at_mut(N * PER_CYLINDER.len());
    for ((s, r), row) in local.iter().zip(rates).zip(of_cylinders.chunks_exact_mut(PER_CYLINDER.len())) {
        let (q1, q2) = r.through_ports();
        row.copy_from_slice(&[s.x, s.v, r.force, r.friction, q1, q2]);
    }
    let with_compensator = plant.cylinders.iter().zip(&local).zip(rates);
    let with_compensator =
        with_compensator.filter(|((unit, _), _)| !matches!(unit.valve.compensator, Compensator::None));
    for (((unit, s), r), drop) in with_compensator.zip(drops) {
        *drop = unit.valve.compensator_drop(s.spool, &r.at_valve());
    }
}
