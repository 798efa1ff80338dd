//! Variables of the FMU of a machine, for its description.

use hydrocrane_fmu::{open, Fault, Kind, Resources, Use};
use hydrocrane_machine::unit_exponents;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Name, kind, its number where there are several, use, unit, description, start, lowest and highest value, nominal value.
type VariableEntry =
    (String, &'static str, usize, &'static str, String, String, Option<f64>, Option<[f64; 2]>, Option<f64>);

/// The variables of the FMU that these files describe, whether a tool can integrate it, and the period of a controller, s.
#[pyfunction]
pub fn fmu_variables(
    py: Python<'_>,
    machine: String,
    scenario: Option<String>,
    settings: &str,
) -> PyResult<(Vec<VariableEntry>, bool, Option<f64>)> {
    let settings = Resources::settings(settings).map_err(PyValueError::new_err)?;
    let resources = Resources { machine, scenario, settings };
    let part = py.detach(|| {
        let mut part = open(&resources)?;
        // Errors of its start are reported now and not in the tool.
        part.begin(0.0).map_err(|fault| match fault {
            Fault::Wrong(text) | Fault::Impossible(text) => text,
        })?;
        Ok::<_, String>(part)
    });
    let part = part.map_err(PyValueError::new_err)?;
    let entries = part.variables().iter().map(|v| {
        let (kind, number) = kind(v.kind);
        let (name, unit, description) = (v.name.clone(), v.unit.clone(), v.description.clone());
        (name, kind, number, usage(v.usage), unit, description, v.start, v.range, v.nominal)
    });
    Ok((entries.collect(), part.exchanges(), part.period()))
}

/// Exponents of m, kg, s, K, A, rad in a unit of machine files; `None` if it is no unit.
#[pyfunction]
pub fn exponents_of_unit(unit: &str) -> Option<[f64; 6]> {
    unit_exponents(unit)
}

fn kind(kind: Kind) -> (&'static str, usize) {
    match kind {
        Kind::Time => ("time", 0),
        Kind::Command(i) => ("command", i),
        Kind::Stick(i) => ("stick", i),
        Kind::Reading(i) => ("reading", i),
        Kind::Payload => ("payload", 0),
        Kind::Parameter(i) => ("parameter", i),
        Kind::Pose(i) => ("pose", i),
        Kind::State(i) => ("state", i),
        Kind::Rate(i) => ("rate", i),
        Kind::Output(i) => ("output", i),
        Kind::SetPoint(i) => ("set-point", i),
    }
}

fn usage(usage: Use) -> &'static str {
    match usage {
        Use::Independent => "independent",
        Use::Input => "input",
        Use::Fixed => "fixed",
        Use::Tunable => "tunable",
        Use::Output => "output",
        Use::Local => "local",
    }
}
