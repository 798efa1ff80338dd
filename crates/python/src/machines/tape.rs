//! A machine as a list of operations, for writers of other languages.

use crate::handed::errors::{cannot_build, file_error};
use crate::machines::machine::Machine;
use hydrocrane_machine::Template;
use hydrocrane_tape::{export, Exported, Function, Request, TapeError};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Result, operation and operands of each step, and the results.
type FunctionEntry = (Vec<(String, &'static str, Vec<String>)>, Vec<String>);

fn entry(function: Function) -> FunctionEntry {
    let steps = function.steps.into_iter().map(|step| (step.result, step.operation, step.operands));
    (steps.collect(), function.results)
}

fn error(source: &str, error: &TapeError) -> PyErr {
    match error {
        TapeError::Machine(error) => file_error(error),
        TapeError::Build(error) => cannot_build(source, error),
        TapeError::Request(text) => PyValueError::new_err(text.clone()),
    }
}

/// The right-hand side of a machine with these parameters and outputs; with its derivatives by the states, if wanted.
#[pyfunction]
pub fn tape<'py>(
    py: Python<'py>,
    machine: &Machine,
    parameters: Vec<String>,
    outputs: Vec<String>,
    derivatives: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let source = machine.source();
    let template = Template::of_text(&machine.to_toml()?, source).map_err(|error| file_error(&error))?;
    let (request, model) = (Request { parameters, outputs, derivatives }, &machine.model);
    let found = py.detach(|| export(&template, model.layout(), model.output_info(), &request));
    let Exported { parameters, outputs, places, program } = found.map_err(|e| error(source, &e))?;
    let out = PyDict::new(py);
    let parameters: Vec<_> = parameters.into_iter().map(|p| (p.key, p.value, p.unit)).collect();
    let outputs: Vec<_> = outputs.into_iter().map(|o| (o.name, o.unit, o.long_name)).collect();
    let tables: Vec<_> = program.tables.into_iter().map(|table| (table.starts, table.columns)).collect();
    out.set_item("parameters", parameters)?;
    out.set_item("outputs", outputs)?;
    out.set_item("places", places)?;
    out.set_item("tables", tables)?;
    out.set_item("prologue", entry(program.prologue))?;
    out.set_item("kept", program.kept)?;
    out.set_item("functions", program.functions.into_iter().map(entry).collect::<Vec<_>>())?;
    Ok(out)
}
