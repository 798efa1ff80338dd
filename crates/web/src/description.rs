//! Description of signals and controls, sent once per drive.

use crate::drive::{Drive, TICK};
use crate::frame::{corners, signals};
use crate::knobs::ground;
use crate::offered;
use hydrocrane_machine::bundled_machines;
use hydrocrane_machine::scenario::StickMode;
use hydrocrane_sim::model::controllers::{tip_gains, CONTROLLERS};
use hydrocrane_sim::total_terms;
use serde_json::{json, Value};

pub fn of(drive: &Drive) -> Value {
    let (model, request) = (drive.model(), &drive.request);
    let machine = model.machine();
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "machine": { "name": machine.name, "title": machine.title, "source": request.machine },
        "machines": machines(),
        "controllers": offered::modes(machine),
        "controller": request.controller,
        "axes": match request.stick_mode() {
            StickMode::Tip => vec!["x".to_string(), "z".to_string()],
            _ => cylinder_names(drive),
        },
        "tick": TICK,
        "payload": drive.playback.live.payload(),
        "supply": machine.supply.pressure,
        "full-speed": machine.control.gain(request.law(), "full-speed"),
        "gains": gains(drive),
        "sensors": !machine.sensors.is_empty(),
        "continued": drive.continued(),
        "replay-until": drive.replayed.then_some(drive.scenario.duration),
        "recorded-by": drive.scenario.recorded.by,
        "request": request,
        "joints": joints(drive),
        "cylinders": cylinders(drive),
        "states": model.layout().names,
        "signals": signals(drive),
        "ledger": total_terms(model.machine()).map(|(name, _, sign)| json!([name, sign])).collect::<Vec<_>>(),
        "shapes": shapes(drive),
        "keep-out": machine.keep_out.iter().map(|(name, corners)| json!({ "name": name, "corners": corners })).collect::<Vec<_>>(),
        "ground": ground::description(machine),
        "hang": ground::hang(machine),
        "tool": machine.payload.tool,
        "workspace": model.workspace(),
    })
}

fn machines() -> Vec<Value> {
    let titled = |(name, text): &(&str, &str)| {
        let title = hydrocrane_machine::parse(text, name, &[]).map(|machine| machine.title).unwrap_or_default();
        json!({ "name": name, "title": title })
    };
    bundled_machines().iter().map(titled).collect()
}

fn cylinder_names(drive: &Drive) -> Vec<String> {
    drive.model().machine().cylinders.iter().map(|cylinder| cylinder.name.clone()).collect()
}

fn joints(drive: &Drive) -> Vec<Value> {
    let layout = drive.model().layout();
    let limits = drive.model().joint_limits().iter().enumerate();
    limits
        .map(|(i, limit)| {
            json!({
                "name": drive.model().machine().joints[i].name,
                "unit": layout.units[i],
                "limits": [limit.lower, limit.upper],
                "reasons": limit.reasons.map(|reason| reason.name()),
                "start": drive.pose[i],
            })
        })
        .collect()
}

fn cylinders(drive: &Drive) -> Vec<Value> {
    let limits = drive.model().stroke_limits();
    let all = drive.model().machine().cylinders.iter().zip(limits);
    all.map(|(c, limits)| {
        json!({
            "name": c.name, "bore": c.bore, "rod": c.rod_diameter, "stroke": c.stroke, "limits": limits,
            "stop": c.end_stop.zone, "spool": c.valve.stroke,
        })
    })
    .collect()
}

fn gains(drive: &Drive) -> Vec<Value> {
    if drive.request.law() != CONTROLLERS[0] {
        return Vec::new();
    }
    let entry = |(key, unit, value)| {
        let key_of_file = format!("control.{}.{key}", CONTROLLERS[0]);
        json!({ "name": key, "key": key_of_file, "unit": unit, "value": value })
    };
    tip_gains(drive.model().machine()).map(entry).collect()
}

fn shapes(drive: &Drive) -> Vec<Value> {
    let shapes = drive.model().drawing(&drive.pose);
    shapes
        .iter()
        .map(|s| json!({ "kind": s.kind.name(), "name": s.name, "points": corners(&s.line).count() }))
        .collect()
}
