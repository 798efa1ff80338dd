//! Closed-loop runs: controllers by name, and controllers written in Python.

use crate::arrays::{matrix, rows, vector, Row, Rows};
use crate::machine::Machine;
use crate::sensors::{sensor_faults, sensor_mode, sensors, FaultEntry};
use crate::simulation::{record_of, stopper, Settings};
use hydrocrane_sim::controller::{Controller, Fault, Measurement, Stick};
use hydrocrane_sim::{simulate_phases, Driver, Phase, SampledPlan, Samples, Sensors, StickKind, Sticks};
use numpy::PyArray2;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// What surrounds the controller, as the facade hands it over.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Plan {
    period: f64,
    delay: f64,
    sensors: String,
    seed: u64,
    faults: Vec<FaultEntry>,
    mode: String,
    stick_times: Vec<f64>,
    /// One row per time.
    deflections: Vec<Vec<f64>>,
    linear: bool,
    dead_zone: f64,
    ramp: f64,
    monitor: bool,
}

impl Plan {
    fn sticks(&self, cylinders: usize) -> Sticks {
        let kind = if self.mode == "lever" { StickKind::Lever } else { StickKind::Tip };
        Sticks {
            times: self.stick_times.clone(),
            deflections: self.deflections.concat(),
            linear: self.linear,
            dead_zone: self.dead_zone,
            ramp: self.ramp,
            ..Sticks::centred(kind, cylinders)
        }
    }
}

/// What the sensors of a machine would have read: the signals, and one row of readings per row of `states`.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub fn measure<'py>(
    py: Python<'py>,
    machine: &Machine,
    times: Row<'py>,
    states: Rows<'py>,
    payload: f64,
    mode: &str,
    seed: u64,
    faults: Vec<FaultEntry>,
) -> PyResult<(Vec<String>, Bound<'py, PyArray2<f64>>)> {
    let model = machine.model.clone();
    let (times, states) = (times.as_slice()?.to_vec(), rows(&states, model.layout().len(), "states")?.to_vec());
    let made = Sensors::for_record(model.as_ref(), sensor_mode(mode)?, seed, &sensor_faults(&faults)?);
    let mut sensors = made.map_err(PyValueError::new_err)?;
    let readings = py.detach(|| sensors.measure(model.as_ref(), &times, &states, payload));
    let signals: Vec<String> = sensors.signals().map(str::to_string).collect();
    let table = matrix(py, readings, signals.len())?;
    Ok((signals, table))
}

/// A controller written in Python: `reset(t, q, p)`, `step(t, q, p, axes)` and `set_point()`; after an exception
/// `failure()` says what it was, and whether the run shall end.
struct PythonController {
    object: Py<PyAny>,
    period: f64,
    /// An exception of `reset`, which has no answer of its own.
    failed: Option<Fault>,
}

impl PythonController {
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
        let told = self.object.call_method0(py, "failure").and_then(|told| told.extract::<(String, bool)>(py));
        match told {
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
        self.failed = self.ask("reset", first, None).err();
    }

    fn step(&mut self, measured: &Measurement, stick: Stick, spool: &mut [f64]) -> Result<(), Fault> {
        if let Some(fault) = &self.failed {
            return Err(fault.clone());
        }
        let answer = match stick {
            Stick::Tip(axes) => self.ask("step", measured, Some(&axes)),
            Stick::Lever(axes) => self.ask("step", measured, Some(axes)),
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
        Python::attach(|py| {
            self.object.call_method0(py, "set_point").and_then(|point| point.extract(py)).ok().flatten()
        })
    }
}

/// From a time on: a machine, a controller and what surrounds it.
///
/// `controller` is a name or an object with the methods of [`PythonController`]; `believed` is the machine from which a
/// controller by name takes its controller model.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct PhaseEntry<'py> {
    from: f64,
    machine: PyRef<'py, Machine>,
    controller: Bound<'py, PyAny>,
    believed: PyRef<'py, Machine>,
    plan: Plan,
}

impl PhaseEntry<'_> {
    fn controller(&self) -> PyResult<Box<dyn Controller>> {
        let believed = &self.believed.model;
        let controller: Box<dyn Controller> = match self.controller.extract::<String>() {
            Ok(name) => believed.controller(&name).map_err(PyValueError::new_err)?,
            Err(_) => {
                let object = self.controller.clone().unbind();
                Box::new(PythonController { object, period: self.plan.period, failed: None })
            }
        };
        Ok(if self.plan.monitor { believed.with_sensor_monitor(controller, self.plan.delay) } else { controller })
    }

    fn surroundings(&self) -> PyResult<SampledPlan> {
        let plan = &self.plan;
        Ok(SampledPlan {
            sticks: plan.sticks(self.machine.model.machine().cylinders.len()),
            sensors: sensors(&self.machine, &plan.sensors, plan.seed, &plan.faults)?,
            delay: plan.delay,
        })
    }
}

/// A run in phases, the first from time zero on.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub fn simulate_controlled<'py>(
    py: Python<'py>,
    x0: Row<'py>,
    t_end: f64,
    phases: Vec<PhaseEntry<'py>>,
    record_times: Row<'py>,
    settings: Settings,
    should_stop: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let mut controllers = phases.iter().map(PhaseEntry::controller).collect::<PyResult<Vec<_>>>()?;
    let plans = phases.iter().map(PhaseEntry::surroundings).collect::<PyResult<Vec<_>>>()?;
    let models: Vec<_> = phases.iter().map(|phase| (phase.from, phase.machine.model.clone())).collect();
    let (x0, record) = (x0.as_slice()?.to_vec(), record_times.as_slice()?.to_vec());
    let options = settings.options();
    let done = py.detach(|| {
        let mut keep_going = stopper(should_stop.as_ref());
        let each = models.iter().zip(&mut controllers).zip(&plans);
        let mut made = each.map(|(((from, model), controller), plan)| Phase {
            from: *from,
            model: model.as_ref(),
            driver: Driver::Controller(controller.as_mut(), plan),
        });
        let first = made.next()?;
        Some(simulate_phases(&x0, t_end, first, made.collect(), &record, &options, &mut keep_going))
    });
    let (Some(done), Some(first)) = (done, phases.first()) else {
        return Err(PyValueError::new_err("a controlled run needs at least one phase"));
    };
    let out = record_of(py, &first.machine, done.run)?;
    let began = done.samples.into_iter().zip(&phases).zip(&plans);
    let samples: PyResult<Vec<_>> = began.map(|((rows, phase), plan)| samples_of(py, rows, phase, plan)).collect();
    out.set_item("samples", samples?)?;
    let events: Vec<(f64, String)> = done.events.into_iter().map(|event| (event.time, event.text)).collect();
    out.set_item("events", events)?;
    Ok(out)
}

fn samples_of<'py>(
    py: Python<'py>,
    rows: Samples,
    phase: &PhaseEntry,
    plan: &SampledPlan,
) -> PyResult<Bound<'py, PyDict>> {
    let signals: Vec<&str> = plan.sensors.signals().collect();
    let samples = PyDict::new(py);
    samples.set_item("t", vector(py, rows.times))?;
    samples.set_item("measured", matrix(py, rows.measured, signals.len())?)?;
    samples.set_item("sticks", matrix(py, rows.sticks, plan.sticks.axes)?)?;
    samples.set_item("set_points", matrix(py, rows.set_points.concat(), 2)?)?;
    samples.set_item("commands", matrix(py, rows.commands, phase.machine.model.layout().joints())?)?;
    samples.set_item("signals", signals)?;
    Ok(samples)
}
