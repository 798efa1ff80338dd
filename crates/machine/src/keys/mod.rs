//! Every key of machine and scenario files, declared once.
//!
//! The reader asks by these declarations ([`crate::reading::reader`]), values are judged by their usual ranges
//! ([`crate::reading::plausible`]), and the schema for editors and the tables of the reference page are made from them
//! (`crate::schema`, with the feature `schema`).

mod circuit;
mod control;
mod hydraulics;
mod scenario;
mod sensor;
mod structure;

pub use control::{CONTROLLERS, PLAUSIBILITY};
pub use scenario::{LEVER, METHODS, SCENARIO, TIP_AXES};

use crate::units::quantities::{Kind, ACCELERATION, ANGLE};
use crate::units::{self, Dimension, Quantity};

/// Everything that may stand at the top of a machine file.
pub static MACHINE: &[Key] = &[
    Key::text("extends")
        .otherwise("none")
        .means("Bundled name or path of the file that this one changes; tables merge key by key."),
    Key::new("without", Value::Texts(&[]))
        .otherwise("none")
        .means("Dotted keys and tables of the extended file that this one does not take over."),
    Key::new("include", Value::Texts(&[])).otherwise("none").means(
        "Files, by paths from here, whose tables override those of this file; later files override earlier ones.",
    ),
    Key::table("machine", HEAD).required().means("Name of the machine, and its tip."),
    Key::table("environment", ENVIRONMENT).required().means("Gravity, and the slope of the ground."),
    Key::tables("link", structure::LINK).required().means("A link: its points, its mass and the bodies fixed on it."),
    Key::tables("joint", structure::JOINT).required().means("A joint between two links; the joints form one chain."),
    Key::tables("cylinder", hydraulics::CYLINDER).required().means("A double-acting cylinder; exactly one per joint."),
    Key::tables("valve", hydraulics::VALVE).required().means("The valve of a cylinder; exactly one per cylinder."),
    Key::tables("counterbalance", circuit::COUNTERBALANCE)
        .otherwise("none")
        .means("A counterbalance valve on one side of a cylinder: it holds the load and lowers it when the other side is fed.")
        .source("theory/hydraulics/counterbalance.md"),
    Key::tables("pilot-check", circuit::PILOT_CHECK)
        .otherwise("none")
        .means("A pilot-operated check valve on one side of a cylinder: it holds the load until the other side is fed.")
        .source("theory/hydraulics/pilot_check.md"),
    Key::tables("hose-burst", circuit::HOSE_BURST)
        .otherwise("none")
        .means("A hose-burst valve on one side of a cylinder: it closes where more would flow out than it is set to.")
        .source("theory/hydraulics/hose_burst.md"),
    Key::tables("line", circuit::LINE)
        .otherwise("the dead volume of the cylinder stands for it")
        .means("A hose or pipe between the valve and one side of a cylinder.")
        .source("theory/hydraulics/line.md"),
    Key::tables("hose-leak", circuit::HOSE_LEAK)
        .otherwise("tight; a scenario may let a hose burst")
        .means("A hole in the hose to one side of a cylinder, through which oil leaves to the outside.")
        .source("theory/hydraulics/hose_leak.md"),
    Key::tables("port-relief", circuit::PORT_RELIEF)
        .otherwise("none")
        .means("A relief (shock) valve from one side of a cylinder to the tank.")
        .source("theory/hydraulics/port_valves.md"),
    Key::tables("crossover-relief", circuit::CROSSOVER_RELIEF)
        .otherwise("none")
        .means("A cross-over relief valve from one side of a cylinder to the other one.")
        .source("theory/hydraulics/crossover_relief.md"),
    Key::tables("anti-cavitation", circuit::ANTI_CAVITATION)
        .otherwise("none")
        .means("A check valve from the tank to one side of a cylinder: it feeds a chamber that a load empties faster than the valve fills it.")
        .source("theory/hydraulics/port_valves.md"),
    Key::tables("friction", hydraulics::FRICTION)
        .required()
        .means("Seal friction of a cylinder; exactly one per cylinder."),
    Key::table("fluid", hydraulics::FLUID).required().means("The oil."),
    Key::table("supply", hydraulics::SUPPLY).required().means("Pressures of pump and tank."),
    Key::tables("pump", hydraulics::PUMP)
        .otherwise("a supply at constant pressure")
        .means("A pump that feeds the mains; up to three, of one type."),
    Key::table("mains", hydraulics::MAINS)
        .otherwise("required with a pump that is not `constant-pressure`")
        .means("The lines between pump and valves, with the main relief valve."),
    Key::tables("accumulator", circuit::ACCUMULATOR)
        .otherwise("none")
        .means("A gas accumulator on the mains; at most one.")
        .source("theory/hydraulics/accumulator.md"),
    Key::table("tank-line", circuit::TANK_LINE)
        .otherwise("what returns is at the pressure of the tank")
        .means("The line through which oil returns to the tank, with its filter; only with [mains].")
        .source("theory/hydraulics/tank_line.md"),
    Key::table("priority", circuit::PRIORITY)
        .otherwise("no section is served first")
        .means("The section that is served first when the pump cannot give what all ask for; only with a pump that senses the load.")
        .source("theory/hydraulics/priority.md"),
    Key::table("payload", structure::PAYLOAD).means("The load at the tip."),
    Key::table("equilibrium", hydraulics::EQUILIBRIUM).means("Pressures of a crane at rest."),
    Key::tables("sensor", sensor::SENSOR)
        .means("A sensor, for controllers with `sensors = \"data-sheet\"` and for `measure`."),
    Key::tables("keep-out", structure::KEEP_OUT).means("A region that controllers keep the tip out of."),
    Key::table("ground", structure::GROUND).means("The ground that carries the tip, or the load that hangs below it."),
    Key::table("control", control::CONTROL).means("The sample period, and the gains of each controller."),
    Key::table("errata", control::ERRATA).means("Which corrections of the thesis apply."),
];

static HEAD: &[Key] = &[
    Key::text("name").required().means("Name of the machine, used for files."),
    Key::text("title").otherwise("none").means("Title for charts and reports."),
    Key::text("description").otherwise("none").means("What the machine is."),
    Key::text("tip").required().means("The crane tip: a point of the last link, as `link.point`."),
];

static ENVIRONMENT: &[Key] = &[
    Key::quantity("gravity", &[ACCELERATION], Sign::NonNegative)
        .required()
        .usual(&[("1 m/s^2", "30 m/s^2", 100.0)])
        .means("Gravitational acceleration; along -z on level ground."),
    Key::quantity("slope", &[ANGLE], Sign::Any)
        .defaults(&["0 deg"])
        .usual(&[("0 deg", "30 deg", 100.0)])
        .means("Slope of the ground that the machine stands on, below 60 deg: positive with the front (+x) raised, so that gravity pulls towards -x. All places stay in the frame of the base, whose z is normal to that ground.")
        .source("theory/dynamics/equations_of_motion.md"),
];

/// The sign a value must have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sign {
    Any,
    NonNegative,
    Positive,
}

/// What a key holds. Where several kinds are listed, other values of the file decide which one it is; none means a unit
/// that other values decide.
#[derive(Debug)]
pub enum Value {
    Quantity(&'static [Kind], Sign),
    /// One value for both, or a list of two.
    Pair(&'static [Kind], Sign),
    /// A list of any length.
    Series(&'static [Kind]),
    Point,
    Points,
    Text,
    /// A list of texts, each one of these; of any where there are none.
    Texts(&'static [&'static str]),
    Choice(&'static [&'static str]),
    /// A table.
    Table(&'static [Key]),
    /// Tables with names of their own.
    Tables(&'static [Key]),
    /// Any key of the machine, with its value.
    Overrides,
}

#[cfg(feature = "schema")]
impl Value {
    /// Whether it is made of numbers with units, whose provenance is kept.
    pub fn is_of_quantities(&self) -> bool {
        matches!(self, Self::Quantity(..) | Self::Pair(..) | Self::Series(_) | Self::Point | Self::Points)
    }
}

/// The lowest and the highest usual magnitude, as they are written, and by which factor a value may lie outside before it
/// is refused. A range without a unit is in SI. Zero is always usual: where a key excludes it, its sign says so.
pub type Usual = (&'static str, &'static str, f64);

/// In place of a default where there is none.
const REQUIRED: &str = "required";

/// Text for people, left out of programs that show none.
#[cfg(feature = "schema")]
#[derive(Debug, Clone, Copy)]
pub struct Note(&'static str);

#[cfg(feature = "schema")]
impl Note {
    const fn new(text: &'static str) -> Self {
        Self(text)
    }

    pub fn text(self) -> &'static str {
        self.0
    }
}

#[cfg(not(feature = "schema"))]
#[derive(Debug, Clone, Copy)]
pub struct Note;

#[cfg(not(feature = "schema"))]
impl Note {
    const fn new(_: &'static str) -> Self {
        Self
    }
}

/// A key. A name in angle brackets, such as `<joint>`, stands for any name.
#[derive(Debug)]
#[cfg_attr(not(feature = "schema"), allow(dead_code))]
pub struct Key {
    pub name: &'static str,
    pub value: Value,
    /// What counts where the file does not have the key; of several the one of the value's dimension.
    pub defaults: &'static [&'static str],
    /// The same in words, where it is no value of its own; `required` where there is none.
    pub otherwise: Note,
    /// Of several ranges the one of the value's dimension counts.
    pub usual: &'static [Usual],
    pub means: Note,
    /// Where the law or value comes from: a page below `docs/theory`, or an equation of the thesis.
    pub source: Note,
}

impl Key {
    const fn new(name: &'static str, value: Value) -> Self {
        let none = Note::new("");
        Self { name, value, defaults: &[], otherwise: none, usual: &[], means: none, source: none }
    }

    const fn quantity(name: &'static str, kinds: &'static [Kind], sign: Sign) -> Self {
        Self::new(name, Value::Quantity(kinds, sign))
    }

    const fn pair(name: &'static str, kinds: &'static [Kind], sign: Sign) -> Self {
        Self::new(name, Value::Pair(kinds, sign))
    }

    const fn series(name: &'static str, kinds: &'static [Kind]) -> Self {
        Self::new(name, Value::Series(kinds))
    }

    const fn text(name: &'static str) -> Self {
        Self::new(name, Value::Text)
    }

    const fn choice(name: &'static str, choices: &'static [&'static str]) -> Self {
        Self::new(name, Value::Choice(choices))
    }

    const fn table(name: &'static str, keys: &'static [Key]) -> Self {
        Self::new(name, Value::Table(keys))
    }

    const fn tables(name: &'static str, keys: &'static [Key]) -> Self {
        Self::new(name, Value::Tables(keys))
    }

    const fn required(self) -> Self {
        self.otherwise(REQUIRED)
    }

    const fn otherwise(mut self, words: &'static str) -> Self {
        self.otherwise = Note::new(words);
        self
    }

    const fn defaults(mut self, texts: &'static [&'static str]) -> Self {
        self.defaults = texts;
        self
    }

    const fn usual(mut self, ranges: &'static [Usual]) -> Self {
        self.usual = ranges;
        self
    }

    const fn means(mut self, sentence: &'static str) -> Self {
        self.means = Note::new(sentence);
        self
    }

    const fn source(mut self, source: &'static str) -> Self {
        self.source = Note::new(source);
        self
    }
}

impl Key {
    /// Whether this declares keys of any name.
    pub fn is_for_any_name(&self) -> bool {
        self.name.starts_with('<')
    }

    #[cfg(feature = "schema")]
    pub fn is_required(&self) -> bool {
        self.otherwise.text() == REQUIRED
    }

    /// The kinds of quantity that it may hold.
    pub fn kinds(&self) -> &'static [Kind] {
        match &self.value {
            Value::Quantity(kinds, _) | Value::Pair(kinds, _) | Value::Series(kinds) => kinds,
            _ => &[],
        }
    }

    /// The quantity that it holds.
    pub fn kind(&self) -> Option<Kind> {
        self.kinds().first().copied()
    }

    /// Whether it may hold this quantity.
    pub fn allows(&self, quantity: &Quantity) -> bool {
        let kinds = self.kinds();
        kinds.is_empty() || kinds.iter().any(|kind| kind.quantity().dimension == quantity.dimension)
    }

    pub fn choices(&self) -> &'static [&'static str] {
        match self.value {
            Value::Choice(choices) | Value::Texts(choices) => choices,
            _ => &[],
        }
    }

    pub fn sign(&self) -> Sign {
        match self.value {
            Value::Quantity(_, sign) | Value::Pair(_, sign) => sign,
            _ => Sign::Any,
        }
    }

    /// The default of this dimension in SI.
    pub fn default_in(&self, dimension: Dimension) -> Option<f64> {
        let defaults = self.defaults.iter().map(|text| units::own_scalar(text));
        defaults.filter(|(_, unit)| unit.dimension == dimension).map(|(number, unit)| unit.to_si(number)).next()
    }
}

/// Declared default of a gain of a controller or a threshold of the sensor monitor, SI; `key` may name a table before a point.
pub fn default_gain(controller: &str, key: &str) -> Option<f64> {
    let (_, keys) = CONTROLLERS.into_iter().chain([PLAUSIBILITY]).find(|(name, _)| *name == controller)?;
    let (table, key) = key.split_once('.').unwrap_or(("", key));
    let own = match find(keys, table).map(|found| &found.value) {
        Some(Value::Table(own)) => own,
        _ => keys,
    };
    let declared = find(own, key)?;
    declared.default_in(declared.kind()?.quantity().dimension)
}

/// The declaration of `name` among `keys`.
pub fn find(keys: &'static [Key], name: &str) -> Option<&'static Key> {
    keys.iter().find(|key| key.name == name).or_else(|| keys.iter().find(|key| key.is_for_any_name()))
}

/// Which declarations the reader has asked for in this thread.
#[cfg(test)]
pub mod asked {
    use std::cell::RefCell;
    use std::collections::HashSet;

    thread_local! {
        static ASKED: RefCell<HashSet<*const super::Key>> = RefCell::default();
    }

    pub fn note(key: &'static super::Key) {
        ASKED.with_borrow_mut(|asked| asked.insert(std::ptr::from_ref(key)));
    }

    pub fn has(key: &'static super::Key) -> bool {
        ASKED.with_borrow(|asked| asked.contains(&std::ptr::from_ref(key)))
    }
}

#[cfg(test)]
mod tests;
