//! Parts of tip control, for studies from Python.

use crate::handed::arrays::{row, rows, vector, Row, Rows};
use hydrocrane_sim::model::controllers;
use hydrocrane_sim::RateRequest;
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Joint rates for a velocity of the tip, and the share of it that they reach.
#[pyfunction]
pub fn resolve_rates<'py>(
    py: Python<'py>,
    jacobian: Rows<'py>,
    velocity: [f64; 2],
    correction: [f64; 2],
    weights: Row<'py>,
    preferred: Row<'py>,
    bounds: Rows<'py>,
) -> PyResult<(Bound<'py, PyArray1<f64>>, f64)> {
    let n = weights.len()?;
    let (jacobian, bounds) = (rows(&jacobian, n, "jacobian")?, rows(&bounds, 2, "bounds")?);
    if jacobian.len() != 2 * n || bounds.len() != 2 * n {
        return Err(PyValueError::new_err(format!("jacobian must be (2, {n}) and bounds ({n}, 2)")));
    }
    let (weights, preferred) = (row(&weights, n, "weights")?, row(&preferred, n, "preferred")?);
    let request = RateRequest { jacobian, velocity, correction, weights, preferred, bounds };
    match hydrocrane_sim::resolve_rates(&request) {
        Some((rates, share)) => Ok((vector(py, rates), share)),
        None => Err(PyValueError::new_err(format!("a controller handles 1 to 6 joints, got {n}"))),
    }
}

/// Key and SI unit of each gain of the controller `tip`.
#[pyfunction]
pub fn tip_gain_units() -> Vec<(&'static str, &'static str)> {
    controllers::tip_gain_units().collect()
}
