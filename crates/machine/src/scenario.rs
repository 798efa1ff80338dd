//! Scenario files: machine, start, inputs and duration of a run.

mod burst;
mod closed_loop;
mod command;
mod goal;
mod initial;
mod log;
mod phase;
mod sensor_fault;
mod stage;
mod stated;
mod supply;
mod value;
mod written;

pub use burst::{burst_fault, burst_times, tighten, with_hoses, without_hoses, Burst, BurstEntry, Side};
pub use closed_loop::{ControllerChoice, Joystick, SensorQuality, StickMode};
pub use command::SpoolCommand;
pub use goal::Goal;
pub use initial::{Initial, Pressures};
pub use phase::Phase;
pub use sensor_fault::{FaultKind, SensorFault};
pub use stage::Stage;
pub use stated::{contradiction, stated, Stated};
pub use supply::SupplyPressure;
pub use value::{check_quantity, choices};
pub use written::Unwritable;

use crate::errors::{ErrorKind, MachineError};
use crate::keys;
use crate::load::{self, is_path, Source};
use crate::model::{Machine, Unusual};
use crate::nearest::suggestion;
use crate::reading::reader::{Field, Log, Reader};
use crate::text::bundled::{bundled_machines, bundled_scenarios};
use crate::text::document::{self, Node, NodeKind};
use crate::text::merge::{apply_override, override_value, Override, OverrideValue};

use hydrocrane_logs::Format;
use log::Files;
pub use log::LOGS;

type Result<T> = std::result::Result<T, MachineError>;

/// A simulation to run; SI throughout.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    pub name: String,
    pub title: String,
    /// Bundled name or path of the machine.
    pub machine: String,
    /// Overrides of the machine's values, by dotted key.
    pub overrides: Vec<(String, OverrideValue)>,
    pub load: Load,
    pub duration: f64,
    pub record_interval: f64,
    pub initial: Initial,
    pub commands: Vec<SpoolCommand>,
    /// `None`: that of the machine.
    pub supply: Option<SupplyPressure>,
    /// The machine's cylinders, which are the axes of lever control.
    pub cylinders: Vec<String>,
    pub controller: Option<ControllerChoice>,
    pub joystick: Option<Joystick>,
    /// Goals of the tip, in order of time.
    pub goals: Vec<Goal>,
    /// Changes during the run, in order of time; phases after the duration have no effect.
    pub phases: Vec<Phase>,
    pub faults: Faults,
    pub solver: Solver,
    pub seed: u64,
    pub recorded: Recorded,
    /// Allowed but unusual values of the file, in the order in which they are read.
    pub warnings: Vec<Unusual>,
}

/// The load at the tip.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Load {
    /// Point mass at the start, kg; `None`: the machine's.
    pub payload: Option<f64>,
    /// Payload from a time (s) on, kg: loads picked up and released.
    pub changes: Vec<(f64, f64)>,
}

/// What fails during the run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Faults {
    pub sensors: Vec<SensorFault>,
    /// Hoses that burst.
    pub bursts: Vec<Burst>,
}

/// Origin of a drive of the cockpit.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Recorded {
    /// Version of hydrocrane that recorded it.
    pub by: Option<String>,
    /// [`Machine::contents`] of the file that it was recorded on; the machine must have the same.
    pub on: Option<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interpolation {
    /// The value holds until the next time.
    Hold,
    Linear,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Solver {
    /// [`AUTO`] or the name of a method.
    pub method: String,
    pub rtol: f64,
    /// Absolute tolerance relative to each state's scale; `None`: chosen from `rtol`.
    pub atol: Option<f64>,
    pub max_step: f64,
    /// Longest fixed step, s; `None`: steps follow from the tolerances.
    pub step: Option<f64>,
}

/// Meanings of the choices of `interpolation`.
const INTERPOLATIONS: [Interpolation; 2] = [Interpolation::Hold, Interpolation::Linear];
const NUMBER_FORMATS: [Format; 2] = [Format::Point, Format::Comma];
pub use crate::keys::METHODS;

/// In place of a method: the fastest suitable one for the machine.
pub const AUTO: &str = "auto";
/// The method of [`AUTO`] for fixed steps where `hc-exponential-4` does not suit.
pub const FIXED_STEPS: &str = "hc-rosenbrock-3";

/// Loads the scenario `source`, a bundled name or a path, with `overrides` by dotted key in place of its values.
/// Names and units are checked against its machine.
///
/// # Errors
/// The first problem met, with its place and cure.
pub fn load_scenario(source: &str, overrides: &[(String, OverrideValue)]) -> Result<Scenario> {
    build(&load::open(source, "scenario", bundled_scenarios())?, overrides, &[])
}

/// As [`load_scenario`], for text in memory; `origin` is what errors call it.
///
/// # Errors
/// The first problem met, with its place and cure.
pub fn parse_scenario(text: &str, origin: &str, overrides: &[(String, OverrideValue)]) -> Result<Scenario> {
    build(&load::in_memory(text, origin, &[]), overrides, &[])
}

/// As [`parse_scenario`], with the names and texts of the `files` that the scenario names: its machine, what this extends
/// and includes, and its logs.
///
/// # Errors
/// The first problem met, with its place and cure.
pub fn parse_scenario_with(text: &str, origin: &str, files: &[(String, String)]) -> Result<Scenario> {
    build(&load::in_memory(text, origin, &[]), &[], files)
}

/// Source of a scenario's machine.
struct MachineSource<'a> {
    /// Bundled name or path.
    name: String,
    /// Files in place of those on disk; `None`: the scenario lies there itself.
    given: Option<&'a [(String, String)]>,
}

impl MachineSource<'_> {
    fn load(&self, overrides: &[Override]) -> Result<Machine> {
        match self.given.filter(|_| is_path(&self.name)) {
            Some(files) => load::load_given(&self.name, files, overrides),
            None => load::load_with(&self.name, overrides),
        }
    }

    /// Whether there is such a machine.
    fn open(&self) -> Result<Source> {
        match self.given.filter(|_| is_path(&self.name)) {
            Some(files) => load::open_given(&self.name, files),
            None => load::open(&self.name, "machine", bundled_machines()),
        }
    }
}

fn build(source: &Source, overrides: &[(String, OverrideValue)], given: &[(String, String)]) -> Result<Scenario> {
    let mut tree = document::parse(&source.file)?;
    let tables = tree.entries().unwrap_or_default();
    let of_a_machine = |key: &str| ["machine", "link", "extends", "include"].contains(&key);
    if let Some(entry) =
        tables.iter().find(|e| of_a_machine(&e.key)).filter(|_| tables.iter().all(|e| e.key != "scenario"))
    {
        let message = "this is a machine file, but a scenario is expected";
        return Err(entry.place.error(ErrorKind::WrongKindOfFile, &entry.key, message).help(load::FOR_A_MACHINE));
    }
    for change in load::placed(overrides) {
        apply_override(&mut tree, &change)?;
    }
    // A scenario describes no machine, so its values have no provenance.
    let log = Log::new(false);
    let root = Reader::root(&tree, keys::SCENARIO, &log)?;
    let Some(head) = root.table("scenario")? else {
        return Err(root.missing("scenario", "add the table [scenario]"));
    };
    let machine_overrides = overrides_in(&root, "overrides")?;
    let name = machine_source(source, head.text("machine")?);
    let files = Files { folder: source.folder.as_deref(), given };
    let machine_source = MachineSource { name, given: source.folder.is_none().then_some(given) };
    let machine = machine(&head, &machine_source, &machine_overrides)?;
    let payload = head.optional_quantity("payload")?;
    let joystick = closed_loop::joystick(&root, &machine, &files)?;
    let controller = closed_loop::controller(&root, joystick.as_ref(), &machine_source, &machine_overrides)?;
    agree(&root, payload, controller.as_ref(), joystick.as_ref(), &machine_overrides)?;
    let (controller_before, joystick_before) = (controller.clone(), joystick.clone());
    let overrides = plain(machine_overrides.clone());
    let start = Stage { from: 0.0, overrides, controller: controller_before, joystick: joystick_before };
    let phases = phase::read(&root, &machine, &files, &machine_source, start.clone(), machine_overrides.clone())?;
    let first_controller = start.first_controller(&phases);
    Ok(Scenario {
        name: head.name("name")?.into(),
        title: head.line("title")?.into(),
        machine: machine_source.name,
        overrides: plain(machine_overrides),
        load: Load { payload, changes: payload_changes(&root)? },
        duration: head.quantity("duration")?,
        record_interval: head.quantity_or_default("record-interval")?,
        initial: initial::read(&root, &machine)?,
        commands: command::read(&root, &machine, &files)?,
        supply: supply::read(&root, &machine, &files)?,
        cylinders: machine.cylinders.iter().map(|cylinder| cylinder.name.clone()).collect(),
        faults: Faults {
            sensors: sensor_fault::read(&root, &machine, first_controller.as_ref())?,
            bursts: burst::read(&root, &machine)?,
        },
        controller,
        joystick,
        goals: goal::read(&root)?,
        phases,
        solver: solver(&root)?,
        seed: seed(&head)?,
        recorded: Recorded { by: optional_text(&head, "recorded-by")?, on: optional_text(&head, "recorded-on")? },
        warnings: log.unusual(),
    })
}

fn optional_text(table: &Reader, key: &str) -> Result<Option<String>> {
    table.optional(key)?.map(|field| field.text().map(str::to_string)).transpose()
}

/// Checks that values in `root` that replace those of the machine agree with the `overrides`.
fn agree(
    root: &Reader,
    payload: Option<f64>,
    choice: Option<&ControllerChoice>,
    stick: Option<&Joystick>,
    overrides: &[Override],
) -> Result<()> {
    let (name, period) = (choice.map(|choice| choice.name.as_str()), choice.and_then(|choice| choice.period));
    for Stated { table, field, value, unit, key } in stated(payload, name, period, stick.and_then(|s| s.full_speed)) {
        let Some(table) = root.names(table)?.filter(|table| table.has(field)) else { continue };
        let other = overrides.iter().find(|change| change.key == key);
        let wrong = other.and_then(|other| contradiction(&OverrideValue::Number(value), unit, &key, &other.value));
        if let Some(message) = wrong {
            return Err(table.error(ErrorKind::ConflictingKeys, field, message).help("leave one out"));
        }
    }
    Ok(())
}

/// A path is taken relative to the scenario file.
fn machine_source(source: &Source, name: &str) -> String {
    match &source.folder {
        Some(folder) if is_path(name) => folder.join(name).display().to_string(),
        _ => name.into(),
    }
}

/// The machine, for its names. An error inside its own file keeps its place there; a wrong name is reported here.
fn machine(head: &Reader, source: &MachineSource, overrides: &[Override]) -> Result<Machine> {
    let place = head.required("machine", "the name of a machine")?;
    let named = place.text()?;
    load::check_path(named)
        .and_then(|()| source.open())
        .map_err(|error| load::relocate(&error, place.place, "scenario.machine"))?;
    if let Some(recorded) = head.optional("recorded-on")? {
        let found = source.load(&[])?.contents();
        if recorded.text()? != found {
            let message = format!("the drive was recorded on another `{}` than this one, `{found}`", source.name);
            let cure = "give the file as it was, or leave `recorded-on` out to drive this one with the same sticks";
            return Err(recorded.error(ErrorKind::ConflictingKeys, message).help(cure));
        }
    }
    source.load(overrides)
}

/// The overrides of a machine in the sub-table `name`.
fn overrides_in(parent: &Reader, name: &str) -> Result<Vec<Override>> {
    let mut overrides = Vec::new();
    if let Some(table) = parent.names(name)? {
        for (key, node) in table.nodes() {
            flatten(&table.path, key, node, &mut overrides)?;
        }
    }
    Ok(overrides)
}

fn plain(overrides: Vec<Override>) -> Vec<(String, OverrideValue)> {
    overrides.into_iter().map(|change| (change.key, change.value)).collect()
}

/// `"supply.pressure" = ...` and `supply.pressure = ...` both name the key `supply.pressure`.
fn flatten(table: &str, key: &str, node: &Node, overrides: &mut Vec<Override>) -> Result<()> {
    match &node.kind {
        NodeKind::Table(entries) => entries
            .iter()
            .try_for_each(|entry| flatten(table, &document::join(key, &entry.key), &entry.node, overrides)),
        NodeKind::Value { value, .. } => {
            let value = override_value(value).ok_or_else(|| {
                let found = format!("expected a value, found {}", value.kind_name());
                node.place.error(ErrorKind::WrongType, &document::join(table, key), found).help("put it in quotes")
            })?;
            overrides.push(Override { key: key.into(), value, place: node.place.clone() });
            Ok(())
        }
    }
}

/// Loads picked up and released: the payload from each time on.
fn payload_changes(root: &Reader) -> Result<Vec<(f64, f64)>> {
    let Some(table) = root.table("payload")? else { return Ok(Vec::new()) };
    let time_field = table.required("time", "a list of times, for example [\"2 s\", \"6 s\"]")?;
    let mass_field = table.required("mass", "a list of masses, for example [\"100 kg\", \"0 kg\"]")?;
    let (times, masses) = (time_field.series()?, mass_field.series()?);
    check_series(&times, &masses, &time_field, &mass_field)?;
    if times[0] <= 0.0 {
        let message = format!("the payload cannot change at {} s, before the run has begun", times[0]);
        let help = "give times above zero; the payload at the start is `scenario.payload`";
        return Err(time_field.error(ErrorKind::OutOfRange, message).help(help));
    }
    match masses.iter().find(|mass| **mass < 0.0) {
        Some(mass) => Err(mass_field
            .error(ErrorKind::OutOfRange, format!("a payload of {mass} kg"))
            .help("give masses of zero or more")),
        None => Ok(times.into_iter().zip(masses).collect()),
    }
}

fn known_name<'n>(
    table: &Reader,
    name: &str,
    what: &str,
    mut names: impl Iterator<Item = &'n str> + Clone,
) -> Result<usize> {
    let all = names.clone();
    names.position(|known| known == name).ok_or_else(|| {
        let message = format!("the machine has no {what} `{name}`");
        table.key_error(ErrorKind::UnknownReference, name, message).help(suggestion(name, all))
    })
}

fn known_cylinder(table: &Reader, name: &str, machine: &Machine) -> Result<usize> {
    known_name(table, name, "cylinder", machine.cylinders.iter().map(|cylinder| cylinder.name.as_str()))
}

fn check_series(at: &[f64], values: &[f64], time: &Field, series: &Field) -> Result<()> {
    let [times, values] = [at.len(), values.len()];
    if times != values {
        let message = format!("{values} values for {times} times");
        return Err(series.error(ErrorKind::BadSeries, message).help("give one value for each time"));
    }
    if times == 0 {
        return Err(time.error(ErrorKind::BadSeries, "the series is empty").help("give at least one time and value"));
    }
    match at.windows(2).find(|pair| pair[1] <= pair[0]) {
        Some(pair) => {
            let message = format!("the times do not increase: {} s follows {} s", pair[1], pair[0]);
            Err(time.error(ErrorKind::BadSeries, message).help("sort the times, each once"))
        }
        None => Ok(()),
    }
}

fn solver(root: &Reader) -> Result<Solver> {
    let table = root.table_or_empty("solver")?;
    let method = table.choice_or_default("method", table.choices("method"))?;
    Ok(Solver {
        method: method.into(),
        step: table.optional_quantity("step")?,
        rtol: table.quantity_or_default("rtol")?,
        atol: table.optional_quantity("atol")?,
        max_step: table.quantity_or_default("max-step")?,
    })
}

/// Seeds are integers that a double represents exactly.
pub const MOST_SEED: u64 = 1 << 53;

fn seed(head: &Reader) -> Result<u64> {
    let seed: f64 = head.quantity_or_default("seed")?;
    if seed.fract() == 0.0 && seed <= MOST_SEED as f64 {
        return Ok(seed as u64);
    }
    Err(head.error(ErrorKind::OutOfRange, "seed", "must be a whole number up to 2^53").help("give for example 1"))
}
