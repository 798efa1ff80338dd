//! A saved drive, or another scenario with a joystick, driven again.

use crate::problem::Problem;
use crate::request::Request;
use hydrocrane_machine::scenario::{ControllerChoice, Interpolation, Joystick, Pressures, Scenario, SensorQuality};
use hydrocrane_machine::{parse_scenario, parse_scenario_with, OverrideValue};
use hydrocrane_sim::{PayloadChange, Sticks};
use serde_json::Value;
use std::collections::VecDeque;

/// What the operator did.
pub struct Replay {
    pub phases: VecDeque<Phase>,
    pub loads: Vec<PayloadChange>,
    /// s
    pub duration: f64,
    pub recorded_by: Option<String>,
}

/// From a time (s) on: what was asked for, and how the sticks moved.
#[derive(Clone)]
pub struct Phase {
    pub from: f64,
    pub request: Request,
    times: Vec<f64>,
    /// Row-major.
    deflections: Vec<f64>,
    linear: bool,
}

impl Phase {
    /// The sticks of the same kind as `centred`, moved.
    pub fn sticks(&self, centred: Sticks) -> Sticks {
        Sticks { times: self.times.clone(), deflections: self.deflections.clone(), linear: self.linear, ..centred }
    }
}

/// What a scenario repeats; an error where the cockpit cannot do what it says. `machine` is the text of the machine file
/// that it names, where it is one of somebody's own.
pub fn of(text: &str, machine: Option<&str>) -> Result<Replay, Problem> {
    let origin = "drive.toml";
    let parsed =
        machine.map_or_else(|| parse_scenario(text, origin, &[]), |own| parse_scenario_with(text, origin, own));
    let scenario = parsed.map_err(|error| Problem::file(&error))?;
    if let Some(what) = beyond(&scenario) {
        return Err(Problem::plain(format!(
            "the cockpit does not drive scenarios with {what}; `hydrocrane simulate` runs them"
        )));
    }
    let (Some(stick), Some(choice)) = (&scenario.joystick, &scenario.controller) else {
        return Err(Problem::plain("the cockpit drives scenarios with a [joystick]; this one has none"));
    };
    let mut overrides = scenario.overrides.clone();
    let mut phases = VecDeque::from([phase_from(&scenario, machine, &overrides, 0.0, choice, Some(stick))]);
    for phase in &scenario.phases {
        overrides.extend(phase.overrides.iter().cloned());
        phases.push_back(phase_from(
            &scenario,
            machine,
            &overrides,
            phase.time,
            &phase.controller,
            phase.joystick.as_ref(),
        ));
    }
    Ok(Replay {
        phases,
        loads: scenario.payload_changes.iter().map(|&(time, mass)| PayloadChange { time, mass }).collect(),
        duration: scenario.duration,
        recorded_by: scenario.recorded_by,
    })
}

fn phase_from(
    scenario: &Scenario,
    machine: Option<&str>,
    overrides: &[(String, OverrideValue)],
    from: f64,
    choice: &ControllerChoice,
    stick: Option<&Joystick>,
) -> Phase {
    let period = choice.period.map(|period| ("control.period".to_string(), OverrideValue::Number(period)));
    let overrides = overrides.iter().cloned().chain(period);
    let request = Request {
        machine: scenario.machine.trim_start_matches("./").to_string(),
        text: machine.filter(|_| scenario.machine.ends_with(".toml")).map(str::to_string),
        overrides: overrides.map(|(key, value)| (key, json_of(&value))).collect(),
        friction: 1.0,
        joints: scenario.initial.joints.iter().map(|(joint, q)| (joint.clone(), Value::from(*q))).collect(),
        payload: scenario.payload,
        controller: choice.name.clone(),
        full_speed: stick.and_then(|stick| stick.full_speed),
        real_sensors: choice.sensors == SensorQuality::DataSheet,
        seed: scenario.seed,
        delay: choice.delay,
        dead_zone: stick.map_or(0.0, |stick| stick.dead_zone),
        ramp: stick.map_or(0.0, |stick| stick.ramp),
        scenario: None,
        ground: false,
        keep_state: false,
    };
    let rows = 0..stick.map_or(0, |stick| stick.time.len());
    Phase {
        from,
        request,
        times: stick.map(|stick| stick.time.clone()).unwrap_or_default(),
        deflections: rows
            .flat_map(|row| stick.into_iter().flat_map(move |s| s.axes.iter().map(move |a| a[row])))
            .collect(),
        linear: stick.is_some_and(|stick| stick.interpolation == Interpolation::Linear),
    }
}

/// What a scenario has that a drive has not.
fn beyond(scenario: &Scenario) -> Option<&'static str> {
    let later = scenario.phases.iter().map(|phase| &phase.controller);
    let choices: Vec<&ControllerChoice> = scenario.controller.iter().chain(later).collect();
    let sticks = || scenario.joystick.iter().chain(scenario.phases.iter().filter_map(|phase| phase.joystick.as_ref()));
    if !scenario.commands.is_empty() {
        Some("spool commands")
    } else if !scenario.sensor_faults.is_empty() {
        Some("sensor faults")
    } else if scenario.initial.pressures != Pressures::Equilibrium {
        Some("explicit pressures")
    } else if choices.iter().any(|c| !c.believed.is_empty()) {
        Some("a controller model of its own")
    } else if choices.iter().any(|c| c.monitor.is_some_and(|on| on == (c.name == "lever"))) {
        Some("an unusual monitor of the sensors")
    } else if sticks().any(|stick| stick.log.is_some()) {
        Some("a joystick in a log")
    } else {
        None
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
