//! `[command]` of a scenario: spool commands against time, by numbers or from a log.

use super::log::{Files, Log, Problem};
use super::{check_series, known_cylinder, Interpolation, Result, INTERPOLATIONS, NUMBER_FORMATS};
use crate::errors::ErrorKind;
use crate::model::Machine;
use crate::quantities::LENGTH;
use crate::reader::{Field, Reader};
use hydrocrane_logs::Format;

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
    let mut wanted = Vec::new();
    for name in open.keys().filter(|key| *key != "log" && !OF_A_LOG.contains(key)) {
        known_cylinder(open, name, machine)?;
        let Some(table) = open.table(name)? else { continue };
        if let Some(key) = ["time", "spool", "interpolation"].into_iter().find(|key| table.has(key)) {
            let message = "excludes `command.log`, which is given too";
            return Err(table.key_error(ErrorKind::ConflictingKeys, key, message).help("keep one of the two"));
        }
        wanted.push(LoggedColumn {
            cylinder: name.into(),
            column: table.optional("column")?.map(|column| column.text().map(str::to_string)).transpose()?,
            unit: table.optional("unit")?.map(|unit| unit.text().map(str::to_string)).transpose()?,
        });
    }
    let asked = CommandLog {
        name: field.text()?.into(),
        time: open.optional("time")?.map(|name| name.text().map(str::to_string)).transpose()?,
        numbers: open.optional_choice("number-format", &NUMBER_FORMATS)?,
        interpolation: open.optional_choice("interpolation", &INTERPOLATIONS)?.unwrap_or(Interpolation::Linear),
        columns: wanted,
    };
    let cylinders: Vec<&str> = machine.cylinders.iter().map(|cylinder| cylinder.name.as_str()).collect();
    let commands =
        asked.read(&field, &cylinders, files).map_err(|(kind, message, cure)| field.error(kind, message).help(cure))?;
    Ok(commands.into_iter().map(|command| (command, field.clone())).collect())
}

/// A log of spool commands with the assignment of its columns.
struct CommandLog {
    /// Path of a text file.
    name: String,
    /// Column of the times; `None`: `time` or `t`.
    time: Option<String>,
    numbers: Option<Format>,
    interpolation: Interpolation,
    /// Empty: all columns named like a cylinder.
    columns: Vec<LoggedColumn>,
}

/// Column of the command of a cylinder.
struct LoggedColumn {
    cylinder: String,
    /// `None`: the column named like the cylinder.
    column: Option<String>,
    /// `None`: the unit in the log, or m.
    unit: Option<String>,
}

impl CommandLog {
    fn read(
        &self,
        field: &Field,
        cylinders: &[&str],
        files: &Files,
    ) -> std::result::Result<Vec<SpoolCommand>, Problem> {
        let log = Log::open(&self.name, self.time.as_deref(), self.numbers, files)?;
        let command = |cylinder: &str, spool: Vec<f64>| SpoolCommand {
            cylinder: cylinder.to_string(),
            time: log.time.clone(),
            spool,
            interpolation: self.interpolation,
        };
        let mut commands = Vec::new();
        for LoggedColumn { cylinder, column, unit } in &self.columns {
            let usual = usual_names(cylinder);
            let names: Vec<&str> = match column {
                Some(column) => vec![column],
                None => usual.iter().map(String::as_str).collect(),
            };
            let what = format!("the command of `{cylinder}`");
            commands.push(command(cylinder, log.column(&names, &what, unit.as_deref(), &LENGTH.quantity())?));
        }
        for cylinder in cylinders.iter().filter(|_| self.columns.is_empty()) {
            let usual = usual_names(cylinder);
            let names: Vec<&str> = usual.iter().map(String::as_str).collect();
            if log.has(&names) {
                commands.push(command(cylinder, log.column(&names, "a command", None, &LENGTH.quantity())?));
            }
        }
        log.tell(field);
        if commands.is_empty() {
            return Err(log.without_columns(cylinders.iter().copied(), "command"));
        }
        Ok(commands)
    }
}
