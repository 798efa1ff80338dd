//! Many cranes at once.

use crate::handed::arrays::{matrix, rows, vector, Numbers, Row, Rows};
use crate::handed::errors::error_of_crane;
use crate::handed::overrides::overrides;
use crate::handed::shared::Shared;
use crate::machines::machine::Machine;
use hydrocrane_machine::OverrideValue;
use hydrocrane_sim::batch::{Batch, BatchOptions};
use hydrocrane_sim::Warning;
use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyList;

/// A value for a key.
type Change = (String, OverrideValue);

#[pyclass(frozen, module = "hydrocrane._core")]
pub struct BatchSimulator {
    batch: Shared<Batch>,
    states: usize,
    cylinders: usize,
    observed: usize,
}

impl BatchSimulator {
    /// What `of` gives of each crane.
    fn each<R: Send>(&self, py: Python<'_>, of: impl Fn(&Batch, usize) -> R + Sync) -> PyResult<Vec<R>> {
        self.batch.ask(py, |batch| (0..batch.cranes()).map(|crane| of(batch, crane)).collect())
    }
}

#[pymethods]
impl BatchSimulator {
    #[new]
    #[allow(clippy::too_many_arguments)]
    fn new(
        machine: &Machine,
        cranes: usize,
        sample_time: f64,
        step: f64,
        tolerance: f64,
        threads: usize,
        instruction_set: Option<String>,
    ) -> PyResult<Self> {
        let options = BatchOptions { sample_time, step, tolerance, threads, instruction_set };
        let batch = Batch::new(machine.model.clone(), cranes, &options)
            .ok_or_else(|| PyRuntimeError::new_err(format!("{threads} threads cannot be started")))?;
        let (layout, observed) = (machine.model.layout(), batch.observed());
        let (states, cylinders) = (layout.len(), layout.joints());
        Ok(BatchSimulator { batch: Shared::new(batch), states, cylinders, observed })
    }

    /// The machines that `base` becomes for these cranes by the changes of each. The error names the first crane that cannot be one.
    fn machines(
        &self,
        py: Python<'_>,
        base: &Machine,
        cranes: Numbers<'_>,
        changes: Vec<Bound<'_, PyList>>,
    ) -> PyResult<Vec<Machine>> {
        let changes: Vec<_> = changes.iter().map(overrides).collect::<PyResult<_>>()?;
        let cranes = cranes.as_slice()?.to_vec();
        self.batch.ask(py, |batch| {
            let made = batch.each(&changes, |changes| base.with(changes));
            let together = cranes.iter().zip(&changes).zip(made);
            let checked = together.map(|((crane, changes), made)| {
                let made = made.map_err(|error| error_of_crane(*crane, &error))?;
                if batch.takes(made.model.as_ref()) {
                    return Ok(made);
                }
                let alone =
                    |change: &&Change| base.with(&[(*change).clone()]).is_ok_and(|m| !batch.takes(m.model.as_ref()));
                let key = changes.iter().find(alone).or(changes.first()).map_or("", |(key, _)| key);
                Err(PyValueError::new_err(format!(
                    "crane {crane}: `{key}` adds a part, or changes a table or a law, and all cranes of a batch have the same; \
                     set it in the machine of the whole batch, or make a batch for each"
                )))
            });
            checked.collect()
        })?
    }

    /// Makes the cranes of these numbers these machines, in these states with these payloads. The error names the first that cannot
    /// start.
    fn reset(
        &self,
        py: Python<'_>,
        cranes: Numbers<'_>,
        machines: Vec<PyRef<'_, Machine>>,
        states: Rows<'_>,
        payloads: Row<'_>,
    ) -> PyResult<()> {
        let (table, payloads) = (rows(&states, self.states, "state")?.to_vec(), payloads.as_slice()?.to_vec());
        let (cranes, machines): (Vec<_>, Vec<_>) =
            cranes.as_slice()?.iter().copied().zip(machines.iter().map(|machine| machine.model.clone())).unzip();
        self.batch.ask(py, |batch| {
            let starts = table.chunks_exact(self.states).zip(payloads);
            for ((crane, model), (state, payload)) in cranes.iter().zip(machines).zip(starts) {
                let fault = batch.reset(*crane as usize, model.as_ref(), state, payload);
                fault.map_err(|message| PyValueError::new_err(format!("crane {crane}: {message}")))?;
            }
            Ok(())
        })?
    }

    /// One sample with the commands held.
    fn step(&self, py: Python<'_>, commands: Rows<'_>) -> PyResult<()> {
        let commands = rows(&commands, self.cylinders, "spool_commands")?;
        self.batch.ask(py, |batch| batch.step(commands))
    }

    /// Per crane q, qd, the pressures p1 and p2 by cylinder, and the tip.
    fn observe<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows = self.batch.ask(py, |batch| batch.observe())?;
        matrix(py, rows, self.observed)
    }

    fn set_payload(&self, py: Python<'_>, cranes: Numbers<'_>, masses: Row<'_>) -> PyResult<()> {
        let (cranes, masses) = (cranes.as_slice()?, masses.as_slice()?);
        self.batch.ask(py, |batch| {
            cranes.iter().zip(masses).for_each(|(crane, mass)| {
                batch.set_payload(*crane as usize, *mass);
            })
        })
    }

    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let states = self.each(py, Batch::state)?;
        matrix(py, states.concat(), self.states)
    }

    #[getter]
    fn payload<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(vector(py, self.each(py, Batch::payload)?))
    }

    #[getter]
    fn time<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(vector(py, self.each(py, |batch, crane| batch.status(crane).time)?))
    }

    /// Outcome kinds.
    #[getter]
    fn outcomes(&self, py: Python<'_>) -> PyResult<Vec<&'static str>> {
        self.each(py, |batch, crane| batch.status(crane).kind.name())
    }

    #[getter]
    fn alive<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<bool>>> {
        Ok(PyArray1::from_vec(py, self.each(py, |batch, crane| batch.status(crane).kind.name() == "completed")?))
    }

    /// Whether a finest step had an error beyond the tolerance since the reset.
    #[getter]
    fn inexact<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<bool>>> {
        Ok(PyArray1::from_vec(py, self.each(py, |batch, crane| batch.status(crane).inexact)?))
    }

    /// The first crane that got a command far beyond the stroke of a spool since its reset; kind, text and cure of the warning.
    #[getter]
    fn astray(&self, py: Python<'_>) -> PyResult<Option<(usize, &'static str, String, String)>> {
        let of =
            |(crane, warning): &(usize, Warning)| (*crane, warning.kind, warning.text.clone(), warning.cure.clone());
        self.batch.ask(py, |batch| batch.astray().map(of))
    }

    #[getter]
    fn threads(&self, py: Python<'_>) -> PyResult<usize> {
        self.batch.ask(py, |batch| batch.threads())
    }

    #[getter]
    fn instruction_set(&self, py: Python<'_>) -> PyResult<&'static str> {
        self.batch.ask(py, |batch| batch.instruction_set())
    }
}
