//! What a run is asked for, and what it computed.

use crate::model::Model;
use crate::outcome::Outcome;
use crate::payload::{PayloadChange, PayloadEvent};
use crate::warning::Warning;
use hydrocrane_machine::scenario::SupplyPressure;
use hydrocrane_ode::{Effort, StepControl, Tolerances};
use hydrocrane_plant::ledger::{shared_terms, LEDGER_PER_CYLINDER};
use std::sync::Arc;

/// Spool commands against time: one row per time, one column per cylinder, m.
#[derive(Debug, Clone, Default)]
pub struct Commands {
    /// Ascending, s.
    pub times: Vec<f64>,
    /// Row-major, `times.len() x cylinders`.
    pub values: Vec<f64>,
    /// Straight between the rows instead of held.
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
    /// Loads taken up and let go on the way, in order of time.
    pub payload_changes: Vec<PayloadChange>,
    /// A measured pressure of the supply, for a machine that takes one.
    pub supply: Option<Arc<SupplyPressure>>,
    /// Integrate the energy ledger along.
    pub ledger: bool,
    /// Accepted steps after which a run is given up.
    pub max_steps: u64,
}

impl RunOptions {
    /// Number of energies integrated along.
    pub(crate) fn quadratures(&self, model: &dyn Model) -> usize {
        if self.ledger {
            LEDGER_PER_CYLINDER * model.layout().joints() + shared_terms(model.machine()).len()
        } else {
            0
        }
    }
}

/// What a run computed, up to wherever it got.
#[derive(Debug, Clone)]
pub struct Run {
    pub times: Vec<f64>,
    /// Row-major, one row per time.
    pub states: Vec<f64>,
    /// Energies (J) since the start, one row per time: the cylinders' terms, that of the ground where there is one,
    /// those of the payload; empty without ledger.
    pub ledger: Vec<f64>,
    /// kg at the tip, one per time. A row at the instant of a change has the state before it.
    pub payloads: Vec<f64>,
    /// Spool commands after delay and limits, m, one row per time.
    pub commands: Vec<f64>,
    pub payload_events: Vec<PayloadEvent>,
    /// What makes the run doubtful, in order of time.
    pub warnings: Vec<Warning>,
    pub outcome: Outcome,
    /// The method that was taken.
    pub method: String,
    pub accepted: u64,
    pub rejected: u64,
    pub effort: Effort,
}
