//! A drive as a scenario file.

use crate::drive::{Drive, Setting, TICK};
use crate::problem::Problem;
use hydrocrane_machine::OverrideValue;
use hydrocrane_sim::Sticks;
use std::fmt::Write;

/// Numbers are written with all their digits, so that the file repeats the drive exactly.
pub fn scenario(drive: &Drive) -> Result<String, Problem> {
    let end = drive.live.sampled_until();
    if end <= 0.0 {
        return Err(Problem::plain("nothing has been driven yet"));
    }
    let earlier = drive.earlier.iter().map(|(setting, sticks)| (setting, sticks));
    let parts: Vec<(&Setting, &Sticks)> =
        earlier.chain([(&drive.now, drive.live.sticks())]).filter(|(setting, _)| setting.from < end).collect();
    let mut text = String::new();
    let mut before: Option<&Setting> = None;
    for (phase, (setting, sticks)) in parts.into_iter().enumerate() {
        let table = match before {
            None => {
                head(drive, setting, end, &mut text);
                String::new()
            }
            Some(_) => {
                let _ = write!(text, "\n[phase.{phase}]\ntime = \"{:?} s\"\n", setting.from);
                format!("phase.{phase}.")
            }
        };
        overrides(setting, before.map_or(&[], |setting| &setting.overrides), &table, &mut text);
        if before.is_none() {
            start(drive, &mut text);
            loads(drive, end, &mut text);
        }
        controls(setting, sticks, &table, &mut text);
        before = Some(setting);
    }
    let _ = write!(text, "\n[solver]\nmethod = \"ros3l\"\nstep = \"{TICK:?} s\"\n");
    Ok(text)
}

fn head(drive: &Drive, first: &Setting, end: f64, text: &mut String) {
    let request = &first.request;
    // A file of one's own is expected beside the scenario.
    let machine = if request.text.is_some() { format!("./{}", request.machine) } else { request.machine.clone() };
    let _ = write!(
        text,
        "# A drive in the cockpit, which `hydrocrane simulate` repeats.\n\n[scenario]\nname = \"drive\"\n\
         title = {}\nmachine = {}\nduration = \"{end:?} s\"\nrecord-interval = \"10 ms\"\npayload = \"{:?} kg\"\nseed = {}\n\
         recorded-by = \"{}\"\n",
        quoted(&format!("{} driven by hand", first.model.machine().name)),
        quoted(&machine),
        drive.live.loads().0,
        request.seed,
        env!("CARGO_PKG_VERSION"),
    );
}

/// What is changed that was not so `before`.
fn overrides(setting: &Setting, before: &[(String, OverrideValue)], table: &str, text: &mut String) {
    let changed: Vec<_> = setting.overrides.iter().filter(|change| !before.contains(change)).collect();
    if changed.is_empty() {
        return;
    }
    let _ = write!(text, "\n[{table}overrides]\n");
    for (key, value) in changed {
        let recorded = setting.model.machine().provenance.iter().find(|entry| entry.key == *key);
        let units = recorded.map_or(&[][..], |entry| &entry.value.units);
        let _ = writeln!(text, "{} = {}", quoted(key), written(value, units));
    }
}

fn start(drive: &Drive, text: &mut String) {
    text.push_str("\n[initial]\npressures = \"equilibrium\"\n\n[initial.joint]\n");
    let model = &drive.now.model;
    for ((joint, q), unit) in model.machine().joints.iter().zip(&drive.pose).zip(&model.layout().units) {
        let _ = writeln!(text, "{} = \"{q:?} {unit}\"", quoted(&joint.name));
    }
}

fn loads(drive: &Drive, end: f64, text: &mut String) {
    let (_, loads) = drive.live.loads();
    let kept: Vec<_> = loads.iter().filter(|load| load.time < end).collect();
    if kept.is_empty() {
        return;
    }
    let times = list(kept.iter().map(|load| format!("\"{:?} s\"", load.time)));
    let masses = list(kept.iter().map(|load| format!("\"{:?} kg\"", load.mass[1])));
    let _ = write!(text, "\n[payload]\ntime = {times}\nmass = {masses}\n");
}

fn controls(setting: &Setting, sticks: &Sticks, table: &str, text: &mut String) {
    let request = &setting.request;
    let sensors = if request.real_sensors { "data-sheet" } else { "ideal" };
    let _ = write!(
        text,
        "\n[{table}controller]\nname = {}\ndelay = \"{:?} s\"\nsensors = \"{sensors}\"\n\n[{table}joystick]\n\
         mode = \"{}\"\n{}dead-zone = {:?}\nramp = \"{:?} s\"\ntime = {}\n",
        quoted(&request.controller),
        request.delay,
        if request.lever() { "lever" } else { "tip" },
        if sticks.linear { "interpolation = \"linear\"\n" } else { "" },
        sticks.dead_zone,
        sticks.ramp,
        list(sticks.times.iter().map(|t| format!("\"{t:?} s\""))),
    );
    let cylinders = setting.model.machine().cylinders.iter().map(|c| c.name.clone());
    let axes: Vec<String> = if request.lever() { cylinders.collect() } else { vec!["x".to_string(), "z".to_string()] };
    for (i, axis) in axes.iter().enumerate() {
        let column = sticks.deflections.iter().skip(i).step_by(sticks.axes);
        let _ = writeln!(text, "{} = {}", quoted(axis), list(column.map(|d| format!("{d:?}"))));
    }
}

fn list(items: impl Iterator<Item = String>) -> String {
    format!("[{}]", items.collect::<Vec<_>>().join(", "))
}

/// `units` are those of the numbers, or one for all; plain numbers have none.
fn written(value: &OverrideValue, units: &[String]) -> String {
    match (value, units.first()) {
        (OverrideValue::Number(number), Some(unit)) if !unit.is_empty() => format!("\"{number:?} {unit}\""),
        (OverrideValue::Number(number), _) => format!("{number:?}"),
        (OverrideValue::Text(text), _) => quoted(text),
        (OverrideValue::Bool(flag), _) => flag.to_string(),
        (OverrideValue::List(items), _) => {
            let unit_of = |i: usize| units.get(i..).filter(|rest| !rest.is_empty()).unwrap_or(units);
            list(items.iter().enumerate().map(|(i, item)| written(item, unit_of(i))))
        }
    }
}

/// JSON's strings are strings of TOML too.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}
