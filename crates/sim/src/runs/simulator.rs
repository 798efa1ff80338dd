//! Step by step simulation for user-defined controllers: commands held over one sample time.

use crate::event_loop::driven::{stepper, Driven};
use crate::event_loop::{EventLoop, Events};
use crate::inputs::command_path::CommandPaths;
use crate::inputs::faults::{start_fault, state_fault};
use crate::inputs::options::RunOptions;
use crate::inputs::sensing::Sensors;
use crate::model::payload::{change_payload, PayloadEvent};
use crate::model::Model;
use crate::outcome::{Outcome, OutcomeKind};
use crate::runs::phases::states_fault;
use crate::warning::Warning;
use hydrocrane_num::Archive;
use hydrocrane_ode::{least_step, Stepper};
use hydrocrane_plant::layout::MAX_JOINTS;
use std::mem::replace;
use std::sync::Arc;

pub struct Simulator {
    model: Arc<dyn Model>,
    options: RunOptions,
    /// At the tip, kg.
    payload: f64,
    sample_time: f64,
    /// Time that was asked for and is too short to be simulated alone, s.
    owed: f64,
    going: Option<EventLoop>,
    paths: CommandPaths,
    sensors: Sensors,
    /// The sensors before their first reading, whose noise a reset repeats.
    unread: Sensors,
}

/// Commands from outside on the command path, and the sensors.
struct Held<'a> {
    paths: &'a mut CommandPaths,
    sensors: &'a mut Sensors,
}

impl Events for Held<'_> {
    fn happen(&mut self, now: f64, driven: &mut Driven, stepper: &mut Stepper) -> Result<(), Outcome> {
        driven.receive(self.paths, now, stepper);
        Ok(())
    }

    fn next(&self) -> f64 {
        self.paths.next_arrival().unwrap_or(f64::INFINITY)
    }

    fn follow(&mut self, stepper: &Stepper) {
        self.sensors.follow(stepper);
    }
}

impl Simulator {
    /// Loads change by [`Self::set_payload`] only, not by `options`.
    pub fn new(model: Arc<dyn Model>, sample_time: f64, options: RunOptions) -> Self {
        let options = RunOptions { payload_changes: Vec::new(), supply: None, ..options };
        let (paths, sensors) = (CommandPaths::new(model.machine(), [0.0; MAX_JOINTS]), Sensors::ideal(model.as_ref()));
        let payload = options.payload;
        Simulator {
            model,
            options,
            payload,
            sample_time,
            owed: 0.0,
            going: None,
            paths,
            unread: sensors.clone(),
            sensors,
        }
    }

    /// Uses these sensors instead of ideal ones.
    pub fn with_sensors(mut self, sensors: Sensors) -> Self {
        self.unread = sensors.clone();
        self.sensors = sensors;
        self
    }

    /// Restarts at time zero; the error states why a state is no admissible start.
    pub fn reset(&mut self, x0: &[f64]) -> Result<(), String> {
        if let Some(fault) = start_fault(self.model.as_ref(), x0, &self.options) {
            return Err(fault);
        }
        self.paths.clear();
        (self.payload, self.owed) = (self.options.payload, 0.0);
        let driven = Driven::new(self.model.as_ref(), &self.options, 0.0);
        let stepper = stepper(x0, self.model.as_ref(), &self.options);
        self.going = stepper.map(|stepper| EventLoop::new(stepper, &driven));
        self.sensors = self.unread.clone();
        self.sensors.settle(0.0, x0);
        self.sensors.read(self.model.as_ref(), 0.0, x0, self.payload);
        Ok(())
    }

    /// Holds the spool commands `u` (m) for one sample time.
    pub fn step(&mut self, u: &[f64]) -> Outcome {
        self.step_for(u, self.sample_time)
    }

    /// Holds the spool commands `u` (m) for this `duration` (s).
    pub fn step_for(&mut self, u: &[f64], duration: f64) -> Outcome {
        let Some(going) = &mut self.going else {
            let message = "reset the simulator before stepping it".to_string();
            return Outcome { kind: OutcomeKind::BadState, time: 0.0, message };
        };
        let model = self.model.as_ref();
        self.owed += duration;
        // No solver resolves less.
        let duration = if self.owed < least_step(going.stepper.t) { 0.0 } else { replace(&mut self.owed, 0.0) };
        let end = going.stepper.t + duration;
        going.stepper.set_max_step(self.options.tolerances.max_step.min(duration));
        self.paths.look(going.stepper.t, model.machine(), u);
        self.paths.send(going.stepper.t, u);
        let mut driven = Driven::new(model, &self.options, going.stepper.t);
        (driven.base, driven.payload) = (self.paths.arrived, self.payload);
        let mut held = Held { paths: &mut self.paths, sensors: &mut self.sensors };
        while going.stepper.t < end {
            if let Err(outcome) = going.step(&mut driven, &mut held, end) {
                return outcome;
            }
        }
        let stepper = &going.stepper;
        self.sensors.read(model, stepper.t, &stepper.x, self.payload);
        Outcome { kind: OutcomeKind::Completed, time: stepper.t, message: "stepped".to_string() }
    }

    /// Sets the payload to `mass` (kg): picks up a load at rest, or releases one. `None` before a reset.
    pub fn set_payload(&mut self, mass: f64) -> Option<PayloadEvent> {
        let stepper = &mut self.going.as_mut()?.stepper;
        let change = [self.payload, mass];
        self.payload = mass;
        let event = change_payload(self.model.as_ref(), stepper.t, &mut stepper.x, change);
        stepper.restart();
        Some(event)
    }

    /// Continues with the values of `model`. The error states why it cannot.
    pub fn change_machine(&mut self, model: Arc<dyn Model>) -> Result<(), String> {
        let state = self.state().and_then(|x| state_fault(model.as_ref(), x));
        if let Some(fault) = states_fault(self.model.as_ref(), model.as_ref()).or(state) {
            return Err(fault);
        }
        if let Some(going) = &mut self.going {
            let mut driven = Driven::new(self.model.as_ref(), &self.options, going.stepper.t);
            (driven.base, driven.payload) = (self.paths.arrived, self.payload);
            going.go_on(&mut driven, model.as_ref());
        }
        self.paths.follow(model.machine());
        self.model = model;
        Ok(())
    }

    /// The changing state after a reset. Read into a reset simulator of the same machine and options, the run continues
    /// with the same bits.
    pub fn archive(&mut self, archive: &mut Archive) {
        archive.number(&mut self.payload);
        archive.number(&mut self.owed);
        self.paths.archive(archive);
        self.sensors.archive(archive);
        let mut driven = Driven::new(self.model.as_ref(), &self.options, 0.0);
        (driven.base, driven.payload) = (self.paths.arrived, self.payload);
        if let Some(going) = &mut self.going {
            going.archive(&driven, archive);
        }
    }

    /// Warnings since the last call.
    pub fn warnings(&mut self) -> Vec<Warning> {
        let found = self.going.as_mut().map_or_else(Vec::new, |going| going.warnings(self.model.as_ref()));
        self.paths.warning().into_iter().chain(found).collect()
    }

    /// The method in use.
    pub fn method(&self) -> &str {
        &self.options.method
    }

    pub fn model(&self) -> &dyn Model {
        self.model.as_ref()
    }

    /// s
    pub fn sample_time(&self) -> f64 {
        self.sample_time
    }

    /// At the tip, kg.
    pub fn payload(&self) -> f64 {
        self.payload
    }

    /// Sensor readings at the last sample.
    pub fn sensors(&self) -> &Sensors {
        &self.sensors
    }

    pub fn state(&self) -> Option<&[f64]> {
        self.going.as_ref().map(|going| going.stepper.x.as_slice())
    }

    /// x, y, z of the tip, m.
    pub fn tip(&self) -> Option<[f64; 3]> {
        self.state().map(|x| self.model.tip(&x[..self.model.layout().joints()]))
    }

    pub fn time(&self) -> f64 {
        self.going.as_ref().map_or(0.0, |going| going.stepper.t + self.owed)
    }
}
