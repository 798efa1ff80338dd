//! A measured supply pressure: a state of the plant that the run prescribes.

use crate::inputs::options::RunOptions;
use crate::model::Model;
use crate::warning::Warning;
use hydrocrane_machine::scenario::{Scenario, SupplyPressure};
use hydrocrane_machine::Machine;
use hydrocrane_ode::Stepper;
use std::sync::Arc;

/// Rounding tolerance between a time of the pressure and the present time, s.
const ROUNDING: f64 = 1e-12;

/// The prescribed pressure of a run, if there is one.
#[derive(Debug, Clone, Default)]
pub(crate) struct Prescribed {
    course: Option<Arc<SupplyPressure>>,
    /// Index of its state.
    at: usize,
    pub now: RateAtHand,
}

/// Rate of the pressure.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct RateAtHand {
    /// Pa/s, constant until the time `next` (s).
    rate: f64,
    next: f64,
}

impl Prescribed {
    pub fn new(model: &dyn Model, options: &RunOptions) -> Self {
        let state = model.layout().mains().filter(|_| model.machine().supply.measured);
        match (state, &options.supply) {
            (Some(at), Some(course)) => Prescribed { course: Some(course.clone()), at, now: RateAtHand::default() },
            _ => Prescribed::default(),
        }
    }

    /// Time of the next change of the rate, s.
    pub fn next_time(&self) -> Option<f64> {
        self.course.as_ref().map(|_| self.now.next)
    }

    /// Sets the state to the pressure, and the rate, if a time of the series is due.
    pub fn follow(&mut self, stepper: &mut Stepper) {
        let due = |course: &&Arc<SupplyPressure>| !course.time.is_empty() && self.now.next <= stepper.t + ROUNDING;
        let Some(course) = self.course.as_ref().filter(due) else { return };
        let (pressure, rate) = course.at(stepper.t + ROUNDING);
        self.now = RateAtHand { rate, next: course.next_time(stepper.t + ROUNDING).unwrap_or(f64::INFINITY) };
        let held = &mut stepper.x[self.at];
        let jumps = (pressure - *held).abs() > JUMP;
        *held = pressure;
        if jumps {
            stepper.restart();
        } else {
            stepper.refresh();
        }
    }

    /// Writes the rate of the state.
    pub fn write(&self, dx: &mut [f64]) {
        if self.course.is_some() {
            dx[self.at] = self.now.rate;
        }
    }
}

/// Sets the pressure at time zero in the state `x`.
pub(crate) fn place(course: &SupplyPressure, model: &dyn Model, x: &mut [f64]) {
    if let Some(p) = model.layout().mains().filter(|_| model.machine().supply.measured) {
        x[p] = course.at(0.0).0;
    }
}

/// Warning on a pressure far from that of the machine: often another unit or column.
pub(crate) fn unusual(course: &SupplyPressure, machine: &Machine) -> Option<Warning> {
    let highest = course.pressure.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let wanted = machine.supply.pressure;
    (highest < USUAL[0] * wanted || highest > USUAL[1] * wanted).then(|| Warning {
        time: 0.0,
        kind: "implausible-value",
        key: None,
        text: format!(
            "the measured supply pressure is {:.4} bar at most, the machine states {:.4} bar",
            1e-5 * highest,
            1e-5 * wanted
        ),
        cure: "check its column and its unit (Pa if none is stated), or `supply.pressure` of the machine".into(),
    })
}

/// Warning on an additional constant supply pressure, for the start or for a phase.
pub(crate) fn overridden(scenario: &Scenario) -> Option<Warning> {
    let of_phases = scenario.phases.iter().map(|phase| (phase.time, &phase.overrides));
    let mut stated = std::iter::once((0.0, &scenario.overrides)).chain(of_phases);
    let (time, _) = stated.find(|(_, overrides)| overrides.iter().any(|(key, _)| key == "supply.pressure"))?;
    scenario.supply.as_ref().map(|_| Warning {
        time,
        kind: "override-without-effect",
        key: None,
        text: "`supply.pressure` is given, but the run follows a measured supply pressure".into(),
        cure: "omit one of the two; use `controller.model` for the value that a controller assumes".into(),
    })
}

/// Shares of the machine's supply pressure between which the highest of a measured one is expected.
const USUAL: [f64; 2] = [0.1, 3.0];
/// A smaller difference than this is rounding, Pa.
const JUMP: f64 = 1.0;

/// The reason if a machine cannot have a prescribed pressure.
pub(crate) fn fault(model: &dyn Model, options: &RunOptions) -> Option<String> {
    let fits = options.supply.is_none() || model.machine().supply.measured;
    (!fits).then(|| "a measured supply pressure needs a machine with `supply.measured` = \"yes\"".into())
}
