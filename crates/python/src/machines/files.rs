//! Machine and scenario files.

use crate::handed::answers::{warnings_of, WarningEntry};
use crate::handed::errors::{assembly_error, file_error};
use crate::handed::overrides::overrides;
use crate::machines::machine::Machine;
use crate::machines::scenario::{Head, ScenarioEntry};
use hydrocrane_machine::FileKind;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyList;

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

/// Name, title, machine and version of its recorder, and whether values are unusual; then the scenario.
type FileEntry<'py> = (Head, Vec<WarningEntry>, ScenarioEntry<'py>);

#[pyfunction]
pub fn load_scenario<'py>(py: Python<'py>, source: &str, pairs: &Bound<'py, PyList>) -> PyResult<FileEntry<'py>> {
    let s = hydrocrane_machine::load_scenario(source, &overrides(pairs)?).map_err(|e| file_error(&e))?;
    let entry = ScenarioEntry::of(py, &s)?;
    let warnings = warnings_of(hydrocrane_sim::implausible(&s.warnings));
    Ok(((s.name, s.title, s.machine, s.recorded.by.unwrap_or_default()), warnings, entry))
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
