//! `[burst.<name>]` of a scenario: hoses that burst.
//!
//! A hose that bursts is a leak of the machine (`[hose-leak]`) whose opening is zero until then, so that all states of a run and all
//! that is recorded are the same before and after.

use super::{Result, Scenario, Stage};
use crate::errors::ErrorKind;
use crate::merge::OverrideValue;
use crate::model::Machine;
use crate::reader::Reader;
use crate::sections::on_a_side;

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

impl Burst {
    /// The leak of the machine that stands for it, and that of its opening at the time `t` (s), by dotted key.
    fn overrides(&self, t: f64) -> [(String, OverrideValue); 3] {
        let of = |key: &str| format!("hose-leak.{}-{}.{key}", self.cylinder, self.side.name());
        let opening = if self.time <= t { self.opening } else { 0.0 };
        [
            (of("cylinder"), OverrideValue::Text(self.cylinder.clone())),
            (of("side"), OverrideValue::Text(self.side.name().into())),
            (of("opening"), OverrideValue::Number(opening)),
        ]
    }
}

impl Scenario {
    /// Times of the bursts after `from` and before `until` (s), ascending, each once.
    pub fn burst_times(&self, from: f64, until: f64) -> Vec<f64> {
        let next = |from: f64| {
            let later = self.bursts.iter().map(|burst| burst.time).filter(|time| *time > from && *time < until);
            later.reduce(f64::min)
        };
        std::iter::successors(next(from), |time| next(*time)).collect()
    }

    /// The stage on a machine with the hoses as they are when it begins.
    pub fn with_hoses(&self, mut stage: Stage) -> Stage {
        let hoses: Vec<_> = self.bursts.iter().flat_map(|burst| burst.overrides(stage.from)).collect();
        stage.overrides.retain(|(key, _)| hoses.iter().all(|(own, _)| own != key));
        stage.overrides.extend(hoses);
        stage
    }
}

/// The hoses that burst.
pub fn read(root: &Reader, machine: &Machine) -> Result<Vec<Burst>> {
    let mut bursts: Vec<Burst> = Vec::new();
    for (_, table) in root.named_tables("burst")? {
        let (cylinder, side) = on_a_side::find(&table, &machine.cylinders)?;
        let burst = Burst {
            cylinder: machine.cylinders[cylinder].name.clone(),
            side: [Side::Piston, Side::Rod][side],
            time: table.quantity("time")?,
            opening: table.quantity("opening")?,
        };
        let refused =
            |message: String, cure: &str| Err(table.error(ErrorKind::NotOneToOne, "side", message).help(cure));
        if machine.cylinders[cylinder].leaks[side].is_some() {
            let message = format!("the machine has a leak in this hose of cylinder `{}` already", burst.cylinder);
            return refused(message, "leave [hose-leak] out of the machine, or the burst");
        }
        if bursts.iter().any(|other| (&other.cylinder, other.side) == (&burst.cylinder, burst.side)) {
            let message = format!("this hose of cylinder `{}` bursts twice", burst.cylinder);
            return refused(message, "keep one of the two");
        }
        bursts.push(burst);
    }
    Ok(bursts)
}
