//! A scenario driven live: its controller, with sticks and goals given during the run.

use crate::answers::{warnings_of, WarningEntry};
use crate::arrays::{matrix, vector};
use crate::errors::assembly_error;
use crate::machine::Machine;
use crate::record::{payload_entry, PayloadEntry};
use crate::run::{cylinders, Host};
use crate::scenario::ScenarioEntry;
use crate::simulation::seen;
use hydrocrane_sim::assembly::{assemble, OwnedDriver, RunSettings};
use hydrocrane_sim::{Live, Warning};
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::{Mutex, MutexGuard, PoisonError};

#[pyclass(frozen, module = "hydrocrane._core")]
pub struct LiveSimulator {
    period: f64,
    axes: Vec<String>,
    going: Mutex<Going>,
}

struct Going {
    live: Live,
    /// Warnings on the start that were not yet returned.
    doubts: Vec<Warning>,
    samples: u64,
}

impl LiveSimulator {
    fn going(&self) -> MutexGuard<'_, Going> {
        self.going.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl LiveSimulator {
    /// At the start of `scenario`, under its controller, on `machine`; `make` as for a run.
    #[new]
    fn new(machine: &Machine, scenario: ScenarioEntry<'_>, make: Option<Py<PyAny>>) -> PyResult<Self> {
        let scenario = scenario.scenario(&cylinders(machine))?;
        let mut host = Host { machine, make, built: Vec::new() };
        let settings = RunSettings { ledger: false, max_steps: u64::MAX };
        let mut assembly = assemble(&scenario, settings, &mut host).map_err(|error| assembly_error(&error))?;
        let stage = assembly.stages.remove(0);
        let OwnedDriver::Controller(controller, plan) = &stage.driver else {
            return Err(PyValueError::new_err("spool commands move the crane: there are no sticks to move"));
        };
        let axes = match plan.sticks.kind {
            hydrocrane_sim::StickKind::Tip => vec!["x".to_string(), "z".to_string()],
            _ => scenario.cylinders,
        };
        let period = controller.period();
        let live = stage.live(&assembly.x0, assembly.options);
        let going = Going { live: live.map_err(PyValueError::new_err)?, doubts: assembly.doubts, samples: 0 };
        Ok(LiveSimulator { period, axes, going: Mutex::new(going) })
    }

    /// Advances by a number of samples of the controller: kind and message of the outcome, and the observation.
    fn step<'py>(&self, py: Python<'py>, samples: u64) -> PyResult<(&'static str, String, Bound<'py, PyArray1<f64>>)> {
        let (kind, message) = py.detach(|| {
            let mut going = self.going();
            going.samples += samples;
            // Counted from the start, so that rounding errors do not accumulate.
            let until = going.samples as f64 * self.period;
            let ended = going.live.advance(until).err();
            ended.map_or(("completed", String::new()), |outcome| (outcome.kind.name(), outcome.message))
        });
        Ok((kind, message, self.observation(py)))
    }

    #[getter]
    fn observation<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let going = self.going();
        let live = &going.live;
        vector(py, seen(live.model(), live.time(), live.state(), live.sensors()))
    }

    /// Deflections in the order of `axes`.
    fn set_sticks(&self, deflections: Vec<f64>) {
        let live = &mut self.going().live;
        live.take_over();
        live.set_sticks(&deflections);
    }

    fn set_precision(&self, share: f64) {
        self.going().live.set_precision(share);
    }

    fn go_to(&self, place: [f64; 2], speed: Option<f64>) -> PyResult<()> {
        let live = &mut self.going().live;
        live.go_to(place, speed).map_err(PyValueError::new_err)?;
        live.take_over();
        Ok(())
    }

    fn drop_goal(&self) {
        let live = &mut self.going().live;
        live.take_over();
        live.drop_goal();
    }

    fn set_payload(&self, mass: f64) {
        let live = &mut self.going().live;
        live.take_over();
        live.carry(mass);
    }

    /// Events since the last call: times and texts.
    fn events(&self) -> Vec<(f64, String)> {
        self.going().live.events().into_iter().map(|event| (event.time, event.text)).collect()
    }

    /// Loads picked up and released so far.
    fn payload_changes(&self) -> Vec<PayloadEntry> {
        self.going().live.loads().1.iter().map(payload_entry).collect()
    }

    fn warnings(&self) -> Vec<WarningEntry> {
        let mut going = self.going();
        let doubts = std::mem::take(&mut going.doubts);
        warnings_of([doubts, going.live.warnings()].concat())
    }

    /// Record of the drive until the last sample: end, mode, times, deflections, precision, goals, payload at the
    /// start.
    fn record<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let going = self.going();
        let (live, sticks, out) = (&going.live, going.live.sticks(), PyDict::new(py));
        let end = live.sampled_until();
        let goal = |goal: &hydrocrane_sim::controller::Goal| {
            (goal.given, goal.place, goal.speed, Some(goal.until).filter(|until| *until < end))
        };
        let goals = sticks.goals.iter().filter(|goal| goal.given < end).map(goal);
        out.set_item("end", end)?;
        out.set_item("linear", sticks.linear)?;
        out.set_item("time", vector(py, sticks.times.clone()))?;
        out.set_item("axes", matrix(py, sticks.deflections.clone(), sticks.axes)?)?;
        out.set_item("precision", vector(py, sticks.precision.clone()))?;
        out.set_item("goals", goals.collect::<Vec<_>>())?;
        out.set_item("payload", live.loads().0)?;
        Ok(out)
    }

    #[getter]
    fn axes(&self) -> Vec<String> {
        self.axes.clone()
    }

    #[getter]
    fn period(&self) -> f64 {
        self.period
    }

    #[getter]
    fn time(&self) -> f64 {
        self.going().live.time()
    }

    #[getter]
    fn payload(&self) -> f64 {
        self.going().live.payload()
    }

    #[getter]
    fn replaying(&self) -> bool {
        self.going().live.replaying()
    }

    #[getter]
    fn goal(&self) -> Option<[f64; 2]> {
        self.going().live.goal()
    }

    #[getter]
    fn set_point(&self) -> Option<[f64; 2]> {
        self.going().live.set_point()
    }

    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, self.going().live.state().to_vec())
    }

    #[getter]
    fn signals(&self) -> Vec<String> {
        self.going().live.sensors().signals().map(str::to_string).collect()
    }
}
