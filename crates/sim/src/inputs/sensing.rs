//! The sensors of a machine in the loop: signal, errors and faults of each.

use crate::model::Model;
use hydrocrane_control::interface::controller::Measurement;
use hydrocrane_machine::model as file;
pub use hydrocrane_machine::scenario::{FaultKind, SensorFault, SensorQuality as SensorMode};
use hydrocrane_num::{Archive, RandomStream};
use hydrocrane_ode::Stepper;
use hydrocrane_physics::sensor::analogue::Quality;
use hydrocrane_physics::sensor::pressure_transmitter::{Decay, Scale};
use hydrocrane_physics::sensor::{Encoder, LoadCell, PressureTransmitter, WirePotentiometer};

#[derive(Debug, Clone)]
enum Device {
    Ideal,
    Encoder(Encoder),
    Pressure(PressureTransmitter),
    Wire(WirePotentiometer),
    Force(LoadCell),
}

/// Source of the true value of a signal.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Truth {
    State(usize),
    Output(usize),
}

#[derive(Debug, Clone)]
struct Channel {
    signal: String,
    truth: Truth,
    device: Device,
    faults: Vec<SensorFault>,
}

/// All sensors of a machine with their last readings: every joint coordinate and chamber pressure; data-sheet sensors
/// also read all other signals with a sensor in the machine file.
#[derive(Debug, Clone)]
pub struct Sensors {
    channels: Vec<Channel>,
    readings: Vec<f64>,
    joints: usize,
    pressures: Vec<[f64; 2]>,
    /// Work space for the model's outputs, if a sensor reads one of them.
    outputs: Vec<f64>,
    reads_outputs: bool,
    /// States that sensors with hysteresis or lag follow between two samples, by increasing index.
    lagged: Vec<usize>,
    /// Work space for a state between two samples.
    between: Vec<f64>,
}

/// Longest interval over which the pressure before a transmitter counts as linear, s.
const LAG_STEP: f64 = 1e-3;

/// Signals that a controller reads: every joint coordinate, then every chamber pressure.
fn controller_signals(machine: &file::Machine) -> impl Iterator<Item = String> + '_ {
    let joints = machine.joints.iter().map(|j| format!("joint.{}.q", j.name));
    joints.chain(machine.cylinders.iter().flat_map(|c| [1, 2].map(|side| format!("cylinder.{}.p{side}", c.name))))
}

/// Signals that a controller reads without a sensor in the machine file; data-sheet sensors then return the true value.
pub fn unmeasured(machine: &file::Machine) -> Vec<String> {
    controller_signals(machine).filter(|signal| machine.sensors.iter().all(|s| s.measures != *signal)).collect()
}

impl Sensors {
    /// Sensors that read true values.
    pub fn ideal(model: &dyn Model) -> Self {
        Self::described(model, &[], |_| Device::Ideal)
    }

    /// The sensors of the machine file, drawn by `seed`, with `faults`. An error names a signal without a sensor.
    pub fn new(model: &dyn Model, mode: SensorMode, seed: u64, faults: &[SensorFault]) -> Result<Self, String> {
        let described = &model.machine().sensors;
        let mut sensors = match mode {
            SensorMode::Ideal => Self::ideal(model),
            SensorMode::DataSheet => Self::described(model, described, |signal| {
                let found = described.iter().find(|sensor| sensor.measures == signal);
                found.map_or(Device::Ideal, |sensor| device(sensor, seed))
            }),
        };
        sensors.add_faults(faults)?;
        Ok(sensors)
    }

    /// As [`Self::new`] for recorded data: ideal sensors read all signals with a sensor in the machine file.
    pub fn for_record(model: &dyn Model, mode: SensorMode, seed: u64, faults: &[SensorFault]) -> Result<Self, String> {
        if mode == SensorMode::DataSheet {
            return Self::new(model, mode, seed, faults);
        }
        let mut sensors = Self::described(model, &model.machine().sensors, |_| Device::Ideal);
        sensors.add_faults(faults)?;
        Ok(sensors)
    }

    fn add_faults(&mut self, faults: &[SensorFault]) -> Result<(), String> {
        for fault in faults {
            let Some(channel) = self.channels.iter_mut().find(|c| c.signal == fault.signal) else {
                let known: Vec<&str> = self.signals().collect();
                return Err(format!("no sensor measures `{}`; measured are {}", fault.signal, known.join(", ")));
            };
            channel.faults.push(fault.clone());
        }
        Ok(())
    }

    fn described(model: &dyn Model, sensors: &[file::Sensor], device: impl Fn(&str) -> Device) -> Self {
        let machine = model.machine();
        let mut signals: Vec<String> = controller_signals(machine).collect();
        for sensor in sensors {
            if !signals.contains(&sensor.measures) {
                signals.push(sensor.measures.clone());
            }
        }
        let channel = |signal: String| {
            let state = model.layout().names.iter().position(|name| *name == signal).map(Truth::State);
            let output = || model.output_info().iter().position(|o| o.name == signal).map(Truth::Output);
            let truth = state.or_else(output)?;
            Some(Channel { truth, device: device(&signal), signal, faults: Vec::new() })
        };
        let channels: Vec<Channel> = signals.into_iter().filter_map(channel).collect();
        let follows = |i: &usize| {
            let followed = |c: &Channel| matches!(c.device, Device::Pressure(_)) && c.truth == Truth::State(*i);
            channels.iter().any(followed)
        };
        Sensors {
            readings: vec![f64::NAN; channels.len()],
            joints: machine.joints.len(),
            pressures: vec![[0.0; 2]; machine.cylinders.len()],
            outputs: vec![0.0; model.output_info().len()],
            reads_outputs: channels.iter().any(|c| matches!(c.truth, Truth::Output(_))),
            lagged: (0..model.layout().len()).filter(follows).collect(),
            between: vec![0.0; model.layout().len()],
            channels,
        }
    }

    /// Measured signals, in the order of [`Self::readings`].
    pub fn signals(&self) -> impl Iterator<Item = &str> {
        self.channels.iter().map(|channel| channel.signal.as_str())
    }

    /// Last readings; NaN before the first.
    pub fn readings(&self) -> &[f64] {
        &self.readings
    }

    /// The readings that a controller gets.
    pub fn measurement(&self, t: f64) -> Measurement<'_> {
        Measurement { t, q: &self.readings[..self.joints], p: &self.pressures }
    }

    /// Their changing state.
    pub fn archive(&mut self, archive: &mut Archive) {
        archive.numbers(&mut self.readings);
        self.pressures.iter_mut().for_each(|pair| archive.numbers(pair));
        for channel in &mut self.channels {
            match &mut channel.device {
                Device::Ideal | Device::Encoder(_) => {}
                Device::Pressure(transmitter) => transmitter.archive(archive),
                Device::Wire(wire) => wire.archive(archive),
                Device::Force(cell) => cell.archive(archive),
            }
        }
    }

    /// Starts at rest in state `x`.
    pub fn settle(&mut self, t: f64, x: &[f64]) {
        for channel in &mut self.channels {
            match (&mut channel.device, channel.truth) {
                (Device::Pressure(transmitter), Truth::State(i)) => transmitter.settle(t, x[i]),
                (Device::Wire(wire), _) => wire.settle(),
                _ => {}
            }
        }
    }

    /// Follows the last step of `stepper`.
    pub fn follow(&mut self, stepper: &Stepper) {
        if self.lagged.is_empty() {
            return;
        }
        let (from, to) = (stepper.previous_time(), stepper.t);
        let parts = ((to - from) / LAG_STEP).ceil().max(1.0);
        let mut x = std::mem::take(&mut self.between);
        x.resize(stepper.x.len(), 0.0);
        for part in 1..=parts as u64 {
            let t = from + (to - from) * part as f64 / parts;
            stepper.interpolate_some(t, &self.lagged, &mut x);
            self.follow_to(t, &x);
        }
        self.between = x;
    }

    /// Advances to time `t`, with pressures that change linearly to those of state `x`.
    fn follow_to(&mut self, t: f64, x: &[f64]) {
        let mut decay = Decay::default();
        for channel in &mut self.channels {
            if let (Device::Pressure(transmitter), Truth::State(i)) = (&mut channel.device, channel.truth) {
                transmitter.follow_with(t, x[i], &mut decay);
            }
        }
    }

    /// Readings of a recorded run, one row of [`Self::signals`] for each of `times`; `states` holds one state per time.
    pub fn measure(&mut self, model: &dyn Model, times: &[f64], states: &[f64], payload: f64) -> Vec<f64> {
        let mut readings = Vec::with_capacity(times.len() * self.readings.len());
        self.readings.fill(f64::NAN);
        for (row, (&t, x)) in times.iter().zip(states.chunks_exact(model.layout().len())).enumerate() {
            if row == 0 {
                self.settle(t, x);
            }
            self.follow_to(t, x);
            self.read(model, t, x, payload);
            readings.extend_from_slice(&self.readings);
        }
        readings
    }

    /// Takes a reading of state `x` at time `t`.
    pub fn read(&mut self, model: &dyn Model, t: f64, x: &[f64], payload: f64) {
        if self.reads_outputs {
            // Energies are no signals of sensors.
            model.outputs_without_oil(x, payload, &mut self.outputs);
        }
        for (channel, reading) in self.channels.iter_mut().zip(&mut self.readings) {
            let truth = match channel.truth {
                Truth::State(i) => x[i],
                Truth::Output(i) => self.outputs[i],
            };
            *reading = channel.read(t, truth, *reading);
        }
        for (c, pair) in self.pressures.iter_mut().enumerate() {
            let first = self.joints + 2 * c;
            *pair = [self.readings[first], self.readings[first + 1]];
        }
    }
}

impl Channel {
    fn read(&mut self, t: f64, truth: f64, last: f64) -> f64 {
        let healthy = match &mut self.device {
            Device::Ideal => truth,
            Device::Encoder(encoder) => encoder.read(truth),
            Device::Pressure(transmitter) => transmitter.read(),
            Device::Wire(wire) => wire.read(truth),
            Device::Force(cell) => cell.read(truth),
        };
        let active = |fault: &&SensorFault| t >= fault.from - 1e-12 && fault.until.is_none_or(|end| t < end - 1e-12);
        self.faults.iter().filter(active).fold(healthy, |reading, fault| match fault.kind {
            // A sensor that is frozen from the start keeps its first reading.
            FaultKind::Freeze if last.is_nan() => reading,
            FaultKind::Freeze => last,
            FaultKind::Jump(size) => reading + size,
            FaultKind::DropOut => f64::NAN,
        })
    }
}

/// One sensor as its file describes it. Its errors depend only on the seed and its name.
fn device(sensor: &file::Sensor, seed: u64) -> Device {
    let (property, share, range) = (|key: &str| sensor.property(key), |key: &str| sensor.share(key), sensor.range());
    let bits = property("bits").map(|bits| bits as u32);
    let quality = Quality {
        accuracy: share("accuracy"),
        linearity: share("linearity"),
        repeatability: share("repeatability"),
        noise: share("noise"),
    };
    let mut random = RandomStream::new(seed, &sensor.name);
    match sensor.kind.as_str() {
        "incremental-encoder" => {
            let of_step = |step: f64| std::f64::consts::TAU / (4.0 * step);
            let pulses = property("pulses").or_else(|| property("resolution").map(of_step)).unwrap_or(1.0);
            Device::Encoder(Encoder::new(pulses, share("division-error").to_degrees(), &mut random))
        }
        "pressure-transmitter" => {
            let scale = Scale { full: range, live_zero: share("live-zero") };
            Device::Pressure(PressureTransmitter::new(scale, bits, share("rise-time"), quality, random))
        }
        "load-cell" => Device::Force(LoadCell::new(range, bits, accuracy_of_cell(quality), random)),
        _ => Device::Wire(WirePotentiometer::new(range, share("offset"), bits, quality, random)),
    }
}

/// A load cell's stated accuracy includes its linearity.
fn accuracy_of_cell(quality: Quality) -> Quality {
    if quality.accuracy > 0.0 {
        Quality { linearity: 0.0, ..quality }
    } else {
        quality
    }
}
