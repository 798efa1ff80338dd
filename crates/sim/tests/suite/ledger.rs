//! What tests ask of the energy ledger of a run.

use hydrocrane_sim::{ledger_terms, Model, Run};

/// Outputs of row `i`.
pub fn outputs(m: &dyn Model, run: &Run, i: usize) -> Vec<f64> {
    let (n, mut out) = (m.layout().len(), vec![0.0; m.output_info().len()]);
    m.outputs(&run.states[i * n..][..n], run.payloads[i], &mut out);
    out
}

/// Largest gap between what the states have gained and what the ledger explains, J.
pub fn gap(m: &dyn Model, run: &Run) -> f64 {
    let terms = ledger_terms(m.machine());
    assert_eq!(terms.len() * run.times.len(), run.ledger.len());
    let open = |i: usize| {
        let energies = m.output_info().iter().zip(outputs(m, run, i));
        let stored: f64 = energies.filter(|(o, _)| o.name.starts_with("energy.")).map(|(_, energy)| energy).sum();
        let row = &run.ledger[i * terms.len()..][..terms.len()];
        stored - row.iter().zip(&terms).map(|(energy, (_, (_, _, sign)))| energy * sign).sum::<f64>()
    };
    let first = open(0);
    (0..run.times.len()).map(|i| (open(i) - first).abs()).fold(0.0, f64::max)
}

/// Last value of a term, J: `lift.supply` of one part of the machine, `supply` of all that have it.
pub fn at_end(m: &dyn Model, run: &Run, name: &str) -> f64 {
    let terms = ledger_terms(m.machine());
    let last = &run.ledger[run.ledger.len() - terms.len()..];
    let found: Vec<f64> = terms
        .iter()
        .zip(last)
        .filter(|((of, (term, ..)), _)| format!("{of}.{term}") == name || *term == name)
        .map(|(_, energy)| *energy)
        .collect();
    assert!(!found.is_empty(), "no term {name}");
    found.iter().sum()
}
