//! `[phase.<name>]` of a scenario: changes from a time on.

use super::closed_loop::{self, ControllerChoice, Joystick};
use super::log::Files;
use super::stage::Stage;
use super::{agree, overrides_in, plain, MachineSource, Result};
use crate::errors::ErrorKind;
use crate::model::Machine;
use crate::reading::reader::Reader;
use crate::text::merge::{Override, OverrideValue};

/// Overrides, controller and sticks from `time` on.
#[derive(Debug, Clone, PartialEq)]
pub struct Phase {
    pub name: String,
    /// s
    pub time: f64,
    /// Added to those in force before, by dotted key.
    pub overrides: Vec<(String, OverrideValue)>,
    /// `None`: unchanged, or that of the sticks' mode.
    pub controller: Option<ControllerChoice>,
    /// `None`: unchanged, or centred if the controller needs another mode.
    pub joystick: Option<Joystick>,
}

/// Most phases, because each loads the machine again.
const MOST_PHASES: usize = 1000;

/// The phases in order of time.
pub fn read(
    root: &Reader,
    machine: &Machine,
    files: &Files,
    of: &MachineSource,
    mut stage: Stage,
    mut overrides: Vec<Override>,
) -> Result<Vec<Phase>> {
    let mut phases = Vec::new();
    for (time, name, table) in in_order(root)? {
        let added = overrides_in(&table, "overrides")?;
        check_load(&added, &overrides, time)?;
        overrides.retain(|old| !added.iter().any(|new| new.key == old.key));
        overrides.extend(added.iter().cloned());
        // Loaded to find errors.
        of.load(&overrides)?;
        let joystick = closed_loop::joystick(&table, machine, files)?;
        let controller = match table.has("controller") {
            true => closed_loop::controller(&table, joystick.as_ref(), of, &overrides)?,
            false => None,
        };
        let phase = Phase { name: name.into(), time, overrides: plain(added.clone()), controller, joystick };
        stage = stage.then(&phase);
        if stage.controller.is_none() {
            let message = "a phase changes controller or sticks, but here spool commands move the crane";
            return Err(root
                .key_error(ErrorKind::ConflictingKeys, "phase", message)
                .help(format!("add [controller] or [joystick], or [phase.{name}.joystick]")));
        }
        agree(&table, None, stage.controller.as_ref(), phase.joystick.as_ref(), &added)?;
        phases.push(phase);
    }
    Ok(phases)
}

/// Time, name and table of each phase, in order of time.
fn in_order<'a>(root: &Reader<'a>) -> Result<Vec<(f64, &'a str, Reader<'a>)>> {
    let mut tables = Vec::new();
    for (name, table) in root.named_tables("phase")? {
        tables.push((begin(&table)?, name, table));
    }
    if tables.len() > MOST_PHASES {
        let message = format!("{} phases; a run has at most {MOST_PHASES}", tables.len());
        return Err(root.key_error(ErrorKind::TooLarge, "phase", message).help("join some of them, or run in parts"));
    }
    tables.sort_by(|a, b| a.0.total_cmp(&b.0));
    if let Some(pair) = tables.windows(2).find(|pair| pair[1].0 <= pair[0].0) {
        let message = format!("phase `{}` begins at {} s too", pair[0].1, pair[0].0);
        let late = &pair[1].2;
        return Err(late.error(ErrorKind::BadSeries, "time", message).help("give each phase a different time"));
    }
    Ok(tables)
}

/// A load is kept in all phases, so another mass at the tip would have no effect.
fn check_load(added: &[Override], before: &[Override], time: f64) -> Result<()> {
    let of = |overrides: &[Override]| overrides.iter().rev().find(|change| change.key == "payload.mass").cloned();
    match of(added) {
        Some(change) if of(before).map(|old| old.value) != Some(change.value.clone()) => Err(change
            .place
            .error(ErrorKind::ConflictingKeys, "payload.mass", "a phase does not change the load")
            .help(format!("add the table [payload] with time = [\"{time} s\"] and the mass from then on"))),
        _ => Ok(()),
    }
}

fn begin(table: &Reader) -> Result<f64> {
    table.required("time", "the time when it begins, for example \"2 s\"")?;
    table.quantity("time")
}
