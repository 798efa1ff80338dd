//! The static friction map of free parameters.

use crate::handed::arrays::{matrix, row, vector, Row};
use hydrocrane_sim::{map_point, MAP_PARAMETERS};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

type Map<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>);

/// Force (n), dF/dv (n) and dF/dparameters (n, 12) at velocities `v`.
#[pyfunction]
pub fn friction_map<'py>(py: Python<'py>, parameters: Row<'py>, v: Row<'py>) -> PyResult<Map<'py>> {
    let mut p = [0.0; MAP_PARAMETERS];
    p.copy_from_slice(row(&parameters, MAP_PARAMETERS, "parameters")?);
    let points: Vec<_> = v.as_slice()?.iter().map(|v| map_point(&p, *v)).collect();
    let force = vector(py, points.iter().map(|at| at.force).collect());
    let slope = vector(py, points.iter().map(|at| at.slope).collect());
    let gradient = points.iter().flat_map(|at| at.gradient).collect();
    Ok((force, slope, matrix(py, gradient, MAP_PARAMETERS)?))
}
