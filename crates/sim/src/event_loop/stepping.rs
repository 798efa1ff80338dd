//! One step with its checks, and the criteria for ending a run.

use crate::event_loop::driven::Driven;
use crate::event_loop::warnings::Watch;
use crate::inputs::faults::failed;
use crate::inputs::options::RunOptions;
use crate::outcome::{Outcome, OutcomeKind};
use hydrocrane_ode::{Stepper, System, CRAWL_ATTEMPTS};

/// The outcome of a run that no longer advances in reasonable time. Call once before each step.
pub(crate) fn crawling(stepper: &mut Stepper) -> Result<(), Outcome> {
    let Some(advance) = stepper.crawls() else { return Ok(()) };
    let message = format!(
        "{CRAWL_ATTEMPTS} steps advanced by only {advance:.1e} s; a law jumps here (friction or orifice law as printed?): \
         take fixed steps (`step`), smooth the friction by `smoothing-velocity`, or loosen the tolerance"
    );
    Err(Outcome { kind: OutcomeKind::SolverFailed, time: stepper.t, message })
}

/// One step of `system`, at most to `limit`, and the checks of the new state. The states of `system` begin with those
/// of the crane `driven`.
pub(crate) fn step_of(
    system: &dyn System,
    stepper: &mut Stepper,
    watch: &mut Watch,
    driven: &Driven,
    limit: f64,
) -> Result<(), Outcome> {
    let stepped = stepper.step(system, limit).map_err(|failure| failed(driven.model, stepper, failure));
    watch.look(stepper, driven);
    stepped
}

/// The reason for an early end after successful steps.
pub(crate) fn given_up(
    stepper: &mut Stepper,
    options: &RunOptions,
    keep_going: &mut dyn FnMut(f64) -> bool,
) -> Option<Outcome> {
    if stepper.accepted >= options.max_steps {
        let message = format!("gave up after {} steps; loosen the tolerance or shorten the run", stepper.accepted);
        return Some(Outcome { kind: OutcomeKind::SolverFailed, time: stepper.t, message });
    }
    if stepper.accepted.is_multiple_of(256) && !keep_going(stepper.t) {
        let message = "stopped from outside".to_string();
        return Some(Outcome { kind: OutcomeKind::Interrupted, time: stepper.t, message });
    }
    None
}
