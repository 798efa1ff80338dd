//! Errors of the core as Python gets them.

use hydrocrane_machine::MachineError;
use hydrocrane_sim::assembly::AssemblyError;
use hydrocrane_sim::BuildError;
use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

create_exception!(_core, PoseFault, PyValueError, "A start that the machine cannot take.");
create_exception!(_core, MachineFileError, PyValueError, "args: message, slug, file, line, column, key");

pub fn file_error(e: &MachineError) -> PyErr {
    stated(e, e.to_string())
}

fn stated(e: &MachineError, message: String) -> PyErr {
    let owned = |text: Option<&str>| text.map(str::to_string);
    MachineFileError::new_err((message, e.slug(), owned(e.file()), e.line(), e.column(), owned(e.key())))
}

/// A valid description of a machine that cannot be simulated.
pub fn cannot_build(source: &str, e: &BuildError) -> PyErr {
    let message = format!("{source}: [cannot-build] {e}");
    MachineFileError::new_err((
        message,
        "cannot-build",
        source.to_string(),
        None::<usize>,
        None::<usize>,
        None::<String>,
    ))
}

/// The error of a machine that is one of the cranes of a batch.
pub fn error_of_crane(crane: i64, error: &AssemblyError) -> PyErr {
    match error {
        AssemblyError::Machine(error) => stated(error, format!("crane {crane}: {error}")),
        AssemblyError::Build(source, error) => cannot_build(&format!("crane {crane}, {source}"), error),
        other => assembly_error(other),
    }
}

/// An error of an assembly as Python gets it.
pub fn assembly_error(error: &AssemblyError) -> PyErr {
    match error {
        AssemblyError::Machine(error) => file_error(error),
        AssemblyError::Build(source, error) => cannot_build(source, error),
        AssemblyError::Pose(_) | AssemblyError::PoseOfFile(..) => PoseFault::new_err(error.to_string()),
        AssemblyError::Scenario(message) => PyValueError::new_err(message.clone()),
    }
}
