//! A scenario driven live: its commands or controllers, until sticks, goals or loads are given during the run.

use crate::handed::answers::{warnings_of, WarningEntry};
use crate::handed::arrays::{matrix, vector};
use crate::handed::errors::assembly_error;
use crate::machines::machine::Machine;
use crate::running::record::{payload_entry, PayloadEntry};
use crate::running::run::{cylinders, Host};
use crate::running::scenario::ScenarioEntry;
use crate::running::simulation::seen;
use hydrocrane_machine::scenario::Scenario;
use hydrocrane_machine::TIP_AXES;
use hydrocrane_sim::assembly::{assemble, RunSettings};
use hydrocrane_sim::{Playback, PlayedStage, StickKind, Sticks};
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::{Mutex, MutexGuard, PoisonError};

#[pyclass(frozen, module = "hydrocrane._core")]
pub struct LiveSimulator {
    cylinders: Vec<String>,
    playback: Mutex<Playback>,
}

impl LiveSimulator {
    fn playback(&self) -> MutexGuard<'_, Playback> {
        self.playback.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn axes_of(&self, sticks: &Sticks) -> Vec<String> {
        match sticks.kind {
            StickKind::Tip => TIP_AXES[..sticks.axes].iter().map(|axis| axis.to_string()).collect(),
            _ => self.cylinders.clone(),
        }
    }

    /// Begin of a stage, its sticks as they were moved, and dead zone, speed and ramp of its joystick.
    fn stage<'py>(&self, py: Python<'py>, played: &PlayedStage, sticks: &Sticks) -> PyResult<Bound<'py, PyDict>> {
        let out = PyDict::new(py);
        out.set_item("from", played.stage.from)?;
        out.set_item("mode", sticks.kind.name())?;
        out.set_item("linear", sticks.linear)?;
        out.set_item("names", self.axes_of(sticks))?;
        out.set_item("time", vector(py, sticks.times.clone()))?;
        out.set_item("axes", matrix(py, sticks.deflections.clone(), sticks.axes)?)?;
        out.set_item("precision", vector(py, sticks.precision.clone()))?;
        let stated = played.stage.joystick.as_ref().map(|stick| (stick.dead_zone, stick.full_speed, stick.ramp));
        out.set_item("stated", stated)?;
        Ok(out)
    }
}

#[pymethods]
impl LiveSimulator {
    /// At the start of `scenario`, on `machine`; `make` as for a run.
    #[new]
    fn new(machine: &Machine, scenario: ScenarioEntry<'_>, make: Option<Py<PyAny>>) -> PyResult<Self> {
        // A drive has no end: all phases begin, and all hoses burst.
        let scenario = Scenario { duration: f64::INFINITY, ..scenario.scenario(&cylinders(machine))? };
        let mut host = Host { machine, make, built: Vec::new() };
        let settings = RunSettings { ledger: false, max_steps: u64::MAX };
        let assembly = assemble(&scenario, settings, &mut host).map_err(|error| assembly_error(&error))?;
        let playback = Playback::new(assembly).map_err(PyValueError::new_err)?;
        Ok(LiveSimulator { cylinders: scenario.cylinders, playback: Mutex::new(playback) })
    }

    /// Advances to the next sample of the controller, or by a duration (s) and on to a sample: kind and message of the outcome.
    fn step(&self, py: Python<'_>, duration: Option<f64>) -> (&'static str, String) {
        py.detach(|| {
            let mut playback = self.playback();
            playback.advance_samples(duration);
            playback.outcome().map_or(("completed", String::new()), |outcome| (outcome.kind.name(), outcome.message))
        })
    }

    #[getter]
    fn observation<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let playback = self.playback();
        let live = &playback.live;
        vector(py, seen(live.model(), live.time(), live.state(), live.sensors()))
    }

    /// Deflections in the order of `axes`.
    fn set_sticks(&self, deflections: Vec<f64>) {
        let mut playback = self.playback();
        playback.take_over();
        playback.live.set_sticks(&deflections);
    }

    fn set_precision(&self, share: f64) {
        self.playback().live.set_precision(share);
    }

    fn go_to(&self, place: [f64; 2], speed: Option<f64>) -> PyResult<()> {
        let mut playback = self.playback();
        playback.live.go_to(place, speed).map_err(PyValueError::new_err)?;
        playback.take_over();
        Ok(())
    }

    fn drop_goal(&self) {
        let mut playback = self.playback();
        playback.take_over();
        playback.live.drop_goal();
    }

    fn set_payload(&self, mass: f64) {
        let mut playback = self.playback();
        playback.take_over();
        playback.live.carry(mass);
    }

    /// Events since the last call: times and texts.
    fn events(&self) -> Vec<(f64, String)> {
        self.playback().live.events().into_iter().map(|event| (event.time, event.text)).collect()
    }

    /// Loads picked up and released so far.
    fn payload_changes(&self) -> Vec<PayloadEntry> {
        self.playback().live.loads().1.iter().map(payload_entry).collect()
    }

    fn warnings(&self) -> Vec<WarningEntry> {
        warnings_of(self.playback().warnings())
    }

    /// Record of the drive until the last sample, or until now under spool commands: end, goals, payload at the start, and the
    /// stages that began before the end.
    fn record<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (playback, out) = (self.playback(), PyDict::new(py));
        let (live, end) = (&playback.live, playback.recorded_until());
        let goal = |goal: &hydrocrane_sim::controller::Goal| {
            (goal.given, goal.place, goal.speed, Some(goal.until).filter(|until| *until < end))
        };
        let goals = live.sticks().goals.iter().filter(|goal| goal.given < end).map(goal);
        let played = playback.played().filter(|(played, _)| played.stage.from < end);
        out.set_item("end", end)?;
        out.set_item("goals", goals.collect::<Vec<_>>())?;
        out.set_item("payload", live.loads().0)?;
        let stages = played.map(|(played, sticks)| self.stage(py, played, sticks));
        out.set_item("stages", stages.collect::<PyResult<Vec<_>>>()?)?;
        Ok(out)
    }

    #[getter]
    fn axes(&self) -> Vec<String> {
        self.axes_of(self.playback().live.sticks())
    }

    #[getter]
    fn period(&self) -> f64 {
        self.playback().live.period()
    }

    /// Number of stages that have ended.
    #[getter]
    fn ended_stages(&self) -> usize {
        self.playback().ended_stages()
    }

    #[getter]
    fn time(&self) -> f64 {
        self.playback().live.time()
    }

    #[getter]
    fn payload(&self) -> f64 {
        self.playback().live.payload()
    }

    #[getter]
    fn replaying(&self) -> bool {
        self.playback().live.replaying()
    }

    #[getter]
    fn goal(&self) -> Option<[f64; 2]> {
        self.playback().live.goal()
    }

    #[getter]
    fn set_point(&self) -> Option<Vec<f64>> {
        let playback = self.playback();
        let axes = playback.live.model().tip_axes();
        playback.live.set_point().map(|place| axes.iter().map(|axis| place[*axis]).collect())
    }

    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, self.playback().live.state().to_vec())
    }

    #[getter]
    fn signals(&self) -> Vec<String> {
        self.playback().live.sensors().signals().map(str::to_string).collect()
    }
}
