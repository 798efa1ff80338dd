//! The energy ledger of a run: the terms of every cylinder, then the common ones, then the loads at the tip.

use crate::model::payload::PAYLOAD_TERMS;
use hydrocrane_machine::Machine;
use hydrocrane_plant::cylinders::ledger::{shared_terms, terms, Term, LEDGER_PER_CYLINDER, LEDGER_TERMS};

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
