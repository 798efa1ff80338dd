//! A controller by name that a program steps itself, away from any simulation.

use crate::machines::machine::Machine;
use hydrocrane_sim::controller::{Controller, Measurement, Stick};
use hydrocrane_sim::controller_memory;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::borrow::Cow;
use std::sync::{Mutex, MutexGuard, PoisonError};

#[pyclass(frozen, module = "hydrocrane._core")]
pub struct SteppedController {
    inner: Mutex<Box<dyn Controller>>,
    cylinders: usize,
    /// Those of (x, y, z) along which the tip moves.
    axes: &'static [usize],
}

impl SteppedController {
    fn inner(&self) -> MutexGuard<'_, Box<dyn Controller>> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl SteppedController {
    /// The controller `name` that knows `machine`; behind a monitor of the sensors its commands leave `delay` (s) after a sample.
    #[new]
    fn new(machine: &Machine, name: &str, monitor: bool, delay: f64) -> PyResult<Self> {
        let model = &machine.model;
        let controller = model.controller(name).map_err(PyValueError::new_err)?;
        let controller = if monitor { model.with_sensor_monitor(controller, delay) } else { controller };
        let (cylinders, axes) = (model.machine().cylinders.len(), model.tip_axes());
        Ok(SteppedController { inner: Mutex::new(controller), cylinders, axes })
    }

    fn reset(&self, t: f64, q: Vec<f64>, p: Vec<[f64; 2]>) {
        self.inner().reset(&Measurement { t, q: &q, p: &p });
    }

    /// Spool commands, and why there are none where there are none; what has happened.
    fn step(
        &self,
        t: f64,
        q: Vec<f64>,
        p: Vec<[f64; 2]>,
        mode: &str,
        axes: Vec<f64>,
    ) -> PyResult<(Vec<f64>, Option<String>, Vec<String>)> {
        let stick = match (mode, axes.as_slice()) {
            ("tip", axes) if axes.len() == 2 || axes.len() == self.axes.len() => Stick::Tip(axes),
            ("lever", axes) => Stick::Lever(axes),
            ("height", axes) => Stick::Height(axes),
            _ => {
                let (given, takes) = (axes.len(), self.axes.len());
                let text = format!("a stick of mode `{mode}` has {given} axes; this crane takes {takes} of mode `tip`");
                return Err(PyValueError::new_err(text));
            }
        };
        let mut command = vec![0.0; self.cylinders];
        let mut inner = self.inner();
        let answer = inner.step(&Measurement { t, q: &q, p: &p }, stick, &mut command);
        let fault = answer.err().map(|fault| fault.to_string());
        if fault.is_some() {
            command.fill(0.0);
        }
        Ok((command, fault, inner.notices().into_iter().map(|report| report.text).collect()))
    }

    #[getter]
    fn period(&self) -> f64 {
        self.inner().period()
    }

    #[getter]
    fn set_point(&self) -> Option<Vec<f64>> {
        let place = self.inner().set_point_in_space()?;
        Some(self.axes.iter().map(|axis| place[*axis]).collect())
    }
}

/// Parameters of the controller `name` that knows `machine`, for a machine without an operating system, and the bytes of memory
/// that it needs there; with a monitor of the sensors its commands leave `delay` (s) after a sample.
#[pyfunction]
pub fn controller_parameters(
    machine: &Machine,
    name: &str,
    monitor: bool,
    delay: f64,
) -> PyResult<(Cow<'static, [u8]>, usize)> {
    let monitored = monitor.then_some(delay);
    let block = machine.model.controller_parameters(name, monitored).map_err(PyValueError::new_err)?;
    Ok((Cow::Owned(block), controller_memory(machine.model.machine().cylinders.len())))
}
