//! Many cranes at once.

use crate::handed::arrays::{matrix, rows, vector, Numbers, Row, Rows};
use crate::handed::errors::error_of_crane;
use crate::handed::overrides::overrides;
use crate::machines::machine::Machine;
use hydrocrane_machine::OverrideValue;
use hydrocrane_sim::batch::{Batch, BatchOptions};
use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyList;

/// A value for a key.
type Change = (String, OverrideValue);

#[pyclass(module = "hydrocrane._core")]
pub struct BatchSimulator {
    inner: Batch,
    states: usize,
    cylinders: usize,
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
        let inner = Batch::new(machine.model.clone(), cranes, &options)
            .ok_or_else(|| PyRuntimeError::new_err(format!("{threads} threads cannot be started")))?;
        let layout = machine.model.layout();
        Ok(BatchSimulator { inner, states: layout.len(), cylinders: layout.joints() })
    }

    /// The machines that `base` becomes for these cranes by the changes of each. The error names the first crane that cannot be one.
    fn machines(
        &mut self,
        py: Python<'_>,
        base: &Machine,
        cranes: Numbers<'_>,
        changes: Vec<Bound<'_, PyList>>,
    ) -> PyResult<Vec<Machine>> {
        let changes: Vec<_> = changes.iter().map(overrides).collect::<PyResult<_>>()?;
        let made = py.detach(|| self.inner.each(&changes, |changes| base.with(changes)));
        let together = cranes.as_slice()?.iter().zip(&changes).zip(made);
        let checked = together.map(|((crane, changes), made)| {
            let made = made.map_err(|error| error_of_crane(*crane, &error))?;
            if self.inner.takes(made.model.as_ref()) {
                return Ok(made);
            }
            let alone = |change: &&Change| base.with(&[(*change).clone()]).is_ok_and(|m| !self.inner.takes(m.model.as_ref()));
            let key = changes.iter().find(alone).or(changes.first()).map_or("", |(key, _)| key);
            Err(PyValueError::new_err(format!(
                "crane {crane}: `{key}` adds a part, or changes a table or a law, and all cranes of a batch have the same; \
                 set it in the machine of the whole batch, or make a batch for each"
            )))
        });
        checked.collect()
    }

    /// Makes the cranes of these numbers these machines, in these states with these payloads. The error names the first that cannot
    /// start.
    fn reset(
        &mut self,
        cranes: Numbers<'_>,
        machines: Vec<PyRef<'_, Machine>>,
        states: Rows<'_>,
        payloads: Row<'_>,
    ) -> PyResult<()> {
        let table = rows(&states, self.states, "state")?;
        let starts = table.chunks_exact(self.states).zip(payloads.as_slice()?);
        for ((crane, machine), (state, payload)) in cranes.as_slice()?.iter().zip(machines).zip(starts) {
            let fault = self.inner.reset(*crane as usize, machine.model.as_ref(), state, *payload);
            fault.map_err(|message| PyValueError::new_err(format!("crane {crane}: {message}")))?;
        }
        Ok(())
    }

    /// One sample with the commands held.
    fn step(&mut self, py: Python<'_>, commands: Rows<'_>) -> PyResult<()> {
        let commands = rows(&commands, self.cylinders, "spool_commands")?;
        py.detach(|| self.inner.step(commands));
        Ok(())
    }

    /// Per crane q, qd, the pressures p1 and p2 by cylinder, and the tip.
    fn observe<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows = py.detach(|| self.inner.observe());
        matrix(py, rows, self.inner.observed())
    }

    fn set_payload(&mut self, cranes: Numbers<'_>, masses: Row<'_>) -> PyResult<()> {
        for (crane, mass) in cranes.as_slice()?.iter().zip(masses.as_slice()?) {
            self.inner.set_payload(*crane as usize, *mass);
        }
        Ok(())
    }

    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let states = (0..self.inner.cranes()).flat_map(|crane| self.inner.state(crane)).collect();
        matrix(py, states, self.states)
    }

    #[getter]
    fn payload<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, (0..self.inner.cranes()).map(|crane| self.inner.payload(crane)).collect())
    }

    #[getter]
    fn time<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, (0..self.inner.cranes()).map(|crane| self.inner.status(crane).time).collect())
    }

    /// Outcome kinds.
    #[getter]
    fn outcomes(&self) -> Vec<&'static str> {
        (0..self.inner.cranes()).map(|crane| self.inner.status(crane).kind.name()).collect()
    }

    #[getter]
    fn alive<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        let well = |crane| self.inner.status(crane).kind.name() == "completed";
        PyArray1::from_iter(py, (0..self.inner.cranes()).map(well))
    }

    /// Whether a finest step had an error beyond the tolerance since the reset.
    #[getter]
    fn inexact<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        PyArray1::from_iter(py, (0..self.inner.cranes()).map(|crane| self.inner.status(crane).inexact))
    }

    /// The first crane that got a command far beyond the stroke of a spool since its reset; kind, text and cure of the warning.
    #[getter]
    fn astray(&self) -> Option<(usize, &'static str, &str, &str)> {
        self.inner.astray().map(|(crane, warning)| (*crane, warning.kind, &*warning.text, &*warning.cure))
    }

    #[getter]
    fn threads(&self) -> usize {
        self.inner.threads()
    }

    #[getter]
    fn instruction_set(&self) -> &'static str {
        self.inner.instruction_set()
    }
}
