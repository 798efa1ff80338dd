//! Start of a scenario: a pose with the holding pressures or with stated ones.

use super::AssemblyError;
use crate::event_loop::warnings::doubts_at_rest;
use crate::inputs::supply::{overridden, place, unusual};
use crate::model::Model;
use crate::warning::{short, Warning};
use hydrocrane_machine::scenario::{Initial, Pressures, Scenario};
use hydrocrane_machine::suggestion;
use hydrocrane_plant::{EquilibriumMode, PoseError};
use std::f64::consts::TAU;

/// State at time zero with `payload` (kg) at the tip, and warnings.
///
/// # Errors
/// A missing or unknown joint or cylinder, or a pose that is not possible.
pub fn start(scenario: &Scenario, model: &dyn Model, payload: f64) -> Result<(Vec<f64>, Vec<Warning>), AssemblyError> {
    let q = pose(&scenario.initial, model)?;
    let placed = |error| with_place(error, &scenario.initial);
    let mut x = at_rest(&scenario.initial, model, &q, payload).map_err(placed)?;
    if let Some(supply) = &scenario.supply {
        if let Some((message, cure)) = supply.fault() {
            return Err(format!("{message}; {cure}").into());
        }
        place(supply, model, &mut x);
    }
    let mut doubts = match scenario.initial.pressures {
        Pressures::Explicit(_) => Vec::new(),
        _ => doubts_at_rest(model, &q, &x, payload),
    };
    if let Some(supply) = &scenario.supply {
        doubts.extend(unusual(supply, model.machine()).into_iter().chain(overridden(scenario)));
    }
    Ok((x, doubts))
}

/// The pose `q` with the holding pressures or with stated ones.
fn at_rest(initial: &Initial, model: &dyn Model, q: &[f64], payload: f64) -> Result<Vec<f64>, AssemblyError> {
    let Pressures::Explicit(stated) = &initial.pressures else {
        return Ok(model.equilibrium(q, EquilibriumMode::Hold, payload)?);
    };
    let names: Vec<&str> = model.machine().cylinders.iter().map(|c| c.name.as_str()).collect();
    let pressures = in_order("cylinder", stated, &names)?;
    let missing = missing(&names, &pressures);
    if !missing.is_empty() {
        return Err(format!("no start pressures for cylinder {missing}; give (p1, p2) of every cylinder").into());
    }
    let layout = model.layout();
    let mut x = vec![0.0; layout.len()];
    x[..q.len()].copy_from_slice(q);
    if let Some(first) = layout.mains() {
        // The supply is at rest, independent of the stated chamber pressures.
        let rest = model.equilibrium(q, EquilibriumMode::Hold, payload)?;
        x[first..].copy_from_slice(&rest[first..]);
    }
    for (c, pair) in pressures.into_iter().flatten().enumerate() {
        [x[layout.p1(c)], x[layout.p2(c)]] = pair;
    }
    Ok(x)
}

/// The error of a start with its place in the file.
fn with_place(error: AssemblyError, initial: &Initial) -> AssemblyError {
    let place = match &error {
        AssemblyError::Pose(PoseError::OutsideLimits { joint, .. }) => place_of(joint, initial),
        _ => None,
    };
    match (error, place) {
        (AssemblyError::Pose(error), Some(place)) => AssemblyError::PoseOfFile(place, error),
        (error, _) => error,
    }
}

/// What stands before a message about the start of a joint that a file states.
fn place_of(joint: &str, initial: &Initial) -> Option<String> {
    let mut stated = initial.joints.iter().zip(&initial.places);
    let (_, place) = stated.find(|((name, _), place)| name == joint && !place.is_empty())?;
    Some(format!("{place}: initial.joint.{joint}: "))
}

/// The coordinate of every joint.
fn pose(initial: &Initial, model: &dyn Model) -> Result<Vec<f64>, AssemblyError> {
    let machine = model.machine();
    let names: Vec<&str> = machine.joints.iter().map(|joint| joint.name.as_str()).collect();
    let q = in_order("joint", &initial.joints, &names)?;
    let missing = missing(&names, &q);
    if !missing.is_empty() {
        let all = &machine.name;
        return Err(format!("no start value for joint {missing}; give every joint of {all}").into());
    }
    let q: Vec<f64> = q.into_iter().flatten().collect();
    let bounds = model.layout().units.iter().zip(model.joint_limits());
    for ((name, value), (unit, limits)) in names.iter().zip(&q).zip(bounds) {
        if *unit == "rad" && value.abs() > TAU {
            return Err(turned(name, *value, limits.lower, limits.upper, place_of(name, initial)).into());
        }
    }
    Ok(q)
}

/// A start of more than a full turn: often degrees in place of radians.
fn turned(name: &str, value: f64, lower: f64, upper: f64, place: Option<String>) -> String {
    let (low, high) = (lower.to_degrees(), upper.to_degrees());
    let meant = match &place {
        _ if !(low..=high).contains(&value) => String::new(),
        Some(_) => format!("; did you mean \"{} deg\"?", short(value)),
        None => format!("; numbers are radians: write np.deg2rad({})", short(value)),
    };
    format!(
        "{}joint {name} starts at {} rad, {} deg: more than a whole turn; its limits are {low:.1} and {high:.1} deg{meant}",
        place.unwrap_or_default(),
        short(value),
        short(value.to_degrees())
    )
}

/// The values `given` by name in the order of `names`.
fn in_order<T: Copy>(what: &str, given: &[(String, T)], names: &[&str]) -> Result<Vec<Option<T>>, String> {
    known(what, given.iter().map(|(name, _)| name.as_str()), names)?;
    Ok(names.iter().map(|name| given.iter().find(|(own, _)| own == name).map(|(_, value)| *value)).collect())
}

/// An error if one of the names `given` is not among the `known` ones.
pub(super) fn known<'n>(what: &str, given: impl Iterator<Item = &'n str>, names: &[&str]) -> Result<(), String> {
    for name in given {
        if !names.contains(&name) {
            return Err(format!("unknown {what} `{name}`; {}", suggestion(name, names.iter().copied())));
        }
    }
    Ok(())
}

/// The names that have no value.
fn missing<T>(names: &[&str], values: &[Option<T>]) -> String {
    let without = names.iter().zip(values).filter(|(_, value)| value.is_none());
    without.map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
}
