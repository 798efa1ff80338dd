//! `[command]` of a scenario: spool commands against time, by numbers or from a log.

use super::log::{Files, Log};
use super::{check_series, known_cylinder, Interpolation, Result, INTERPOLATIONS};
use crate::errors::ErrorKind;
use crate::model::Machine;
use crate::quantities::LENGTH;
use crate::reader::{Field, Reader};

/// Spool position commanded to the valve of a cylinder against time.
#[derive(Debug, Clone, PartialEq)]
pub struct SpoolCommand {
    pub cylinder: String,
    pub time: Vec<f64>,
    /// m; positive extends the piston.
    pub spool: Vec<f64>,
    pub interpolation: Interpolation,
}

/// What a log calls the command of a cylinder.
fn usual_names(cylinder: &str) -> [String; 3] {
    [cylinder.to_string(), format!("command.{cylinder}"), format!("cylinder.{cylinder}.command")]
}

/// The commands by cylinder, those of a log where `[command]` names one.
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
            return Err(place.error(ErrorKind::OutOfRange, message).help("stay within plus and minus the stroke"));
        }
    }
    Ok(commands.into_iter().map(|(command, _)| command).collect())
}

/// Each command with the value that tells its spool positions.
type Placed<'a> = Vec<(SpoolCommand, Field<'a>)>;

/// Commands by numbers.
fn stated<'a>(open: &Reader<'a>, machine: &Machine) -> Result<Placed<'a>> {
    let of_a_log = ["time", "interpolation"].into_iter().find(|key| open.has(key) && open.table(key).is_err());
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

/// Commands from a log: of the cylinders that have a table, or else of all that it has a column for.
fn logged<'a>(open: &Reader<'a>, field: Field<'a>, machine: &Machine, files: &Files) -> Result<Placed<'a>> {
    let time = open.optional("time")?.map(|name| name.text()).transpose()?;
    let log = Log::open(&field, time, files)?;
    let interpolation = open.optional_choice("interpolation", &INTERPOLATIONS)?.unwrap_or(Interpolation::Linear);
    let mut commands = Vec::new();
    let tables = open.keys().filter(|key| !["log", "time", "interpolation"].contains(key));
    for name in tables {
        known_cylinder(open, name, machine)?;
        let Some(table) = open.table(name)? else { continue };
        if let Some(key) = ["time", "spool", "interpolation"].into_iter().find(|key| table.has(key)) {
            let message = "excludes `command.log`, which is given too";
            return Err(table.key_error(ErrorKind::ConflictingKeys, key, message).help("keep one of the two"));
        }
        let column = table.optional("column")?.map(|column| column.text()).transpose()?;
        let usual = usual_names(name);
        let names = column.map_or_else(|| usual.iter().map(String::as_str).collect(), |column| vec![column]);
        let unit = table.optional("unit")?.map(|unit| unit.text()).transpose()?;
        commands.push((name, log.column(&names, &format!("the command of `{name}`"), unit, &LENGTH.quantity())?));
    }
    if commands.is_empty() {
        for cylinder in &machine.cylinders {
            let usual = usual_names(&cylinder.name);
            let names: Vec<&str> = usual.iter().map(String::as_str).collect();
            if log.has(&names) {
                commands.push((&cylinder.name, log.column(&names, "a command", None, &LENGTH.quantity())?));
            }
        }
    }
    if commands.is_empty() {
        return Err(log.without_columns(machine.cylinders.iter().map(|c| c.name.as_str()), "command"));
    }
    let of = |(cylinder, spool): (&str, Vec<f64>)| {
        let (cylinder, time) = (cylinder.to_string(), log.time.clone());
        (SpoolCommand { cylinder, time, spool, interpolation }, field.clone())
    };
    Ok(commands.into_iter().map(of).collect())
}
