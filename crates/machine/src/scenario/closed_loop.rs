//! `[controller]` and `[joystick]` of a scenario: the controller and the operator's input.

use super::log::{is_text, Files, Log, Problem};
use super::{check_series, overrides_in, plain, Interpolation, MachineSource, Result, INTERPOLATIONS, NUMBER_FORMATS};
use crate::errors::ErrorKind;
use crate::keys::{CONTROLLERS, LEVER, TIP_AXES};
use crate::model::Machine;
use crate::reading::reader::{Field, Reader};
use crate::text::merge::{Override, OverrideValue};
use crate::units::quantities::NUMBER;
use hydrocrane_logs::Format;

/// A sampled controller with its sensors, delay and model.
#[derive(Debug, Clone, PartialEq)]
pub struct ControllerChoice {
    pub name: String,
    /// Time between samples, s; `None`: the machine's or the controller's own.
    pub period: Option<f64>,
    /// Computation delay, s.
    pub delay: f64,
    pub sensors: SensorQuality,
    /// The controller model: overrides of the machine, by dotted key.
    pub model: Vec<(String, OverrideValue)>,
    /// Another machine as controller model, in place of overrides: a bundled name or path, and its own overrides.
    pub other_model: Option<(String, Vec<(String, OverrideValue)>)>,
    /// Whether implausible sensors close the valves; `None`: the default of the controller.
    pub monitor: Option<bool>,
    /// Number of a user-defined controller, which has no name and is in no file.
    pub own: Option<usize>,
}

impl ControllerChoice {
    /// The controller `name` with ideal sensors and the crane as its model.
    pub fn named(name: &str) -> Self {
        ControllerChoice {
            name: name.into(),
            period: None,
            delay: 0.0,
            sensors: SensorQuality::Ideal,
            model: Vec::new(),
            other_model: None,
            monitor: None,
            own: None,
        }
    }

    /// Whether implausible sensors close the valves; default is yes for a controller by name that reads sensors.
    pub fn monitored(&self) -> bool {
        self.monitor.unwrap_or(self.own.is_none() && self.name != LEVER)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensorQuality {
    Ideal,
    /// The sensors of the machine file.
    DataSheet,
}

/// Deflections of the operator's sticks against time.
#[derive(Debug, Clone, PartialEq)]
pub struct Joystick {
    pub mode: StickMode,
    pub time: Vec<f64>,
    /// Deflections, -1 to 1: per axis (x, z and slew as far as stated; or the machine's cylinders) one per time.
    pub axes: Vec<Vec<f64>>,
    /// File with the deflections in place of the above.
    pub log: Option<String>,
    pub interpolation: Interpolation,
    /// Dead zone around the centre, as a share of the deflection.
    pub dead_zone: f64,
    /// Speed of the tip at full deflection, m/s; `None`: the machine's or the controller's own.
    pub full_speed: Option<f64>,
    /// Time from the centre to full deflection, s.
    pub ramp: f64,
    /// Share of the full speed, one per time; empty: full speed.
    pub precision: Vec<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StickMode {
    /// One stick: the tip's velocity.
    Tip,
    /// One axis per cylinder.
    Lever,
    /// One axis per cylinder, for pistons at a speed, while one joint holds the tip's height.
    Height,
}

impl StickMode {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            StickMode::Tip => "tip",
            StickMode::Lever => "lever",
            StickMode::Height => "height",
        }
    }
}

impl Joystick {
    /// Whether a controller supports sticks of this mode.
    pub fn fits(&self, controller: &ControllerChoice) -> bool {
        controller.own.is_some() || modes(&controller.name).contains(&self.mode)
    }
}

/// The stick modes of a controller by name, the usual one first.
fn modes(controller: &str) -> &'static [StickMode] {
    match controller {
        LEVER => &[StickMode::Lever],
        "tip" => &[StickMode::Tip, StickMode::Height],
        _ => &[StickMode::Tip],
    }
}

/// The controller that a joystick selects.
pub fn fitting(stick: Option<&Joystick>) -> &'static str {
    match stick {
        Some(Joystick { mode: StickMode::Lever, .. }) => LEVER,
        _ => CONTROLLERS[0].0,
    }
}

/// The controller; a joystick alone selects that of its mode, goals select that which moves the tip.
/// `machine` and `overrides` are those of the scenario.
pub fn controller(
    root: &Reader,
    stick: Option<&Joystick>,
    machine: &MachineSource,
    overrides: &[Override],
) -> Result<Option<ControllerChoice>> {
    let fitting = fitting(stick);
    let Some(table) = root.table("controller")? else {
        let goes = root.has("goal") && !root.has("command");
        return Ok((stick.is_some() || goes).then(|| ControllerChoice::named(fitting)));
    };
    if root.has("command") {
        let message = "excludes `command`, which is given too";
        return Err(root
            .key_error(ErrorKind::ConflictingKeys, "controller", message)
            .help("either a controller or spool commands move the crane"));
    }
    let choice = ControllerChoice {
        name: table.optional_choice("name", table.choices("name"))?.unwrap_or(fitting).into(),
        period: table.optional_quantity("period")?,
        delay: table.quantity_or_default("delay")?,
        sensors: table.choice_or_default("sensors", &[SensorQuality::Ideal, SensorQuality::DataSheet])?,
        model: controller_model(&table, machine, overrides)?,
        monitor: table.optional_choice("monitor", &[true, false])?,
        ..ControllerChoice::named(fitting)
    };
    check_mode(&table, &choice, stick)?;
    Ok(Some(choice))
}

/// The overrides of the controller model. They are loaded once, which finds what is wrong with them.
fn controller_model(
    table: &Reader,
    machine: &MachineSource,
    overrides: &[Override],
) -> Result<Vec<(String, OverrideValue)>> {
    let changes = overrides_in(table, "model")?;
    if !changes.is_empty() {
        machine.load(&[overrides, &changes].concat())?;
    }
    Ok(plain(changes))
}

fn check_mode(table: &Reader, choice: &ControllerChoice, stick: Option<&Joystick>) -> Result<()> {
    if stick.is_none_or(|stick| stick.fits(choice)) {
        return Ok(());
    }
    let (name, given) = (&choice.name, stick.map_or("", |stick| stick.mode.name()));
    let wants: Vec<String> = modes(name).iter().map(|mode| format!("`{}`", mode.name())).collect();
    let message = format!("`{name}` needs the stick mode {}, the joystick has `{given}`", wants.join(" or "));
    Err(table
        .error(ErrorKind::ConflictingKeys, "name", message)
        .help(format!("set `mode = \"{}\"` in [joystick]", modes(name)[0].name())))
}

/// The joystick, if there is one.
pub fn joystick(root: &Reader, machine: &Machine, files: &Files) -> Result<Option<Joystick>> {
    let Some(open) = root.names("joystick")? else { return Ok(None) };
    if root.has("command") {
        let message = "excludes `command`, which is given too";
        return Err(root
            .key_error(ErrorKind::ConflictingKeys, "joystick", message)
            .help("either sticks or spool commands move the crane"));
    }
    let mode = open.choice_or_default("mode", &[StickMode::Tip, StickMode::Lever, StickMode::Height])?;
    let axes: Vec<&str> = match mode {
        StickMode::Tip => machine.tip_axes().to_vec(),
        StickMode::Lever | StickMode::Height => {
            machine.cylinders.iter().map(|cylinder| cylinder.name.as_str()).collect()
        }
    };
    let mut known: Vec<&str> = open.known().filter(|key| !TIP_AXES.contains(key)).collect();
    known.extend(&axes);
    let Some(table) = root.table_of("joystick", &known)? else { return Ok(None) };
    let sticks = series(&table, mode, &axes, files)?;
    let dead_zone = table.quantity_or_default("dead-zone")?;
    if dead_zone >= 1.0 {
        let message = format!("a dead zone of {dead_zone} covers the whole stick");
        return Err(table
            .error(ErrorKind::OutOfRange, "dead-zone", message)
            .help("give a share below 1, such as 0.05"));
    }
    Ok(Some(Joystick {
        mode,
        time: sticks.time,
        axes: sticks.axes,
        log: sticks.log,
        precision: sticks.precision,
        interpolation: table.optional_choice("interpolation", &INTERPOLATIONS)?.unwrap_or(sticks.interpolation),
        dead_zone,
        full_speed: table.optional_quantity("full-speed")?,
        ramp: table.quantity_or_default("ramp")?,
    }))
}

/// The deflections of a joystick, or the log with them.
struct Deflections {
    time: Vec<f64>,
    axes: Vec<Vec<f64>>,
    precision: Vec<f64>,
    log: Option<String>,
    /// Where none is stated.
    interpolation: Interpolation,
}

/// Times and the deflections of each axis; an axis that is not given stays centred.
fn series(table: &Reader, mode: StickMode, axes: &[&str], files: &Files) -> Result<Deflections> {
    let numbers = table.optional_choice("number-format", &NUMBER_FORMATS)?;
    if let Some(field) = table.optional("log")? {
        if let Some(key) = ["time", PRECISION].iter().chain(axes).find(|key| table.has(key)) {
            let message = "excludes `log`, which is given too";
            return Err(table.error(ErrorKind::ConflictingKeys, key, message).help("keep one of the two"));
        }
        return logged(&field, mode, axes, numbers, files);
    }
    if numbers.is_some() {
        let message = "belongs to a log, and there is none";
        return Err(table.error(ErrorKind::MissingKey, "number-format", message).help("add log = \"file.csv\""));
    }
    let time_field = table.required("time", "a list of times, for example [\"0 s\", \"1 s\"]")?;
    let times = time_field.series()?;
    if !axes.iter().any(|axis| table.has(axis)) && !table.has(PRECISION) {
        return Err(table.missing(axes[0], "give the deflection of one axis or more, for example [1, 0]"));
    }
    let mut deflections = Vec::new();
    for axis in axes {
        let values = match table.optional(axis)? {
            None => vec![0.0; times.len()],
            Some(field) => {
                let values = field.series()?;
                check_series(&times, &values, &time_field, &field)?;
                check_range(&field, &values)?;
                values
            }
        };
        deflections.push(values);
    }
    let precision = match table.optional(PRECISION)? {
        None => Vec::new(),
        Some(field) => {
            let shares = field.series()?;
            check_series(&times, &shares, &time_field, &field)?;
            check_shares(&field, &shares)?;
            shares
        }
    };
    Ok(Deflections { time: times, axes: deflections, precision, log: None, interpolation: Interpolation::Hold })
}

/// The share of the full speed beside the axes of a stick.
const PRECISION: &str = "precision";

fn check_shares(field: &Field, shares: &[f64]) -> Result<()> {
    match shares.iter().find(|share| !(0.0..=1.0).contains(*share)) {
        Some(share) => Err(field
            .error(ErrorKind::OutOfRange, format!("{share} is not a share of the full speed"))
            .help("give shares from 0 to 1, such as 0.25; 1 is the full speed")),
        None => Ok(()),
    }
}

/// Deflections from a log; a log that is no text is read by the caller.
fn logged(
    field: &Field,
    mode: StickMode,
    axes: &[&str],
    numbers: Option<Format>,
    files: &Files,
) -> Result<Deflections> {
    let (name, interpolation) = (field.text()?, Interpolation::Linear);
    let wrong = |(kind, message, cure): Problem| field.error(kind, message).help(cure);
    if !is_text(name) {
        let (time, axes, precision) = (Vec::new(), vec![Vec::new(); axes.len()], Vec::new());
        return Ok(Deflections { time, axes, precision, log: Some(files.beside(name).map_err(wrong)?), interpolation });
    }
    let log = Log::open(name, None, numbers, files).map_err(wrong)?;
    let mut deflections = Vec::new();
    let mut found = false;
    for axis in axes {
        let of_a_stick = format!("stick.{axis}");
        let names = [of_a_stick.as_str(), axis];
        let values = log.column(&names, None, &NUMBER.quantity()).map_err(wrong)?;
        found |= values.is_some();
        let values = values.unwrap_or_else(|| vec![0.0; log.time.len()]);
        check_range(field, &values)?;
        deflections.push(values);
    }
    if !found {
        let what = if mode == StickMode::Tip { "stick axis" } else { "lever" };
        return Err(wrong(log.without_columns(axes.iter().copied(), what)));
    }
    let names = ["stick.precision", PRECISION];
    let precision = log.column(&names, None, &NUMBER.quantity()).map_err(wrong)?.unwrap_or_default();
    check_shares(field, &precision)?;
    log.tell(field);
    Ok(Deflections { time: log.time, axes: deflections, precision, log: None, interpolation })
}

/// Rounding error by which a deflection may exceed its end; it counts as the end.
const ROUNDING: f64 = 1e-9;

fn check_range(field: &Field, values: &[f64]) -> Result<()> {
    match values.iter().find(|value| value.abs() > 1.0 + ROUNDING) {
        Some(value) => Err(field
            .error(ErrorKind::OutOfRange, format!("a deflection of {value} is beyond the end of the stick"))
            .help("give shares from -1 to 1; `full-speed` is the speed at 1")),
        None => Ok(()),
    }
}
