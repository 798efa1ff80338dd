//! Messages on inadmissible start states and failed steps.

use crate::inputs::options::RunOptions;
use crate::inputs::supply;
use crate::model::payload;
use crate::model::Model;
use crate::outcome::{Outcome, OutcomeKind};
use hydrocrane_ode::{StepFailure, Stepper, METHODS};

/// The reason if a state is no admissible start.
pub(crate) fn start_fault(model: &dyn Model, x0: &[f64], options: &RunOptions) -> Option<String> {
    if !METHODS.contains(&options.method.as_str()) {
        return Some(format!("no method `{}`; there are {}", options.method, METHODS.join(", ")));
    }
    payload::fault(&options.payload_changes)
        .or_else(|| supply::fault(model, options))
        .or_else(|| state_fault(model, x0))
}

/// The reason if a state is physically impossible.
pub(crate) fn state_fault(model: &dyn Model, x0: &[f64]) -> Option<String> {
    let layout = model.layout();
    if x0.len() != layout.len() {
        return Some(format!("the initial state has {} numbers, the machine {} states", x0.len(), layout.len()));
    }
    if let Some(i) = x0.iter().position(|v| !v.is_finite()) {
        return Some(format!("initial state `{}` is {}; it must be a finite number", layout.names[i], x0[i]));
    }
    (!model.admissible(x0)).then(|| format!("the initial state is impossible: {}", outside(model, x0)))
}

/// Names the piston nearest to, or beyond, an end of its stroke, or the linkage that cannot close.
fn outside(model: &dyn Model, x: &[f64]) -> String {
    let Some((c, position)) = outermost(model, x) else { return "a linkage does not close".to_string() };
    let cylinder = &model.machine().cylinders[c];
    let half = cylinder.stroke / 2.0;
    format!("the piston of `{}` is at {position:.4} m, its ends are at -{half:.4} and {half:.4} m", cylinder.name)
}

/// The cylinder whose piston is relatively farthest out, with its position; `None` if a linkage cannot close.
fn outermost(model: &dyn Model, x: &[f64]) -> Option<(usize, f64)> {
    let n = model.layout().joints();
    let (mut position, mut gain) = (vec![0.0; n], vec![0.0; n]);
    model.strokes(&x[..n], &mut position, &mut gain);
    let fill = |c: usize| position[c].abs() / (model.machine().cylinders[c].stroke / 2.0);
    let c = (0..n).max_by(|&a, &b| fill(a).total_cmp(&fill(b)))?;
    position[c].is_finite().then(|| (c, position[c]))
}

/// Outcome of a run that cannot continue.
pub(crate) fn failed(model: &dyn Model, stepper: &Stepper, failure: StepFailure) -> Outcome {
    let beyond = outermost(model, &stepper.x)
        .is_none_or(|(c, position)| position.abs() >= model.machine().cylinders[c].stroke / 2.0);
    // With a piston in its dead volume every step fails, whatever the solver reports.
    let (kind, message) = if failure == StepFailure::NotAdmissible || beyond {
        (OutcomeKind::StrokeLimit, format!("a piston left its cylinder: {}", outside(model, &stepper.x)))
    } else if failure == StepFailure::NotFinite {
        let least = 1e6 * stepper.least_part();
        let message = format!(
            "fixed steps divided down to {least:.0} us cannot follow the motion; shorten the step, or use `rodas5p`, \
             which has step size control"
        );
        (OutcomeKind::SolverFailed, message)
    } else {
        let message = "the step size fell below rounding; a law jumps here (as-printed friction or orifice law?) \
                       or the tolerance is too tight";
        (OutcomeKind::SolverFailed, message.to_string())
    };
    Outcome { kind, time: stepper.t, message }
}
