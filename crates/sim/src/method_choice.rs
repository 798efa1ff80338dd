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
    } else if solver.step.is_some() {
        FIXED_STEPS
    } else if task == Task::States && is_smooth(machine) {
        "hc-exponential-4"
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

/// Whether the laws of a machine are nearly linear over a step: all friction has bristles, and no law jumps.
fn is_smooth(machine: &Machine) -> bool {
    let errata = &machine.errata;
    let bristles = machine.cylinders.iter().all(|cylinder| cylinder.friction.model == FrictionModel::LuGre);
    bristles && machine.ground.is_none() && errata.friction_map && errata.orifice_law
}

#[cfg(test)]
mod tests {
    use super::*;
    use hydrocrane_machine::scenario::{FORMER_METHODS, METHODS};
    use hydrocrane_machine::{load, OverrideValue};

    fn solver(method: &str, step: Option<f64>) -> Solver {
        Solver { method: method.to_string(), rtol: 1e-4, atol: None, max_step: 0.05, step }
    }

    fn machine(name: &str, changes: &[(&str, &str)]) -> Machine {
        let text = |value: &str| OverrideValue::Text(value.to_string());
        let changes: Vec<_> = changes.iter().map(|(key, value)| (key.to_string(), text(value))).collect();
        load(name, &changes).expect("a bundled machine")
    }

    fn taken(machine: &Machine) -> String {
        method_for(&solver(AUTO, None), machine, Task::States).to_string()
    }

    #[test]
    fn bristles_take_the_exponential_method() {
        for name in ["rottne-f9-lab", "hiab-xs031", "single-cylinder"] {
            assert_eq!(taken(&machine(name, &[])), "hc-exponential-4", "{name}");
        }
    }

    #[test]
    fn a_static_map_the_ground_or_a_law_that_jumps_takes_rodas5p() {
        assert_eq!(taken(&machine("heinze-2007", &[])), "rodas5p");
        assert_eq!(taken(&machine("rottne-f9-lab", &[("friction.jib.model", "static")])), "rodas5p");
        assert_eq!(taken(&machine("rottne-f9-lab", &[("errata.orifice-law", "as-printed")])), "rodas5p");
        assert_eq!(taken(&machine("rottne-f9-lab", &[("ground.height", "-1 m")])), "rodas5p");
    }

    #[test]
    fn a_step_takes_even_steps_and_sensitivities_the_more_exact_method() {
        let machine = machine("rottne-f9-lab", &[]);
        assert_eq!(method_for(&solver(AUTO, Some(1e-3)), &machine, Task::States), "hc-rosenbrock-3");
        assert_eq!(method_for(&solver(AUTO, None), &machine, Task::Sensitivities), "rodas5p");
    }

    #[test]
    fn files_name_the_methods_that_there_are() {
        let known: Vec<&str> = std::iter::once(AUTO).chain(hydrocrane_ode::METHODS).collect();
        assert_eq!(METHODS, known);
        assert!(FORMER_METHODS.iter().all(|(_, present)| METHODS.contains(present)));
    }

    #[test]
    fn a_stated_method_is_taken_as_it_is() {
        let machine = machine("heinze-2007", &[]);
        assert_eq!(method_for(&solver("tsit5", None), &machine, Task::States), "tsit5");
    }
}
