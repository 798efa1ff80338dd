//! Machine and scenario files.

use crate::handed::answers::warnings_of;
use crate::handed::errors::{assembly_error, file_error};
use crate::handed::overrides::{overrides, pairs_of};
use crate::machines::machine::Machine;
use hydrocrane_machine::scenario::{
    Burst, ControllerChoice, FaultKind, Interpolation, Joystick, Phase, Pressures, SensorFault, SensorQuality,
    SupplyPressure,
};
use hydrocrane_machine::FileKind;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};

#[pyfunction]
pub fn load_machine(py: Python<'_>, source: &str, pairs: &Bound<'_, PyList>) -> PyResult<Machine> {
    let changes = overrides(pairs)?;
    py.detach(|| Machine::open(source, &changes)).map_err(|error| assembly_error(&error))
}

/// As [`load_machine`], from a text that names no files; `source` is what errors call it.
#[pyfunction]
pub fn machine_of_text(py: Python<'_>, text: &str, source: &str, pairs: &Bound<'_, PyList>) -> PyResult<Machine> {
    let changes = overrides(pairs)?;
    py.detach(|| Machine::of_text(text, source, &changes)).map_err(|error| assembly_error(&error))
}

#[pyfunction]
pub fn load_scenario<'py>(py: Python<'py>, source: &str, pairs: &Bound<'py, PyList>) -> PyResult<Bound<'py, PyDict>> {
    let s = hydrocrane_machine::load_scenario(source, &overrides(pairs)?).map_err(|e| file_error(&e))?;
    let out = PyDict::new(py);
    out.set_item("name", s.name)?;
    out.set_item("title", s.title)?;
    out.set_item("machine", s.machine)?;
    out.set_item("overrides", pairs_of(py, &s.overrides)?)?;
    out.set_item("payload", s.load.payload)?;
    out.set_item("payload_changes", s.load.changes)?;
    out.set_item("duration", s.duration)?;
    out.set_item("record_interval", s.record_interval)?;
    out.set_item("seed", s.seed)?;
    let joints = PyDict::new(py);
    for (name, q) in &s.initial.joints {
        joints.set_item(name, q)?;
    }
    out.set_item("joints", joints)?;
    out.set_item("places", &s.initial.places)?;
    match &s.initial.pressures {
        Pressures::Equilibrium => out.set_item("pressures", "equilibrium")?,
        Pressures::Explicit(pairs) => {
            let pressures = PyDict::new(py);
            for (name, p) in pairs {
                pressures.set_item(name, PyTuple::new(py, p)?)?;
            }
            out.set_item("pressures", pressures)?;
        }
    }
    let commands = PyDict::new(py);
    for c in s.commands {
        let command = PyDict::new(py);
        command.set_item("time", c.time)?;
        command.set_item("spool", c.spool)?;
        command.set_item("interpolation", word(c.interpolation))?;
        commands.set_item(c.cylinder, command)?;
    }
    out.set_item("commands", commands)?;
    out.set_item("supply", s.supply.map(|supply| supply_of(py, supply)).transpose()?)?;
    out.set_item("controller", s.controller.map(|c| controller_of(py, c)).transpose()?)?;
    out.set_item("cylinders", s.cylinders)?;
    out.set_item("joystick", s.joystick.map(|j| joystick_of(py, j)).transpose()?)?;
    let goals = s.goals.iter().map(|goal| (goal.time, goal.place, goal.speed, goal.until));
    out.set_item("goals", goals.collect::<Vec<_>>())?;
    let phases: PyResult<Vec<_>> = s.phases.into_iter().map(|phase| phase_of(py, phase)).collect();
    out.set_item("phases", phases?)?;
    out.set_item("recorded_by", s.recorded.by)?;
    out.set_item("warnings", warnings_of(hydrocrane_sim::implausible(&s.warnings)))?;
    let faults: PyResult<Vec<_>> = s.faults.sensors.into_iter().map(|f| fault_of(py, f)).collect();
    out.set_item("sensor_faults", faults?)?;
    out.set_item("bursts", s.faults.bursts.iter().map(Burst::entry).collect::<Vec<_>>())?;
    let solver = PyDict::new(py);
    solver.set_item("method", s.solver.method)?;
    solver.set_item("rtol", s.solver.rtol)?;
    solver.set_item("atol", s.solver.atol)?;
    solver.set_item("max_step", s.solver.max_step)?;
    solver.set_item("step", s.solver.step)?;
    out.set_item("solver", solver)?;
    Ok(out)
}

fn supply_of(py: Python<'_>, supply: SupplyPressure) -> PyResult<Bound<'_, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("time", supply.time)?;
    out.set_item("pressure", supply.pressure)?;
    out.set_item("interpolation", word(supply.interpolation))?;
    Ok(out)
}

fn word(interpolation: Interpolation) -> &'static str {
    match interpolation {
        Interpolation::Linear => "linear",
        Interpolation::Hold => "hold",
    }
}

fn phase_of<'py>(py: Python<'py>, p: Phase) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("time", p.time)?;
    out.set_item("overrides", pairs_of(py, &p.overrides)?)?;
    out.set_item("controller", p.controller.map(|c| controller_of(py, c)).transpose()?)?;
    out.set_item("joystick", p.joystick.map(|j| joystick_of(py, j)).transpose()?)?;
    Ok(out)
}

fn controller_of<'py>(py: Python<'py>, c: ControllerChoice) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("name", c.name)?;
    out.set_item("period", c.period)?;
    out.set_item("delay", c.delay)?;
    out.set_item("controller_model", pairs_of(py, &c.model)?)?;
    out.set_item("monitor", c.monitor)?;
    out.set_item("sensors", if c.sensors == SensorQuality::Ideal { "ideal" } else { "data-sheet" })?;
    Ok(out)
}

fn fault_of<'py>(py: Python<'py>, f: SensorFault) -> PyResult<Bound<'py, PyDict>> {
    let (kind, size) = match f.kind {
        FaultKind::Freeze => ("freeze", 0.0),
        FaultKind::Jump(size) => ("jump", size),
        FaultKind::DropOut => ("drop-out", 0.0),
    };
    let out = PyDict::new(py);
    out.set_item("signal", f.signal)?;
    out.set_item("kind", kind)?;
    out.set_item("time", f.from)?;
    out.set_item("until", f.until)?;
    out.set_item("size", size)?;
    Ok(out)
}

fn joystick_of<'py>(py: Python<'py>, j: Joystick) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("mode", j.mode.name())?;
    out.set_item("time", j.time)?;
    out.set_item("axes", j.axes)?;
    out.set_item("log", j.log)?;
    out.set_item("interpolation", word(j.interpolation))?;
    out.set_item("dead_zone", j.dead_zone)?;
    out.set_item("full_speed", j.full_speed)?;
    out.set_item("ramp", j.ramp)?;
    out.set_item("precision", j.precision)?;
    Ok(out)
}

#[pyfunction]
pub fn bundled_machines() -> Vec<&'static str> {
    hydrocrane_machine::bundled_machines().iter().map(|(name, _)| *name).collect()
}

#[pyfunction]
pub fn bundled_scenarios() -> Vec<&'static str> {
    hydrocrane_machine::bundled_scenarios().iter().map(|(name, _)| *name).collect()
}

/// The file behind a bundled name; `kind` is `machine` or `scenario`.
#[pyfunction]
pub fn bundled_text(kind: &str, name: &str) -> PyResult<&'static str> {
    let files = match kind {
        "machine" => hydrocrane_machine::bundled_machines(),
        "scenario" => hydrocrane_machine::bundled_scenarios(),
        _ => return Err(PyValueError::new_err(format!("kind must be `machine` or `scenario`, got `{kind}`"))),
    };
    let found = files.iter().find(|(n, _)| *n == name);
    found.map(|(_, text)| *text).ok_or_else(|| PyValueError::new_err(format!("no bundled {kind} `{name}`")))
}

/// `"140 bar"` as its SI value and the name of its dimension.
#[pyfunction]
#[pyo3(signature = (text, expected=None))]
pub fn quantity(text: &str, expected: Option<&str>) -> PyResult<(f64, String)> {
    hydrocrane_machine::quantity(text, expected).map_err(PyValueError::new_err)
}

/// Why this is no name, and the cure; `None` if it is one.
#[pyfunction]
pub fn name_fault(name: &str) -> Option<String> {
    hydrocrane_machine::name_fault(name).map(|(fault, cure)| format!("{fault}; {cure}"))
}

/// Why this is no text of one line; `None` if it is.
#[pyfunction]
pub fn text_fault(text: &str) -> Option<String> {
    hydrocrane_machine::text_fault(text)
}

/// Why a file may not name this path, and the cure; `None` if it may.
#[pyfunction]
pub fn path_fault(path: &str) -> Option<String> {
    hydrocrane_machine::path_fault(path).map(|(fault, cure)| format!("{fault}; {cure}"))
}

fn kind_of_file(name: &str) -> PyResult<FileKind> {
    let found = FileKind::ALL.into_iter().find(|(known, _)| *known == name);
    found
        .map(|(_, kind)| kind)
        .ok_or_else(|| PyValueError::new_err(format!("kind must be `machine` or `scenario`, got `{name}`")))
}

/// The JSON Schema of `machine` or `scenario` files.
#[pyfunction]
pub fn json_schema(kind: &str) -> PyResult<String> {
    Ok(kind_of_file(kind)?.json_schema())
}

/// Every key of `machine` or `scenario` files with all that is declared of it, as JSON.
#[pyfunction]
pub fn key_list(kind: &str) -> PyResult<String> {
    Ok(kind_of_file(kind)?.key_list())
}

/// Names at the top of a machine or scenario file; none if it cannot be read.
#[pyfunction]
pub fn tables_of(path: &str) -> Vec<String> {
    hydrocrane_machine::tables_of(path)
}

/// The text of a machine file with the content of all files that it needs.
#[pyfunction]
pub fn machine_text(path: &str) -> PyResult<String> {
    hydrocrane_machine::whole_text(path).map_err(|error| file_error(&error))
}
