//! `[phase.<name>]` of a scenario: what changes from a time on.

use super::closed_loop::{self, ControllerChoice, Joystick};
use super::{overrides_in, plain, MachineSource, Result, Stated};
use crate::errors::ErrorKind;
use crate::load::Source;
use crate::merge::{Override, OverrideValue};
use crate::model::Machine;
use crate::reader::Reader;

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

/// Each loads the machine anew.
const MOST_PHASES: usize = 1000;

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
    for (name, table) in root.named_tables("phase")? {
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
    if tables.len() > MOST_PHASES {
        let message = format!("{} phases; a run has at most {MOST_PHASES}", tables.len());
        return Err(root.key_error(ErrorKind::TooLarge, "phase", message).help("join some of them, or run in parts"));
    }
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
        check_load(&added, &overrides, time)?;
        overrides.retain(|old| !added.iter().any(|new| new.key == old.key));
        overrides.extend(added.iter().cloned());
        // Loading it finds what is wrong.
        let changed = before.machine.load(&overrides)?;
        let stated = closed_loop::joystick(&table, machine, source)?;
        controller = chosen(&table, stated.as_ref(), &controller, before.machine, &overrides)?;
        let here = Stated { machine: &changed, overrides: &added };
        here.agree_loop(&table, Some(&controller), stated.as_ref())?;
        // What is stated later counts: an override before what earlier tables stated.
        if here.has("control.period") && !states(&table, "controller", "period")? {
            controller.period = None;
        }
        let earlier = joystick.map(|stick| match here.has(&format!("control.{}.full-speed", controller.name)) {
            true => Joystick { full_speed: None, ..stick },
            false => stick,
        });
        joystick = stated.or(earlier).filter(|stick| stick.fits(&controller));
        let (controller, joystick) = (controller.clone(), joystick.clone());
        phases.push(Phase { name: name.into(), time, overrides: plain(added), controller, joystick });
    }
    Ok(phases)
}

/// Whether the sub-table `name` states `key`.
fn states(table: &Reader, name: &str, key: &str) -> Result<bool> {
    Ok(table.names(name)?.is_some_and(|own| own.has(key)))
}

/// A load goes on through phases, so that another mass at the tip would be ignored.
fn check_load(added: &[Override], before: &[Override], time: f64) -> Result<()> {
    let of = |overrides: &[Override]| overrides.iter().rev().find(|change| change.key == "payload.mass").cloned();
    match of(added) {
        Some(change) if of(before).map(|old| old.value) != Some(change.value.clone()) => Err(change
            .place
            .error(ErrorKind::ConflictingKeys, "payload.mass", "a phase does not change the load, which goes on")
            .help(format!("add the table [payload] with time = [\"{time} s\"] and the mass from then on"))),
        _ => Ok(()),
    }
}

fn begin(table: &Reader) -> Result<f64> {
    table.required("time", "the time when it begins, for example \"2 s\"")?;
    table.quantity("time")
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
