//! `[command]` of a scenario: spool commands against time, by numbers or from a log.

use super::log::{Files, Log, Problem};
use super::{check_series, known_cylinder, Interpolation, Result, INTERPOLATIONS, NUMBER_FORMATS};
use crate::errors::ErrorKind;
use crate::model::Machine;
use crate::reading::reader::{Field, Reader};
use crate::units::quantities::LENGTH;

/// Spool position commanded to the valve of a cylinder against time.
#[derive(Debug, Clone, PartialEq)]
pub struct SpoolCommand {
    pub cylinder: String,
    pub time: Vec<f64>,
    /// m; positive extends the piston.
    pub spool: Vec<f64>,
    pub interpolation: Interpolation,
}

/// Names of the command of a cylinder in a log.
fn usual_names(cylinder: &str) -> [String; 3] {
    [cylinder.to_string(), format!("command.{cylinder}"), format!("cylinder.{cylinder}.command")]
}

/// Keys beside `log`.
const OF_A_LOG: [&str; 3] = ["time", "number-format", "interpolation"];

/// The commands by cylinder; those of a log if `[command]` names one.
pub fn read(root: &Reader, machine: &Machine, files: &Files) -> Result<Vec<SpoolCommand>> {
    let Some(open) = root.names("command")? else { return Ok(Vec::new()) };
    let commands = match open.optional("log")? {
        Some(field) => logged(&open, field, machine, files)?,
        None => stated(&open, machine)?,
    };
    for (command, place) in &commands {
        let stroke = machine.cylinders[known_cylinder(&open, &command.cylinder, machine)?].valve.stroke;
        if let Some(spool) = command.spool.iter().find(|spool| spool.abs() > stroke * (1.0 + 1e-9)) {
            let message = format!("{spool} m exceeds the spool stroke of {stroke} m");
            let cure = "stay within plus and minus the stroke, and check the unit: m, mm or um?";
            return Err(place.error(ErrorKind::OutOfRange, message).help(cure));
        }
    }
    Ok(commands.into_iter().map(|(command, _)| command).collect())
}

/// Each command with the value that holds its spool positions.
type Placed<'a> = Vec<(SpoolCommand, Field<'a>)>;

/// Commands by numbers.
fn stated<'a>(open: &Reader<'a>, machine: &Machine) -> Result<Placed<'a>> {
    let of_a_log = OF_A_LOG.into_iter().find(|key| open.has(key) && open.table(key).is_err());
    if let Some(key) = of_a_log {
        let message = "belongs to a log, and there is none";
        return Err(open
            .key_error(ErrorKind::MissingKey, key, message)
            .help("add log = \"file.csv\", or put the key into the table of a cylinder"));
    }
    let mut commands = Vec::new();
    for name in open.keys() {
        known_cylinder(open, name, machine)?;
        let Some(table) = open.table(name)? else { continue };
        if let Some(key) = ["column", "unit"].into_iter().find(|key| table.has(key)) {
            let message = "belongs to a log, and there is none";
            let help = "add log = \"file.csv\" to [command]";
            return Err(table.key_error(ErrorKind::MissingKey, key, message).help(help));
        }
        let time_field = table.required("time", "a list of times, for example [\"0 s\", \"1 s\"]")?;
        let spool_field = table.required("spool", "a list of spool positions, for example [\"0 mm\", \"10 mm\"]")?;
        let command = SpoolCommand {
            cylinder: name.into(),
            time: time_field.series()?,
            spool: spool_field.series()?,
            interpolation: table.choice_or_default("interpolation", &INTERPOLATIONS)?,
        };
        check_series(&command.time, &command.spool, &time_field, &spool_field)?;
        commands.push((command, spool_field));
    }
    Ok(commands)
}

/// Commands from the log that `field` names: of the cylinders that have a table, or else of all that it has a column for.
fn logged<'a>(open: &Reader<'a>, field: Field<'a>, machine: &Machine, files: &Files) -> Result<Placed<'a>> {
    let text =
        |table: &Reader, key: &str| table.optional(key)?.map(|field| field.text().map(str::to_string)).transpose();
    let mut wanted = Vec::new();
    for name in open.keys().filter(|key| *key != "log" && !OF_A_LOG.contains(key)) {
        known_cylinder(open, name, machine)?;
        let Some(table) = open.table(name)? else { continue };
        if let Some(key) = ["time", "spool", "interpolation"].into_iter().find(|key| table.has(key)) {
            let message = "excludes `command.log`, which is given too";
            return Err(table.key_error(ErrorKind::ConflictingKeys, key, message).help("keep one of the two"));
        }
        wanted.push((name, text(&table, "column")?, text(&table, "unit")?));
    }
    let (name, time) = (field.text()?, text(open, "time")?);
    let numbers = open.optional_choice("number-format", &NUMBER_FORMATS)?;
    let interpolation = open.optional_choice("interpolation", &INTERPOLATIONS)?.unwrap_or(Interpolation::Linear);
    let cylinders = machine.cylinders.iter().map(|cylinder| cylinder.name.as_str());
    let every = wanted.is_empty();
    if every {
        wanted = cylinders.clone().map(|name| (name, None, None)).collect();
    }
    let read = || {
        let log = Log::open(name, time.as_deref(), numbers, files)?;
        let mut commands = Vec::new();
        for (cylinder, column, unit) in wanted {
            let usual = usual_names(cylinder);
            let names = column.as_ref().map_or(&usual[..], std::slice::from_ref);
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            match log.column(&names, unit.as_deref(), &LENGTH.quantity())? {
                Some(spool) => {
                    let (cylinder, time) = (cylinder.into(), log.time.clone());
                    commands.push(SpoolCommand { cylinder, time, spool, interpolation });
                }
                None if every => {}
                None => return Err(log.without(names[0], &format!("the command of `{cylinder}`"))),
            }
        }
        log.tell(&field);
        if commands.is_empty() {
            Err(log.without_columns(cylinders, "command"))
        } else {
            Ok(commands)
        }
    };
    let commands = read().map_err(|(kind, message, cure): Problem| field.error(kind, message).help(cure))?;
    Ok(commands.into_iter().map(|command| (command, field.clone())).collect())
}
