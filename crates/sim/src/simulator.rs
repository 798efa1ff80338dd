//! Step by step simulation for people's own controllers: commands held over one sample time.

use crate::integrator::{method, Stepper};
use crate::model::{Model, MAX_JOINTS};
use crate::outcome::{Outcome, OutcomeKind};
use crate::run::{failed, start_fault, Driven, RunOptions};
use std::collections::VecDeque;
use std::sync::Arc;

pub struct Simulator {
    model: Arc<dyn Model>,
    options: RunOptions,
    sample_time: f64,
    stepper: Option<Stepper>,
    /// Commands on their way through each valve's delay: (time of arrival, value).
    pending: Vec<VecDeque<(f64, f64)>>,
    arrived: [f64; MAX_JOINTS],
}

impl Simulator {
    pub fn new(model: Arc<dyn Model>, sample_time: f64, options: RunOptions) -> Self {
        let n = model.layout().joints();
        Simulator {
            model,
            options,
            sample_time,
            stepper: None,
            pending: vec![VecDeque::new(); n],
            arrived: [0.0; MAX_JOINTS],
        }
    }

    /// Starts anew at time zero; the error says why a state cannot be started from.
    pub fn reset(&mut self, x0: &[f64]) -> Result<(), String> {
        if let Some(fault) = start_fault(self.model.as_ref(), x0, &self.options) {
            return Err(fault);
        }
        self.pending.iter_mut().for_each(VecDeque::clear);
        self.arrived.fill(0.0);
        self.stepper = method(&self.options.method, x0.len(), 0)
            .map(|method| Stepper::new(method, self.options.tolerances, 0.0, x0, 0));
        Ok(())
    }

    /// Holds the spool commands `u` (m) for one sample time.
    pub fn step(&mut self, u: &[f64]) -> Outcome {
        let Some(mut stepper) = self.stepper.take() else {
            let message = "reset the simulator before stepping it".to_string();
            return Outcome { kind: OutcomeKind::BadState, time: 0.0, message };
        };
        let outcome = self.advance(&mut stepper, u);
        self.stepper = Some(stepper);
        outcome
    }

    fn advance(&mut self, stepper: &mut Stepper, u: &[f64]) -> Outcome {
        let end = stepper.t + self.sample_time;
        self.send(stepper.t, u);
        while stepper.t < end {
            self.receive(stepper.t);
            let arrivals = self.pending.iter().filter_map(|line| line.front());
            let limit = arrivals.map(|&(t, _)| t).fold(end, f64::min);
            let driven = Driven {
                model: self.model.as_ref(),
                payload: self.options.payload,
                quadratures: 0,
                base: self.arrived,
                slope: [0.0; MAX_JOINTS],
                since: stepper.t,
            };
            stepper.refresh();
            while stepper.t < limit {
                if let Err(failure) = stepper.step(&driven, limit) {
                    return failed(self.model.as_ref(), stepper, failure);
                }
            }
        }
        Outcome { kind: OutcomeKind::Completed, time: stepper.t, message: "stepped".to_string() }
    }

    fn send(&mut self, now: f64, u: &[f64]) {
        let cylinders = &self.model.machine().cylinders;
        for ((line, value), c) in self.pending.iter_mut().zip(u).zip(cylinders) {
            let limit = c.valve.stroke;
            line.push_back((now + c.valve.delay, value.clamp(-limit, limit)));
        }
    }

    fn receive(&mut self, now: f64) {
        for (line, arrived) in self.pending.iter_mut().zip(&mut self.arrived) {
            while line.front().is_some_and(|&(t, _)| t <= now + 1e-12) {
                if let Some((_, value)) = line.pop_front() {
                    *arrived = value;
                }
            }
        }
    }

    pub fn state(&self) -> Option<&[f64]> {
        self.stepper.as_ref().map(|s| s.x.as_slice())
    }

    pub fn time(&self) -> f64 {
        self.stepper.as_ref().map_or(0.0, |s| s.t)
    }
}
