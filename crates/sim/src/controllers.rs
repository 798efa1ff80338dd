//! Controllers by name, each with a nominal model taken from a machine description.

use crate::cylinder_unit::{CylinderUnit, FrictionLaw};
use crate::from_machine::plant;
use crate::plant::Plant;
use hydrocrane_control::controller::Controller;
use hydrocrane_control::drive::DriveGains;
use hydrocrane_control::feed_forward::{steady_speed, Mains};
use hydrocrane_control::heinze_pid::{self, Extension, HeinzePid};
use hydrocrane_control::inverse_kinematics::Printed;
use hydrocrane_control::nominal::{Nominal, NominalCylinder};
use hydrocrane_control::set_point::Shape;
use hydrocrane_control::tip::{self, Tip};
use hydrocrane_machine::Machine;

/// Names of the controllers, the default first.
pub const CONTROLLERS: [&str; 2] = ["tip", "heinze-pid"];

/// Builds a controller for a machine.
pub fn build(machine: &Machine, name: &str) -> Result<Box<dyn Controller>, String> {
    match machine.joints.len() {
        1 => sized::<1>(machine, name),
        2 => sized::<2>(machine, name),
        3 => sized::<3>(machine, name),
        4 => sized::<4>(machine, name),
        5 => sized::<5>(machine, name),
        6 => sized::<6>(machine, name),
        n => Err(format!("`{}` has {n} joints; a controller handles 1 to 6", machine.name)),
    }
}

fn sized<const N: usize>(machine: &Machine, name: &str) -> Result<Box<dyn Controller>, String> {
    match name {
        "tip" => Ok(Box::new(Tip::new(nominal::<N>(machine)?, tip_settings(machine)?))),
        "heinze-pid" => Ok(Box::new(HeinzePid::new(nominal::<N>(machine)?, heinze_settings(machine)))),
        _ => Err(format!("no controller `{name}`; there are {}", CONTROLLERS.join(", "))),
    }
}

/// What a controller believes of a machine: here, the truth but for the bristles of its friction.
pub fn nominal<const N: usize>(machine: &Machine) -> Result<Nominal<N>, String> {
    let model = crate::build(machine).map_err(|e| e.to_string())?;
    let Plant { mechanics, actuations, cylinders, fluid, mains } = plant::<N>(machine).map_err(|e| e.to_string())?;
    let strokes = model.spool_strokes();
    let limits = model.joint_limits();
    Ok(Nominal {
        mechanics,
        actuations,
        cylinders: std::array::from_fn(|c| nominal_cylinder(&cylinders[c], strokes[c])),
        fluid,
        supply: mains.supply,
        tank: mains.tank,
        payload: machine.payload.mass,
        joint_limits: std::array::from_fn(|i| [limits[i].lower, limits[i].upper]),
    })
}

fn nominal_cylinder(unit: &CylinderUnit<f64>, stroke: f64) -> NominalCylinder {
    let stop = &unit.end_stop;
    let (FrictionLaw::Static { map, .. } | FrictionLaw::Printed { map } | FrictionLaw::LuGre { map, .. }) =
        unit.friction;
    NominalCylinder {
        chambers: unit.chambers,
        valve: unit.valve,
        leakage: unit.leakage,
        friction: map,
        stroke,
        free: [stop.lower + stop.zone, stop.upper - stop.zone],
    }
}

/// Default settings of `tip` for a machine.
pub fn tip_settings<const N: usize>(machine: &Machine) -> Result<tip::Settings<N>, String> {
    let nominal = nominal::<N>(machine)?;
    let telescope = nominal.mechanics.joints.map(|j| !j.revolute);
    Ok(tip::Settings {
        period: 0.01,
        full_speed: fastest_joint(&nominal),
        shape: Shape {
            stick_bandwidth: 15.0,
            path_rate: 30.0,
            limit_rate: 2.0,
            centring: telescope.map(|t| if t { 0.5 } else { 0.0 }),
            effort: [1.0; N],
        },
        drive: DriveGains {
            position: 4.0,
            damping: 5.0,
            damping_band: [5.0, 20.0],
            observer: 5.0,
            pressure: 15.0,
            reserve: 0.95,
            rest_band: 2e-4,
        },
        lag_limit: 0.03,
        settling: 0.5,
    })
}

/// Tip speed that the fastest joint alone gives in the middle of all ranges, unloaded, m/s.
fn fastest_joint<const N: usize>(n: &Nominal<N>) -> f64 {
    let posture = n.posture(&n.joint_limits.map(|[low, high]| 0.5 * (low + high)));
    let mains = Mains { supply: n.supply, tank: n.tank };
    let speed = |i: usize| {
        let piston = steady_speed(&n.cylinders[i], &mains, 0.0, 1.0);
        posture.jacobian[0][i].hypot(posture.jacobian[1][i]) * (piston / posture.gain[i]).abs()
    };
    (0..N).map(speed).fold(0.0, f64::max)
}

/// Settings of `heinze-pid`: printed gains, 1 m/s at full stick, the set-point moved at every sample.
pub fn heinze_settings<const N: usize>(machine: &Machine) -> heinze_pid::Settings<N> {
    let errata = &machine.errata;
    heinze_pid::Settings {
        period: 2e-4,
        set_point_interval: 2e-4,
        full_speed: 1.0,
        gains: heinze_pid::printed_gains(),
        extension: Extension::Zero,
        printed: Printed {
            quadrant: !errata.ik_quadrant,
            unreachable: !errata.ik_unreachable,
            extension: !errata.ik_extension,
        },
    }
}
