//! Collects the results of a run at the record times.

use crate::event_loop::driven::Driven;
use crate::event_loop::warnings::Watch;
use crate::event_loop::Record;
use crate::inputs::options::{Run, RunOptions};
use crate::model::payload::PAYLOAD_TERMS;
use crate::model::Model;
use crate::outcome::{Outcome, OutcomeKind};
use hydrocrane_ode::{Effort, Stepper};

/// Collects rows at the record times.
pub(crate) struct Recorder<'a> {
    record: &'a [f64],
    next: usize,
    state: Vec<f64>,
    energies: Vec<f64>,
    run: Run,
}

impl<'a> Recorder<'a> {
    pub fn new(model: &dyn Model, record: &'a [f64], options: &RunOptions) -> Self {
        let n = model.layout().joints();
        let quadratures = options.quadratures(model);
        let outcome = Outcome { kind: OutcomeKind::Completed, time: 0.0, message: String::new() };
        Recorder {
            record,
            next: 0,
            state: vec![0.0; model.layout().len()],
            energies: vec![0.0; quadratures],
            run: Run {
                times: Vec::with_capacity(record.len()),
                states: Vec::with_capacity(record.len() * model.layout().len()),
                ledger: Vec::with_capacity(record.len() * (quadratures + PAYLOAD_TERMS.len())),
                payloads: Vec::with_capacity(record.len()),
                commands: Vec::with_capacity(record.len() * n),
                payload_events: Vec::new(),
                warnings: Vec::new(),
                outcome,
                method: options.method.clone(),
                accepted: 0,
                rejected: 0,
                effort: Effort::default(),
                tip_error: None,
            },
        }
    }

    fn push(&mut self, t: f64, driven: &Driven) {
        self.run.times.push(t);
        self.run.states.extend_from_slice(&self.state);
        if !self.energies.is_empty() {
            self.run.ledger.extend(self.energies.iter().chain(&driven.loads.account));
        }
        self.run.payloads.push(driven.payload);
        self.run.commands.extend_from_slice(&driven.command(t)[..driven.model.layout().joints()]);
    }

    /// The run so far. A run that ended early also has its last state.
    pub fn finish(mut self, outcome: Outcome, end: Option<(&Stepper, &Driven, &mut Watch)>) -> Run {
        if let Some((stepper, driven, watch)) = end {
            let last = self.run.times.last().copied().unwrap_or(-1.0);
            if outcome.kind != OutcomeKind::Completed && stepper.t > last {
                self.state.copy_from_slice(&stepper.x);
                self.energies.copy_from_slice(stepper.integrals());
                self.push(stepper.t, driven);
            }
            self.run.payload_events.clone_from(&driven.loads.events);
            self.run.warnings = watch.close(stepper, driven);
            self.run.accepted = stepper.accepted;
            self.run.rejected = stepper.rejected;
            self.run.effort = stepper.effort();
            self.run.tip_error = watch.tip_error;
        }
        self.run.outcome = outcome;
        self.run
    }
}

impl Record for Recorder<'_> {
    /// Every record time up to the stepper's.
    fn take(&mut self, stepper: &Stepper, driven: &Driven) {
        while self.next < self.record.len() && self.record[self.next] <= stepper.t + 1e-12 {
            let t = self.record[self.next];
            stepper.interpolate(t, &mut self.state);
            stepper.interpolate_integrals(t, &mut self.energies);
            self.push(t, driven);
            self.next += 1;
        }
    }
}
