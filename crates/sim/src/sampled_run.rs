//! A run under one controller from start to end.

use crate::model::Model;
use crate::options::{Run, RunOptions};
use crate::phases::{simulate_phases, Phase};
use crate::sampled::{Event, SampledPlan, Samples};
use hydrocrane_control::controller::Controller;

/// A run with its samples.
#[derive(Debug, Clone)]
pub struct SampledRun {
    pub run: Run,
    pub samples: Samples,
    pub events: Vec<Event>,
}

/// Runs `model` from `x0` to `end` under `controller`, recording states at `record` (ascending times).
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
    let only = Phase { from: 0.0, model, controller, plan: plan.clone() };
    let mut done = simulate_phases(x0, end, only, Vec::new(), record, options, keep_going);
    SampledRun { run: done.run, samples: done.samples.swap_remove(0), events: done.events }
}
