//! Open-loop runs: spool commands in, a record and an outcome out.

use crate::driven::{stepper, Driven};
use crate::faults::start_fault;
use crate::model::Model;
use crate::options::{Commands, Run, RunOptions};
use crate::outcome::{Outcome, OutcomeKind};
use crate::recorder::Recorder;
use crate::schedule::Schedule;
use crate::stepping::{given_up, step};
use crate::warnings::Watch;
use hydrocrane_ode::Stepper;

/// Runs `model` from `x0` to `end`, recording at `record` (ascending times). `keep_going` is asked now and then.
pub fn simulate(
    model: &dyn Model,
    x0: &[f64],
    end: f64,
    commands: &Commands,
    record: &[f64],
    options: &RunOptions,
    keep_going: &mut dyn FnMut(f64) -> bool,
) -> Run {
    let mut recorder = Recorder::new(model, record, options);
    if let Some(message) = start_fault(model, x0, options) {
        return recorder.finish(Outcome { kind: OutcomeKind::BadState, time: 0.0, message }, None);
    }
    let schedule = Schedule::new(commands, model);
    let mut driven = Driven::new(model, options, 0.0);
    let Some(mut stepper) = stepper(x0, model, options) else {
        let message = format!("no method `{}`", options.method);
        return recorder.finish(Outcome { kind: OutcomeKind::BadState, time: 0.0, message }, None);
    };
    let mut watch = Watch::new(&stepper, &driven);
    let outcome = drive(&mut stepper, &mut watch, &mut driven, &schedule, end, options, &mut recorder, keep_going);
    recorder.finish(outcome, Some((&stepper, &driven, &mut watch)))
}

/// Steps from break to break until the end or until something stops it.
#[allow(clippy::too_many_arguments)]
fn drive(
    stepper: &mut Stepper,
    watch: &mut Watch,
    driven: &mut Driven,
    schedule: &Schedule,
    end: f64,
    options: &RunOptions,
    recorder: &mut Recorder,
    keep_going: &mut dyn FnMut(f64) -> bool,
) -> Outcome {
    schedule.apply(0.0, driven);
    recorder.take(stepper, driven);
    while stepper.t < end {
        driven.change_payload(stepper);
        let next = schedule.breaks.iter().copied().find(|&b| b > stepper.t + 1e-12);
        let limit = next.into_iter().chain(driven.loads.next_time()).fold(end, f64::min);
        if let Err(outcome) = step(stepper, watch, driven, limit) {
            return outcome;
        }
        recorder.take(stepper, driven);
        if next.is_some_and(|at| stepper.t >= at) {
            schedule.apply(stepper.t, driven);
            stepper.restart();
        }
        if let Some(outcome) = given_up(stepper, options, keep_going) {
            return outcome;
        }
    }
    Outcome { kind: OutcomeKind::Completed, time: stepper.t, message: "reached the end".to_string() }
}
