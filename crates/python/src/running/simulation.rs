//! Runs and the stepping interface.

use crate::handed::answers::{warnings_of, WarningEntry};
use crate::handed::arrays::{row, rows, vector, Row, Rows};
use crate::machines::machine::Machine;
use crate::machines::sensors::{self, FaultEntry};
use crate::running::record::{payload_entry, PayloadEntry, MAX_STEPS};
use crate::running::scenario::SolverEntry;
use hydrocrane_machine::scenario::Solver;
use hydrocrane_sim::assembly::{options, RunSettings};
use hydrocrane_sim::{Layout, Model, OutcomeKind, Sensors, Task};
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::time::Instant;

/// The method that a run of this machine takes with this solver.
#[pyfunction]
pub fn method_for(machine: &Machine, solver: SolverEntry) -> String {
    hydrocrane_sim::method_for(&solver.solver(), machine.model.machine(), Task::States).to_string()
}

#[pyclass(module = "hydrocrane._core")]
pub struct Simulator {
    inner: hydrocrane_sim::Simulator,
    /// Why the last sample failed; empty if it did not.
    reason: String,
}

impl Simulator {
    fn layout(&self) -> &Layout {
        self.inner.model().layout()
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
        Ok(Simulator {
            inner: hydrocrane_sim::Simulator::new(machine.model.clone(), sample_time, options).with_sensors(sensors),
            reason: String::new(),
        })
    }

    fn reset(&mut self, x0: Row<'_>) -> PyResult<()> {
        self.inner.reset(x0.as_slice()?).map_err(PyValueError::new_err)
    }

    /// Outcome kind after one sample with the commands held, and what is seen then.
    fn step<'py>(&mut self, py: Python<'py>, u: Row<'py>) -> PyResult<(&'static str, Bound<'py, PyArray1<f64>>)> {
        let u = row(&u, self.layout().joints(), "spool_command")?;
        if !u.iter().all(|u| u.is_finite()) {
            return Err(PyValueError::new_err("spool_command must be finite"));
        }
        let u = u.to_vec();
        let outcome = py.detach(|| self.inner.step(&u));
        self.reason = if outcome.kind == OutcomeKind::Completed { String::new() } else { outcome.message };
        Ok((outcome.kind.name(), self.observation(py)?))
    }

    /// Why the last sample failed, with the cure; empty if it did not.
    #[getter]
    fn reason(&self) -> &str {
        &self.reason
    }

    /// As [`seen`] tells it.
    #[getter]
    fn observation<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let state = self.inner.state().ok_or_else(not_reset)?;
        Ok(vector(py, seen(self.inner.model(), self.inner.time(), state, self.inner.sensors())))
    }

    /// The method that is taken.
    #[getter]
    fn method(&self) -> &str {
        self.inner.method()
    }

    /// What has made the simulation doubtful since the last call.
    fn warnings(&mut self) -> Vec<WarningEntry> {
        warnings_of(self.inner.warnings())
    }

    /// What the sensors measure, in the order of their readings.
    #[getter]
    fn signals(&self) -> Vec<&str> {
        self.inner.sensors().signals().collect()
    }

    /// Wall time (s) of one step under each row of commands, up to the first that does not end well.
    fn step_times<'py>(&mut self, py: Python<'py>, commands: Rows<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let cylinders = self.layout().joints();
        let commands = rows(&commands, cylinders, "commands")?.to_vec();
        let times = py.detach(|| {
            let mut times = Vec::with_capacity(commands.len() / cylinders);
            for u in commands.chunks_exact(cylinders) {
                let began = Instant::now();
                let outcome = self.inner.step(u);
                let elapsed = began.elapsed().as_secs_f64();
                if outcome.kind != OutcomeKind::Completed {
                    break;
                }
                times.push(elapsed);
            }
            times
        });
        Ok(vector(py, times))
    }

    /// Time, masses and tip velocities before and after, loss.
    fn set_payload(&mut self, mass: f64) -> PyResult<PayloadEntry> {
        let event = self.inner.set_payload(mass).ok_or_else(not_reset)?;
        Ok(payload_entry(&event))
    }

    #[getter]
    fn payload(&self) -> f64 {
        self.inner.payload()
    }

    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let state = self.inner.state().ok_or_else(not_reset)?;
        Ok(vector(py, state.to_vec()))
    }

    #[getter]
    fn time(&self) -> f64 {
        self.inner.time()
    }
}
