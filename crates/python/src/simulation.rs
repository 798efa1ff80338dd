//! Runs and the stepping interface.

use crate::answers::{outcome_of, warnings_of, WarningEntry};
use crate::arrays::{matrix, row, rows, vector, Row, Rows};
use crate::machine::Machine;
use crate::sensors::{self, FaultEntry};
use hydrocrane_ode::{Effort, Tolerances};
use hydrocrane_sim::{Commands, Layout, OutcomeKind, PayloadChange, PayloadEvent, Run, RunOptions};
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::time::Instant;

/// Steps after which a run is given up: minutes of computing.
const MAX_STEPS: u64 = 20_000_000;

/// How a run is integrated, as the facade hands it over.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Settings {
    payload: f64,
    /// (time, mass)
    payload_changes: Vec<(f64, f64)>,
    method: String,
    rtol: f64,
    atol: Option<f64>,
    max_step: f64,
    /// Of a method with fixed steps.
    step: Option<f64>,
    ledger: bool,
}

impl Settings {
    pub fn options(&self) -> RunOptions {
        let max_step = self.step.unwrap_or(self.max_step);
        let changes = self.payload_changes.iter().map(|&(time, mass)| PayloadChange { time, mass });
        RunOptions {
            payload_changes: changes.collect(),
            ..options(self.payload, &self.method, self.rtol, self.atol, max_step, self.ledger)
        }
    }
}

fn options(payload: f64, method: &str, rtol: f64, atol: Option<f64>, max_step: f64, ledger: bool) -> RunOptions {
    RunOptions {
        method: method.to_string(),
        tolerances: Tolerances { relative: rtol, absolute: atol.unwrap_or(rtol), max_step },
        payload,
        payload_changes: Vec::new(),
        ledger,
        max_steps: MAX_STEPS,
    }
}

#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub fn simulate<'py>(
    py: Python<'py>,
    machine: &Machine,
    x0: Row<'py>,
    t_end: f64,
    command_times: Row<'py>,
    commands: Rows<'py>,
    linear: bool,
    record_times: Row<'py>,
    settings: Settings,
    should_stop: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let n = machine.model.layout().joints();
    let commands = Commands {
        times: command_times.as_slice()?.to_vec(),
        values: rows(&commands, n, "commands")?.to_vec(),
        linear,
    };
    let (x0, record) = (x0.as_slice()?.to_vec(), record_times.as_slice()?.to_vec());
    let options = settings.options();
    let model = machine.model.clone();
    let run = py.detach(|| {
        let mut keep_going = stopper(should_stop.as_ref());
        hydrocrane_sim::simulate(model.as_ref(), &x0, t_end, &commands, &record, &options, &mut keep_going)
    });
    record_of(py, machine, run)
}

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
type PayloadEntry = (f64, [f64; 2], [[f64; 2]; 2], f64);

fn payload_entry(event: &PayloadEvent) -> PayloadEntry {
    (event.time, event.mass, event.tip_velocity, event.loss)
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

#[pyclass(module = "hydrocrane._core")]
pub struct Simulator {
    inner: hydrocrane_sim::Simulator,
}

impl Simulator {
    fn layout(&self) -> &Layout {
        self.inner.model().layout()
    }
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
        let largest = step.unwrap_or(sample_time.min(0.05));
        let options = options(payload, method, rtol, None, largest, false);
        let sensors = sensors::sensors(machine, sensors, seed, &faults)?;
        Ok(Simulator {
            inner: hydrocrane_sim::Simulator::new(machine.model.clone(), sample_time, options).with_sensors(sensors),
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
        let kind = py.detach(|| self.inner.step(&u)).kind;
        Ok((kind.name(), self.observation(py)?))
    }

    /// Time, joint coordinates, their rates, both pressures of each cylinder, x and z of the tip, and the readings of all
    /// sensors.
    #[getter]
    fn observation<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (state, tip) = self.inner.state().zip(self.inner.tip()).ok_or_else(not_reset)?;
        let (layout, n) = (self.layout(), self.layout().joints());
        let joints = (0..n).map(|i| layout.q(i)).chain((0..n).map(|i| layout.qd(i)));
        let pressures = (0..n).flat_map(|c| [layout.own(c).p1, layout.own(c).p2]);
        let mut seen = Vec::with_capacity(3 + 4 * n + self.inner.sensors().readings().len());
        seen.push(self.inner.time());
        seen.extend(joints.chain(pressures).map(|i| state[i]));
        seen.extend(tip);
        seen.extend(self.inner.sensors().readings());
        Ok(vector(py, seen))
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
