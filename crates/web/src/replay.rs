//! Replay of a saved drive or of any other scenario.

use crate::friction_level;
use crate::problem::{problem, Problem};
use crate::request::{Request, HEIGHT};
use crate::scenario::{solver, SETTINGS};
use hydrocrane_machine::scenario::{without_hoses, Burst, Scenario, SensorQuality, Stage, StickMode, LOGS};
use hydrocrane_machine::{bundled_machines, parse_scenario_with, whole_text_of, OverrideValue};
use hydrocrane_sim::assembly::{assemble, Assembly, Machines};
use hydrocrane_sim::model::controllers::LEVER;
use hydrocrane_sim::CHAINS;
use serde_json::{json, Value};
use std::collections::VecDeque;

/// A scenario with the equivalent request of each of its stages.
pub struct Replay {
    pub scenario: Scenario,
    pub assembly: Assembly,
    pub requests: VecDeque<Request>,
}

/// What a scenario repeats. `asked` brings the files that it names: its machine, where it is one of somebody's own, and its
/// logs.
pub fn of(text: &str, asked: &Request) -> Result<Replay, Problem> {
    if !LOGS && asked.files.keys().any(|name| !name.ends_with(".toml")) {
        return Err(Problem::named("chain", "this core reads no logs"));
    }
    let files: Vec<(String, String)> = asked.files.iter().map(|(name, text)| (name.clone(), text.clone())).collect();
    let parsed = parse_scenario_with(text, asked.scenario_name.as_deref().unwrap_or("drive.toml"), &files);
    let mut scenario = parsed.map_err(|error| Problem::file(&error))?;
    if let Some(log) = unread(&scenario) {
        return Err(Problem::plain(format!("the cockpit reads logs that are text; save {log} as CSV")));
    }
    scenario.solver = solver();
    let name = scenario.machine.trim_start_matches("./").to_string();
    let bundled = bundled_machines().iter().any(|(known, _)| *known == name);
    let text = if bundled { None } else { Some(whole_text_of(&name, &files).map_err(|error| Problem::file(&error))?) };
    let text = text.as_deref();
    let mut machines = Machines { machine: &name, text };
    let assembly = assemble(&scenario, SETTINGS, &mut machines).map_err(problem)?;
    let request = |stage: &Stage| friction_level::settled(request(&scenario, stage, &name, text));
    let requests = assembly.stages.iter().map(|assembled| request(&assembled.stage)).collect();
    Ok(Replay { assembly, requests, scenario })
}

/// A missing log.
fn unread(scenario: &Scenario) -> Option<&str> {
    let later = scenario.phases.iter().filter_map(|phase| phase.joystick.as_ref());
    scenario.joystick.iter().chain(later).find_map(|stick| stick.log.as_deref())
}

/// The overrides of a stage but those of its hoses, which the scenario states.
pub fn own_overrides(scenario: &Scenario, stage: &Stage) -> Vec<(String, OverrideValue)> {
    let all = stage.machine_overrides();
    if CHAINS {
        without_hoses(&scenario.faults.bursts, all)
    } else {
        all
    }
}

/// The request that is equivalent to a stage.
fn request(scenario: &Scenario, stage: &Stage, machine: &str, text: Option<&str>) -> Request {
    let (choice, stick) = (stage.controller.as_ref(), stage.joystick.as_ref());
    let joints = &scenario.initial.joints;
    Request {
        machine: machine.to_string(),
        text: text.map(str::to_string),
        overrides: own_overrides(scenario, stage).iter().map(|(key, value)| (key.clone(), json_of(value))).collect(),
        joints: joints.iter().map(|(joint, q)| (joint.clone(), Value::from(*q))).collect(),
        payload: scenario.load.payload,
        bursts: if CHAINS {
            json!(scenario.faults.bursts.iter().map(Burst::entry).collect::<Vec<_>>())
        } else {
            Value::Null
        },
        // Levers are available while spool commands are repeated.
        controller: match (choice, stage.stick_mode()) {
            (_, StickMode::Height) => HEIGHT.to_string(),
            (None, _) => LEVER.to_string(),
            (Some(choice), _) => choice.name.clone(),
        },
        full_speed: stick.and_then(|stick| stick.full_speed),
        real_sensors: choice.is_some_and(|choice| choice.sensors == SensorQuality::DataSheet),
        seed: scenario.seed,
        delay: choice.map_or(0.0, |choice| choice.delay),
        dead_zone: stick.map_or(0.0, |stick| stick.dead_zone),
        ramp: stick.map_or(0.0, |stick| stick.ramp),
        ..Request::plain()
    }
}

fn json_of(value: &OverrideValue) -> Value {
    match value {
        OverrideValue::Number(number) => Value::from(*number),
        OverrideValue::Text(text) => Value::from(text.as_str()),
        OverrideValue::Bool(flag) => Value::from(*flag),
        OverrideValue::List(items) => items.iter().map(json_of).collect(),
    }
}
