//! The monitor of a machine's sensors around any controller.       theory: docs/theory/control/plausibility.md

use crate::controller_model::controller_model;
use crate::controllers::gain;
use hydrocrane_control::controller::Controller;
use hydrocrane_control::controller_model::ControllerModel;
use hydrocrane_control::feed_forward::SupplyPressures;
use hydrocrane_control::monitored::Monitored;
use hydrocrane_control::notice::Names;
use hydrocrane_control::oil_displacement::Trust;
use hydrocrane_control::plausibility::{Monitor, Settings, INTERVAL};
use hydrocrane_machine::model::{Cylinder, Sensor, Valve};
use hydrocrane_machine::Machine;
use hydrocrane_num::portable;
use hydrocrane_physics::hydraulics::compensator::Compensator;
use hydrocrane_plant::{Crane, Kinematics, StateSpace};

/// `controller` behind a monitor of the machine's sensors; its commands leave `delay` (s) after each sample.
pub(crate) fn with_sensor_monitor<const N: usize>(
    crane: &Crane<N>,
    controller: Box<dyn Controller>,
    delay: f64,
) -> Box<dyn Controller> {
    let (machine, model) = (crane.machine(), controller_model(crane));
    let monitor = Monitor::new(settings(crane, &model, controller.period(), delay, controller.reads_pressures()));
    let names = names(machine, crane.plant().mechanics.joints.map(|j| j.revolute).into());
    Box::new(Monitored::new(controller, model, monitor, names))
}

/// Names for messages; `revolute`: whether a joint is revolute.
pub(crate) fn names(machine: &Machine, revolute: Vec<bool>) -> Names {
    Names {
        joints: machine.joints.iter().map(|j| j.name.clone()).collect(),
        revolute,
        cylinders: machine.cylinders.iter().map(|c| c.name.clone()).collect(),
    }
}

/// Thresholds of a machine's monitor, with or without pressures.
pub(crate) fn settings<const N: usize>(
    crane: &Crane<N>,
    model: &ControllerModel<N>,
    period: f64,
    delay: f64,
    reads_pressures: bool,
) -> Settings<N> {
    let (machine, plant) = (crane.machine(), crane.plant());
    let value = |key: &str| gain(machine, "plausibility", key);
    let stated = |key: &str| machine.control.gain("plausibility", key);
    let sensor = |signal: String| machine.sensors.iter().find(|sensor| sensor.measures == signal);
    let cylinders: [&Cylinder; N] = hydrocrane_num::array::from_fn(|c| &machine.cylinders[c]);
    let pressure = |c: usize, side: usize| sensor(format!("cylinder.{}.p{}", cylinders[c].name, side + 1));
    let fastest: [f64; N] = hydrocrane_num::array::from_fn(|c| model.fastest(c));
    let jump = fastest.map(|v| stated("jump").unwrap_or(value("flow-tolerance") * v * period.max(INTERVAL)));
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
    let around = Around::of(crane, model, &fastest);
    let trust = hydrocrane_num::array::from_fn(|c| {
        trust(
            crane,
            c,
            &around,
            [0, 1].map(|side| pressure(c, side)),
            value("flow-tolerance"),
            value("pressure-tolerance"),
        )
    });
    let limits_of_pressure = |c: usize| {
        let (one, two) = (plant.cylinders[c].chambers.area_1, plant.cylinders[c].chambers.area_2);
        // Only the printed oil law, without cavitation, allows lower pressures.
        let lowest = if plant.fluid.ignore_cavitation { f64::NEG_INFINITY } else { plant.fluid.vacuum };
        // A supply that is turned down leaves the sensors what they were made for.
        let supply = machine.supply.pressure.max(machine.supply.rated);
        let most = value("pressure-limit") * supply * (one / two).max(two / one);
        let accuracy: [f64; 2] = trust[c].pressure;
        [lowest - accuracy[0].max(accuracy[1]), most]
    };
    Settings {
        frozen: jump.map(|jump| stated("frozen").unwrap_or(FROZEN * jump)),
        jump,
        told: hydrocrane_num::array::from_fn(|c| [0, 1].map(|side| pressure(c, side).map_or(1.0, told))),
        resolution: hydrocrane_num::array::from_fn(|c| [0, 1].map(|side| pressure(c, side).map_or(0.0, step))),
        ride_through: value("ride-through"),
        recovery_time: value("recovery-time"),
        joints: hydrocrane_num::array::from_fn(joints),
        strokes: hydrocrane_num::array::from_fn(strokes),
        pressures: reads_pressures.then(|| hydrocrane_num::array::from_fn(limits_of_pressure)),
        scatter: hydrocrane_num::array::from_fn(|i| {
            sensor(format!("joint.{}.q", machine.joints[i].name)).map_or(0.0, scatter)
        }),
        trust,
        memory: hydrocrane_num::array::from_fn(|c| delay + memory(&cylinders[c].valve)),
    }
}

/// What all cylinders are fed from and drain to, Pa.
struct Around {
    supply: [f64; 2],
    tank: [f64; 2],
}

impl Around {
    /// Nothing measures the pressures of mains and tank line: the one lies between the tank and what the relief valve lets it have, the
    /// other between the tank and what all that can return at once leaves there.
    fn of<const N: usize>(crane: &Crane<N>, model: &ControllerModel<N>, fastest: &[f64; N]) -> Self {
        let (machine, SupplyPressures { supply, tank }) = (crane.machine(), model.supply_pressures());
        let Some(own) = crane.plant().supply() else {
            let supply = if machine.supply.measured { [tank, PRESCRIBED * supply] } else { [supply; 2] };
            return Around { supply, tank: [tank; 2] };
        };
        let pumped = model.pump.map_or(0.0, |pump| pump.most(tank, tank));
        let chambers = model.cylinders.map(|c| c.chambers);
        let returned = chambers.iter().zip(fastest).map(|(c, v)| v * c.area_1.max(c.area_2)).sum::<f64>() + pumped;
        let relieved = own.relief.pressure + pumped / own.relief.gradient;
        let risen = own.tank_line.as_ref().map_or(tank, |line| line.at_rest(returned));
        Around { supply: [tank, own.highest.max(relieved)], tank: [tank, risen] }
    }
}

/// How well the oil of cylinder `c` is known; `sensors` measure its pressures.
fn trust<const N: usize>(
    crane: &Crane<N>,
    c: usize,
    around: &Around,
    sensors: [Option<&Sensor>; 2],
    flow: f64,
    pressure: f64,
) -> Trust {
    let (machine, unit) = (crane.machine(), &crane.plant().cylinders[c]);
    let valve = &machine.cylinders[c].valve;
    let scatter = sensors.map(|sensor| sensor.map_or(0.0, scatter));
    let floor = pressure * machine.supply.rated;
    let accuracy = |side: usize| sensors[side].map_or(0.0, |s| accuracy(s) + scatter[side]).max(floor);
    // Largest swing of a second-order lag around the middle of what it is asked for, over half of that span: the integral of its
    // impulse response without sign.
    let overshoot = match valve.damping_ratio {
        ratio if ratio < 1.0 => portable::exp(-std::f64::consts::PI * ratio / (1.0 - ratio * ratio).sqrt()),
        _ => 0.0,
    };
    Trust {
        flow,
        pressure: [0, 1].map(accuracy),
        scatter,
        supply: around.supply,
        tank: around.tank,
        compensated: matches!(unit.valve.compensator, Compensator::Before(_)) && unit.compensator_lag().is_none(),
        port_valves: unit.port_valves,
        crossover: unit.crossover,
        swing: 2.0 * overshoot / (1.0 - overshoot),
        play: valve.command.play,
    }
}

/// Time in which a valve forgets a command, s.
fn memory(valve: &Valve) -> f64 {
    // Of its slower pole.
    let damped = match valve.damping_ratio {
        ratio if ratio > 1.0 => ratio - (ratio * ratio - 1.0).sqrt(),
        ratio => ratio,
    };
    let slow = SPOOL_LAGS / (valve.natural_frequency * damped);
    let way = valve.velocity_limit.map_or(0.0, |limit| 2.0 * valve.stroke / limit);
    valve.delay + valve.command.delay + slow + way
}

/// Displacement that a position reading must have missed, in displacements that count as a jump: it is the sum of many.
const FROZEN: f64 = 2.0;
/// Highest pressure that a scenario may prescribe without a warning, in supply pressures.
const PRESCRIBED: f64 = 3.0;
/// Time constants after which a spool has forgotten a command: with critical damping 0.3 % of it are left.
const SPOOL_LAGS: f64 = 8.0;
/// Standard deviations of noise between two readings that count as possible.
const NOISE: f64 = 8.0;

/// Largest difference of two readings of the same quantity.
fn scatter(sensor: &Sensor) -> f64 {
    if sensor.kind == "incremental-encoder" {
        let pulses = sensor.property("pulses").map(|pulses| std::f64::consts::TAU / (4.0 * pulses));
        // One count, and the change of the division error over one.
        return 1.1 * pulses.unwrap_or(sensor.share("resolution"));
    }
    let share = 2.0 * sensor.share("repeatability") + NOISE * sensor.share("noise");
    share * sensor.range() + step(sensor)
}

/// Step of its converter; zero without one.
fn step(sensor: &Sensor) -> f64 {
    sensor.property("bits").map_or(0.0, |bits| sensor.range() / (portable::pow(2.0, bits) - 1.0))
}

/// Bits that a repeated reading tells against a sensor: by the chance that the noise around a value in the middle of a step stays within
/// it, and one at most, so that no reading counts for more than it is known to.
fn told(sensor: &Sensor) -> f64 {
    let step = step(sensor);
    if step == 0.0 {
        return 1.0;
    }
    let noise = sensor.share("noise") * sensor.range();
    let chance = portable::erf(step / (2.0 * std::f64::consts::SQRT_2 * noise));
    (-portable::log2(chance)).clamp(0.0, 1.0)
}

/// Largest error of its mean reading.
fn accuracy(sensor: &Sensor) -> f64 {
    (sensor.share("accuracy") + sensor.share("linearity")) * sensor.range()
}
