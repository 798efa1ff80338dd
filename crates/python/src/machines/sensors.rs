//! Sensors and their faults from what Python hands over.

use crate::handed::arrays::{matrix, rows, Row, Rows};
use crate::machines::machine::Machine;
use hydrocrane_sim::{FaultKind, SensorFault, SensorMode, Sensors};
use numpy::PyArray2;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Name, kind, start (s), end (s, may be infinite) and size of a sensor's fault.
pub type FaultEntry = (String, String, f64, f64, f64);

/// Sensors of a machine; the error names an unknown mode, kind of fault or signal.
pub fn sensors(machine: &Machine, mode: &str, seed: u64, faults: &[FaultEntry]) -> PyResult<Sensors> {
    let made = Sensors::new(machine.model.as_ref(), sensor_mode(mode)?, seed, &sensor_faults(faults)?);
    made.map_err(PyValueError::new_err)
}

pub fn sensor_mode(mode: &str) -> PyResult<SensorMode> {
    match mode {
        "ideal" => Ok(SensorMode::Ideal),
        "data-sheet" => Ok(SensorMode::DataSheet),
        _ => Err(PyValueError::new_err(format!("sensors must be `ideal` or `data-sheet`, got `{mode}`"))),
    }
}

/// The error names an unknown kind.
pub fn sensor_faults(faults: &[FaultEntry]) -> PyResult<Vec<SensorFault>> {
    let fault = |(signal, kind, from, until, size): &FaultEntry| {
        let kind = match kind.as_str() {
            "freeze" => FaultKind::Freeze,
            "jump" => FaultKind::Jump(*size),
            "drop-out" => FaultKind::DropOut,
            _ => {
                let message = format!("a sensor can `freeze`, `jump` or `drop-out`, not `{kind}`");
                return Err(PyValueError::new_err(message));
            }
        };
        let until = until.is_finite().then_some(*until);
        Ok(SensorFault { signal: signal.clone(), kind, from: *from, until })
    };
    faults.iter().map(fault).collect()
}

pub fn fault_entry(fault: &SensorFault) -> FaultEntry {
    let (kind, size) = match fault.kind {
        FaultKind::Freeze => ("freeze", 0.0),
        FaultKind::Jump(size) => ("jump", size),
        FaultKind::DropOut => ("drop-out", 0.0),
    };
    (fault.signal.clone(), kind.into(), fault.from, fault.until.unwrap_or(f64::INFINITY), size)
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
