//! `[initial]` of a scenario: the state at the start.

use super::{known_cylinder, known_name, Result};
use crate::errors::ErrorKind;
use crate::model::Machine;
use crate::reading::reader::Reader;
use crate::sections::coordinate;

/// The state at the start; joints that are not named are at zero.
#[derive(Debug, Clone, PartialEq)]
pub struct Initial {
    /// Joint coordinates by name, rad or m.
    pub joints: Vec<(String, f64)>,
    /// Where the file states each; empty without a file.
    pub places: Vec<String>,
    pub pressures: Pressures,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Pressures {
    /// Equilibrium: each cylinder holds its load at rest.
    Equilibrium,
    /// Gauge pressures at piston and rod side by cylinder, Pa.
    Explicit(Vec<(String, [f64; 2])>),
}

/// The start that `[initial]` describes.
pub fn read(root: &Reader, machine: &Machine) -> Result<Initial> {
    let Some(table) = root.table("initial")? else {
        return Ok(Initial { joints: Vec::new(), places: Vec::new(), pressures: Pressures::Equilibrium });
    };
    let (mut joints, mut places) = (Vec::new(), Vec::new());
    if let Some(names) = table.names("joint")? {
        for name in names.keys() {
            let joint =
                &machine.joints[known_name(&names, name, "joint", machine.joints.iter().map(|j| j.name.as_str()))?];
            let field = names.required(name, "the start of the joint")?;
            joints.push((name.to_string(), field.quantity_of(&coordinate(&joint.kind))?));
            places.push(field.place.to_string());
        }
    }
    Ok(Initial { joints, places, pressures: pressures(&table, machine)? })
}

fn pressures(table: &Reader, machine: &Machine) -> Result<Pressures> {
    table.choice_or_default("pressures", &[()])?;
    let Some(names) = table.names("pressure")? else { return Ok(Pressures::Equilibrium) };
    if table.has("pressures") {
        let message = "excludes `pressures`, which is given too";
        return Err(table.error(ErrorKind::ConflictingKeys, "pressure", message).help("keep one of the two"));
    }
    let mut explicit = Vec::new();
    for name in names.keys() {
        known_cylinder(&names, name, machine)?;
        let field = names.required(name, "two pressures")?;
        explicit.push((name.to_string(), field.pair()?));
    }
    let missing = machine.cylinders.iter().find(|cylinder| !names.has(&cylinder.name));
    match missing {
        Some(cylinder) => Err(names.missing(&cylinder.name, "give the pressures of every cylinder")),
        None => Ok(Pressures::Explicit(explicit)),
    }
}
