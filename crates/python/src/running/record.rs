//! What the core recorded of a run, as Python gets it.

use crate::handed::answers::{outcome_of, warnings_of};
use crate::handed::arrays::{matrix, vector};
use crate::machines::machine::Machine;
use hydrocrane_ode::Effort;
use hydrocrane_sim::{PayloadEvent, Run};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Steps after which a run is given up: minutes of computing.
pub const MAX_STEPS: u64 = 20_000_000;

/// Whether a run shall go on, by the answer of a Python function that says when to stop.
pub fn stopper(should_stop: Option<&Py<PyAny>>) -> impl FnMut(f64) -> bool + '_ {
    move |_t| match should_stop {
        None => true,
        Some(ask) => Python::attach(|py| {
            let answer = ask.call0(py).and_then(|a| a.extract::<bool>(py));
            py.check_signals().is_ok() && !answer.unwrap_or(true)
        }),
    }
}

/// Time, masses and tip velocities before and after, loss.
pub type PayloadEntry = (f64, [f64; 2], [Vec<f64>; 2], f64);

pub fn payload_entry(event: &PayloadEvent) -> PayloadEntry {
    let along = |velocity: [f64; 3]| event.tip_axes.iter().map(|axis| velocity[*axis]).collect();
    (event.time, event.mass, event.tip_velocity.map(along), event.loss)
}

pub fn record_of<'py>(py: Python<'py>, machine: &Machine, run: Run) -> PyResult<Bound<'py, PyDict>> {
    let layout = machine.model.layout();
    let out = PyDict::new(py);
    let ledger_width = run.ledger.len().checked_div(run.times.len()).unwrap_or(0);
    out.set_item("t", vector(py, run.times))?;
    out.set_item("states", matrix(py, run.states, layout.len())?)?;
    out.set_item("ledger", matrix(py, run.ledger, ledger_width)?)?;
    out.set_item("payloads", vector(py, run.payloads))?;
    let events: Vec<PayloadEntry> = run.payload_events.iter().map(payload_entry).collect();
    out.set_item("payload_changes", events)?;
    out.set_item("commands", matrix(py, run.commands, layout.joints())?)?;
    out.set_item("warnings", warnings_of(run.warnings))?;
    out.set_item("outcome", outcome_of(run.outcome))?;
    out.set_item("method", run.method)?;
    out.set_item("tip_error", run.tip_error)?;
    out.set_item("stats", statistics_of(py, (run.accepted, run.rejected), run.effort)?)?;
    Ok(out)
}

/// `steps`: accepted and rejected.
pub fn statistics_of(py: Python<'_>, steps: (u64, u64), effort: Effort) -> PyResult<Bound<'_, PyDict>> {
    let stats = PyDict::new(py);
    stats.set_item("steps", steps.0)?;
    stats.set_item("rejected", steps.1)?;
    stats.set_item("rhs", effort.derivatives)?;
    stats.set_item("jacobians", effort.jacobians)?;
    stats.set_item("factorisations", effort.factorisations)?;
    Ok(stats)
}
