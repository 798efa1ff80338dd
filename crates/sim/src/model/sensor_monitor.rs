//! The monitor of a machine's sensors around any controller.       theory: docs/theory/control/plausibility.md

use crate::model::controller_model::controller_model;
use crate::model::gain::gain;
use hydrocrane_control::interface::controller::Controller;
use hydrocrane_control::interface::notice::Names;
use hydrocrane_control::model::controller_model::ControllerModel;
use hydrocrane_control::model::feed_forward::SupplyPressures;
use hydrocrane_control::model::oil_displacement::Trust;
use hydrocrane_control::monitor::monitored::Monitored;
use hydrocrane_control::monitor::plausibility::{Monitor, Settings, INTERVAL};
use hydrocrane_machine::model::{Sensor, Valve};
use hydrocrane_machine::Machine;
use hydrocrane_num::portable;
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

/// Thresholds of a machine's monitor, with or without pressures; the controller samples with this `period` (s), and its commands leave
/// `delay` (s) after each sample.
pub(crate) fn settings<const N: usize>(
    crane: &Crane<N>,
    model: &ControllerModel<N>,
    period: f64,
    delay: f64,
    reads_pressures: bool,
) -> Settings<N> {
    let basis = Basis { crane, model };
    let jump = hydrocrane_num::array::from_fn(|c| basis.jump(c, period));
    let around = basis.around();
    let trust = hydrocrane_num::array::from_fn(|c| basis.trust(c, &around));
    let of_pressures = |of: fn(&Sensor) -> f64, without: f64| {
        hydrocrane_num::array::from_fn(|c| basis.pressure_sensors(c).map(|sensor| sensor.map_or(without, of)))
    };
    Settings {
        frozen: jump.map(|jump| basis.stated("frozen").unwrap_or(FROZEN * jump)),
        jump,
        against: of_pressures(against, 1.0),
        resolution: of_pressures(step, 0.0),
        ride_through: basis.value("ride-through"),
        recovery_time: basis.value("recovery-time"),
        joints: hydrocrane_num::array::from_fn(|i| basis.joint_range(i)),
        strokes: hydrocrane_num::array::from_fn(|c| basis.stroke_range(c)),
        pressures: hydrocrane_num::array::from_fn(|c| basis.pressure_range(c, &trust[c])),
        reads_pressures,
        scatter: hydrocrane_num::array::from_fn(|i| {
            basis.sensor(&format!("joint.{}.q", crane.machine().joints[i].name)).map_or(0.0, scatter)
        }),
        trust,
        memory: hydrocrane_num::array::from_fn(|c| delay + memory(&crane.machine().cylinders[c].valve)),
    }
}

/// What all cylinders are fed from and drain to, lowest and highest, Pa.
struct Around {
    supply: [f64; 2],
    tank: [f64; 2],
}

/// What the thresholds follow from.
struct Basis<'a, const N: usize> {
    crane: &'a Crane<N>,
    model: &'a ControllerModel<N>,
}

impl<const N: usize> Basis<'_, N> {
    fn value(&self, key: &str) -> f64 {
        gain(self.crane.machine(), "plausibility", key)
    }

    /// A threshold that follows from others unless somebody states it.
    fn stated(&self, key: &str) -> Option<f64> {
        self.crane.machine().control.gain("plausibility", key)
    }

    fn sensor(&self, signal: &str) -> Option<&Sensor> {
        self.crane.machine().sensors.iter().find(|sensor| sensor.measures == signal)
    }

    fn pressure_sensors(&self, c: usize) -> [Option<&Sensor>; 2] {
        let name = &self.crane.machine().cylinders[c].name;
        [1, 2].map(|side| self.sensor(&format!("cylinder.{name}.p{side}")))
    }

    /// Displacement of a piston between two samples that counts as a jump, m.
    fn jump(&self, c: usize, period: f64) -> f64 {
        let travel = self.model.fastest(c) * period.max(INTERVAL);
        self.stated("jump").unwrap_or(self.value("flow-tolerance") * travel)
    }

    fn stroke_range(&self, c: usize) -> [f64; 2] {
        let stop = &self.crane.plant().cylinders[c].end_stop;
        let margin = self.value("stroke-margin") * (stop.upper - stop.lower);
        [stop.lower - margin, stop.upper + margin]
    }

    /// A file's limits may be narrower than the motion of the machine; here they only identify the turn.
    fn joint_range(&self, i: usize) -> [f64; 2] {
        let limits = &self.crane.joint_limits()[i];
        let half = 0.5 * (limits.upper - limits.lower);
        [limits.lower - half, limits.upper + half]
    }

    fn pressure_range(&self, c: usize, trust: &Trust) -> [f64; 2] {
        let (supply, fluid) = (&self.crane.machine().supply, &self.crane.plant().fluid);
        let (one, two) = (self.model.cylinders[c].chambers.area_1, self.model.cylinders[c].chambers.area_2);
        // Only the printed oil law, without cavitation, allows lower pressures.
        let lowest = if fluid.ignore_cavitation { f64::NEG_INFINITY } else { fluid.vacuum };
        // A supply that is turned down leaves the sensors what they were made for.
        let most = self.value("pressure-limit") * supply.pressure.max(supply.rated) * (one / two).max(two / one);
        [lowest - trust.pressure[0].max(trust.pressure[1]), most]
    }

    /// Nothing measures the pressures of mains and tank line: the one lies between the tank and what the relief valve lets it have, the
    /// other between the tank and what all that can return at once leaves there.
    fn around(&self) -> Around {
        let SupplyPressures { supply, tank } = self.model.supply_pressures();
        let Some(own) = self.crane.plant().supply() else {
            let measured = self.crane.machine().supply.measured;
            return Around {
                supply: if measured { [tank, PRESCRIBED * supply] } else { [supply; 2] },
                tank: [tank; 2],
            };
        };
        let pumped = self.model.pump.map_or(0.0, |pump| pump.most(tank, tank));
        let returned: f64 = (0..N).map(|c| self.model.fastest(c) * self.model.cylinders[c].chambers.area_1).sum();
        // A supply that is turned down leaves the mains where they were for a moment.
        let turned = (self.crane.machine().supply.rated / supply).max(1.0);
        let relieved = turned * own.relief.pressure + pumped / own.relief.gradient;
        let risen = own.tank_line.as_ref().map_or(tank, |line| line.at_rest(returned + pumped));
        Around { supply: [tank, (turned * own.highest).max(relieved)], tank: [tank, risen] }
    }

    /// How well the oil of cylinder `c` is known.
    fn trust(&self, c: usize, around: &Around) -> Trust {
        let (machine, unit) = (self.crane.machine(), &self.crane.plant().cylinders[c]);
        let (valve, sensors) = (&machine.cylinders[c].valve, self.pressure_sensors(c));
        let floor = self.value("pressure-tolerance") * machine.supply.rated;
        let scatter = sensors.map(|sensor| sensor.map_or(0.0, scatter));
        let accuracy = |side: usize| sensors[side].map_or(0.0, |s| accuracy(s) + scatter[side]).max(floor);
        let overshoot = self.model.cylinders[c].dynamics.overshoot();
        Trust {
            flow: self.value("flow-tolerance"),
            pressure: [0, 1].map(accuracy),
            scatter,
            full: sensors.map(|sensor| sensor.and_then(Sensor::limits).map_or(f64::INFINITY, |[_, full]| full)),
            supply: around.supply,
            tank: around.tank,
            compensator: unit.valve.compensator,
            late: unit.compensator_lag().is_some(),
            gives_way: unit.priority.is_some(),
            port_valves: unit.port_valves,
            crossover: unit.crossover,
            leaks: unit.leaks,
            // The integral of the magnitude of a second-order lag's impulse response, less one.
            swing: 2.0 * overshoot / (1.0 - overshoot),
            play: valve.command.play,
        }
    }
}

/// Time in which a valve forgets a command, s.
fn memory(valve: &Valve) -> f64 {
    // Of its slower pole.
    let damped = match valve.spool.damping_ratio {
        ratio if ratio > 1.0 => ratio - (ratio * ratio - 1.0).sqrt(),
        ratio => ratio,
    };
    let slow = SPOOL_LAGS / (valve.spool.natural_frequency * damped);
    let travel = valve.spool.velocity_limit.map_or(0.0, |limit| 2.0 * valve.stroke / limit);
    valve.delay + valve.command.delay + slow + travel
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
fn against(sensor: &Sensor) -> f64 {
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
