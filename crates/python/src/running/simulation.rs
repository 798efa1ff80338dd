//! Runs and the stepping interface.

use crate::handed::answers::{warnings_of, WarningEntry};
use crate::handed::arrays::{row, rows, vector, Row, Rows};
use crate::handed::shared::Shared;
use crate::machines::machine::Machine;
use crate::machines::scenario::SolverEntry;
use crate::machines::sensors::{self, FaultEntry};
use crate::running::record::{payload_entry, PayloadEntry, MAX_STEPS};
use hydrocrane_machine::scenario::Solver;
use hydrocrane_sim::assembly::{options, RunSettings};
use hydrocrane_sim::{Model, OutcomeKind, Sensors, Task};
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::time::Instant;

/// The method that a run of this machine takes with this solver.
#[pyfunction]
pub fn method_for(machine: &Machine, solver: SolverEntry) -> String {
    hydrocrane_sim::method_for(&solver.solver(), machine.model.machine(), Task::States).to_string()
}

#[pyclass(frozen, module = "hydrocrane._core")]
pub struct Simulator {
    joints: usize,
    signals: Vec<String>,
    going: Shared<Going>,
}

struct Going {
    inner: hydrocrane_sim::Simulator,
    /// Why the last sample failed; empty if it did not.
    reason: String,
}

impl Going {
    fn seen(&self) -> Option<Vec<f64>> {
        let state = self.inner.state()?;
        Some(seen(self.inner.model(), self.inner.time(), state, self.inner.sensors()))
    }
}

/// Time, joint coordinates, their rates, both pressures of each cylinder, the tip, and the readings of all sensors.
pub fn seen(model: &dyn Model, time: f64, state: &[f64], sensors: &Sensors) -> Vec<f64> {
    let (layout, n) = (model.layout(), model.layout().joints());
    let joints = (0..n).map(|i| layout.q(i)).chain((0..n).map(|i| layout.qd(i)));
    let pressures = (0..n).flat_map(|c| [layout.own(c).p1, layout.own(c).p2]);
    let mut seen = Vec::with_capacity(4 + 4 * n + sensors.readings().len());
    seen.push(time);
    seen.extend(joints.chain(pressures).map(|i| state[i]));
    let tip = model.tip(&state[..n]);
    seen.extend(model.tip_axes().iter().map(|axis| tip[*axis]));
    seen.extend(sensors.readings());
    seen
}

/// What is asked of a simulator before its first reset.
fn not_reset() -> PyErr {
    PyValueError::new_err("reset the simulator first")
}

#[pymethods]
impl Simulator {
    #[new]
    #[allow(clippy::too_many_arguments)]
    fn new(
        machine: &Machine,
        sample_time: f64,
        payload: f64,
        method: &str,
        rtol: f64,
        step: Option<f64>,
        sensors: &str,
        seed: u64,
        faults: Vec<FaultEntry>,
    ) -> PyResult<Self> {
        let solver = Solver { method: method.to_string(), rtol, atol: None, max_step: 0.05, step };
        let settings = RunSettings { ledger: false, max_steps: MAX_STEPS };
        let options = options(&solver, machine.model.machine(), Task::States, payload, settings);
        let sensors = sensors::sensors(machine, sensors, seed, &faults)?;
        let inner = hydrocrane_sim::Simulator::new(machine.model.clone(), sample_time, options).with_sensors(sensors);
        let signals = inner.sensors().signals().map(str::to_string).collect();
        let joints = inner.model().layout().joints();
        Ok(Simulator { joints, signals, going: Shared::new(Going { inner, reason: String::new() }) })
    }

    fn reset(&self, py: Python<'_>, x0: Row<'_>) -> PyResult<()> {
        let x0 = x0.as_slice()?.to_vec();
        self.going.ask(py, |going| going.inner.reset(&x0))?.map_err(PyValueError::new_err)
    }

    /// Outcome kind after one sample with the commands held, and what is seen then.
    fn step<'py>(&self, py: Python<'py>, u: Row<'py>) -> PyResult<(&'static str, Bound<'py, PyArray1<f64>>)> {
        let u = row(&u, self.joints, "spool_command")?;
        if !u.iter().all(|u| u.is_finite()) {
            return Err(PyValueError::new_err("spool_command must be finite"));
        }
        let u = u.to_vec();
        let (kind, seen) = self.going.ask(py, |going| {
            let outcome = going.inner.step(&u);
            going.reason = if outcome.kind == OutcomeKind::Completed { String::new() } else { outcome.message };
            (outcome.kind.name(), going.seen())
        })?;
        Ok((kind, vector(py, seen.ok_or_else(not_reset)?)))
    }

    /// Why the last sample failed, with the cure; empty if it did not.
    #[getter]
    fn reason(&self, py: Python<'_>) -> PyResult<String> {
        self.going.ask(py, |going| going.reason.clone())
    }

    /// As [`seen`] tells it.
    #[getter]
    fn observation<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let seen = self.going.ask(py, |going| going.seen())?;
        Ok(vector(py, seen.ok_or_else(not_reset)?))
    }

    /// The method that is taken.
    #[getter]
    fn method(&self, py: Python<'_>) -> PyResult<String> {
        self.going.ask(py, |going| going.inner.method().to_string())
    }

    /// What has made the simulation doubtful since the last call.
    fn warnings(&self, py: Python<'_>) -> PyResult<Vec<WarningEntry>> {
        Ok(warnings_of(self.going.ask(py, |going| going.inner.warnings())?))
    }

    /// What the sensors measure, in the order of their readings.
    #[getter]
    fn signals(&self) -> Vec<String> {
        self.signals.clone()
    }

    /// Wall time (s) of one step under each row of commands, up to the first that does not end well.
    fn step_times<'py>(&self, py: Python<'py>, commands: Rows<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let commands = rows(&commands, self.joints, "commands")?.to_vec();
        let times = self.going.ask(py, |going| {
            let mut times = Vec::with_capacity(commands.len() / self.joints);
            for u in commands.chunks_exact(self.joints) {
                let began = Instant::now();
                let outcome = going.inner.step(u);
                let elapsed = began.elapsed().as_secs_f64();
                if outcome.kind != OutcomeKind::Completed {
                    break;
                }
                times.push(elapsed);
            }
            times
        })?;
        Ok(vector(py, times))
    }

    /// Time, masses and tip velocities before and after, loss.
    fn set_payload(&self, py: Python<'_>, mass: f64) -> PyResult<PayloadEntry> {
        let event = self.going.ask(py, |going| going.inner.set_payload(mass))?.ok_or_else(not_reset)?;
        Ok(payload_entry(&event))
    }

    #[getter]
    fn payload(&self, py: Python<'_>) -> PyResult<f64> {
        self.going.ask(py, |going| going.inner.payload())
    }

    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let state = self.going.ask(py, |going| going.inner.state().map(<[f64]>::to_vec))?;
        Ok(vector(py, state.ok_or_else(not_reset)?))
    }

    #[getter]
    fn time(&self, py: Python<'_>) -> PyResult<f64> {
        self.going.ask(py, |going| going.inner.time())
    }
}
