//! The energy ledger of a run: the terms of every cylinder, then the common ones, then the loads at the tip; and its audit.

use crate::event_loop::driven::Driven;
use crate::model::payload::PAYLOAD_TERMS;
use crate::model::Model;
use hydrocrane_machine::Machine;
use hydrocrane_ode::Stepper;
use hydrocrane_plant::cylinders::ledger::{shared_terms, terms, Term, LEDGER_PER_CYLINDER, LEDGER_TERMS};
use hydrocrane_plant::equations::outputs::energies;

/// Time between two audits, s.
const INTERVAL: f64 = 0.5;
/// Allowed residual, as a share of the energy that flowed.
const SHARE: f64 = 0.01;
/// Least energy for an audit, as a share of the supply energy of one stroke of all pistons.
const FLOOR: f64 = 1e-4;

/// Every term in the order of a run's columns, each with its part of the machine.
pub fn ledger_terms(machine: &Machine) -> Vec<(&str, &'static Term)> {
    terms(machine).into_iter().chain(PAYLOAD_TERMS.iter().map(|term| ("payload", term))).collect()
}

/// The terms, summed over all cylinders, in the order of [`ledger_totals`].
pub fn total_terms(machine: &Machine) -> impl Iterator<Item = &'static Term> {
    let shared = shared_terms(machine).into_iter().map(|(_, term)| term);
    LEDGER_TERMS.iter().chain(shared).chain(&PAYLOAD_TERMS)
}

/// The `energies` of [`ledger_terms`], those of all cylinders added up.
pub fn ledger_totals(energies: &[f64], cylinders: usize) -> Vec<f64> {
    let (own, shared) = energies.split_at(cylinders * LEDGER_PER_CYLINDER);
    let total = |term: usize| own.iter().skip(term).step_by(LEDGER_PER_CYLINDER).sum();
    (0..LEDGER_PER_CYLINDER).map(total).chain(shared.iter().copied()).collect()
}

/// The ledger against the energies stored.
pub struct Audit {
    /// Stored energy at the start, with the changes by phases with another machine, J.
    start: f64,
    next: f64,
    floor: f64,
    outputs: Vec<f64>,
}

impl Audit {
    /// From the state of `stepper` on; `None` without a ledger.
    pub fn begin(stepper: &Stepper, driven: &Driven) -> Option<Self> {
        if stepper.integrals().is_empty() {
            return None;
        }
        let machine = driven.model.machine();
        let mut outputs = vec![0.0; driven.model.output_info().len()];
        let start = stored(driven.model, driven.payload, stepper, &mut outputs);
        let volume: f64 = machine.cylinders.iter().map(|c| c.areas()[0] * c.stroke).sum();
        Some(Audit { start, next: INTERVAL, floor: FLOOR * volume * machine.supply.pressure, outputs })
    }

    /// Time of the next audit, s.
    pub fn next(&self) -> f64 {
        self.next
    }

    /// The values of the machine have changed from `before` to those of `driven`.
    pub fn follow(&mut self, before: &dyn Model, driven: &Driven, stepper: &Stepper) {
        let mut of = |model| stored(model, driven.payload, stepper, &mut self.outputs);
        self.start += of(driven.model) - of(before);
    }

    /// The share of the energy that flowed which is unaccounted for, if it is more than is allowed.
    pub fn open(&mut self, stepper: &Stepper, driven: &Driven) -> Option<f64> {
        self.next = stepper.t + INTERVAL;
        let gained = stored(driven.model, driven.payload, stepper, &mut self.outputs) - self.start;
        let energies = stepper.integrals().iter().chain(&driven.loads.account);
        let (mut balance, mut flowed) = (0.0, 0.0);
        for (energy, (_, (_, _, sign))) in energies.zip(ledger_terms(driven.model.machine())) {
            balance += sign * energy;
            flowed += (sign * energy).abs();
        }
        // Energy that flows in flows out or is stored, so half of the sum has flowed.
        let open = (gained - balance).abs() / (0.5 * (flowed + gained.abs())).max(self.floor / SHARE);
        (open > SHARE || open.is_nan()).then_some(open)
    }
}

/// Energy stored in crane and oil, J.
fn stored(model: &dyn Model, payload: f64, stepper: &Stepper, outputs: &mut [f64]) -> f64 {
    model.outputs(&stepper.x, payload, outputs);
    outputs[energies(model.machine())].iter().sum()
}
