//! Controllers by name, each with a controller model taken from a machine description.

use crate::model::controller_model::controller_model;
use crate::model::gain::gain;
use crate::model::sensor_monitor::{self, names};
use hydrocrane_control::estimate::chamber_estimate::Pressures;
use hydrocrane_control::interface::controller::Controller;
use hydrocrane_control::lever::Lever;
use hydrocrane_control::model::controller_model::ControllerModel;
use hydrocrane_control::model::inverse_kinematics::Printed;
use hydrocrane_control::model::valve_answer::MOST;
use hydrocrane_control::parameter_block::{Kind, Parameters};
use hydrocrane_control::reference::keep_out::{KeepOut, Region};
use hydrocrane_control::reference::set_point::Shape;
use hydrocrane_control::regulate::damping::DampingGains;
use hydrocrane_control::regulate::drive::DriveGains;
use hydrocrane_control::thesis::heinze_pid::{self, Extension, HeinzePid};
use hydrocrane_control::thesis::penalty::Weights;
use hydrocrane_control::thesis::working_area::WorkingArea;
use hydrocrane_control::tip::{self, Tip};
use hydrocrane_machine::Machine;
use hydrocrane_plant::{Crane, StateSpace};

/// Names of the controllers, the default first.
pub const CONTROLLERS: [&str; 2] = ["tip", "heinze-pid"];

/// Name of lever control, and its default period, s.
pub const LEVER: &str = "lever";
const LEVER_PERIOD: f64 = 0.01;

/// The controller `name` for a crane, with the machine's period and gains if stated.
fn kind<const N: usize>(crane: &Crane<N>, model: &ControllerModel<N>, name: &str) -> Result<Kind<N>, String> {
    let machine = crane.machine();
    // Builds for the smallest chains only refuse machines in space before.
    if cfg!(feature = "chains")
        && machine.is_spatial()
        && CONTROLLERS.contains(&name)
        && !(name == "tip" && machine.slews())
    {
        let what = match name {
            "tip" => "moves the tip in a plane that the first joint may turn about the vertical axis",
            _ => "reckons in the plane",
        };
        let of = &machine.name;
        return Err(format!(
            "the controller `{name}` {what}, and machine `{of}` moves otherwise in space; {LEVER} drives it, or one of your own"
        ));
    }
    Ok(match name {
        "tip" => {
            let settings = tip_settings(machine, model);
            followed(machine, model, settings.period)?;
            Kind::Tip(settings)
        }
        "heinze-pid" => Kind::HeinzePid(heinze_settings(machine, model)),
        LEVER => {
            let period = machine.control.period.unwrap_or(LEVER_PERIOD);
            Kind::Lever(Lever::new(period, model.cylinders.map(|cylinder| cylinder.stroke)))
        }
        _ => return Err(format!("no controller `{name}`; there are {}, {LEVER}", CONTROLLERS.join(", "))),
    })
}

/// Parameters of the controller `name` for a crane; with a monitor its commands leave a delay (s) after each sample.
pub(crate) fn parameters<const N: usize>(
    crane: &Crane<N>,
    name: &str,
    monitored: Option<f64>,
) -> Result<Parameters<N>, String> {
    let model = controller_model(crane);
    let monitor = match monitored {
        Some(delay) => {
            let built = build(crane, name)?;
            Some(sensor_monitor::settings(crane, &model, built.period(), delay, built.reads_pressures()))
        }
        None => None,
    };
    Ok(Parameters { model, controller: kind(crane, &model, name)?, monitor })
}

/// The controller `name` for a crane.
pub(crate) fn build<const N: usize>(crane: &Crane<N>, name: &str) -> Result<Box<dyn Controller>, String> {
    let model = controller_model(crane);
    Ok(match kind(crane, &model, name)? {
        Kind::Tip(settings) => {
            let revolute = model.mechanics.joints.map(|joint| joint.revolute).into();
            Box::new(Tip::new(model, settings).named(names(crane.machine(), revolute)))
        }
        Kind::HeinzePid(settings) => Box::new(HeinzePid::new(model, settings)),
        Kind::Lever(lever) => Box::new(lever),
    })
}

/// Refuses a period in which a slow valve's answer has no room.
fn followed<const N: usize>(machine: &Machine, model: &ControllerModel<N>, period: f64) -> Result<(), String> {
    let refusal = |c: usize| {
        let least = model.cylinders[c].dynamics.too_short(period)?;
        let name = &machine.cylinders[c].name;
        Some(format!(
            "`control.period`: {:.3} ms is too short for the valve of cylinder `{name}`, which answers for more than {MOST} \
             periods; state {:.2} ms or more",
            1e3 * period,
            1e3 * least
        ))
    };
    (0..N).find_map(refusal).map_or(Ok(()), Err)
}

/// The gains of `tip` that have a default: key, SI unit (empty for a plain number) and value for a machine.
pub fn tip_gains(machine: &Machine) -> impl Iterator<Item = (&'static str, &'static str, f64)> + '_ {
    let with_default = tip_gain_units();
    with_default.map(|(key, unit)| (key, unit, gain(machine, CONTROLLERS[0], key)))
}

/// Keys and SI units of the same.
pub fn tip_gain_units() -> impl Iterator<Item = (&'static str, &'static str)> {
    let (_, keys) = hydrocrane_machine::CONTROLLERS[0];
    let with_default = keys.iter().filter(|key| !key.defaults.is_empty());
    with_default.filter_map(|key| Some((key.name, key.kind()?.unit)))
}

/// Settings of `tip` for a machine.
pub fn tip_settings<const N: usize>(machine: &Machine, controller_model: &ControllerModel<N>) -> tip::Settings<N> {
    let telescope = controller_model.mechanics.joints.map(|j| !j.revolute);
    let gain = |key: &str| gain(machine, "tip", key);
    let centring = gain("telescope-centring");
    let estimates = machine.control.estimates_pressures;
    let period = machine.control.period.unwrap_or(0.01);
    let lag_limit = machine.control.gain("tip", "lag-limit").unwrap_or_else(|| controller_model.lag_limit());
    // At a higher speed a single sample could cross the border.
    let border_rate = gain("limit-rate").min(1.0 / period);
    tip::Settings {
        period,
        full_speed: machine
            .control
            .gain("tip", "full-speed")
            .unwrap_or_else(|| controller_model.full_speed(gain("stick-bandwidth"), lag_limit)),
        lever_speeds: hydrocrane_num::array::from_fn(|i| {
            [-1.0, 1.0].map(|sense| controller_model.unloaded_speed(i, sense))
        }),
        shape: Shape {
            stick_bandwidth: gain("stick-bandwidth"),
            path_rate: gain("path-rate"),
            limit_rate: gain("limit-rate"),
            centring: telescope.map(|t| if t { centring } else { 0.0 }),
            effort: [1.0; N],
            keep_out: keep_out(machine, gain("keep-out-margin"), border_rate),
            height_joint: machine.control.height_joint.unwrap_or_else(|| {
                let telescopes = telescope.iter().position(|&t| t);
                telescopes.unwrap_or(N - 1)
            }),
        },
        drive: DriveGains {
            position: gain("position-gain"),
            observer: gain("observer-bandwidth"),
            pressure: gain("pressure-bandwidth"),
            reserve: gain("reserve"),
            rest_band: gain("rest-band"),
            // Without pressures a wrong valve and an unknown load have the same effect.
            learning: if estimates { 0.0 } else { gain("learning-time") },
            pressures: match estimates {
                true => Pressures::Estimated(machine.equilibrium.back_pressure),
                false => Pressures::Measured,
            },
        },
        damping: DampingGains {
            ratio: gain("damping-ratio"),
            quiet: gain("quiet-speed"),
            period,
            share: DampingGains::share(!estimates),
        },
        lag_limit,
        settling: gain("settling-time"),
    }
}

fn keep_out(machine: &Machine, margin: f64, rate: f64) -> KeepOut {
    let regions = machine.keep_out.iter().map(|(_, corners)| Region::new(corners.clone())).collect();
    KeepOut { regions, margin, rate }
}

/// Number of candidates of the penalty search on each side of the telescope's position.
const EXTENSION_CANDIDATES: usize = 10;

/// Settings of `heinze-pid`: printed gains, 1 m/s at full stick, the set-point moved at every sample and kept in the
/// working area, the telescope at zero, unless the machine says otherwise.
pub fn heinze_settings<const N: usize>(
    machine: &Machine,
    controller_model: &ControllerModel<N>,
) -> heinze_pid::Settings<N> {
    let errata = &machine.errata;
    let gain = |key: &str| gain(machine, "heinze-pid", key);
    let period = machine.control.period.unwrap_or(2e-4);
    let limit_rate = gain("limit-rate");
    let area = WorkingArea { keep_out: keep_out(machine, gain("keep-out-margin"), limit_rate), limit_rate };
    let steps = machine.control.thesis;
    heinze_pid::Settings {
        period,
        set_point_interval: machine.control.gain("heinze-pid", "set-point-interval").unwrap_or(period),
        full_speed: gain("full-speed"),
        gains: heinze_pid::printed_gains(),
        extension: match steps.penalty {
            true => Extension::Penalty {
                weights: penalty_weights(machine, controller_model),
                candidates: EXTENSION_CANDIDATES,
            },
            false => Extension::Zero,
        },
        printed: Printed {
            quadrant: !errata.ik_quadrant,
            unreachable: !errata.ik_unreachable,
            extension: !errata.ik_extension,
        },
        working_area: steps.working_area.then_some(area),
    }
}

/// Weights of the penalty (131) per joint, with the joint's range as the unit of its coordinate: a motion over the
/// range has the same cost for each joint. By default the distance from the middle costs a tenth of that, so the telescope moves
/// when boom and jib are near their ends, and not at each motion of them.
fn penalty_weights<const N: usize>(machine: &Machine, controller_model: &ControllerModel<N>) -> Weights<N> {
    let [motion, middle] = ["motion-weight", "middle-weight"].map(|table| {
        hydrocrane_num::array::from_fn(|i| {
            let [low, high] = controller_model.joint_limits[i];
            let key = format!("{table}.{}", machine.joints[i].name);
            gain(machine, "heinze-pid", &key) / (high - low).powi(2)
        })
    });
    Weights { motion, middle }
}
