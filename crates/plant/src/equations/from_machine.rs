//! From a machine description to the parameters of the laws; only this file depends on both.

use crate::cylinders::hydraulic_axis::{FrictionLaw, HydraulicAxis, SupplyPressures};
use crate::cylinders::in_chains::in_chains;
use crate::cylinders::supply::{ControlledPump, Supply};
use crate::equations::plant::Plant;
use crate::errors::BuildError;
use hydrocrane_machine::{model as file, Number};
use hydrocrane_num::functions::curve::MonotoneCurve;
use hydrocrane_num::{functions::smooth, Real, Vec2, Vec3};
use hydrocrane_physics::dynamics::ground::{Ground, Soil, Support, MOST_SUPPORTS};
use hydrocrane_physics::dynamics::space::Tensor;
use hydrocrane_physics::dynamics::spatial::{Solid, SpatialMechanics};
use hydrocrane_physics::dynamics::{Body, Mechanics};
use hydrocrane_physics::friction::{lugre::LuGre, StaticParameters};
use hydrocrane_physics::geometry::four_bar::FourBar;
use hydrocrane_physics::geometry::frames::Joint;
use hydrocrane_physics::geometry::spatial_chain::Stance;
use hydrocrane_physics::geometry::stroke::{Actuation, Mounting};
use hydrocrane_physics::hydraulics::accumulator::Accumulator;
use hydrocrane_physics::hydraulics::chamber::Chambers;
use hydrocrane_physics::hydraulics::compensator::{Compensator, CompensatorLag};
use hydrocrane_physics::hydraulics::connector::{dynamic_pressure_coefficient, Connector};
use hydrocrane_physics::hydraulics::counterbalance::Counterbalance;
use hydrocrane_physics::hydraulics::crossover_relief::CrossoverRelief;
use hydrocrane_physics::hydraulics::end_stop::EndStop;
use hydrocrane_physics::hydraulics::fluid::Fluid;
use hydrocrane_physics::hydraulics::hose_burst::HoseBurst;
use hydrocrane_physics::hydraulics::hose_leak::HoseLeak;
use hydrocrane_physics::hydraulics::leakage::{annular_gap_conductance, Leakage};
use hydrocrane_physics::hydraulics::line::Resistance;
use hydrocrane_physics::hydraulics::load_holding::LoadHolding;
use hydrocrane_physics::hydraulics::load_sensing::{Connection, LoadSensing};
use hydrocrane_physics::hydraulics::mains::Mains;
use hydrocrane_physics::hydraulics::meter_out::MeterOut;
use hydrocrane_physics::hydraulics::metering::{Edge, Metering};
use hydrocrane_physics::hydraulics::orifice::{Orifice, OrificeLaw};
use hydrocrane_physics::hydraulics::pilot_check::PilotCheck;
use hydrocrane_physics::hydraulics::port_valves::{AntiCavitation, PortValves};
use hydrocrane_physics::hydraulics::priority::Priority;
use hydrocrane_physics::hydraulics::pump::{PressureControl, Pump};
use hydrocrane_physics::hydraulics::relief_valve::ReliefValve;
use hydrocrane_physics::hydraulics::spool::Spool;
use hydrocrane_physics::hydraulics::spool_valve::SpoolValve;
use hydrocrane_physics::hydraulics::tank_line::{Bypass, TankLine};
use std::f64::consts::{FRAC_PI_4, PI, TAU};

/// Share of a spool's stroke over which it connects its port with the load-sensing line.
const CONNECTION: f64 = 0.01;
/// Default velocity over which the static map changes its sign, m/s.
const SMOOTHING: f64 = 1e-3;

/// The plant of a machine with exactly `N` joints, with the derivatives that the machine was read with.
pub fn plant<T: Number, const N: usize>(m: &file::Machine<T>) -> Result<Plant<T, N>, BuildError> {
    if m.tip.link != N {
        return Err(BuildError::TipNotOnLastLink(m.links[m.tip.link].name.clone(), m.links[N].name.clone()));
    }
    let mut actuations = Vec::with_capacity(N);
    for c in &m.cylinders {
        actuations.push(actuation(m, c)?);
    }
    Ok(Plant {
        mechanics: Mechanics {
            joints: hydrocrane_num::array::from_fn(|i| joint(m, i)),
            bodies: hydrocrane_num::array::from_fn(|i| body(m, &m.links[i + 1])),
            tip: vector(m.tip.position),
            gravity: gravity(m),
        },
        space: in_chains(m.is_spatial().then_some(())).map(|()| spatial(m)).transpose()?,
        actuations: hydrocrane_num::array::from_fn(|i| actuations[i]),
        cylinders: hydrocrane_num::array::from_fn(|i| cylinder(m, &m.cylinders[i])),
        fluid: fluid(&m.fluid),
        supply_pressures: SupplyPressures {
            supply: m.supply.pressure,
            load: m.supply.tank_pressure,
            tank: m.supply.tank_pressure,
        },
        supply: in_chains(m.supply.mains.as_ref()).map(|mains| supply(&m.supply, mains)),
        ground: m.ground.as_ref().map(|g| ground(g, &m.payload, up(m))),
    })
}

/// The efficiencies of a data sheet are those at full displacement and the supply pressure.
fn supply<T: Number>(of: &file::Supply<T>, mains: &file::Mains<T>) -> Supply<T> {
    let rise = of.pressure - of.tank_pressure;
    Supply {
        pumps: hydrocrane_num::array::from_fn(|i| {
            mains.pumps().nth(i).map(|p| ControlledPump { pump: pump(p, rise), control: control(p), margin: p.margin })
        }),
        highest: of.pressure,
        sensing: mains
            .load_sensing
            .as_ref()
            .map(|sensing| LoadSensing { margin: sensing.margin, time_constant: sensing.time_constant }),
        mains: Mains { volume: mains.volume, compliance: mains.compliance },
        relief: ReliefValve { pressure: mains.relief_pressure, gradient: mains.relief_gradient },
        accumulator: mains.accumulator.as_ref().map(|a| Accumulator {
            volume: a.volume,
            precharge: a.precharge,
            exponent: a.polytropic_exponent,
        }),
        tank_line: mains.tank_line.as_ref().map(|line| tank_line(line, of.tank_pressure)),
    }
}

/// Its efficiencies are those at full displacement, its rated speed and the pressure `rise` (Pa).
fn pump<T: Number>(p: &file::Pump<T>, rise: T) -> Pump<T> {
    let displacement = p.displacement / TAU;
    Pump {
        displacement,
        speed: p.speed,
        droop: p.engine.as_ref().map_or(T::c(0.0), |engine| engine.droop * p.speed / engine.rated_torque),
        leakage: (T::c(1.0) - p.volumetric_efficiency) * displacement * p.rated_speed / rise,
        mechanical_loss: T::c(1.0) / p.hydromechanical_efficiency - 1.0,
    }
}

fn control<T: Number>(p: &file::Pump<T>) -> Option<PressureControl<T>> {
    p.control.as_ref().map(|control| PressureControl {
        range: control.range,
        time_constant: control.time_constant,
        torque_limit: control.torque_limit.unwrap_or(T::c(f64::INFINITY)),
    })
}

/// A filter passes its nominal flow at its nominal drop, and its bypass valve as much at the overpressure.
fn tank_line<T: Number>(of: &file::TankLine<T>, tank: T) -> TankLine<T> {
    let none = T::c(0.0);
    let bypass = |filter: &file::ReturnFilter<T>| {
        let own = filter.bypass.as_ref()?;
        Some(Bypass { pressure: own.pressure, gradient: filter.nominal_flow / own.overpressure })
    };
    TankLine {
        volume: Mains { volume: of.volume, compliance: of.compliance },
        tank,
        resistance: of.resistance.as_ref().map_or(Resistance { laminar: none, turbulent: none }, |of| Resistance {
            laminar: of.laminar,
            turbulent: of.turbulent,
        }),
        filter: of.filter.as_ref().map_or(none, |filter| filter.nominal_pressure_drop / filter.nominal_flow),
        bypass: of.filter.as_ref().and_then(bypass),
    }
}

fn vector<T: Real>([x, z]: [T; 2]) -> Vec2<T> {
    Vec2::new(x, z)
}

fn in_space<T: Real>([x, y, z]: [T; 3]) -> Vec3<T> {
    Vec3::new(x, y, z)
}

/// Unit vector against gravity in the frame of the base, which a slope turns.
fn up<T: Number>(m: &file::Machine<T>) -> Vec2<T> {
    let (sin, cos) = m.environment.slope.stated_sin_cos();
    Vec2::new(sin, cos)
}

fn gravity<T: Number>(m: &file::Machine<T>) -> Vec2<T> {
    let upwards = up(m) * m.environment.gravity;
    if m.errata.gravity_sign {
        upwards
    } else {
        Vec2::default() - upwards
    }
}

fn ground<T: Number>(g: &file::Ground<T>, load: &file::Payload<T>, up: Vec2<T>) -> Ground<T> {
    let mut supports: Vec<&file::Support<T>> = g.supports.iter().collect();
    supports.sort_by(|a, b| a.height.plain().total_cmp(&b.height.plain()));
    let support = |s: &file::Support<T>| Support { height: s.height, from: s.from, to: s.to, edge: s.edge };
    // Unused entries are ignored.
    let none = Support { height: 0.0, from: 0.0, to: 0.0, edge: 1.0 }.lift();
    Ground {
        soil: Soil {
            height: g.height,
            stiffness: g.stiffness,
            damping: g.damping,
            friction: g.friction,
            hang: load.hang,
            hang_growth: load.hang_growth,
        },
        up,
        supports: hydrocrane_num::array::from_fn(|i| supports.get(i).map_or(none, |s| support(s))),
        count: supports.len().min(MOST_SUPPORTS),
    }
}

fn joint<T: Number>(m: &file::Machine<T>, i: usize) -> Joint<T> {
    let j = &m.joints[i];
    let (at, zero) = (vector(j.at), j.zero);
    match j.kind {
        // In the plane across its own axis, with the origin on it.
        file::JointKind::Revolute(_) if j.axis.is_some() => {
            let (at, offset) = (Vec2::default(), T::c(0.0));
            Joint { at, direction: Vec2::default(), offset, zero, sense: T::c(j.sense), revolute: true }
        }
        file::JointKind::Revolute(convention) => {
            let folded = if convention == file::AngleConvention::Included { PI } else { 0.0 };
            let offset = m.links[i].axis - m.links[i + 1].axis - j.sense * folded;
            Joint { at, direction: Vec2::default(), offset, zero, sense: T::c(j.sense), revolute: true }
        }
        file::JointKind::Prismatic { direction } => {
            let (sin, cos) = direction.stated_sin_cos();
            let direction = Vec2::new(cos * j.sense, sin * j.sense);
            Joint { at, direction, offset: T::c(0.0), zero, sense: T::c(0.0), revolute: false }
        }
    }
}

/// The chain in space of the same links and joints.
fn spatial<T: Number, const N: usize>(m: &file::Machine<T>) -> Result<SpatialMechanics<T, N>, BuildError> {
    let mut solids = Vec::with_capacity(N);
    for link in &m.links[1..] {
        let Some(of) = link.solid else { return Err(BuildError::Flat(link.name.clone())) };
        let Body { mass, x, z, inertia: yy } = body(m, link);
        let inertia = Tensor { xx: of.xx, yy, zz: of.zz, xy: of.xy, xz: of.xz, yz: of.yz };
        solids.push(Solid { mass, centre_of_gravity: Vec3::new(x, of.y, z), inertia });
    }
    let stance = |i: usize| Stance {
        at: in_space(m.joints[i].at_in_space()),
        axis: Vec3::c(m.joints[i].turning_axis()),
        direction: Vec3::of(joint(m, i).direction, T::c(0.0)),
        leaves_plane: m.joints[i].axis.is_some(),
    };
    Ok(SpatialMechanics {
        stances: hydrocrane_num::array::from_fn(stance),
        solids: hydrocrane_num::array::from_fn(|i| solids[i]),
        tip: in_space(m.tip.in_space()),
        gravity: Vec3::of(gravity(m), T::c(0.0)),
    })
}

/// The inertia about the centre of gravity, by the parallel axis theorem if the file gives that about the frame.
fn body<T: Number>(m: &file::Machine<T>, link: &file::Link<T>) -> Body<T> {
    let [x, z] = link.centre_of_gravity;
    let shift = match link.inertia_about {
        file::InertiaAbout::Frame if m.errata.inertia_about => link.mass * (x * x + z * z),
        _ => T::c(0.0),
    };
    Body { mass: link.mass, x, z, inertia: link.inertia - shift }
}

fn actuation<T: Number>(m: &file::Machine<T>, c: &file::Cylinder<T>) -> Result<Actuation<T>, BuildError> {
    let parent = c.joint;
    let barrel = vector(c.barrel_pin.position);
    let mounting = match &c.rod_pin {
        file::RodPin::Point(rod) => {
            let barrel_on_child = c.barrel_pin.link != parent;
            let (on_parent, on_child) = if barrel_on_child { (rod, &c.barrel_pin) } else { (&c.barrel_pin, rod) };
            let (on_parent, before) = beside(&m.joints[parent], on_parent, true);
            let (on_child, behind) = beside(&m.joints[parent], on_child, false);
            Mounting::Pins { on_parent, on_child, barrel_on_child, aside: before - behind }
        }
        file::RodPin::FourBar(l) => {
            if c.barrel_pin.link != parent {
                return Err(BuildError::BarrelOnChild(c.name.clone(), m.links[parent].name.clone()));
            }
            let linkage = FourBar {
                rocker_pivot: vector(l.rocker_pivot.position),
                coupler_pivot: vector(l.coupler_pivot.position),
                rocker_length: l.rocker_length,
                coupler_length: l.coupler_length,
                side: T::c(l.side),
            };
            Mounting::FourBar { barrel, linkage }
        }
        // Mid-stroke lies where the joint is at zero.
        file::RodPin::Rack(radius) => Mounting::Rack { radius: *radius },
    };
    Ok(Actuation { mounting, mid_length: c.mid_length })
}

/// A pin in the plane across the axis of a joint, and its place along that axis; of a joint with an axis of its own, seen from the joint.
fn beside<T: Number>(joint: &file::Joint<T>, pin: &file::Point<T>, on_parent: bool) -> (Vec2<T>, T) {
    let from = if on_parent { joint.aside } else { T::c(0.0) };
    let Some(axis) = joint.axis else { return (vector(pin.position), from - pin.aside) };
    let place = in_space(pin.in_space());
    let place = if on_parent { place - in_space(joint.at_in_space()) } else { place };
    let axis = Vec3::<f64>::c(axis);
    // The nearer of x and y to a right angle with the axis, as that across the plane of x and z has x.
    let near =
        if axis.x.abs() < axis.y.abs().max(axis.z.abs()) { Vec3::c([1.0, 0.0, 0.0]) } else { Vec3::c([0.0, 1.0, 0.0]) };
    let first = near - axis * near.dot(axis);
    let first = first * (1.0 / first.norm());
    let along = |unit: Vec3<f64>| place.dot(Vec3::c([unit.x, unit.y, unit.z]));
    (Vec2::new(along(first), along(axis.cross(first))), along(axis))
}

fn circle<T: Real>(diameter: T) -> T {
    diameter * FRAC_PI_4 * diameter
}

fn cylinder<T: Number>(m: &file::Machine<T>, c: &file::Cylinder<T>) -> HydraulicAxis<T> {
    // The cylinders in parallel are one with the sum of their areas, volumes, leaks, forces and stiffnesses.
    let [area_1, area_2] = c.areas();
    let dead = match c.printed_dead_volume {
        Some(printed) if !m.errata.extension_dead_volume => printed,
        _ => c.dead_volume,
    }
    .map(|of_one| of_one * c.count);
    let dynamic = |area: T| {
        let ports = |d: T| circle(d) * c.count;
        c.port_diameter.map_or(T::c(0.0), |d| dynamic_pressure_coefficient(m.fluid.density, area, ports(d)))
    };
    let at_middle = |dead: T, area: T| if c.motor { dead } else { dead + area * c.stroke / 2.0 };
    let with_line = |side: usize, volume: T| c.ports.lines[side].as_ref().map_or(volume, |line| volume + line.volume);
    let compliance = |side: usize| c.ports.lines[side].as_ref().map_or(T::c(0.0), |line| line.compliance);
    let boundless = T::c(f64::INFINITY);
    HydraulicAxis {
        chambers: Chambers {
            area_1,
            area_2,
            mid_volume_1: with_line(0, at_middle(dead[0], area_1)),
            mid_volume_2: with_line(1, at_middle(dead[1], area_2)),
            compliance_1: compliance(0),
            compliance_2: compliance(1),
            elastic: c.has_elastic_line(),
            motor: c.motor,
        },
        valve: valve(m, c),
        compensator_lag: in_chains(c.valve.compensator_time_constant)
            .map(|time_constant| CompensatorLag { time_constant }),
        priority: priority(&m.supply, c),
        port_valves: hydrocrane_num::array::from_fn(|side| port_valves(&c.ports.valves[side])),
        crossover: CrossoverRelief {
            from: hydrocrane_num::array::from_fn(|side| in_chains(c.ports.crossover[side].as_ref()).map(port_relief)),
        },
        leaks: hydrocrane_num::array::from_fn(|side| {
            in_chains(c.ports.leaks[side].as_ref()).map(|leak| hose_leak(leak, &m.fluid))
        }),
        spool: Spool {
            natural_frequency: c.valve.spool.natural_frequency,
            damping_ratio: c.valve.spool.damping_ratio,
            velocity_limit: c.valve.spool.velocity_limit.unwrap_or(boundless),
            acceleration_limit: c.valve.spool.acceleration_limit.unwrap_or(boundless),
        },
        leakage: leakage(m, c),
        connector: Connector { piston_side: dynamic(area_1), rod_side: dynamic(area_2) },
        end_stop: end_stop(m, c),
        friction: friction(m, &c.friction, c.count),
    }
}

fn valve<T: Number>(m: &file::Machine<T>, c: &file::Cylinder<T>) -> SpoolValve<T> {
    let v = &c.valve;
    let edge = |port: usize| {
        let blend = v.printed_blend.as_ref();
        let law = if m.errata.orifice_law {
            OrificeLaw::TwoRegime
        } else {
            OrificeLaw::Printed { blended: blend.is_some_and(|b| b.ports[port]) }
        };
        Orifice {
            coefficient: v.nominal_flow / ((v.stroke - v.overlap) * v.edge_pressure_drop.sqrt()),
            transition_pressure: v.transition_pressure,
            laminar_curvature: smooth::root_curvature(v.transition_pressure),
            blend_low: blend.map_or(T::c(0.0), |b| b.low),
            blend_high: blend.map_or(T::c(1.0), |b| b.high),
            law,
        }
    };
    SpoolValve {
        edge_a: edge(0),
        edge_b: edge(1),
        overlap: v.overlap,
        nominal_opening: v.stroke - v.overlap,
        metering: metering(v),
        meter_out: [0, 1].map(|port| {
            let of = in_chains(v.meter_out[port].as_ref());
            of.map(|of| MeterOut { pressure: of.pressure, range: of.range })
        }),
        leakage: v.leakage,
        return_ratio: v.return_ratio,
        regenerative: T::c(if v.kind == file::ValveKind::Regenerative { 1.0 } else { 0.0 }),
        load_check: v.load_check,
        compensator: match v.compensator {
            file::Compensator::None => Compensator::None,
            file::Compensator::Before(setting) => Compensator::Before(setting),
            file::Compensator::Behind => Compensator::Behind,
        },
        connection: connection(v),
        holding: hydrocrane_num::array::from_fn(|side| in_chains(c.ports.holding[side].as_ref()).map(load_holding)),
        lines: hydrocrane_num::array::from_fn(|side| {
            let resistance = in_chains(c.ports.lines[side].as_ref()).and_then(|line| line.resistance.as_ref());
            resistance.map(|of| Resistance { laminar: of.laminar, turbulent: of.turbulent })
        }),
    }
}

/// `None` for the section that is served first, and where there is none.
fn priority<T: Number>(of: &file::Supply<T>, c: &file::Cylinder<T>) -> Option<Priority<T>> {
    let mains = in_chains(of.mains.as_ref())?;
    let (own, sensing) = (mains.priority.as_ref()?, mains.load_sensing.as_ref()?);
    (own.cylinder != c.joint).then(|| Priority {
        highest: if mains.pump.control.is_some() { of.pressure } else { mains.relief_pressure },
        margin: sensing.margin,
        kept: own.margin,
        range: own.range,
    })
}

fn port_valves<T: Number>(v: &file::PortValves<T>) -> PortValves<T> {
    PortValves {
        relief: in_chains(v.relief.as_ref()).map(port_relief),
        anti_cavitation: in_chains(v.anti_cavitation.as_ref()).map(|v| AntiCavitation {
            opening_pressure: v.opening_pressure,
            coefficient: v.nominal_flow / (v.nominal_pressure_drop - v.opening_pressure).sqrt(),
        }),
    }
}

fn hose_leak<T: Number>(of: &file::HoseLeak<T>, fluid: &file::Fluid<T>) -> HoseLeak<T> {
    HoseLeak { coefficient: of.discharge_coefficient * of.opening * (T::c(2.0) / fluid.density).sqrt() }
}

fn port_relief<T: Number>(v: &file::PortRelief<T>) -> ReliefValve<T> {
    ReliefValve { pressure: v.setting, gradient: v.nominal_flow / v.overpressure }
}

fn load_holding<T: Number>(v: &file::LoadHolding<T>) -> LoadHolding<T> {
    let coefficient = v.nominal_flow / v.nominal_pressure_drop.sqrt();
    match &v.kind {
        file::HoldingKind::Counterbalance(v) => LoadHolding::Counterbalance(Counterbalance {
            setting: v.setting,
            pilot_ratio: v.pilot_ratio,
            opening_pressure: v.opening_pressure,
            coefficient,
        }),
        file::HoldingKind::PilotCheck(v) => LoadHolding::PilotCheck(PilotCheck {
            pilot_ratio: v.pilot_ratio,
            spring: v.spring_pressure,
            opening_pressure: v.opening_pressure,
            coefficient,
        }),
        file::HoldingKind::HoseBurst(v) => {
            LoadHolding::HoseBurst(HoseBurst { closing_flow: v.closing_flow, bleed: v.bleed, coefficient })
        }
    }
}

/// The port is connected just before its metering edge opens, or over the first part of the stroke if the edges begin
/// at the middle.
fn connection<T: Number>(v: &file::Valve<T>) -> Connection<T> {
    let travel = v.stroke * CONNECTION;
    Connection { begins: (v.closed_zone() - travel).max(T::c(0.0)), travel }
}

/// `None` if no edge has a curve.
fn metering<T: Number>(v: &file::Valve<T>) -> Option<Metering<T>> {
    let mut curves: [Option<&file::EdgeCurve<T>>; 4] = hydrocrane_num::array::from_fn(|edge| v.metering[edge].as_ref());
    if v.kind == file::ValveKind::Regenerative {
        // With regeneration port B is connected to the supply while the piston extends.
        curves[Edge::BToTank as usize] = curves[Edge::SupplyToB as usize];
    }
    in_chains(curves.iter().any(Option::is_some).then_some(())).map(|()| Metering {
        stroke: v.stroke,
        full: curves.map(|curve| (v.stroke - v.overlap) * curve.map_or(T::c(1.0), |curve| curve.full)),
        curves: curves.map(|curve| curve.map(|curve| MonotoneCurve::new(&curve.points))),
    })
}

fn leakage<T: Number>(m: &file::Machine<T>, c: &file::Cylinder<T>) -> Leakage<T> {
    let of = |internal: T, external: T, external_from_piston_side: bool| Leakage {
        internal: internal * c.count,
        external: external * c.count,
        external_from_piston_side,
    };
    match c.leakage {
        file::Leakage::Conductance { internal, external } => of(internal, external, false),
        file::Leakage::Gap { gap, piston_length, gland_length, printed_external_from_piston_side } => {
            let viscosity = match m.fluid.printed_leakage_viscosity {
                Some(printed) if !m.errata.leakage_viscosity => printed,
                _ => m.fluid.viscosity,
            };
            of(
                annular_gap_conductance(c.bore, gap, piston_length, viscosity),
                annular_gap_conductance(c.rod_diameter, gap, gland_length, viscosity),
                printed_external_from_piston_side && !m.errata.extension_leakage,
            )
        }
    }
}

/// The stops end at the stroke end, or at the contact of the rod face with the barrel if that comes first.
fn end_stop<T: Number>(m: &file::Machine<T>, c: &file::Cylinder<T>) -> EndStop<T> {
    let upper = c.stroke / 2.0;
    let printed = !m.errata.end_stop;
    let lower = match c.rod_contact {
        Some(contact) if !printed => contact.max(-upper),
        _ => -upper,
    };
    let s = &c.end_stop;
    EndStop { lower, upper, zone: s.zone, stiffness: s.stiffness * c.count, damping: s.damping * c.count, printed }
}

/// Of so many equal seals together.
fn friction<T: Number>(m: &file::Machine<T>, f: &file::Friction<T>, count: T) -> FrictionLaw<T> {
    let [coulomb, breakaway, viscous] = [f.coulomb, f.breakaway, f.viscous].map(|of_one| of_one.map(|f| f * count));
    let map = StaticParameters {
        coulomb_extending: coulomb[0],
        coulomb_retracting: coulomb[1],
        breakaway_extending: breakaway[0],
        breakaway_retracting: breakaway[1],
        stribeck_velocity_extending: f.stribeck_velocity[0],
        stribeck_velocity_retracting: f.stribeck_velocity[1],
        stribeck_exponent_extending: f.stribeck_exponent[0],
        stribeck_exponent_retracting: f.stribeck_exponent[1],
        viscous_extending: viscous[0],
        viscous_retracting: viscous[1],
        viscous_exponent_extending: f.viscous_exponent[0],
        viscous_exponent_retracting: f.viscous_exponent[1],
        // The short cuts ignore the exponents, so they are not used for derivatives by these.
        gaussian: f.stribeck_exponent.iter().all(|exponent| exponent.always(2.0)),
        three_halves: f.viscous_exponent.iter().all(|exponent| exponent.always(1.5)),
    };
    match f.model {
        file::FrictionModel::LuGre => {
            let fading = f.bristle_damping_velocity.map_or(T::c(0.0), |v| T::c(1.0) / (v * v));
            let [stiffness, damping] = [f.bristle_stiffness, f.bristle_damping].map(|of_one| of_one * count);
            let bristle = LuGre { stiffness, damping, fading };
            FrictionLaw::LuGre { map, bristle }
        }
        file::FrictionModel::Static if m.errata.friction_map => {
            FrictionLaw::Static { map, width: f.smoothing_velocity.unwrap_or(T::c(SMOOTHING)) }
        }
        file::FrictionModel::Static => FrictionLaw::Printed { map, width: f.smoothing_velocity },
    }
}

fn fluid<T: Number>(f: &file::Fluid<T>) -> Fluid<T> {
    let (vacuum, ignore_cavitation) = match f.cavitation {
        file::Cavitation::FreeGas { vacuum } => (vacuum, false),
        file::Cavitation::None => (T::c(-1e5), true),
    };
    Fluid {
        density: f.density,
        bulk_max: f.bulk_modulus_max,
        rise: f.bulk_c1 / f.bulk_reference_pressure,
        c2: f.bulk_c2,
        vacuum,
        ignore_cavitation,
    }
}
