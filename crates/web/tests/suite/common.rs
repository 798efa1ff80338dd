//! What tests of drives share: opening one, reading its frames, and the native run of a saved drive.

use hydrocrane_machine::scenario::{ControllerChoice, Interpolation, Joystick, Scenario, SensorQuality, StickMode};
use hydrocrane_machine::{load, OverrideValue};
use hydrocrane_ode::Tolerances;
use hydrocrane_sim::controller::Controller;
use hydrocrane_sim::{
    build, simulate_phases, Driver, EquilibriumMode, Model, OutcomeKind, PayloadChange, Phase, RunOptions, SampledPlan,
    SensorMode, Sensors, StickKind, Sticks,
};
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

fn named(model: &dyn Model, choice: &ControllerChoice) -> Box<dyn Controller> {
    let controller = model.controller(&choice.name).expect("a known controller");
    if choice.name == "lever" {
        return controller;
    }
    model.with_sensor_monitor(controller, choice.delay)
}

fn plan(model: &dyn Model, choice: &ControllerChoice, stick: &Joystick, seed: u64) -> SampledPlan {
    let kind = if stick.mode == StickMode::Tip { StickKind::Tip } else { StickKind::Lever };
    let deflections = (0..stick.time.len()).flat_map(|row| stick.axes.iter().map(move |axis| axis[row])).collect();
    let sensors = if choice.sensors == SensorQuality::Ideal { SensorMode::Ideal } else { SensorMode::DataSheet };
    SampledPlan {
        sticks: Sticks {
            times: stick.time.clone(),
            deflections,
            linear: stick.interpolation == Interpolation::Linear,
            dead_zone: stick.dead_zone,
            ramp: stick.ramp,
            ..Sticks::centred(kind, model.machine().cylinders.len())
        },
        sensors: Sensors::new(model, sensors, seed, &[]).expect("sensors"),
        delay: choice.delay,
    }
}

/// What `hydrocrane simulate` does with a scenario that has a joystick: (time, tip) at its end.
pub fn simulated(scenario: &Scenario) -> (f64, [f64; 2]) {
    let mut overrides = scenario.overrides.clone();
    let (choice, stick) = (scenario.controller.as_ref().expect("one"), scenario.joystick.as_ref().expect("one"));
    let mut parts = vec![(0.0, built(&scenario.machine, &overrides), choice, stick)];
    for phase in &scenario.phases {
        overrides.extend(phase.overrides.iter().cloned());
        let stick = phase.joystick.as_ref().expect("one");
        parts.push((phase.time, built(&scenario.machine, &overrides), &phase.controller, stick));
    }
    let mut controllers: Vec<_> = parts.iter().map(|(_, model, choice, _)| named(model.as_ref(), choice)).collect();
    let plan_of = |(_, model, choice, stick): &_| plan(Arc::as_ref(model), choice, stick, scenario.seed);
    let plans: Vec<_> = parts.iter().map(plan_of).collect();
    let phases = parts.iter().zip(&mut controllers).zip(&plans).map(|(((from, model, ..), controller), plan)| Phase {
        from: *from,
        model: model.as_ref(),
        driver: Driver::Controller(controller.as_mut(), plan),
    });
    let mut phases: Vec<Phase> = phases.collect();
    let first = phases.remove(0);
    let at = |name: &str| scenario.initial.joints.iter().find(|(joint, _)| joint == name).map_or(0.0, |(_, q)| *q);
    let q: Vec<f64> = first.model.machine().joints.iter().map(|joint| at(&joint.name)).collect();
    let payload = scenario.payload.expect("written in the file");
    let x0 = first.model.equilibrium(&q, EquilibriumMode::Hold, payload).expect("a pose to rest in");
    let step = scenario.solver.step.expect("fixed steps");
    let options = RunOptions {
        method: scenario.solver.method.clone(),
        tolerances: Tolerances { relative: 1e-4, absolute: 1e-4, max_step: step },
        payload,
        payload_changes: scenario.payload_changes.iter().map(|&(time, mass)| PayloadChange { time, mass }).collect(),
        ledger: false,
        max_steps: 1_000_000,
    };
    let end = scenario.duration;
    let model = first.model;
    let done = simulate_phases(&x0, end, first, phases, &[end], &options, &mut |_| true);
    assert_eq!(done.run.outcome.kind, OutcomeKind::Completed, "{}", done.run.outcome.message);
    (end, model.tip(&done.run.states[..q.len()]))
}
