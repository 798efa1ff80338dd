//! A scenario driven live: its commands or controllers, until sticks, goals or loads are given during the run.

use crate::handed::answers::{warnings_of, WarningEntry};
use crate::handed::arrays::{matrix, vector};
use crate::handed::errors::assembly_error;
use crate::handed::shared::Shared;
use crate::machines::machine::Machine;
use crate::machines::scenario::ScenarioEntry;
use crate::running::record::{payload_entry, PayloadEntry};
use crate::running::run::{cylinders, Host};
use crate::running::simulation::seen;
use hydrocrane_machine::scenario::Scenario;
use hydrocrane_machine::TIP_AXES;
use hydrocrane_sim::assembly::{assemble, RunSettings};
use hydrocrane_sim::{Live, Playback, PlayedStage, StickKind, Sticks};
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

#[pyclass(frozen, module = "hydrocrane._core")]
pub struct LiveSimulator {
    cylinders: Vec<String>,
    playback: Shared<Playback>,
}

/// Names of the axes of these sticks.
fn axes_of(cylinders: &[String], sticks: &Sticks) -> Vec<String> {
    match sticks.kind {
        StickKind::Tip => TIP_AXES[..sticks.axes].iter().map(|axis| axis.to_string()).collect(),
        _ => cylinders.to_vec(),
    }
}

/// Begin of a stage, dead zone, speed and ramp of its joystick, and its sticks as they were moved.
type DrivenStage = (f64, Option<(f64, Option<f64>, f64)>, Sticks);

fn stage<'py>(
    py: Python<'py>,
    cylinders: &[String],
    (from, stated, sticks): &DrivenStage,
) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("from", from)?;
    out.set_item("mode", sticks.kind.name())?;
    out.set_item("linear", sticks.linear)?;
    out.set_item("names", axes_of(cylinders, sticks))?;
    out.set_item("time", vector(py, sticks.times.clone()))?;
    out.set_item("axes", matrix(py, sticks.deflections.clone(), sticks.axes)?)?;
    out.set_item("precision", vector(py, sticks.precision.clone()))?;
    out.set_item("stated", stated)?;
    Ok(out)
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
        Ok(LiveSimulator { cylinders: scenario.cylinders, playback: Shared::new(playback) })
    }

    /// Advances to the next sample of the controller, or by a duration (s) and on to a sample: kind and message of the outcome.
    fn step(&self, py: Python<'_>, duration: Option<f64>) -> PyResult<(&'static str, String)> {
        self.playback.ask(py, |playback| {
            playback.advance_samples(duration);
            playback.outcome().map_or(("completed", String::new()), |outcome| (outcome.kind.name(), outcome.message))
        })
    }

    #[getter]
    fn observation<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let seen = |live: &Live| seen(live.model(), live.time(), live.state(), live.sensors());
        Ok(vector(py, self.playback.ask(py, |playback| seen(&playback.live))?))
    }

    /// Deflections in the order of `axes`.
    fn set_sticks(&self, py: Python<'_>, deflections: Vec<f64>) -> PyResult<()> {
        self.playback.ask(py, |playback| {
            playback.take_over();
            playback.live.set_sticks(&deflections);
        })
    }

    fn set_precision(&self, py: Python<'_>, share: f64) -> PyResult<()> {
        self.playback.ask(py, |playback| playback.live.set_precision(share))
    }

    fn go_to(&self, py: Python<'_>, place: [f64; 2], speed: Option<f64>) -> PyResult<()> {
        self.playback.ask(py, |playback| {
            playback.live.go_to(place, speed).map_err(PyValueError::new_err)?;
            playback.take_over();
            Ok(())
        })?
    }

    fn drop_goal(&self, py: Python<'_>) -> PyResult<()> {
        self.playback.ask(py, |playback| {
            playback.take_over();
            playback.live.drop_goal();
        })
    }

    fn set_payload(&self, py: Python<'_>, mass: f64) -> PyResult<()> {
        self.playback.ask(py, |playback| {
            playback.take_over();
            playback.live.carry(mass);
        })
    }

    /// Events since the last call: times and texts.
    fn events(&self, py: Python<'_>) -> PyResult<Vec<(f64, String)>> {
        let events = |playback: &mut Playback| playback.live.events();
        Ok(self.playback.ask(py, events)?.into_iter().map(|event| (event.time, event.text)).collect())
    }

    /// Loads picked up and released so far.
    fn payload_changes(&self, py: Python<'_>) -> PyResult<Vec<PayloadEntry>> {
        self.playback.ask(py, |playback| playback.live.loads().1.iter().map(payload_entry).collect())
    }

    fn warnings(&self, py: Python<'_>) -> PyResult<Vec<WarningEntry>> {
        Ok(warnings_of(self.playback.ask(py, |playback| playback.warnings())?))
    }

    /// Record of the drive until the last sample, or until now under spool commands: end, goals, payload at the start, and the
    /// stages that began before the end.
    fn record<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (end, goals, payload, stages) = self.playback.ask(py, |playback| {
            let (live, end) = (&playback.live, playback.recorded_until());
            let goal = |goal: &hydrocrane_sim::controller::Goal| {
                (goal.given, goal.place, goal.speed, Some(goal.until).filter(|until| *until < end))
            };
            let goals: Vec<_> = live.sticks().goals.iter().filter(|goal| goal.given < end).map(goal).collect();
            let played = playback.played().filter(|(played, _)| played.stage.from < end);
            let stated = |stage: &PlayedStage| {
                stage.stage.joystick.as_ref().map(|stick| (stick.dead_zone, stick.full_speed, stick.ramp))
            };
            let stages: Vec<DrivenStage> =
                played.map(|(played, sticks)| (played.stage.from, stated(played), sticks.clone())).collect();
            (end, goals, live.loads().0, stages)
        })?;
        let out = PyDict::new(py);
        out.set_item("end", end)?;
        out.set_item("goals", goals)?;
        out.set_item("payload", payload)?;
        let stages = stages.iter().map(|played| stage(py, &self.cylinders, played));
        out.set_item("stages", stages.collect::<PyResult<Vec<_>>>()?)?;
        Ok(out)
    }

    #[getter]
    fn axes(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.playback.ask(py, |playback| axes_of(&self.cylinders, playback.live.sticks()))
    }

    #[getter]
    fn period(&self, py: Python<'_>) -> PyResult<f64> {
        self.playback.ask(py, |playback| playback.live.period())
    }

    /// Number of stages that have ended.
    #[getter]
    fn ended_stages(&self, py: Python<'_>) -> PyResult<usize> {
        self.playback.ask(py, |playback| playback.ended_stages())
    }

    #[getter]
    fn time(&self, py: Python<'_>) -> PyResult<f64> {
        self.playback.ask(py, |playback| playback.live.time())
    }

    #[getter]
    fn payload(&self, py: Python<'_>) -> PyResult<f64> {
        self.playback.ask(py, |playback| playback.live.payload())
    }

    #[getter]
    fn replaying(&self, py: Python<'_>) -> PyResult<bool> {
        self.playback.ask(py, |playback| playback.live.replaying())
    }

    #[getter]
    fn goal(&self, py: Python<'_>) -> PyResult<Option<[f64; 2]>> {
        self.playback.ask(py, |playback| playback.live.goal())
    }

    #[getter]
    fn set_point(&self, py: Python<'_>) -> PyResult<Option<Vec<f64>>> {
        self.playback.ask(py, |playback| {
            let axes = playback.live.model().tip_axes();
            playback.live.set_point().map(|place| axes.iter().map(|axis| place[*axis]).collect())
        })
    }

    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(vector(py, self.playback.ask(py, |playback| playback.live.state().to_vec())?))
    }

    #[getter]
    fn signals(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.playback.ask(py, |playback| playback.live.sensors().signals().map(str::to_string).collect())
    }
}
