//! What tests of drives share: opening one, reading its frames, and the native run of a saved drive.

use hydrocrane_machine::scenario::Scenario;
use hydrocrane_machine::{load, OverrideValue};
use hydrocrane_sim::assembly::{assemble, Machines, RunSettings};
use hydrocrane_sim::{build, Model, OutcomeKind};
use hydrocrane_web::Cockpit;
use serde_json::Value;
use std::sync::Arc;

pub fn opened(request: Value) -> (Cockpit, Value) {
    let mut cockpit = Cockpit::default();
    let description = cockpit.open(&request.to_string()).unwrap_or_else(|problem| panic!("{problem:?}"));
    (cockpit, description)
}

/// Where a signal stands in the frames.
pub fn index(description: &Value, name: &str) -> usize {
    let signals = description["signals"].as_array().expect("a list");
    signals.iter().position(|signal| signal["name"] == name).unwrap_or_else(|| panic!("no signal {name}"))
}

pub fn tip(cockpit: &mut Cockpit, description: &Value) -> [f64; 2] {
    ["tip.x", "tip.z"].map(|name| cockpit.frame()[index(description, name)])
}

pub fn built(machine: &str, overrides: &[(String, OverrideValue)]) -> Arc<dyn Model> {
    build(&load(machine, overrides).expect("the machine of the drive")).expect("a machine that can be built")
}

/// What `hydrocrane simulate` does with a scenario: (time, tip) at its end.
pub fn simulated(scenario: &Scenario) -> (f64, [f64; 2]) {
    let settings = RunSettings { ledger: false, max_steps: 1_000_000 };
    let mut machines = Machines { machine: &scenario.machine, text: None };
    let mut assembly = assemble(scenario, settings, &mut machines).unwrap_or_else(|error| panic!("{error}"));
    let end = scenario.duration;
    let done = assembly.run(&[end], &mut |_| true);
    assert_eq!(done.run.outcome.kind, OutcomeKind::Completed, "{}", done.run.outcome.message);
    let model = &assembly.stages[0].model;
    (end, model.tip_in_plane(&done.run.states[..model.layout().joints()]))
}
