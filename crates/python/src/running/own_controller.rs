//! Controllers written in Python.

use hydrocrane_sim::controller::{Controller, Fault, Measurement, Stick};
use pyo3::prelude::*;

/// A controller written in Python: `reset(t, q, p)`, `step(t, q, p, axes)` and `set_point()`; after an exception
/// `failure()` says what it was, and whether the run shall end.
pub struct PythonController {
    object: Py<PyAny>,
    period: f64,
    /// An exception of its making or of `reset`, which have no answer of their own.
    failed: Option<Fault>,
}

/// Time between samples where a scenario states none, s.
const PERIOD: f64 = 0.01;

impl PythonController {
    /// Of an `object` that was made, or could not be.
    pub fn new(py: Python, object: PyResult<Bound<PyAny>>, period: Option<f64>) -> Self {
        let (object, failed) = match object {
            Ok(object) => (object.unbind(), None),
            Err(error) => (py.None(), Some(Fault::Fatal(error.to_string()))),
        };
        PythonController { object, period: period.unwrap_or(PERIOD), failed }
    }

    fn ask(&self, method: &str, measured: &Measurement, axes: Option<&[f64]>) -> Result<Vec<f64>, Fault> {
        Python::attach(|py| {
            let (q, p) = (measured.q.to_vec(), measured.p.to_vec());
            let answer = match axes {
                None => self.object.call_method1(py, method, (measured.t, q, p)),
                Some(axes) => self.object.call_method1(py, method, (measured.t, q, p, axes.to_vec())),
            };
            let values = answer.and_then(|value| value.extract::<Option<Vec<f64>>>(py));
            values.map(Option::unwrap_or_default).map_err(|error| self.fault(py, &error))
        })
    }

    fn fault(&self, py: Python, error: &PyErr) -> Fault {
        let answer = self.object.call_method0(py, "failure").and_then(|answer| answer.extract::<(String, bool)>(py));
        match answer {
            Ok((text, true)) => Fault::Fatal(text),
            Ok((text, false)) => Fault::Failed(text),
            Err(_) => Fault::Fatal(error.to_string()),
        }
    }
}

impl Controller for PythonController {
    fn period(&self) -> f64 {
        self.period
    }

    fn reset(&mut self, first: &Measurement) {
        if self.failed.is_none() {
            self.failed = self.ask("reset", first, None).err();
        }
    }

    fn step(&mut self, measured: &Measurement, stick: Stick, spool: &mut [f64]) -> Result<(), Fault> {
        if let Some(fault) = &self.failed {
            return Err(fault.clone());
        }
        let answer = match stick {
            Stick::Tip(axes) | Stick::Lever(axes) | Stick::Height(axes) => self.ask("step", measured, Some(axes)),
            Stick::Goal(_) => return Err(Fault::WrongStick("tip")),
        };
        let command = answer?;
        if command.len() != spool.len() {
            let (got, wanted) = (command.len(), spool.len());
            return Err(Fault::Fatal(format!("the controller gave {got} spool commands for {wanted} cylinders")));
        }
        spool.copy_from_slice(&command);
        Ok(())
    }

    fn set_point(&self) -> Option<[f64; 2]> {
        self.set_point_in_space().map(|[x, _, z]| [x, z])
    }

    fn set_point_in_space(&self) -> Option<[f64; 3]> {
        Python::attach(|py| {
            self.object.call_method0(py, "set_point").and_then(|point| point.extract(py)).ok().flatten()
        })
    }
}
