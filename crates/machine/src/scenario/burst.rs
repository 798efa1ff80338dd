//! `[burst.<name>]` of a scenario: hoses that burst.
//!
//! A hose that bursts is a leak of the machine (`[hose-leak]`) whose opening is zero until then, so that all states of a run and all
//! that is recorded are the same before and after.

use super::{check_quantity, Result, Scenario, Stage};
use crate::errors::ErrorKind;
use crate::model::Machine;
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::on_a_side;
use crate::text::merge::OverrideValue;

/// A hose that bursts.
#[derive(Debug, Clone, PartialEq)]
pub struct Burst {
    /// Name of the cylinder to which it leads.
    pub cylinder: String,
    pub side: Side,
    /// s
    pub time: f64,
    /// Area of the hole, m^2.
    pub opening: f64,
}

/// A side of a cylinder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    Piston,
    Rod,
}

impl Side {
    pub fn name(self) -> &'static str {
        match self {
            Side::Piston => "piston-side",
            Side::Rod => "rod-side",
        }
    }

    /// The side with this name.
    pub fn named(name: &str) -> Option<Self> {
        [Side::Piston, Side::Rod].into_iter().find(|side| side.name() == name)
    }
}

/// Cylinder, side, time (s) and opening (m^2), as other languages hand a [`Burst`] over.
pub type BurstEntry = (String, String, f64, f64);

impl Burst {
    /// From an entry; the error says what is wrong with it.
    pub fn of((cylinder, side, time, opening): &BurstEntry) -> std::result::Result<Self, String> {
        let unknown = || format!("a hose leads to the `piston-side` or the `rod-side`, not `{side}`");
        let burst = Burst {
            cylinder: cylinder.clone(),
            side: Side::named(side).ok_or_else(unknown)?,
            time: *time,
            opening: *opening,
        };
        for (key, value) in [("burst.<name>.time", burst.time), ("burst.<name>.opening", burst.opening)] {
            check_quantity(key, value).map_err(|error| error.message().to_string())?;
        }
        Ok(burst)
    }

    pub fn entry(&self) -> BurstEntry {
        (self.cylinder.clone(), self.side.name().into(), self.time, self.opening)
    }

    /// The leak of the machine that stands for it, and that of its opening at the time `t` (s), by dotted key.
    fn overrides(&self, t: f64) -> [(String, OverrideValue); 3] {
        let of = |key: &str| format!("hose-leak.burst-{}-{}.{key}", self.cylinder, self.side.name());
        let opening = if self.time <= t { self.opening } else { 0.0 };
        [
            (of("cylinder"), OverrideValue::Text(self.cylinder.clone())),
            (of("side"), OverrideValue::Text(self.side.name().into())),
            (of("opening"), OverrideValue::Number(opening)),
        ]
    }
}

/// Times of `bursts` after `from` and before `until` (s), ascending, each once.
pub fn burst_times(bursts: &[Burst], from: f64, until: f64) -> Vec<f64> {
    let next = |from: f64| {
        let later = bursts.iter().map(|burst| burst.time).filter(|time| *time > from && *time < until);
        later.reduce(f64::min)
    };
    std::iter::successors(next(from), |time| next(*time)).collect()
}

/// Overrides of a machine, with its hoses as they are at the time `t` (s).
pub fn with_hoses(bursts: &[Burst], overrides: Vec<(String, OverrideValue)>, t: f64) -> Vec<(String, OverrideValue)> {
    let mut all = without_hoses(bursts, overrides);
    all.extend(bursts.iter().flat_map(|burst| burst.overrides(t)));
    all
}

/// Overrides of a machine but those of [`with_hoses`].
pub fn without_hoses(bursts: &[Burst], mut overrides: Vec<(String, OverrideValue)>) -> Vec<(String, OverrideValue)> {
    let hoses: Vec<_> = bursts.iter().flat_map(|burst| burst.overrides(0.0)).collect();
    overrides.retain(|(key, _)| hoses.iter().all(|(own, _)| own != key));
    overrides
}

/// Makes those hoses of a machine tight that have not burst at the time `t` (s).
pub fn tighten<T: Number>(bursts: &[Burst], machine: &mut Machine<T>, t: f64) {
    for burst in bursts.iter().filter(|burst| burst.time > t) {
        let to_it = machine.cylinders.iter_mut().find(|cylinder| cylinder.name == burst.cylinder);
        if let Some(leak) = to_it.and_then(|cylinder| cylinder.ports.leaks[burst.side as usize].as_mut()) {
            leak.opening = T::c(0.0);
        }
    }
}

/// Index of the first of `bursts` whose hose has burst before, with what is wrong and the cure.
pub fn burst_fault(bursts: &[Burst]) -> Option<(usize, String, &'static str)> {
    let again = |i: &usize| {
        bursts[..*i].iter().any(|other| (&other.cylinder, other.side) == (&bursts[*i].cylinder, bursts[*i].side))
    };
    let i = (0..bursts.len()).find(again)?;
    let (side, cylinder) = (bursts[i].side.name(), &bursts[i].cylinder);
    Some((i, format!("the hose to the {side} of cylinder `{cylinder}` bursts twice"), "keep one of the two"))
}

impl Scenario {
    /// The stage on a machine with the hoses as they are when it begins.
    pub fn with_hoses(&self, mut stage: Stage) -> Stage {
        stage.overrides = with_hoses(&self.faults.bursts, stage.overrides, stage.from);
        stage
    }
}

/// The hoses that burst.
pub fn read(root: &Reader, machine: &Machine) -> Result<Vec<Burst>> {
    let tables = root.named_tables("burst")?;
    let bursts = tables.iter().map(|(_, table)| one(table, machine)).collect::<Result<Vec<_>>>()?;
    match burst_fault(&bursts) {
        Some((i, message, cure)) => Err(tables[i].1.error(ErrorKind::NotOneToOne, "side", message).help(cure)),
        None => Ok(bursts),
    }
}

fn one(table: &Reader, machine: &Machine) -> Result<Burst> {
    let (cylinder, side) = on_a_side::find(table, &machine.cylinders)?;
    let cylinder = &machine.cylinders[cylinder];
    let burst = Burst {
        cylinder: cylinder.name.clone(),
        side: [Side::Piston, Side::Rod][side],
        time: table.quantity("time")?,
        opening: table.quantity("opening")?,
    };
    if cylinder.ports.leaks[side].is_none() {
        return Ok(burst);
    }
    let message = format!("the machine has a leak in this hose of cylinder `{}` already", burst.cylinder);
    let cure = "leave [hose-leak] out of the machine, or the burst";
    Err(table.error(ErrorKind::NotOneToOne, "side", message).help(cure))
}
