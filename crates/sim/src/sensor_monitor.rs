//! The monitor of a machine's sensors around any controller.       theory: docs/theory/control/plausibility.md

use crate::controller_model::controller_model;
use hydrocrane_control::controller::Controller;
use hydrocrane_control::monitored::Monitored;
use hydrocrane_control::notice::Names;
use hydrocrane_control::oil_displacement::Trust;
use hydrocrane_control::plausibility::{Monitor, Settings};
use hydrocrane_machine::model::{Cylinder, Sensor};
use hydrocrane_machine::Machine;
use hydrocrane_num::portable;
use hydrocrane_plant::{Crane, Kinematics, StateSpace};

/// Default thresholds, SI.
pub const PLAUSIBILITY: [(&str, f64); 9] = [
    ("jump", 0.5e-3),
    ("frozen", 1e-3),
    ("frozen-pressure", 10e-3),
    ("flow-tolerance", 0.25),
    ("pressure-tolerance", 0.03),
    ("stroke-margin", 0.05),
    ("pressure-limit", 2.0),
    ("recovery-time", 0.5),
    ("ride-through", 0.05),
];

/// `controller` behind a monitor of the machine's sensors; its commands leave `delay` (s) after each sample.
pub(crate) fn with_sensor_monitor<const N: usize>(
    crane: &Crane<N>,
    controller: Box<dyn Controller>,
    delay: f64,
) -> Box<dyn Controller> {
    let machine = crane.machine();
    let monitor = Monitor::new(settings(crane, delay, controller.reads_pressures()));
    let names = names(machine, crane.plant().mechanics.joints.map(|j| j.revolute).into());
    Box::new(Monitored::new(controller, controller_model(crane), monitor, names))
}

/// Names for messages; `revolute`: whether a joint is revolute.
pub(crate) fn names(machine: &Machine, revolute: Vec<bool>) -> Names {
    Names {
        joints: machine.joints.iter().map(|j| j.name.clone()).collect(),
        revolute,
        cylinders: machine.cylinders.iter().map(|c| c.name.clone()).collect(),
    }
}

fn threshold(machine: &Machine, key: &str) -> f64 {
    let default = PLAUSIBILITY.iter().find(|(name, _)| *name == key).map_or(f64::NAN, |(_, value)| *value);
    machine.control.gain("plausibility", key).unwrap_or(default)
}

/// Thresholds of a machine's monitor, with or without pressures.
pub(crate) fn settings<const N: usize>(crane: &Crane<N>, delay: f64, reads_pressures: bool) -> Settings<N> {
    let (machine, plant) = (crane.machine(), crane.plant());
    let value = |key: &str| threshold(machine, key);
    let sensor = |signal: String| machine.sensors.iter().find(|sensor| sensor.measures == signal);
    let cylinders: [&Cylinder; N] = hydrocrane_num::array::from_fn(|c| &machine.cylinders[c]);
    let pressure = |c: usize, side: usize| sensor(format!("cylinder.{}.p{}", cylinders[c].name, side + 1));
    let floor = value("pressure-tolerance") * machine.supply.pressure;
    let trust = |c: usize| {
        let scatter = [0, 1].map(|side| pressure(c, side).map_or(0.0, scatter));
        let accuracy = |side: usize| pressure(c, side).map_or(0.0, |s| accuracy(s) + scatter[side]).max(floor);
        Trust { flow: value("flow-tolerance"), pressure: [0, 1].map(accuracy), scatter }
    };
    let strokes = |c: usize| {
        let (stop, margin) = (&plant.cylinders[c].end_stop, value("stroke-margin"));
        let margin = margin * (stop.upper - stop.lower);
        [stop.lower - margin, stop.upper + margin]
    };
    let limits = crane.joint_limits();
    let joints = |i: usize| {
        // A file's limits may be narrower than the motion of the machine; here they only identify the turn.
        let half = 0.5 * (limits[i].upper - limits[i].lower);
        [limits[i].lower - half, limits[i].upper + half]
    };
    let limits_of_pressure = |c: usize| {
        let (one, two) = (plant.cylinders[c].chambers.area_1, plant.cylinders[c].chambers.area_2);
        // Only the printed oil law, without cavitation, allows lower pressures.
        let lowest = if plant.fluid.ignore_cavitation { f64::NEG_INFINITY } else { plant.fluid.vacuum };
        let most = value("pressure-limit") * machine.supply.pressure * (one / two).max(two / one);
        [lowest - trust(c).pressure[0].max(trust(c).pressure[1]), most]
    };
    let memory = |c: usize| {
        let valve = &cylinders[c].valve;
        let slow = SPOOL_LAGS / (valve.natural_frequency * valve.damping_ratio.min(1.0));
        let way = valve.velocity_limit.map_or(0.0, |limit| 2.0 * valve.stroke / limit);
        delay + valve.delay + valve.command.delay + slow + way
    };
    Settings {
        jump: value("jump"),
        frozen: value("frozen"),
        frozen_pressure: value("frozen-pressure"),
        resolution: hydrocrane_num::array::from_fn(|c| [0, 1].map(|side| pressure(c, side).map_or(0.0, coarseness))),
        ride_through: value("ride-through"),
        recovery_time: value("recovery-time"),
        joints: hydrocrane_num::array::from_fn(joints),
        strokes: hydrocrane_num::array::from_fn(strokes),
        pressures: reads_pressures.then(|| hydrocrane_num::array::from_fn(limits_of_pressure)),
        scatter: hydrocrane_num::array::from_fn(|i| {
            sensor(format!("joint.{}.q", machine.joints[i].name)).map_or(0.0, scatter)
        }),
        trust: hydrocrane_num::array::from_fn(trust),
        memory: hydrocrane_num::array::from_fn(memory),
    }
}

/// Settling time of a spool in time constants.
const SPOOL_LAGS: f64 = 4.0;
/// Standard deviations of noise between two readings that count as possible.
const NOISE: f64 = 8.0;

/// Largest difference of two readings of the same quantity.
fn scatter(sensor: &Sensor) -> f64 {
    let property = |key: &str| sensor.properties.iter().find(|(name, _)| name == key).map(|(_, value)| *value);
    if sensor.kind == "incremental-encoder" {
        let pulses = property("pulses").map(|pulses| std::f64::consts::TAU / (4.0 * pulses));
        // One count, and the change of the division error over one.
        return 1.1 * pulses.or_else(|| property("resolution")).unwrap_or(0.0);
    }
    let code = property("bits").map_or(0.0, |bits| 1.0 / (portable::pow(2.0, bits) - 1.0));
    let share = 2.0 * property("repeatability").unwrap_or(0.0) + NOISE * property("noise").unwrap_or(0.0) + code;
    share * range(sensor)
}

/// Change of the true value that a reading without noise does not show; zero if noise changes the reading at every
/// sample.
fn coarseness(sensor: &Sensor) -> f64 {
    let property = |key: &str| sensor.properties.iter().find(|(name, _)| name == key).map_or(0.0, |(_, value)| *value);
    let step = property("bits").max(0.0);
    let step = if step > 0.0 { range(sensor) / (portable::pow(2.0, step) - 1.0) } else { 0.0 };
    if step > LEAST_DITHER * property("noise") * range(sensor) {
        step
    } else {
        0.0
    }
}

/// Largest converter step, in standard deviations of noise, for which a reading hardly ever repeats.
const LEAST_DITHER: f64 = 2.0;

/// Largest error of its mean reading.
fn accuracy(sensor: &Sensor) -> f64 {
    let share = |key: &str| sensor.properties.iter().find(|(name, _)| name == key).map_or(0.0, |(_, value)| *value);
    (share("accuracy") + share("linearity")) * range(sensor)
}

fn range(sensor: &Sensor) -> f64 {
    let named = |key: &&str| sensor.properties.iter().find(|(name, _)| name == key).map(|(_, value)| *value);
    ["range", "full-scale", "span"].iter().find_map(named).unwrap_or(0.0)
}
