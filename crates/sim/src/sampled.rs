//! Closed-loop runs: a controller that samples, computes, and holds its command until the next one arrives.
//!
//! At t = k T: sensors are read, the sticks moved, the controller computes; its command arrives after the computation
//! delay, the signal chain and the valve's delay, and is held. The controller never sees the state and never runs
//! inside the right-hand side.

use crate::command_path::CommandPaths;
use crate::driven::Driven;
use crate::model::Model;
use crate::options::RunOptions;
use crate::outcome::{Outcome, OutcomeKind};
use crate::recorder::Recorder;
use crate::sensing::Sensors;
use crate::stepping::{given_up, step};
use crate::stick::{Hand, Sticks, ROUNDING};
use crate::warnings::Watch;
use hydrocrane_control::controller::{Controller, Fault};
use hydrocrane_ode::Stepper;

/// Samples without a usable command after which a run ends.
pub const FAILURES_IN_A_ROW: u32 = 10;

/// What surrounds the controller.
#[derive(Debug, Clone)]
pub struct SampledPlan {
    pub sticks: Sticks,
    pub sensors: Sensors,
    /// Time that the controller takes to compute, s.
    pub delay: f64,
}

/// Something worth knowing that happened in a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// s
    pub time: f64,
    pub text: String,
}

/// What was measured and commanded, one row per sample.
#[derive(Debug, Clone, Default)]
pub struct Samples {
    pub times: Vec<f64>,
    /// Row-major, in the order of [`Sensors::signals`].
    pub measured: Vec<f64>,
    /// Row-major, deflections after dead zone and ramp.
    pub sticks: Vec<f64>,
    /// (x, z) of the tip, m; NaN where the controller has none.
    pub set_points: Vec<[f64; 2]>,
    /// Row-major, spool commands (m) as the controller gave them, zero where it gave none that can be used.
    pub commands: Vec<f64>,
}

impl Samples {
    /// Forgets all rows.
    pub(crate) fn clear(&mut self) {
        self.times.clear();
        self.measured.clear();
        self.sticks.clear();
        self.set_points.clear();
        self.commands.clear();
    }
}

/// Why a plan cannot be carried out, if it cannot.
pub(crate) fn plan_fault(plan: &SampledPlan, period: f64) -> Option<String> {
    if !(period.is_finite() && period > 0.0) {
        return Some(format!("the controller's period is {period} s; it must be greater than zero"));
    }
    if !(plan.delay.is_finite() && plan.delay >= 0.0) {
        return Some(format!("the computation delay is {} s; it must be zero or greater", plan.delay));
    }
    let sticks = &plan.sticks;
    if sticks.deflections.len() != sticks.times.len() * sticks.axes {
        let (values, times) = (sticks.deflections.len(), sticks.times.len());
        return Some(format!("{values} deflections for {times} times and {} stick axes", sticks.axes));
    }
    let beyond = sticks.deflections.iter().find(|d| d.is_nan() || d.abs() > 1.0 + ROUNDING);
    beyond.map(|d| format!("a stick's deflection is {d}; it must lie between -1 and 1"))
}

/// Crane, sensors and sticks between the samples of a controller.
pub(crate) struct ClosedLoop {
    pub stepper: Stepper,
    pub watch: Watch,
    pub sensors: Sensors,
    pub hand: Hand,
    pub paths: CommandPaths,
    delay: f64,
    /// When the first sample of the phase at hand is due, s, and how many it has taken.
    began: f64,
    sample: u64,
    /// End of the stretch under constant commands, s.
    limit: f64,
    /// Samples in a row that gave no usable command, and why the last of them did not.
    failing: u32,
    last_fault: String,
    /// The controller cannot go on.
    given_up: bool,
    /// Room for the command of a sample.
    command: Vec<f64>,
    pub samples: Samples,
    pub events: Vec<Event>,
}

impl ClosedLoop {
    /// At rest in the state of `stepper`, at time zero.
    pub fn new(stepper: Stepper, driven: &Driven, plan: &SampledPlan) -> Self {
        let machine = driven.model.machine();
        let mut sensors = plan.sensors.clone();
        sensors.settle(0.0, &stepper.x);
        ClosedLoop {
            watch: Watch::new(&stepper, driven),
            stepper,
            sensors,
            hand: Hand::new(plan.sticks.clone()),
            paths: CommandPaths::new(machine),
            delay: plan.delay,
            began: 0.0,
            sample: 0,
            limit: 0.0,
            failing: 0,
            last_fault: String::new(),
            given_up: false,
            command: vec![0.0; machine.cylinders.len()],
            samples: Samples::default(),
            events: Vec::new(),
        }
    }

    /// Another phase begins where the loop stands, in a state that `model` can have.
    pub fn go_on<'a>(&mut self, driven: &mut Driven<'a>, model: &'a dyn Model, plan: &SampledPlan) {
        let now = self.limit;
        let before = driven.model;
        driven.model = model;
        self.watch.follow(before, driven, &self.stepper);
        self.stepper.restart();
        self.sensors = plan.sensors.clone();
        self.sensors.settle(now, &self.stepper.x);
        self.hand.take(plan.sticks.clone(), now);
        self.paths.follow(model.machine());
        self.delay = plan.delay;
        (self.began, self.sample, self.failing) = (now, 0, 0);
    }

    /// Nobody moves the sticks as planned any more, after the last sample of a controller with this period (s).
    pub fn take_over(&mut self, period: f64) {
        let (began, taken) = (self.began, self.sample);
        self.hand.forget_after((0..taken).map(|sample| began + sample as f64 * period));
    }

    /// When the controller measures next, s.
    fn next_sample(&self, period: f64) -> f64 {
        self.began + self.sample as f64 * period
    }

    pub fn run(
        &mut self,
        driven: &mut Driven,
        controller: &mut dyn Controller,
        recorder: &mut Recorder,
        end: f64,
        options: &RunOptions,
        keep_going: &mut dyn FnMut(f64) -> bool,
    ) -> Outcome {
        recorder.take(&self.stepper, driven);
        while self.stepper.t < end {
            if let Err(outcome) = self.step(driven, controller, end) {
                return outcome;
            }
            recorder.take(&self.stepper, driven);
            if let Some(outcome) = given_up(&mut self.stepper, options, keep_going) {
                return outcome;
            }
        }
        Outcome { kind: OutcomeKind::Completed, time: self.stepper.t, message: "reached the end".to_string() }
    }

    /// One step of the integrator on the way to `end`, after all that happens where it begins.
    pub fn step(&mut self, driven: &mut Driven, controller: &mut dyn Controller, end: f64) -> Result<(), Outcome> {
        while self.stepper.t >= self.limit {
            self.interrupt(driven, controller, end)?;
        }
        step(&mut self.stepper, &mut self.watch, driven, self.limit)?;
        self.sensors.follow(&self.stepper);
        Ok(())
    }

    /// When the next sample is taken, if that is before the next step.
    pub fn sample_due(&self, period: f64) -> Option<f64> {
        (self.stepper.t >= self.limit && self.limit >= self.next_sample(period)).then_some(self.limit)
    }

    /// A sample if it is due, commands that arrive, loads that come and go; then on to the next of these.
    fn interrupt(&mut self, driven: &mut Driven, controller: &mut dyn Controller, end: f64) -> Result<(), Outcome> {
        let (now, period) = (self.limit, controller.period());
        if now >= self.next_sample(period) {
            self.take_sample(driven, controller, now);
            if self.given_up {
                let message = self.last_fault.clone();
                return Err(Outcome { kind: OutcomeKind::ControllerFailed, time: now, message });
            }
            if self.failing >= FAILURES_IN_A_ROW {
                let message = format!("{FAILURES_IN_A_ROW} samples in a row without a command: {}", self.last_fault);
                return Err(Outcome { kind: OutcomeKind::ControllerFailed, time: now, message });
            }
            self.sample += 1;
        }
        self.receive(driven, now);
        driven.change_payload(&mut self.stepper);
        // The next sample counts its times anew, so that no rounding piles up.
        let next = self.next_sample(period).min(end);
        let interruptions = self.paths.next_arrival().into_iter().chain(driven.loads.next_time());
        self.limit = interruptions.fold(next, f64::min);
        Ok(())
    }

    /// Delivers commands to the spools.
    fn receive(&mut self, driven: &mut Driven, now: f64) {
        if self.paths.receive(now) {
            driven.base = self.paths.arrived;
            driven.since = now;
            self.stepper.refresh();
        }
    }

    /// One sample: measure, move the sticks, compute, send.
    fn take_sample(&mut self, driven: &Driven, controller: &mut dyn Controller, now: f64) {
        self.sensors.read(driven.model, now, &self.stepper.x, driven.payload);
        let measured = self.sensors.measurement(now);
        if self.sample == 0 {
            controller.reset(&measured);
        }
        self.hand.move_to(now);
        let mut command = std::mem::take(&mut self.command);
        command.fill(0.0);
        let answer = controller.step(&measured, self.hand.stick(), &mut command);
        let notices = controller.notices().into_iter();
        self.events.extend(notices.map(|text| Event { time: now, text }));
        self.given_up = matches!(answer, Err(Fault::Fatal(_)));
        let fault = match answer {
            Err(fault) => Some(fault.to_string()),
            Ok(()) if command.iter().any(|u| !u.is_finite()) => {
                Some("the controller's command is not a finite number".to_string())
            }
            Ok(()) => None,
        };
        self.judge(now, fault, &mut command);
        for (u, c) in command.iter_mut().zip(&driven.model.machine().cylinders) {
            *u = u.clamp(-c.valve.stroke, c.valve.stroke);
        }
        self.paths.send(now + self.delay, &command);
        self.keep(now, controller.set_point(), &command);
        self.command = command;
    }

    /// Centres the spools where there is no usable command, and notes when that begins, changes or ends.
    fn judge(&mut self, now: f64, fault: Option<String>, command: &mut [f64]) {
        let Some(text) = fault else {
            if self.failing > 0 {
                let text = format!("the controller gives commands again after {} samples", self.failing);
                self.events.push(Event { time: now, text });
            }
            self.failing = 0;
            return;
        };
        command.fill(0.0);
        if self.failing == 0 || text != self.last_fault {
            let then = if self.given_up { "the run ends" } else { "the spools go to neutral" };
            self.events.push(Event { time: now, text: format!("{text}; {then}") });
        }
        self.failing += 1;
        self.last_fault = text;
    }

    fn keep(&mut self, now: f64, set_point: Option<[f64; 2]>, command: &[f64]) {
        self.samples.times.push(now);
        self.samples.measured.extend_from_slice(self.sensors.readings());
        self.samples.sticks.extend_from_slice(self.hand.at());
        self.samples.set_points.push(set_point.unwrap_or([f64::NAN; 2]));
        self.samples.commands.extend_from_slice(command);
    }
}
