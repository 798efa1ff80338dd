//! A drive as a scenario file.

use crate::cockpit::{Drive, TICK};
use crate::problem::Problem;
use hydrocrane_machine::OverrideValue;
use std::fmt::Write;

/// Numbers are written with all their digits, so that the file repeats the drive exactly.
pub fn scenario(drive: &Drive) -> Result<String, Problem> {
    if let Some(from) = drive.continued {
        return Err(Problem::plain(format!(
            "this drive went on from another one at {from:.3} s, which no scenario can begin with; reset, then drive"
        )));
    }
    if drive.live.sticks().linear {
        return Err(Problem::plain(
            "this drive began as a replay of sticks that move in straight lines; reset, then drive",
        ));
    }
    let end = drive.live.sampled_until();
    if end <= 0.0 {
        return Err(Problem::plain("nothing has been driven yet"));
    }
    let mut text = head(drive, end);
    overrides(drive, &mut text);
    start(drive, &mut text);
    loads(drive, end, &mut text);
    controls(drive, &mut text);
    let _ = write!(text, "\n[solver]\nmethod = \"ros3l\"\nstep = \"{TICK:?} s\"\n");
    Ok(text)
}

fn head(drive: &Drive, end: f64) -> String {
    let request = &drive.request;
    // A file of one's own is expected beside the scenario.
    let machine = if request.text.is_some() { format!("./{}", request.machine) } else { request.machine.clone() };
    format!(
        "# A drive in the cockpit of hydrocrane {}, which `hydrocrane simulate` repeats.\n\n[scenario]\nname = \"drive\"\n\
         title = {}\nmachine = {}\nduration = \"{end:?} s\"\nrecord-interval = \"10 ms\"\npayload = \"{:?} kg\"\nseed = {}\n",
        env!("CARGO_PKG_VERSION"),
        quoted(&format!("{} driven by hand", drive.model.machine().name)),
        quoted(&machine),
        drive.live.loads().0,
        request.seed,
    )
}

fn overrides(drive: &Drive, text: &mut String) {
    if drive.overrides.is_empty() {
        return;
    }
    text.push_str("\n[overrides]\n");
    for (key, value) in &drive.overrides {
        let recorded = drive.model.machine().provenance.iter().find(|entry| entry.key == *key);
        let units = recorded.map_or(&[][..], |entry| &entry.value.units);
        let _ = writeln!(text, "{} = {}", quoted(key), written(value, units));
    }
}

fn start(drive: &Drive, text: &mut String) {
    text.push_str("\n[initial]\npressures = \"equilibrium\"\n\n[initial.joint]\n");
    let units = &drive.model.layout().units;
    for ((joint, q), unit) in drive.model.machine().joints.iter().zip(&drive.pose).zip(units) {
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

fn controls(drive: &Drive, text: &mut String) {
    let (request, sticks) = (&drive.request, drive.live.sticks());
    let sensors = if request.real_sensors { "data-sheet" } else { "ideal" };
    let _ = write!(
        text,
        "\n[controller]\nname = {}\ndelay = \"{:?} s\"\nsensors = \"{sensors}\"\n\n[joystick]\nmode = \"{}\"\n\
         dead-zone = {:?}\nramp = \"{:?} s\"\ntime = {}\n",
        quoted(&request.controller),
        request.delay,
        if request.lever() { "lever" } else { "tip" },
        sticks.dead_zone,
        sticks.ramp,
        list(sticks.times.iter().map(|t| format!("\"{t:?} s\""))),
    );
    let cylinders = drive.model.machine().cylinders.iter().map(|c| c.name.clone());
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
