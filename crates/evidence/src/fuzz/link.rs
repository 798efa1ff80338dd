//! Damages what a link asks the page for: a tree of JSON, with files of TOML in it.

use super::{mutate, one_of, pick};
use hydrocrane_num::RandomStream;
use serde_json::{json, Value};

/// Bytes damaged in the finished text, as a share of all links.
const TORN: f64 = 0.05;

/// A request with one to three damages.
pub fn request(random: &mut RandomStream, machines: &[String], scenarios: &[String]) -> String {
    let mut request = one_of(random, &requests(machines, scenarios)).clone();
    for _ in 0..=pick(random, 3) {
        damage(random, &mut request, machines, scenarios);
    }
    let text = request.to_string();
    if random.uniform() < TORN {
        let at = pick(random, text.len());
        let rest = text.get(at + 1..).unwrap_or_default();
        return format!("{}{}{rest}", text.get(..at).unwrap_or_default(), one_of(random, &["{", "\"", "\\", "9", ","]));
    }
    text
}

fn requests(machines: &[String], scenarios: &[String]) -> Vec<Value> {
    vec![
        json!({ "machine": "rottne-f9-lab", "full-speed": 0.3, "dead-zone": 0.02, "ramp": 0.15, "friction": 1.5 }),
        json!({ "machine": "hiab-xs031", "controller": "lever", "payload": 80, "joints": { "lift": 0.9 }, "keep-state": true }),
        json!({ "machine": "rig-kalmar", "controller": "lever", "overrides": { "supply.pressure": 3e6 }, "seed": 3 }),
        json!({
            "machine": "rottne-f9-lab", "real-sensors": true, "delay": 0.002, "friction": 0.0,
            "overrides": { "control.period": 0.01, "control.tip.reserve": 0.5, "cylinder.lift.bore": 0.1 },
        }),
        json!({ "machine": "own.toml", "text": machines[0], "controller": "lever", "payload": 0 }),
        json!({ "machine": "own.toml", "text": machines[machines.len() / 2], "controller": "heinze-pid" }),
        json!({ "scenario": drive() }),
        json!({ "scenario": scenarios[scenarios.len() / 2] }),
    ]
}

/// A drive as the page saves it.
fn drive() -> &'static str {
    r#"
[scenario]
name = "drive"
title = "A drive"
machine = "rottne-f9-lab"
duration = "3 s"
record-interval = "10 ms"
payload = "20 kg"
seed = 0

[initial]
pressures = "equilibrium"

[initial.joint]
"boom" = "1.7 rad"
"jib" = "1.7 rad"
"extension" = "0.0 m"

[payload]
time = ["0.5 s"]
mass = ["60 kg"]

[controller]
name = "tip"
delay = "0.0 s"
sensors = "ideal"

[joystick]
mode = "tip"
interpolation = "linear"
dead-zone = 0.02
ramp = "0.15 s"
time = ["0.0 s", "0.5 s", "2.0 s"]
"x" = [0.0, 1.0, -1.0]
"z" = [0.0, -0.5, 0.5]

[phase.1]
time = "1.0 s"

[phase.1.controller]
name = "lever"

[phase.1.joystick]
mode = "lever"
time = ["1.0 s"]
lift = [0.5]
jib = [0.0]
extension = [0.0]
"#
}

fn extreme(random: &mut RandomStream) -> Value {
    let numbers = [0.0, -1.0, 1e-300, 1e300, -1e300, 5e-324, 1e9, 1e-9, 1e6, 0.5, 1.0, 1e3];
    match pick(random, 10) {
        0..=5 => json!(numbers[pick(random, numbers.len())]),
        6 => json!(u64::MAX),
        7 => one_of(random, &[json!(null), json!(true), json!([]), json!({}), json!(""), json!("nan")]).clone(),
        8 => one_of(random, &[json!("1e-9 s"), json!("1e300 m"), json!("-1 kg"), json!("tip"), json!("lever")]).clone(),
        _ => match pick(random, 3) {
            0 => Value::Array(vec![json!(1.0); 100_000]),
            1 => json!("long ".repeat(60_000)),
            _ => (0..100).fold(json!(1), |inner, _| json!([inner])),
        },
    }
}

/// Keys that a request can have, and machine keys to change.
const KEYS: [&str; 15] = [
    "machine",
    "text",
    "files",
    "scenario-name",
    "overrides",
    "friction",
    "joints",
    "payload",
    "controller",
    "full-speed",
    "real-sensors",
    "seed",
    "delay",
    "dead-zone",
    "ramp",
];
const CHANGES: [&str; 14] = [
    "control.period",
    "supply.pressure",
    "supply.tank-pressure",
    "payload.mass",
    "cylinder.lift.bore",
    "cylinder.lift.stroke",
    "valve.lift.nominal-flow",
    "valve.lift.natural-frequency",
    "friction.lift.coulomb",
    "friction.lift.model",
    "fluid.bulk-modulus-max",
    "control.tip.position-gain",
    "keep-out.ground.outline",
    "environment.gravity",
];

fn damage(random: &mut RandomStream, request: &mut Value, machines: &[String], scenarios: &[String]) {
    for (key, files) in [("text", machines), ("scenario", scenarios)] {
        if let Some(text) = request[key].as_str().map(str::to_string) {
            if random.uniform() < 0.7 {
                request[key] = json!(mutate::damaged(random, &text, files));
                return;
            }
        }
    }
    let Some(object) = request.as_object_mut() else { return };
    let present: Vec<String> = object.keys().cloned().collect();
    match pick(random, 8) {
        0..=2 => drop(object.insert((*one_of(random, &KEYS)).into(), extreme(random))),
        3 | 4 => {
            let overrides = object.entry("overrides").or_insert_with(|| json!({}));
            if let Some(overrides) = overrides.as_object_mut() {
                overrides.insert((*one_of(random, &CHANGES)).into(), extreme(random));
            }
        }
        5 if !present.is_empty() => drop(object.insert(one_of(random, &present).clone(), extreme(random))),
        6 if !present.is_empty() => drop(object.shift_remove(one_of(random, &present))),
        _ => {
            let joint = *one_of(random, &["boom", "lift", "jib", "slide", "extension", "none"]);
            object.insert("joints".into(), json!({ joint: extreme(random) }));
        }
    }
}
