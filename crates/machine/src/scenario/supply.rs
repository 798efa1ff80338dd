//! `[supply]` of a scenario: a measured supply pressure against time, by numbers or from a log.

use super::log::{Files, Log, Problem};
use super::{check_series, Interpolation, Result, INTERPOLATIONS, NUMBER_FORMATS};
use crate::errors::ErrorKind;
use crate::model::Machine;
use crate::reading::reader::{Field, Reader};
use crate::units::log_units::ATMOSPHERE;
use crate::units::quantities::PRESSURE;

/// The key that a machine with a measured pressure must have.
pub const MEASURED: (&str, &str) = ("supply.measured", "yes");
/// Names of the pressure in a log.
const USUAL_NAMES: [&str; 3] = ["supply.pressure", "mains.p", "supply"];
/// Lowest possible pressure: a perfect vacuum as gauge pressure, Pa.
const VACUUM: f64 = -ATMOSPHERE;

/// Supply pressure against time; constant before the first time and after the last.
#[derive(Debug, Clone, PartialEq)]
pub struct SupplyPressure {
    /// s
    pub time: Vec<f64>,
    /// Gauge, Pa.
    pub pressure: Vec<f64>,
    pub interpolation: Interpolation,
}

impl SupplyPressure {
    /// Pressure at the time `t` and its rate of change just after it.
    pub fn at(&self, t: f64) -> (f64, f64) {
        let next = self.time.partition_point(|time| *time <= t);
        match (next.checked_sub(1), self.time.get(next)) {
            (None, _) => (self.pressure[0], 0.0),
            (Some(last), Some(end)) if self.interpolation == Interpolation::Linear => {
                let rate = (self.pressure[next] - self.pressure[last]) / (end - self.time[last]);
                (self.pressure[last] + rate * (t - self.time[last]), rate)
            }
            (Some(last), _) => (self.pressure[last], 0.0),
        }
    }

    /// The first of its times after `t`.
    pub fn next_time(&self, t: f64) -> Option<f64> {
        self.time.get(self.time.partition_point(|time| *time <= t)).copied()
    }

    /// The reason if no supply can have this pressure, and the cure.
    pub fn fault(&self) -> Option<(String, &'static str)> {
        let (time, pressure) = self.time.iter().zip(&self.pressure).find(|(_, pressure)| **pressure < VACUUM)?;
        let message = format!("the supply pressure at {time} s is {:.3} bar, below vacuum", 1e-5 * pressure);
        Some((message, "check zero, sign and unit of the sensor; pressures are gauge"))
    }
}

/// The measured pressure that `[supply]` states.
pub fn read(root: &Reader, machine: &Machine, files: &Files) -> Result<Option<SupplyPressure>> {
    let Some(table) = root.table("supply")? else { return Ok(None) };
    if machine.supply.mains.is_some() {
        let message = "the machine has a pump, which determines the supply pressure";
        let help = "omit [supply], or use the machine without its pump";
        return Err(root.key_error(ErrorKind::ConflictingKeys, "supply", message).help(help));
    }
    let interpolation = table.optional_choice("interpolation", &INTERPOLATIONS)?.unwrap_or(Interpolation::Linear);
    let (supply, place) = match table.optional("log")? {
        Some(field) => logged(&table, field, interpolation, files)?,
        None => stated(&table, interpolation)?,
    };
    match supply.fault() {
        Some((message, cure)) => Err(place.error(ErrorKind::OutOfRange, message).help(cure)),
        None => Ok(Some(supply)),
    }
}

/// The pressure by numbers, with the value that holds it.
fn stated<'a>(table: &Reader<'a>, interpolation: Interpolation) -> Result<(SupplyPressure, Field<'a>)> {
    if let Some(key) = ["column", "unit", "time-column", "number-format"].into_iter().find(|key| table.has(key)) {
        let message = "belongs to a log, and there is none";
        let help = "add log = \"file.csv\" to [supply]";
        return Err(table.key_error(ErrorKind::MissingKey, key, message).help(help));
    }
    let time_field = table.required("time", "a list of times, or log = \"file.csv\"")?;
    let field = table.required("pressure", "a list of pressures, for example [\"140 bar\", \"120 bar\"]")?;
    let supply = SupplyPressure { time: time_field.series()?, pressure: field.series()?, interpolation };
    check_series(&supply.time, &supply.pressure, &time_field, &field)?;
    Ok((supply, field))
}

/// The pressure from the log that `field` names.
fn logged<'a>(
    table: &Reader<'a>,
    field: Field<'a>,
    interpolation: Interpolation,
    files: &Files,
) -> Result<(SupplyPressure, Field<'a>)> {
    if let Some(key) = ["time", "pressure"].into_iter().find(|key| table.has(key)) {
        let message = "excludes `supply.log`, which is given too";
        let help = "keep one of the two; the column of the times is `time-column`";
        return Err(table.key_error(ErrorKind::ConflictingKeys, key, message).help(help));
    }
    let text = |key: &str| table.optional(key)?.map(|field| field.text().map(str::to_string)).transpose();
    let (time, column, unit) = (text("time-column")?, text("column")?, text("unit")?);
    let numbers = table.optional_choice("number-format", &NUMBER_FORMATS)?;
    let name = field.text()?;
    let read = || {
        let log = Log::open(name, time.as_deref(), numbers, files)?;
        let names = column.as_deref().map_or_else(|| USUAL_NAMES.to_vec(), |column| vec![column]);
        let pressure = log.column(&names, unit.as_deref(), &PRESSURE.quantity())?;
        let pressure = pressure.ok_or_else(|| log.without(names[0], "the supply pressure"))?;
        log.tell(&field);
        Ok(SupplyPressure { time: log.time, pressure, interpolation })
    };
    let read = read().map_err(|(kind, message, cure): Problem| field.error(kind, message).help(cure))?;
    Ok((read, field))
}
