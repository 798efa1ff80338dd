//! The loop of all runs: the due events between two steps, then steps until the next event.
//!
//! Commands against time, the samples of a controller and commands held from outside differ only in their [`Events`].

pub(crate) mod driven;
pub(crate) mod ledger;
pub(crate) mod oil_lost;
pub mod promises;
pub(crate) mod recorder;
pub(crate) mod stepping;
pub(crate) mod warnings;

use crate::event_loop::driven::Driven;
use crate::event_loop::stepping::{crawling, given_up, step_of};
use crate::event_loop::warnings::Watch;
use crate::inputs::options::RunOptions;
use crate::model::Model;
use crate::outcome::{Outcome, OutcomeKind};
use crate::warning::Warning;
use hydrocrane_num::Archive;
use hydrocrane_ode::{Stepper, System};

/// The system that is stepped: a crane with commands, alone or with tangents appended to its states.
pub(crate) trait Stepped<'a> {
    fn system(&self) -> &dyn System;
    fn driven(&self) -> &Driven<'a>;
    fn driven_mut(&mut self) -> &mut Driven<'a>;
    /// Picks up and releases the loads that are due at the time of `stepper`.
    fn change_payload(&mut self, stepper: &mut Stepper) {
        self.driven_mut().change_payload(stepper);
    }
}

impl<'a> Stepped<'a> for Driven<'a> {
    fn system(&self) -> &dyn System {
        self
    }
    fn driven(&self) -> &Driven<'a> {
        self
    }
    fn driven_mut(&mut self) -> &mut Driven<'a> {
        self
    }
}

/// Events between steps.
pub(crate) trait Events {
    /// Executes all events that are due at time `now` (s). An error is the outcome of the run.
    fn happen(&mut self, now: f64, driven: &mut Driven, stepper: &mut Stepper) -> Result<(), Outcome>;
    /// Time of the next event, s; infinite if there is none.
    fn next(&self) -> f64;
    /// Called after a step.
    fn follow(&mut self, _stepper: &Stepper) {}
}

/// Records a run.
pub(crate) trait Record {
    fn take(&mut self, stepper: &Stepper, driven: &Driven);
}

/// A state that advances in time, with checks after every step.
pub(crate) struct EventLoop {
    pub stepper: Stepper,
    pub watch: Watch,
    /// Time of the next event, s; all earlier ones are done.
    limit: f64,
}

impl EventLoop {
    /// At the state and time of `stepper`.
    pub fn new(stepper: Stepper, driven: &Driven) -> Self {
        EventLoop { watch: Watch::new(&stepper, driven), limit: stepper.t, stepper }
    }

    /// Steps until `end` or until something stops the run.
    pub fn run<'a>(
        &mut self,
        crane: &mut impl Stepped<'a>,
        events: &mut dyn Events,
        record: &mut dyn Record,
        end: f64,
        options: &RunOptions,
        keep_going: &mut dyn FnMut(f64) -> bool,
    ) -> Outcome {
        record.take(&self.stepper, crane.driven());
        while self.stepper.t < end {
            if let Err(outcome) = self.step(crane, events, end) {
                return outcome;
            }
            record.take(&self.stepper, crane.driven());
            if let Some(outcome) = given_up(&mut self.stepper, options, keep_going) {
                return outcome;
            }
        }
        Outcome { kind: OutcomeKind::Completed, time: self.stepper.t, message: "reached the end".to_string() }
    }

    /// One step towards `end`, after all events at its start. An error is the outcome: nothing steps for ever.
    pub fn step<'a>(&mut self, crane: &mut impl Stepped<'a>, events: &mut dyn Events, end: f64) -> Result<(), Outcome> {
        crawling(&mut self.stepper)?;
        while self.stepper.t >= self.limit {
            events.happen(self.limit, crane.driven_mut(), &mut self.stepper)?;
            crane.change_payload(&mut self.stepper);
            let driven = crane.driven_mut();
            driven.supply.follow(&mut self.stepper);
            if let Some(model) = driven.changes.due(self.limit) {
                self.change_model(driven, model);
            }
            let changes = [driven.loads.next_time(), driven.supply.next_time(), driven.changes.next_time()];
            self.limit = changes.into_iter().flatten().chain([events.next()]).fold(end, f64::min);
        }
        step_of(crane.system(), &mut self.stepper, &mut self.watch, crane.driven(), self.limit)?;
        events.follow(&self.stepper);
        Ok(())
    }

    /// The time of an event that is due before the next step, if there is one.
    pub fn due(&self) -> Option<f64> {
        (self.stepper.t >= self.limit).then_some(self.limit)
    }

    /// Continues with the values of `model`, whose states are the same.
    fn change_model<'a>(&mut self, driven: &mut Driven<'a>, model: &'a dyn Model) {
        let before = driven.model;
        driven.model = model;
        self.watch.follow(before, driven, &self.stepper);
        self.stepper.restart();
    }

    /// The same under another driver.
    pub fn go_on<'a>(&mut self, driven: &mut Driven<'a>, model: &'a dyn Model) {
        self.change_model(driven, model);
        // The next event belonged to the previous driver.
        self.limit = self.stepper.t;
    }

    /// All data that determine the continuation, without integrals and warnings.
    pub fn archive(&mut self, system: &dyn System, archive: &mut Archive) {
        archive.number(&mut self.limit);
        self.stepper.archive(system, archive);
    }

    /// Warnings since the last call.
    pub fn warnings(&mut self, model: &dyn Model) -> Vec<Warning> {
        self.watch.news(model)
    }
}
