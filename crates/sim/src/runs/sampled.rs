//! Closed-loop runs: a controller that samples, computes, and holds its command until the next one arrives.
//!
//! At t = k T: sensors are read, the sticks moved, the controller computes; its command arrives after the computation
//! delay, the signal chain and the valve's delay, and is held. The controller never sees the state and never runs
//! inside the right-hand side.

use crate::event_loop::driven::Driven;
use crate::event_loop::Events;
use crate::inputs::command_path::CommandPaths;
use crate::inputs::sensing::Sensors;
use crate::inputs::stick::{Hand, Sticks, ROUNDING};
use crate::outcome::{Outcome, OutcomeKind};
use hydrocrane_control::estimate::valve_learning::LearntValve;
use hydrocrane_control::interface::controller::{Alarm, Controller, Fault, Report};
use hydrocrane_ode::Stepper;

/// Number of consecutive samples without a usable command after which a run ends.
pub const FAILURES_IN_A_ROW: u32 = 10;

/// Sensors, sticks and delay of a controller.
#[derive(Debug, Clone)]
pub struct SampledPlan {
    pub sticks: Sticks,
    pub sensors: Sensors,
    /// Computation delay, s.
    pub delay: f64,
}

/// An event of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// s
    pub time: f64,
    pub text: String,
    /// What the run is warned of.
    pub alarm: Option<Alarm>,
}

impl Event {
    fn new(time: f64, text: String) -> Self {
        Event { time, text, alarm: None }
    }
}

/// Readings and commands, one row per sample.
#[derive(Debug, Clone, Default)]
pub struct Samples {
    pub times: Vec<f64>,
    /// Row-major, in the order of [`Sensors::signals`].
    pub measured: Vec<f64>,
    /// Row-major, deflections after dead zone and ramp.
    pub sticks: Vec<f64>,
    /// Set-point (x, y, z) of the tip, m; NaN if the controller has none.
    pub set_points: Vec<[f64; 3]>,
    /// Row-major, spool commands (m) of the controller, zero if it has no usable one.
    pub commands: Vec<f64>,
    /// Learnt parameters of each valve at the end.
    pub learnt: Vec<LearntValve>,
}

impl Samples {
    /// Removes all rows.
    pub(crate) fn clear(&mut self) {
        self.times.clear();
        self.measured.clear();
        self.sticks.clear();
        self.set_points.clear();
        self.commands.clear();
        self.learnt.clear();
    }
}

/// The reason if a plan cannot be executed.
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
    if !sticks.precision.is_empty() && sticks.precision.len() != sticks.times.len() {
        let (values, times) = (sticks.precision.len(), sticks.times.len());
        return Some(format!("{values} values of precision for {times} times of the sticks"));
    }
    let beyond = sticks.deflections.iter().find(|d| d.is_nan() || d.abs() > 1.0 + ROUNDING);
    beyond.map(|d| format!("a stick's deflection is {d}; it must lie between -1 and 1"))
}

/// Sensors, sticks and sent commands between the samples of a controller.
pub(crate) struct Sampled {
    pub sensors: Sensors,
    pub hand: Hand,
    pub paths: CommandPaths,
    delay: f64,
    /// Time of the first sample of the present phase, s, and its number of samples so far.
    began: f64,
    sample: u64,
    /// Number of consecutive samples without a usable command, and the reason at the last one.
    failing: u32,
    last_fault: String,
    /// The controller cannot continue.
    given_up: bool,
    /// Work space for the command of a sample.
    command: Vec<f64>,
    pub samples: Samples,
    pub events: Vec<Event>,
}

impl Sampled {
    /// From time `now` (s) and state `x` on, with the spools where `driven` has them.
    pub fn new(now: f64, x: &[f64], driven: &Driven, plan: &SampledPlan) -> Self {
        let machine = driven.model.machine();
        let mut sensors = plan.sensors.clone();
        sensors.settle(now, x);
        Sampled {
            sensors,
            hand: Hand::new(plan.sticks.clone(), now),
            paths: CommandPaths::new(machine, driven.command(now)),
            delay: plan.delay,
            began: now,
            sample: 0,
            failing: 0,
            last_fault: String::new(),
            given_up: false,
            command: vec![0.0; machine.cylinders.len()],
            samples: Samples::default(),
            events: Vec::new(),
        }
    }

    /// Another phase begins at time `now` (s) in state `x`.
    pub fn go_on(&mut self, now: f64, x: &[f64], driven: &Driven, plan: &SampledPlan) {
        self.sensors = plan.sensors.clone();
        self.sensors.settle(now, x);
        self.hand.take(plan.sticks.clone(), now);
        self.paths.follow(driven.model.machine());
        self.delay = plan.delay;
        (self.began, self.sample, self.failing) = (now, 0, 0);
    }

    /// Ends the plan of the sticks after the last sample of a controller with this period (s).
    pub fn take_over(&mut self, period: f64) {
        let (began, taken) = (self.began, self.sample);
        self.hand.forget_after((0..taken).map(|sample| began + sample as f64 * period));
    }

    /// Time of the next sample of a controller with this period (s), s.
    pub fn next_sample(&self, period: f64) -> f64 {
        // Computed from the count, so that rounding errors do not accumulate.
        self.began + self.sample as f64 * period
    }

    /// One sample: measure, move the sticks, compute, send.
    fn take_sample(&mut self, driven: &Driven, controller: &mut dyn Controller, now: f64, x: &[f64]) {
        self.sensors.read(driven.model, now, x, driven.payload);
        let measured = self.sensors.measurement(now);
        if self.sample == 0 {
            controller.reset(&measured);
        }
        self.hand.move_to(now);
        if let Some(goal) = self.hand.refused() {
            let text = format!("the goal {} is ignored: a stick is deflected; release it first", goal.name());
            self.events.push(Event::new(now, text));
        }
        let mut command = std::mem::take(&mut self.command);
        command.fill(0.0);
        let answer = controller.step(&measured, self.hand.stick(), &mut command);
        if !controller.heading() {
            self.hand.arrive();
        }
        let notices = controller.notices().into_iter();
        self.events.extend(notices.map(|Report { text, alarm }| Event { time: now, text, alarm }));
        self.given_up = matches!(answer, Err(Fault::Fatal(_)));
        let fault = match answer {
            Err(fault) => Some(fault.to_string()),
            Ok(()) if command.iter().any(|u| !u.is_finite()) => {
                Some("the controller's command is not a finite number".to_string())
            }
            Ok(()) => None,
        };
        self.judge(now, fault, &mut command);
        self.paths.look(now, driven.model.machine(), &command);
        for (u, c) in command.iter_mut().zip(&driven.model.machine().cylinders) {
            *u = u.clamp(-c.valve.stroke, c.valve.stroke);
        }
        self.paths.send(now + self.delay, &command);
        self.keep(now, controller.set_point_in_space(), &command);
        self.command = command;
    }

    /// Centres the spools if there is no usable command, and records when that begins, changes or ends.
    fn judge(&mut self, now: f64, fault: Option<String>, command: &mut [f64]) {
        let Some(text) = fault else {
            if self.failing > 0 {
                let text = format!("the controller gives commands again after {} samples", self.failing);
                self.events.push(Event::new(now, text));
            }
            self.failing = 0;
            return;
        };
        command.fill(0.0);
        if self.failing == 0 || text != self.last_fault {
            let then = if self.given_up { "the run ends" } else { "the spools go to neutral" };
            self.events.push(Event::new(now, format!("{text}; {then}")));
        }
        self.failing += 1;
        self.last_fault = text;
    }

    fn keep(&mut self, now: f64, set_point: Option<[f64; 3]>, command: &[f64]) {
        self.samples.times.push(now);
        self.samples.measured.extend_from_slice(self.sensors.readings());
        self.samples.sticks.extend_from_slice(self.hand.at());
        self.samples.set_points.push(set_point.unwrap_or([f64::NAN; 3]));
        self.samples.commands.extend_from_slice(command);
    }
}

/// The samples of a controller as events of a run.
pub(crate) struct Sampling<'a> {
    pub state: &'a mut Sampled,
    pub controller: &'a mut dyn Controller,
}

impl Events for Sampling<'_> {
    /// Takes a sample if it is due, and delivers commands that arrive.
    fn happen(&mut self, now: f64, driven: &mut Driven, stepper: &mut Stepper) -> Result<(), Outcome> {
        let Sampling { state, controller } = self;
        if now >= state.next_sample(controller.period()) {
            state.take_sample(driven, *controller, now, &stepper.x);
            let failed = |message| Err(Outcome { kind: OutcomeKind::ControllerFailed, time: now, message });
            if state.given_up {
                return failed(state.last_fault.clone());
            }
            if state.failing >= FAILURES_IN_A_ROW {
                return failed(format!("{FAILURES_IN_A_ROW} samples in a row without a command: {}", state.last_fault));
            }
            state.sample += 1;
        }
        driven.receive(&mut state.paths, now, stepper);
        Ok(())
    }

    fn next(&self) -> f64 {
        let sample = self.state.next_sample(self.controller.period());
        self.state.paths.next_arrival().map_or(sample, |arrival| arrival.min(sample))
    }

    fn follow(&mut self, stepper: &Stepper) {
        self.state.sensors.follow(stepper);
    }
}
