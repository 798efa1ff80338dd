//! From a machine description to the parameters of the laws: the one place where the two meet.

use crate::errors::BuildError;
use crate::hydraulic_axis::{FrictionLaw, HydraulicAxis, SupplyPressures};
use crate::plant::Plant;
use hydrocrane_machine::model as file;
use hydrocrane_num::{portable, smooth, Vec2};
use hydrocrane_physics::dynamics::ground::{Ground, Soil, Support, MOST_SUPPORTS};
use hydrocrane_physics::dynamics::{Body, Mechanics};
use hydrocrane_physics::friction::{lugre::LuGre, StaticParameters};
use hydrocrane_physics::geometry::four_bar::FourBar;
use hydrocrane_physics::geometry::frames::Joint;
use hydrocrane_physics::geometry::stroke::{Actuation, Drive};
use hydrocrane_physics::hydraulics::chamber::Chambers;
use hydrocrane_physics::hydraulics::connector::{dynamic_pressure_coefficient, Connector};
use hydrocrane_physics::hydraulics::end_stop::EndStop;
use hydrocrane_physics::hydraulics::fluid::Fluid;
use hydrocrane_physics::hydraulics::leakage::{annular_gap_conductance, Leakage};
use hydrocrane_physics::hydraulics::orifice::{Orifice, OrificeLaw};
use hydrocrane_physics::hydraulics::spool::Spool;
use hydrocrane_physics::hydraulics::spool_valve::SpoolValve;
use std::f64::consts::{FRAC_PI_4, PI};

/// Velocity over which the static map changes its sign where the file states none, m/s.
const SMOOTHING: f64 = 1e-3;

/// The plant of a machine with exactly `N` joints.
pub fn plant<const N: usize>(m: &file::Machine) -> Result<Plant<f64, N>, BuildError> {
    if m.tip.link != N {
        return Err(BuildError::TipNotOnLastLink(m.links[m.tip.link].name.clone(), m.links[N].name.clone()));
    }
    let mut actuations = Vec::with_capacity(N);
    for c in &m.cylinders {
        actuations.push(actuation(m, c)?);
    }
    Ok(Plant {
        mechanics: Mechanics {
            joints: std::array::from_fn(|i| joint(m, i)),
            bodies: std::array::from_fn(|i| body(m, &m.links[i + 1])),
            tip: Vec2::c(m.tip.position),
            gravity: if m.errata.gravity_sign { m.gravity } else { -m.gravity },
        },
        actuations: std::array::from_fn(|i| actuations[i]),
        cylinders: std::array::from_fn(|i| cylinder(m, &m.cylinders[i])),
        fluid: fluid(&m.fluid),
        supply_pressures: SupplyPressures { supply: m.supply.pressure, tank: m.supply.tank_pressure },
        ground: m.ground.as_ref().map(|g| ground(g, &m.payload)),
    })
}

fn ground(g: &file::Ground, load: &file::Payload) -> Ground<f64> {
    let mut supports: Vec<&file::Support> = g.supports.iter().collect();
    supports.sort_by(|a, b| a.height.total_cmp(&b.height));
    let support = |s: &file::Support| Support { height: s.height, from: s.from, to: s.to, edge: s.edge };
    // Places that stay free are not looked at.
    let none = Support { height: 0.0, from: 0.0, to: 0.0, edge: 1.0 };
    Ground {
        soil: Soil {
            height: g.height,
            stiffness: g.stiffness,
            damping: g.damping,
            friction: g.friction,
            hang: load.hang,
            hang_growth: load.hang_growth,
        },
        supports: std::array::from_fn(|i| supports.get(i).map_or(none, |s| support(s))),
        count: supports.len().min(MOST_SUPPORTS),
    }
}

fn joint(m: &file::Machine, i: usize) -> Joint<f64> {
    let j = &m.joints[i];
    let at = Vec2::c(j.at);
    match j.kind {
        file::JointKind::Revolute(convention) => {
            let folded = if convention == file::AngleConvention::Included { PI } else { 0.0 };
            let offset = m.links[i].axis - m.links[i + 1].axis - j.sense * folded;
            Joint { at, direction: Vec2::default(), offset, zero: j.zero, sense: j.sense, revolute: true }
        }
        file::JointKind::Prismatic { direction } => {
            let (sin, cos) = portable::sin_cos(direction);
            let direction = Vec2::new(j.sense * cos, j.sense * sin);
            Joint { at, direction, offset: 0.0, zero: j.zero, sense: 0.0, revolute: false }
        }
    }
}

/// The inertia about the centre of gravity, by the parallel axis theorem where the file gives the frame's.
fn body(m: &file::Machine, link: &file::Link) -> Body<f64> {
    let [x, z] = link.centre_of_gravity;
    let shift = match link.inertia_about {
        file::InertiaAbout::Frame if m.errata.inertia_about => link.mass * (x * x + z * z),
        _ => 0.0,
    };
    Body { mass: link.mass, x, z, inertia: link.inertia - shift }
}

fn actuation(m: &file::Machine, c: &file::Cylinder) -> Result<Actuation<f64>, BuildError> {
    let parent = c.joint;
    let barrel = Vec2::c(c.barrel_pin.position);
    let drive = match &c.rod_pin {
        file::RodPin::Point(rod) => {
            let rod = Vec2::c(rod.position);
            let barrel_on_child = c.barrel_pin.link != parent;
            let (on_parent, on_child) = if barrel_on_child { (rod, barrel) } else { (barrel, rod) };
            Drive::Pins { on_parent, on_child, barrel_on_child }
        }
        file::RodPin::FourBar(l) => {
            if c.barrel_pin.link != parent {
                return Err(BuildError::BarrelOnChild(c.name.clone(), m.links[parent].name.clone()));
            }
            let linkage = FourBar {
                rocker_pivot: Vec2::c(l.rocker_pivot.position),
                coupler_pivot: Vec2::c(l.coupler_pivot.position),
                rocker_length: l.rocker_length,
                coupler_length: l.coupler_length,
                side: l.side,
            };
            Drive::FourBar { barrel, linkage }
        }
    };
    Ok(Actuation { drive, mid_length: c.mid_length })
}

fn cylinder(m: &file::Machine, c: &file::Cylinder) -> HydraulicAxis<f64> {
    let area_1 = FRAC_PI_4 * c.bore * c.bore;
    let area_2 = area_1 - FRAC_PI_4 * c.rod_diameter * c.rod_diameter;
    let dead = match c.printed_dead_volume {
        Some(printed) if !m.errata.extension_dead_volume => printed,
        _ => c.dead_volume,
    };
    let dynamic = |area: f64| {
        c.port_diameter.map_or(0.0, |d| dynamic_pressure_coefficient(m.fluid.density, area, FRAC_PI_4 * d * d))
    };
    HydraulicAxis {
        chambers: Chambers {
            area_1,
            area_2,
            mid_volume_1: dead[0] + area_1 * c.stroke / 2.0,
            mid_volume_2: dead[1] + area_2 * c.stroke / 2.0,
        },
        valve: valve(m, &c.valve),
        spool: Spool {
            natural_frequency: c.valve.natural_frequency,
            damping_ratio: c.valve.damping_ratio,
            velocity_limit: c.valve.velocity_limit.unwrap_or(f64::INFINITY),
            acceleration_limit: c.valve.acceleration_limit.unwrap_or(f64::INFINITY),
        },
        leakage: leakage(m, c),
        connector: Connector { piston_side: dynamic(area_1), rod_side: dynamic(area_2) },
        end_stop: end_stop(m, c),
        friction: friction(m, &c.friction),
    }
}

fn valve(m: &file::Machine, v: &file::Valve) -> SpoolValve<f64> {
    let edge = |port: usize| {
        let blend = v.printed_blend.as_ref();
        let law = if m.errata.orifice_law {
            OrificeLaw::TwoRegime
        } else {
            OrificeLaw::Printed { blended: blend.is_some_and(|b| b.ports[port]) }
        };
        Orifice {
            coefficient: v.nominal_flow / (v.stroke * v.edge_pressure_drop.sqrt()),
            transition_pressure: v.transition_pressure,
            laminar_curvature: smooth::root_curvature(v.transition_pressure),
            blend_low: blend.map_or(0.0, |b| b.low),
            blend_high: blend.map_or(1.0, |b| b.high),
            law,
        }
    };
    SpoolValve {
        edge_a: edge(0),
        edge_b: edge(1),
        overlap: v.overlap,
        leakage: v.leakage,
        regenerative: if v.kind == file::ValveKind::Regenerative { 1.0 } else { 0.0 },
    }
}

fn leakage(m: &file::Machine, c: &file::Cylinder) -> Leakage<f64> {
    match c.leakage {
        file::Leakage::Conductance { internal, external } => {
            Leakage { internal, external, external_from_piston_side: false }
        }
        file::Leakage::Gap { gap, piston_length, gland_length, printed_external_from_piston_side } => {
            let viscosity = match m.fluid.printed_leakage_viscosity {
                Some(printed) if !m.errata.leakage_viscosity => printed,
                _ => m.fluid.viscosity,
            };
            Leakage {
                internal: annular_gap_conductance(c.bore, gap, piston_length, viscosity),
                external: annular_gap_conductance(c.rod_diameter, gap, gland_length, viscosity),
                external_from_piston_side: printed_external_from_piston_side && !m.errata.extension_leakage,
            }
        }
    }
}

/// The stops end where the stroke does, or where the rod face meets the barrel if that comes first.
fn end_stop(m: &file::Machine, c: &file::Cylinder) -> EndStop<f64> {
    let upper = c.stroke / 2.0;
    let printed = !m.errata.end_stop;
    let lower = match c.rod_contact {
        Some(contact) if !printed => contact.max(-upper),
        _ => -upper,
    };
    let s = &c.end_stop;
    EndStop { lower, upper, zone: s.zone, stiffness: s.stiffness, damping: s.damping, printed }
}

fn friction(m: &file::Machine, f: &file::Friction) -> FrictionLaw<f64> {
    let map = StaticParameters {
        coulomb_extending: f.coulomb[0],
        coulomb_retracting: f.coulomb[1],
        breakaway_extending: f.breakaway[0],
        breakaway_retracting: f.breakaway[1],
        stribeck_velocity_extending: f.stribeck_velocity[0],
        stribeck_velocity_retracting: f.stribeck_velocity[1],
        stribeck_exponent_extending: f.stribeck_exponent[0],
        stribeck_exponent_retracting: f.stribeck_exponent[1],
        viscous_extending: f.viscous[0],
        viscous_retracting: f.viscous[1],
        viscous_exponent_extending: f.viscous_exponent[0],
        viscous_exponent_retracting: f.viscous_exponent[1],
        gaussian: f.stribeck_exponent == [2.0, 2.0],
        three_halves: f.viscous_exponent == [1.5, 1.5],
    };
    match f.model {
        file::FrictionModel::LuGre => {
            let fading = f.bristle_damping_velocity.map_or(0.0, |v| 1.0 / (v * v));
            let bristle = LuGre { stiffness: f.bristle_stiffness, damping: f.bristle_damping, fading };
            FrictionLaw::LuGre { map, bristle }
        }
        file::FrictionModel::Static if m.errata.friction_map => {
            FrictionLaw::Static { map, width: f.smoothing_velocity.unwrap_or(SMOOTHING) }
        }
        file::FrictionModel::Static => FrictionLaw::Printed { map, width: f.smoothing_velocity },
    }
}

fn fluid(f: &file::Fluid) -> Fluid<f64> {
    let (vacuum, ignore_cavitation) = match f.cavitation {
        file::Cavitation::FreeGas { vacuum } => (vacuum, false),
        file::Cavitation::None => (-1e5, true),
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
