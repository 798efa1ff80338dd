//! A run under one driver from start to end.

use crate::inputs::options::{Commands, Run, RunOptions};
use crate::model::Model;
use crate::runs::phases::{simulate_phases, Driver, Phase};
use crate::runs::sampled::{Event, SampledPlan, Samples};
use hydrocrane_control::interface::controller::Controller;

/// Runs `model` from `x0` to `end` under spool commands against time, recording at `record` (ascending times).
/// `keep_going` is called from time to time.
pub fn simulate(
    model: &dyn Model,
    x0: &[f64],
    end: f64,
    commands: &Commands,
    record: &[f64],
    options: &RunOptions,
    keep_going: &mut dyn FnMut(f64) -> bool,
) -> Run {
    let only = Phase { from: 0.0, model, changes: Vec::new(), driver: Driver::Commands(commands) };
    simulate_phases(x0, end, only, Vec::new(), record, options, keep_going).run
}

/// A run with its samples.
#[derive(Debug, Clone)]
pub struct SampledRun {
    pub run: Run,
    pub samples: Samples,
    pub events: Vec<Event>,
}

/// As [`simulate`], under `controller`.
#[allow(clippy::too_many_arguments)]
pub fn simulate_sampled(
    model: &dyn Model,
    x0: &[f64],
    end: f64,
    controller: &mut dyn Controller,
    plan: &SampledPlan,
    record: &[f64],
    options: &RunOptions,
    keep_going: &mut dyn FnMut(f64) -> bool,
) -> SampledRun {
    let only = Phase { from: 0.0, model, changes: Vec::new(), driver: Driver::Controller(controller, plan) };
    let mut done = simulate_phases(x0, end, only, Vec::new(), record, options, keep_going);
    SampledRun { run: done.run, samples: done.samples.swap_remove(0), events: done.events }
}
