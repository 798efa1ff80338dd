//! The method that a run takes where none is stated.

use hydrocrane_machine::scenario::{Solver, AUTO, METHODS};
use hydrocrane_machine::{load, Machine, OverrideValue};
use hydrocrane_sim::{method_for, Task};

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
fn only_laws_that_jump_take_the_secant_in_fixed_steps_and_sensitivities_the_more_exact_method() {
    let (smooth, stepped) = (machine("rottne-f9-lab", &[]), solver(AUTO, Some(1e-3)));
    assert_eq!(method_for(&stepped, &smooth, Task::States), "hc-exponential-4");
    let coarse = machine("rottne-f9-lab", &[("friction.jib.model", "static"), ("ground.height", "-1 m")]);
    assert_eq!(method_for(&stepped, &coarse, Task::States), "hc-exponential-4");
    assert_eq!(method_for(&stepped, &machine("heinze-2007", &[]), Task::States), "hc-rosenbrock-3");
    assert_eq!(method_for(&solver(AUTO, None), &smooth, Task::Sensitivities), "rodas5p");
    assert_eq!(method_for(&stepped, &smooth, Task::Sensitivities), "hc-rosenbrock-3");
}

#[test]
fn files_name_the_methods_that_there_are() {
    let known: Vec<&str> = std::iter::once(AUTO).chain(hydrocrane_ode::METHODS).collect();
    assert_eq!(METHODS, known);
}

#[test]
fn a_stated_method_is_taken_as_it_is() {
    let machine = machine("heinze-2007", &[]);
    assert_eq!(method_for(&solver("tsit5", None), &machine, Task::States), "tsit5");
}
