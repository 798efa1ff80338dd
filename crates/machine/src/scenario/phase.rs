//! `[phase.<name>]` of a scenario: what changes from a time on.

use super::closed_loop::{self, ControllerChoice, Joystick};
use super::{overrides_in, plain, MachineSource, Result};
use crate::errors::ErrorKind;
use crate::load::Source;
use crate::merge::{Override, OverrideValue};
use crate::model::Machine;
use crate::quantities::time;
use crate::reader::{Reader, Sign};

/// From `time` on the machine has further overrides, and the crane is driven like this.
#[derive(Debug, Clone, PartialEq)]
pub struct Phase {
    pub name: String,
    /// s
    pub time: f64,
    /// Added to those in force before, by dotted key.
    pub overrides: Vec<(String, OverrideValue)>,
    /// Also where it stays as it was.
    pub controller: ControllerChoice,
    /// Also where it stays as it was; `None`: all sticks centred.
    pub joystick: Option<Joystick>,
}

const KEYS: [&str; 4] = ["time", "overrides", "controller", "joystick"];

/// What holds where a phase begins.
pub struct Before<'a> {
    pub machine: &'a MachineSource,
    pub overrides: Vec<Override>,
    pub controller: Option<&'a ControllerChoice>,
    pub joystick: Option<&'a Joystick>,
}

/// The phases in order of time.
pub fn read(root: &Reader, machine: &Machine, source: &Source, before: Before) -> Result<Vec<Phase>> {
    let mut tables = Vec::new();
    for (name, table) in root.named_tables("phase", &KEYS)? {
        tables.push((begin(&table)?, name, table));
    }
    if tables.is_empty() {
        return Ok(Vec::new());
    }
    let Some(controller) = before.controller else {
        let message = "a phase changes who drives the crane, and here spool commands do";
        return Err(root
            .key_error(ErrorKind::ConflictingKeys, "phase", message)
            .help("add [controller] or [joystick]"));
    };
    tables.sort_by(|a, b| a.0.total_cmp(&b.0));
    if let Some(pair) = tables.windows(2).find(|pair| pair[1].0 <= pair[0].0) {
        let message = format!("phase `{}` begins at {} s too", pair[0].1, pair[0].0);
        let late = &pair[1].2;
        return Err(late.error(ErrorKind::BadSeries, "time", message).help("give each phase a time of its own"));
    }
    let mut overrides = before.overrides;
    let (mut controller, mut joystick) = (controller.clone(), before.joystick.cloned());
    let mut phases = Vec::new();
    for (time, name, table) in tables {
        let added = overrides_in(&table, "overrides")?;
        overrides.extend(added.iter().cloned());
        // Loading it finds what is wrong.
        before.machine.load(&overrides)?;
        let stated = closed_loop::joystick(&table, machine, source)?;
        controller = chosen(&table, stated.as_ref(), &controller, before.machine, &overrides)?;
        joystick = stated.or(joystick).filter(|stick| stick.fits(&controller));
        let (controller, joystick) = (controller.clone(), joystick.clone());
        phases.push(Phase { name: name.into(), time, overrides: plain(added), controller, joystick });
    }
    Ok(phases)
}

fn begin(table: &Reader) -> Result<f64> {
    table.required("time", "the time when it begins, for example \"2 s\"")?;
    table.quantity("time", &time(), Sign::Positive)
}

/// The controller that the phase states; else the one before, or the one that a stick of the other mode calls for.
fn chosen(
    table: &Reader,
    stick: Option<&Joystick>,
    before: &ControllerChoice,
    machine: &MachineSource,
    overrides: &[Override],
) -> Result<ControllerChoice> {
    if table.has("controller") {
        let choice = closed_loop::controller(table, stick, machine, overrides)?.unwrap_or_else(|| before.clone());
        return Ok(ControllerChoice { period: choice.period.or(before.period), ..choice });
    }
    Ok(match stick {
        Some(stick) if !stick.fits(before) => {
            ControllerChoice { name: closed_loop::fitting(Some(stick)).into(), monitor: None, ..before.clone() }
        }
        _ => before.clone(),
    })
}
