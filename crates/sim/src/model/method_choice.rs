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
    } else if task == Task::States && is_smooth(machine) {
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

/// Whether the laws of a machine are nearly linear over a step: all friction has bristles, and no law jumps.
fn is_smooth(machine: &Machine) -> bool {
    let bristles = machine.cylinders.iter().all(|cylinder| cylinder.friction.model == FrictionModel::LuGre);
    bristles && machine.ground.is_none() && machine.errata.orifice_law && !jumps(machine)
}
