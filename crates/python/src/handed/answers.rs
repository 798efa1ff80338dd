//! Outcomes and warnings as Python gets them.

use hydrocrane_sim::{Outcome, Warning};

/// Kind, text, cure, time and key of each.
pub type WarningEntry = (&'static str, String, String, f64, Option<String>);

pub fn warnings_of(warnings: Vec<Warning>) -> Vec<WarningEntry> {
    warnings.into_iter().map(|w| (w.kind, w.text, w.cure, w.time, w.key)).collect()
}

/// Kind, time and message.
pub fn outcome_of(outcome: Outcome) -> (&'static str, f64, String) {
    (outcome.kind.name(), outcome.time, outcome.message)
}
