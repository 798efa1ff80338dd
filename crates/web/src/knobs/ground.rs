//! The ground that a drive has: the machine's own, or the region named `ground` that controllers keep the tip out of.

use crate::knobs::values::stated;
use hydrocrane_machine::{Machine, OverrideValue};
use serde_json::{json, Value};

/// The region whose upper edge is the ground.
const REGION: &str = "ground";
/// From the tip to the underside of a load without mass, m, and its growth with the root of the mass, m/kg^(1/2), where a
/// machine states neither: a grapple that holds round logs of one length by their ends.
const HANG: f64 = 0.32;
const GROWTH: f64 = 0.044;

/// Whether a key is one of the ground.
pub fn is_its(key: &str) -> bool {
    key.starts_with("ground.")
}

/// Overrides that make the drawn ground solid: none if the machine states a ground, has no such region, or moves in space.
pub fn drawn(machine: &Machine) -> Vec<(String, OverrideValue)> {
    if machine.is_spatial() {
        return Vec::new();
    }
    let region = machine.keep_out.iter().find(|(name, _)| name == REGION);
    let surface = region.map(|(_, corners)| corners.iter().fold(f64::NEG_INFINITY, |top, [_, z]| top.max(*z)));
    let mut changes = Vec::new();
    if let (None, Some(height)) = (&machine.ground, surface) {
        changes.push(("ground.height".to_string(), OverrideValue::Number(height)));
    }
    if machine.ground.is_some() || surface.is_some() {
        let [hang, growth] = hang(machine);
        for (key, value) in [("payload.hang", hang), ("payload.hang-growth", growth)] {
            if stated(machine, key).is_none() {
                changes.push((key.to_string(), OverrideValue::Number(value)));
            }
        }
    }
    changes
}

/// Distance of the underside of a load below the tip: m, and m/kg^(1/2).
pub fn hang(machine: &Machine) -> [f64; 2] {
    let load = &machine.payload;
    let known = ["payload.hang", "payload.hang-growth"].iter().any(|key| stated(machine, key).is_some());
    if known {
        [load.hang, load.hang_growth]
    } else {
        [HANG, GROWTH]
    }
}

/// The ground for the drawing; empty without ground.
pub fn description(machine: &Machine) -> Value {
    let Some(ground) = &machine.ground else { return Value::Null };
    let supports = ground.supports.iter();
    let supports =
        supports.map(|s| json!({ "name": s.name, "height": s.height, "from": s.from, "to": s.to, "edge": s.edge }));
    json!({ "height": ground.height, "supports": supports.collect::<Vec<_>>() })
}
