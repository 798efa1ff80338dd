//! Runs with their derivatives by keys of the machine file.

use crate::handed::answers::{outcome_of, warnings_of};
use crate::handed::arrays::{matrix, tensor, vector, Row};
use crate::handed::errors::{cannot_build, file_error};
use crate::handed::overrides::overrides;
use crate::machines::machine::Machine;
use crate::machines::scenario::ScenarioEntry;
use crate::running::record::{payload_entry, statistics_of, PayloadEntry, MAX_STEPS};
use hydrocrane_sim::assembly::commands;
use hydrocrane_sim::sensitivity::{self, Experiment, Parameter, Sensitivities, SensitivityError, Start};
use hydrocrane_sim::PayloadChange;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::sync::Arc;

/// Key, value and unit of a parameter.
type ParameterEntry = (String, f64, String);

/// An experiment that can be run again and again with other values of its keys.
#[pyclass(frozen, module = "hydrocrane._core")]
pub struct SensitivityExperiment {
    inner: Experiment,
    cylinders: usize,
}

fn error(source: &str, e: SensitivityError) -> PyErr {
    match e {
        SensitivityError::Machine(e) => file_error(&e),
        SensitivityError::Build(e) => cannot_build(source, &e),
        _ => PyValueError::new_err(e.to_string()),
    }
}

fn entries(parameters: Vec<Parameter>) -> Vec<ParameterEntry> {
    parameters.into_iter().map(|p| (p.key, p.value, p.unit)).collect()
}

#[pymethods]
impl SensitivityExperiment {
    /// A scenario with spool commands on `machine`, which `source` and the pairs make; `start` is a pose where `at_rest`, else a state.
    #[new]
    #[allow(clippy::too_many_arguments)]
    fn new(
        machine: &Machine,
        source: &str,
        pairs: &Bound<'_, PyList>,
        scenario: ScenarioEntry<'_>,
        keys: Vec<String>,
        start: Row<'_>,
        at_rest: bool,
        record_times: Row<'_>,
        resolve_sensitivities: bool,
    ) -> PyResult<Self> {
        let cylinders = machine.model.machine().cylinders.iter().map(|cylinder| cylinder.name.as_str());
        let plan = scenario.scenario(&cylinders.collect::<Vec<_>>())?;
        let start = start.as_slice()?.to_vec();
        let inner = Experiment {
            source: source.to_string(),
            overrides: overrides(pairs)?,
            keys,
            start: if at_rest { Start::Rest(start) } else { Start::State(start) },
            end: plan.duration,
            commands: commands(&plan.commands, machine.model.as_ref()).map_err(PyValueError::new_err)?,
            supply: plan.supply.map(Arc::new),
            bursts: plan.faults.bursts,
            payload_changes: plan.load.changes.iter().map(|&(time, mass)| PayloadChange { time, mass }).collect(),
            record: record_times.as_slice()?.to_vec(),
            solver: plan.solver,
            max_steps: MAX_STEPS,
            resolve_sensitivities,
        };
        Ok(SensitivityExperiment { inner, cylinders: plan.cylinders.len() })
    }

    /// Key, value and unit of each parameter, as the machine has them.
    fn parameters(&self) -> PyResult<Vec<ParameterEntry>> {
        sensitivity::parameters(&self.inner).map(entries).map_err(|e| error(&self.inner.source, e))
    }

    /// `values`: of the keys, in place of the machine's. `watch` is told the time now and then, and says when to stop.
    fn run<'py>(
        &self,
        py: Python<'py>,
        values: Option<Vec<f64>>,
        watch: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let done = py.detach(|| {
            let mut keep_going = |t: f64| watch.as_ref().is_none_or(|watch| goes_on(watch, t));
            sensitivity::sensitivities(&self.inner, values.as_deref(), &mut keep_going)
        });
        self.result(py, done.map_err(|e| error(&self.inner.source, e))?)
    }
}

fn goes_on(watch: &Py<PyAny>, t: f64) -> bool {
    Python::attach(|py| {
        let answer = watch.call1(py, (t,)).and_then(|stop| stop.extract::<bool>(py));
        py.check_signals().is_ok() && !answer.unwrap_or(true)
    })
}

impl SensitivityExperiment {
    fn result<'py>(&self, py: Python<'py>, done: Sensitivities) -> PyResult<Bound<'py, PyDict>> {
        let out = PyDict::new(py);
        let (signals, parameters) = (done.signals.len(), done.parameters.len());
        out.set_item("t", vector(py, done.times))?;
        out.set_item("values", matrix(py, done.values, signals)?)?;
        out.set_item("sensitivities", tensor(py, done.sensitivities, (signals, parameters))?)?;
        out.set_item("commands", matrix(py, done.commands, self.cylinders)?)?;
        out.set_item("payloads", vector(py, done.payloads))?;
        let events: Vec<PayloadEntry> = done.payload_events.iter().map(payload_entry).collect();
        out.set_item("payload_changes", events)?;
        let names: Vec<_> = done.signals.into_iter().map(|s| (s.name, s.unit, s.long_name)).collect();
        out.set_item("signals", names)?;
        out.set_item("parameters", entries(done.parameters))?;
        out.set_item("warnings", warnings_of(done.warnings))?;
        out.set_item("outcome", outcome_of(done.outcome))?;
        out.set_item("method", done.method)?;
        out.set_item("stats", statistics_of(py, (done.accepted, done.rejected), done.effort)?)?;
        Ok(out)
    }
}
