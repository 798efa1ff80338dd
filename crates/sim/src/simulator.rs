//! Step by step simulation for people's own controllers: commands held over one sample time.

use crate::command_path::CommandPaths;
use crate::driven::{stepper, Driven};
use crate::faults::start_fault;
use crate::model::Model;
use crate::options::RunOptions;
use crate::outcome::{Outcome, OutcomeKind};
use crate::payload::{change_payload, PayloadEvent};
use crate::sensing::Sensors;
use crate::stepping::step;
use crate::warning::Warning;
use crate::warnings::Watch;
use hydrocrane_ode::Stepper;
use std::sync::Arc;

pub struct Simulator {
    model: Arc<dyn Model>,
    options: RunOptions,
    /// At the tip, kg.
    payload: f64,
    sample_time: f64,
    stepper: Option<(Stepper, Watch)>,
    paths: CommandPaths,
    sensors: Sensors,
    /// The sensors before their first reading, whose noise a reset repeats.
    unread: Sensors,
}

impl Simulator {
    pub fn new(model: Arc<dyn Model>, sample_time: f64, options: RunOptions) -> Self {
        let (paths, sensors) = (CommandPaths::new(model.machine()), Sensors::ideal(model.as_ref()));
        let payload = options.payload;
        Simulator { model, options, payload, sample_time, stepper: None, paths, unread: sensors.clone(), sensors }
    }

    /// Reads through these sensors instead of ideal ones.
    pub fn with_sensors(mut self, sensors: Sensors) -> Self {
        self.unread = sensors.clone();
        self.sensors = sensors;
        self
    }

    /// Starts anew at time zero; the error says why a state cannot be started from.
    pub fn reset(&mut self, x0: &[f64]) -> Result<(), String> {
        if let Some(fault) = start_fault(self.model.as_ref(), x0, &self.options) {
            return Err(fault);
        }
        self.paths.clear();
        self.payload = self.options.payload;
        let driven = Driven::new(self.model.as_ref(), &self.options, 0.0);
        let stepper = stepper(x0, self.model.as_ref(), &self.options);
        self.stepper = stepper.map(|stepper| {
            let watch = Watch::new(&stepper, &driven);
            (stepper, watch)
        });
        self.sensors = self.unread.clone();
        self.sensors.settle(0.0, x0);
        self.sensors.read(self.model.as_ref(), 0.0, x0, self.payload);
        Ok(())
    }

    /// Holds the spool commands `u` (m) for one sample time.
    pub fn step(&mut self, u: &[f64]) -> Outcome {
        let Some((mut stepper, mut watch)) = self.stepper.take() else {
            let message = "reset the simulator before stepping it".to_string();
            return Outcome { kind: OutcomeKind::BadState, time: 0.0, message };
        };
        let outcome = self.advance(&mut stepper, &mut watch, u);
        self.stepper = Some((stepper, watch));
        outcome
    }

    fn advance(&mut self, stepper: &mut Stepper, watch: &mut Watch, u: &[f64]) -> Outcome {
        let end = stepper.t + self.sample_time;
        self.paths.send(stepper.t, u);
        while stepper.t < end {
            self.paths.receive(stepper.t);
            let limit = self.paths.next_arrival().map_or(end, |t| t.min(end));
            let mut driven = Driven::new(self.model.as_ref(), &self.options, stepper.t);
            driven.base = self.paths.arrived;
            driven.payload = self.payload;
            stepper.refresh();
            while stepper.t < limit {
                if let Err(outcome) = step(stepper, watch, &driven, limit) {
                    return outcome;
                }
                self.sensors.follow(stepper);
            }
        }
        self.sensors.read(self.model.as_ref(), stepper.t, &stepper.x, self.payload);
        Outcome { kind: OutcomeKind::Completed, time: stepper.t, message: "stepped".to_string() }
    }

    /// From here on the tip carries `mass` (kg): takes up a load that lies still, or lets one go. `None` before a reset.
    pub fn set_payload(&mut self, mass: f64) -> Option<PayloadEvent> {
        let (stepper, _) = self.stepper.as_mut()?;
        let change = [self.payload, mass];
        self.payload = mass;
        let event = change_payload(self.model.as_ref(), stepper.t, &mut stepper.x, change);
        stepper.restart();
        Some(event)
    }

    /// What has made the simulation doubtful since the last call.
    pub fn warnings(&mut self) -> Vec<Warning> {
        self.stepper.as_mut().map_or_else(Vec::new, |(_, watch)| watch.news(self.model.as_ref()))
    }

    pub fn model(&self) -> &dyn Model {
        self.model.as_ref()
    }

    /// At the tip, kg.
    pub fn payload(&self) -> f64 {
        self.payload
    }

    /// What the sensors read at the last sample.
    pub fn sensors(&self) -> &Sensors {
        &self.sensors
    }

    pub fn state(&self) -> Option<&[f64]> {
        self.stepper.as_ref().map(|(s, _)| s.x.as_slice())
    }

    /// x, z of the tip, m.
    pub fn tip(&self) -> Option<[f64; 2]> {
        self.stepper.as_ref().map(|(s, _)| self.model.tip(&s.x[..self.model.layout().joints()]))
    }

    pub fn time(&self) -> f64 {
        self.stepper.as_ref().map_or(0.0, |(s, _)| s.t)
    }
}
