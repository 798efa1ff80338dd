//! Options and results of a run.

use crate::model::payload::{PayloadChange, PayloadEvent};
use crate::model::Model;
use crate::outcome::Outcome;
use crate::warning::Warning;
use hydrocrane_machine::scenario::SupplyPressure;
use hydrocrane_ode::{Effort, StepControl, Tolerances};
use hydrocrane_plant::cylinders::ledger::{shared_terms, LEDGER_PER_CYLINDER};
use std::sync::Arc;

/// Spool commands against time: one row per time, one column per cylinder, m.
#[derive(Debug, Clone, Default)]
pub struct Commands {
    /// Ascending, s.
    pub times: Vec<f64>,
    /// Row-major, `times.len() x cylinders`.
    pub values: Vec<f64>,
    /// Whether commands are interpolated linearly instead of held.
    pub linear: bool,
}

#[derive(Debug, Clone)]
pub struct RunOptions {
    /// Name of a method in [`METHODS`].
    pub method: String,
    pub tolerances: Tolerances,
    pub control: StepControl,
    /// kg at the tip
    pub payload: f64,
    /// Loads picked up and released, in order of time.
    pub payload_changes: Vec<PayloadChange>,
    /// A measured supply pressure, for a machine that needs one.
    pub supply: Option<Arc<SupplyPressure>>,
    /// Whether the energy ledger is integrated.
    pub ledger: bool,
    /// Number of accepted steps after which a run ends.
    pub max_steps: u64,
}

impl RunOptions {
    /// Number of integrated energies.
    pub(crate) fn quadratures(&self, model: &dyn Model) -> usize {
        if self.ledger {
            LEDGER_PER_CYLINDER * model.layout().joints() + shared_terms(model.machine()).len()
        } else {
            0
        }
    }
}

/// Results of a run, up to its end.
#[derive(Debug, Clone)]
pub struct Run {
    pub times: Vec<f64>,
    /// Row-major, one row per time.
    pub states: Vec<f64>,
    /// Energies (J) since the start, one row per time: the terms of the cylinders, of the ground if there is one, and
    /// of the payload; empty without ledger.
    pub ledger: Vec<f64>,
    /// kg at the tip, one per time. A row at the instant of a change has the state before it.
    pub payloads: Vec<f64>,
    /// Spool commands after delay and limits, m, one row per time.
    pub commands: Vec<f64>,
    pub payload_events: Vec<PayloadEvent>,
    /// Warnings in order of time.
    pub warnings: Vec<Warning>,
    pub outcome: Outcome,
    /// The method that was used.
    pub method: String,
    pub accepted: u64,
    pub rejected: u64,
    pub effort: Effort,
    /// How far the errors of all steps put the tip off at most, m, as far as they are estimated; `None` where they are not: under a
    /// controller, and by a method that carries no errors on.
    pub tip_error: Option<f64>,
}
