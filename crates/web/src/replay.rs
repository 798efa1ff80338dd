//! A saved drive, or another scenario with a joystick, driven again.

use crate::problem::Problem;
use crate::request::Request;
use hydrocrane_machine::scenario::{Interpolation, Pressures, Scenario, SensorQuality};
use hydrocrane_machine::{parse_scenario, OverrideValue};
use hydrocrane_sim::{PayloadChange, Sticks};
use serde_json::Value;

/// What the operator did.
pub struct Replay {
    pub times: Vec<f64>,
    /// Row-major.
    pub deflections: Vec<f64>,
    pub linear: bool,
    pub loads: Vec<PayloadChange>,
    /// s
    pub duration: f64,
}

impl Replay {
    /// The sticks of the same kind as `centred`, moved.
    pub fn sticks(&self, centred: Sticks) -> Sticks {
        Sticks { times: self.times.clone(), deflections: self.deflections.clone(), linear: self.linear, ..centred }
    }
}

/// The request that a scenario stands for, and what is repeated. An error where the cockpit cannot do what it says.
pub fn of(text: &str) -> Result<(Request, Replay), Problem> {
    let scenario = parse_scenario(text, "drive.toml", &[]).map_err(|error| Problem::file(&error))?;
    if let Some(what) = beyond(&scenario) {
        return Err(Problem::plain(format!(
            "the cockpit does not drive scenarios with {what}; `hydrocrane simulate` runs them"
        )));
    }
    let (Some(stick), Some(choice)) = (&scenario.joystick, &scenario.controller) else {
        return Err(Problem::plain("the cockpit drives scenarios with a [joystick]; this one has none"));
    };
    let rows = 0..stick.time.len();
    let replay = Replay {
        times: stick.time.clone(),
        deflections: rows.flat_map(|row| stick.axes.iter().map(move |axis| axis[row])).collect(),
        linear: stick.interpolation == Interpolation::Linear,
        loads: scenario.payload_changes.iter().map(|&(time, mass)| PayloadChange { time, mass }).collect(),
        duration: scenario.duration,
    };
    let period = choice.period.map(|period| ("control.period".to_string(), OverrideValue::Number(period)));
    let overrides = scenario.overrides.iter().cloned().chain(period);
    let request = Request {
        machine: scenario.machine.clone(),
        text: None,
        overrides: overrides.map(|(key, value)| (key, json_of(&value))).collect(),
        friction: 1.0,
        joints: scenario.initial.joints.iter().map(|(joint, q)| (joint.clone(), Value::from(*q))).collect(),
        payload: scenario.payload,
        controller: choice.name.clone(),
        full_speed: stick.full_speed,
        real_sensors: choice.sensors == SensorQuality::DataSheet,
        seed: scenario.seed,
        delay: choice.delay,
        dead_zone: stick.dead_zone,
        ramp: stick.ramp,
        scenario: Some(text.to_string()),
        keep_state: false,
    };
    Ok((request, replay))
}

/// What a scenario has that a drive has not.
fn beyond(scenario: &Scenario) -> Option<&'static str> {
    let choice = scenario.controller.as_ref();
    if !scenario.commands.is_empty() {
        Some("spool commands")
    } else if !scenario.sensor_faults.is_empty() {
        Some("sensor faults")
    } else if scenario.initial.pressures != Pressures::Equilibrium {
        Some("explicit pressures")
    } else if choice.is_some_and(|c| !c.believed.is_empty()) {
        Some("a believed machine")
    } else if choice.is_some_and(|c| c.monitor.is_some_and(|on| on == (c.name == "lever"))) {
        Some("an unusual monitor of the sensors")
    } else if scenario.joystick.as_ref().is_some_and(|stick| stick.log.is_some()) {
        Some("a joystick in a log")
    } else {
        None
    }
}

/// The version of the cockpit that a drive was recorded with, where its first line says so.
pub fn recorded_by(text: &str) -> Option<&str> {
    let rest = text.lines().next()?.split("in the cockpit of hydrocrane ").nth(1)?;
    rest.split(',').next()
}

fn json_of(value: &OverrideValue) -> Value {
    match value {
        OverrideValue::Number(number) => Value::from(*number),
        OverrideValue::Text(text) => Value::from(text.as_str()),
        OverrideValue::Bool(flag) => Value::from(*flag),
        OverrideValue::List(items) => items.iter().map(json_of).collect(),
    }
}
