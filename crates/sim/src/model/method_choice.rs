//! The default method of a run.   theory: docs/theory/integration.md

use hydrocrane_machine::model::FrictionModel;
use hydrocrane_machine::scenario::{Solver, AUTO, FIXED_STEPS};
use hydrocrane_machine::Machine;
use hydrocrane_ode::StepControl;

/// Kind of the integrated system.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Task {
    States,
    /// The states with their derivatives by parameters.
    Sensitivities,
}

/// The method that `solver` states, or the fastest suitable one for the `task`, which meets its tolerance.
pub fn method_for<'a>(solver: &'a Solver, machine: &Machine, task: Task) -> &'a str {
    if solver.method != AUTO {
        &solver.method
    } else if task == Task::States && suits_exponential(machine, solver.step.is_some()) {
        "hc-exponential-4"
    } else if solver.step.is_some() {
        FIXED_STEPS
    } else {
        "rodas5p"
    }
}

/// Step size control of `solver`.
pub(crate) fn step_control(solver: &Solver) -> StepControl {
    match solver.step {
        Some(_) => StepControl::Even,
        None => StepControl::Adaptive,
    }
}

/// Whether a law of the machine jumps: a step over a jump has the same error, however short it is.
pub(crate) fn jumps(machine: &Machine) -> bool {
    !machine.errata.friction_map
}

/// Whether `hc-exponential-4` is the most exact method in the same time: no law jumps and, unless steps are `fixed`, all friction has
/// bristles and nothing meets the ground.
fn suits_exponential(machine: &Machine, fixed: bool) -> bool {
    let bristles = || machine.cylinders.iter().all(|cylinder| cylinder.friction.model == FrictionModel::LuGre);
    machine.errata.orifice_law && !jumps(machine) && (fixed || bristles() && machine.ground.is_none())
}
