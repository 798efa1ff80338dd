//! Sensors and their faults from what Python hands over.

use crate::machine::Machine;
use hydrocrane_sim::{FaultKind, SensorFault, SensorMode, Sensors};
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
        Ok(SensorFault { signal: signal.clone(), kind, from: *from, until: *until })
    };
    faults.iter().map(fault).collect()
}
