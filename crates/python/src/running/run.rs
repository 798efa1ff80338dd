//! Runs of scenarios, and what is known of one before it runs.

use crate::handed::answers::{warnings_of, WarningEntry};
use crate::handed::arrays::{matrix, vector, Row};
use crate::handed::errors::assembly_error;
use crate::handed::overrides::pairs_of;
use crate::machines::machine::Machine;
use crate::machines::scenario::{Head, ScenarioEntry};
use crate::running::own_controller::PythonController;
use crate::running::record::{record_of, stopper, MAX_STEPS};
use hydrocrane_machine::scenario::{Recorded, Scenario, SensorQuality, Stage};
use hydrocrane_machine::OverrideValue;
use hydrocrane_sim::assembly::{
    assemble, commands, stages as assembled_stages, start, unreached, AssembledStage, AssemblyError, OwnedDriver,
    RunSettings, Surroundings,
};
use hydrocrane_sim::controller::Controller;
use hydrocrane_sim::{Model, Samples};
use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;

/// A scenario's machines, and somebody's own controllers: `make(number, machine, mode, full_speed)` gives each.
pub struct Host<'a> {
    pub machine: &'a Machine,
    pub make: Option<Py<PyAny>>,
    /// All that were built, to tell what each is.
    pub built: Vec<Machine>,
}

impl Surroundings for Host<'_> {
    fn machine(
        &mut self,
        source: Option<&str>,
        overrides: &[(String, OverrideValue)],
    ) -> Result<Arc<dyn Model>, AssemblyError> {
        let built = match source {
            None => self.machine.with(overrides)?,
            Some(source) => Machine::open(source, overrides)?,
        };
        let model = built.model.clone();
        self.built.push(built);
        Ok(model)
    }

    fn own_controller(
        &mut self,
        number: usize,
        stage: &Stage,
        controller_model: &Arc<dyn Model>,
    ) -> Option<Box<dyn Controller>> {
        let made = self.built.iter().find(|built| Arc::ptr_eq(&built.model, controller_model))?;
        let full_speed = stage.joystick.as_ref().and_then(|stick| stick.full_speed);
        let period = stage.controller.as_ref().and_then(|choice| choice.period);
        let ask = |py: Python| {
            let make = self.make.as_ref()?.bind(py);
            let machine = Bound::new(py, made.clone());
            let about = machine.map(|machine| (number, machine, stage.stick_mode().name(), full_speed));
            let object = about.and_then(|about| make.call1(about));
            Some(PythonController::new(py, object, period))
        };
        Some(Box::new(Python::attach(ask)?))
    }
}

pub fn cylinders(machine: &Machine) -> Vec<&str> {
    machine.model.machine().cylinders.iter().map(|cylinder| cylinder.name.as_str()).collect()
}

/// Runs a scenario on `machine`, which has the values that the scenario begins with.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub fn run<'py>(
    py: Python<'py>,
    machine: &Machine,
    scenario: ScenarioEntry<'py>,
    record_times: Row<'py>,
    ledger: bool,
    make: Option<Py<PyAny>>,
    should_stop: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let scenario = scenario.scenario(&cylinders(machine))?;
    let record = record_times.as_slice()?.to_vec();
    let settings = RunSettings { ledger, max_steps: MAX_STEPS };
    let done = py.detach(|| {
        let mut host = Host { machine, make, built: Vec::new() };
        let mut assembly = assemble(&scenario, settings, &mut host)?;
        let mut keep_going = stopper(should_stop.as_ref());
        let done = assembly.run(&record, &mut keep_going);
        Ok((assembly, done, host.built))
    });
    let (assembly, done, built) = done.map_err(|error| assembly_error(&error))?;
    let out = record_of(py, machine, done.run)?;
    out.set_item("doubts", warnings_of(assembly.doubts))?;
    let table = |stage: &AssembledStage| stage_of(py, stage, &built);
    out.set_item("stages", assembly.stages.iter().map(table).collect::<PyResult<Vec<_>>>()?)?;
    let samples = done.samples.into_iter().zip(&assembly.stages).map(|(rows, stage)| samples_of(py, rows, stage));
    out.set_item("samples", samples.collect::<PyResult<Vec<_>>>()?)?;
    let events: Vec<(f64, String)> = done.events.into_iter().map(|event| (event.time, event.text)).collect();
    out.set_item("events", events)?;
    Ok(out)
}

/// What holds in a stage, with the machine that it has.
fn stage_of<'py>(py: Python<'py>, assembled: &AssembledStage, built: &[Machine]) -> PyResult<Bound<'py, PyDict>> {
    let stage = &assembled.stage;
    let out = stage_table(py, stage)?;
    for (key, model) in [("machine", &assembled.model), ("controller_model", &assembled.controller_model)] {
        out.set_item(key, made(model, built))?;
    }
    let changes: Vec<_> = assembled.changes.iter().map(|(time, model)| (*time, made(model, built))).collect();
    out.set_item("changes", changes)?;
    Ok(out)
}

/// The machine that was built for a model.
fn made(model: &Arc<dyn Model>, built: &[Machine]) -> Option<Machine> {
    built.iter().find(|built| Arc::ptr_eq(&built.model, model)).cloned()
}

/// Begin, controller, sensors, sticks and overrides of a stage.
fn stage_table<'py>(py: Python<'py>, stage: &Stage) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("from", stage.from)?;
    out.set_item("mode", stage.stick_mode().name())?;
    out.set_item("overrides", pairs_of(py, &stage.machine_overrides())?)?;
    let choice = stage.controller.as_ref();
    out.set_item("controller", choice.filter(|choice| choice.own.is_none()).map(|choice| &choice.name))?;
    out.set_item("own", choice.and_then(|choice| choice.own))?;
    let real = choice.is_some_and(|choice| choice.sensors == SensorQuality::DataSheet);
    out.set_item("sensors", if real { "data-sheet" } else { "ideal" })?;
    out.set_item("stick_times", stage.joystick.as_ref().map_or(0, |stick| stick.time.len()))?;
    Ok(out)
}

/// What holds in each stage of a scenario.
#[pyfunction]
pub fn stages<'py>(py: Python<'py>, scenario: ScenarioEntry<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
    scenario.scenario(&scenario.levers())?.stages().iter().map(|stage| stage_table(py, stage)).collect()
}

/// Times (s) at which the values of `machine` change during a scenario without phases, each with the machine from then on.
#[pyfunction]
pub fn machine_changes(machine: &Machine, scenario: ScenarioEntry<'_>) -> PyResult<Vec<(f64, Machine)>> {
    let scenario = scenario.scenario(&cylinders(machine))?;
    let mut host = Host { machine, make: None, built: Vec::new() };
    let assembled = assembled_stages(&scenario, &mut host).map_err(|error| assembly_error(&error))?;
    let changes = assembled.iter().flat_map(|stage| &stage.changes);
    Ok(changes.filter_map(|(time, model)| Some((*time, made(model, &host.built)?))).collect())
}

/// The state at the start of a scenario on `machine`, and what makes that or its run doubtful.
#[pyfunction]
pub fn start_state<'py>(
    py: Python<'py>,
    machine: &Machine,
    scenario: ScenarioEntry<'py>,
) -> PyResult<(Bound<'py, PyArray1<f64>>, Vec<WarningEntry>)> {
    let scenario = scenario.scenario(&cylinders(machine))?;
    let payload = scenario.load.payload.unwrap_or(machine.model.machine().payload.mass);
    let found = start(&scenario, machine.model.as_ref(), payload);
    let (x0, mut doubts) = found.map_err(|error| assembly_error(&error))?;
    doubts.extend(unreached(&scenario, machine.model.machine()));
    Ok((vector(py, x0), warnings_of(doubts)))
}

/// Times, a row of spool commands for each, and whether to join them.
type CommandTable<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>, bool);

/// The spool commands of a scenario on common times, for `machine`.
#[pyfunction]
pub fn command_table<'py>(
    py: Python<'py>,
    machine: &Machine,
    scenario: ScenarioEntry<'py>,
) -> PyResult<CommandTable<'py>> {
    let table = commands(&scenario.commands()?, machine.model.as_ref()).map_err(PyValueError::new_err)?;
    let columns = machine.model.machine().cylinders.len();
    Ok((vector(py, table.times), matrix(py, table.values, columns)?, table.linear))
}

/// The text of a file that states a scenario on `machine`.
#[pyfunction]
pub fn scenario_text(machine: &Machine, scenario: ScenarioEntry<'_>, head: Head) -> PyResult<String> {
    let (name, title, source, recorder) = head;
    let recorded = Recorded { by: (!recorder.is_empty()).then_some(recorder), on: None };
    let scenario = Scenario { name, title, machine: source, recorded, ..scenario.scenario(&cylinders(machine))? };
    let made =
        scenario.stages().iter().map(|stage| machine.with(&stage.machine_overrides())).collect::<Result<Vec<_>, _>>();
    let made = made.map_err(|error| assembly_error(&error))?;
    let machines: Vec<_> = made.iter().map(|machine| machine.model.machine()).collect();
    scenario.to_toml(&machines).map_err(|error| PyValueError::new_err(error.0))
}

fn samples_of<'py>(py: Python<'py>, rows: Samples, stage: &AssembledStage) -> PyResult<Bound<'py, PyDict>> {
    let samples = PyDict::new(py);
    let (signals, axes): (Vec<&str>, usize) = match &stage.driver {
        OwnedDriver::Controller(_, plan) => (plan.sensors.signals().collect(), plan.sticks.axes),
        OwnedDriver::Commands(_) => (Vec::new(), 0),
    };
    samples.set_item("t", vector(py, rows.times))?;
    samples.set_item("measured", matrix(py, rows.measured, signals.len())?)?;
    samples.set_item("sticks", matrix(py, rows.sticks, axes)?)?;
    let places = stage.model.tip_axes();
    let set_points = rows.set_points.iter().flat_map(|place| places.iter().map(|axis| place[*axis]));
    samples.set_item("set_points", matrix(py, set_points.collect(), places.len())?)?;
    samples.set_item("commands", matrix(py, rows.commands, stage.model.layout().joints())?)?;
    let learnt = rows.learnt.iter().flat_map(|v| [v.chain.offset, v.chain.gain, v.chain.dead_band, v.leakage]);
    samples.set_item("learnt", matrix(py, learnt.collect(), 4)?)?;
    let valves = stage.model.machine().cylinders.iter().map(|c| c.valve.name.clone());
    samples.set_item("valves", valves.collect::<Vec<_>>())?;
    samples.set_item("signals", signals)?;
    Ok(samples)
}
