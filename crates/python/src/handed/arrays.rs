//! Rows in, rows out.

use numpy::ndarray::Dimension;
use numpy::{Element, IntoPyArray, Ix1, Ix2, PyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::ops::Deref;

/// An array as Rust can read it, wherever its memory lies: what another process sends begins at any byte.
pub struct Readable<'py, T: Element, D: Dimension>(PyReadonlyArray<'py, T, D>);

impl<'a, 'py, T: Element + 'a, D: Dimension + 'a> FromPyObject<'a, 'py> for Readable<'py, T, D> {
    type Error = PyErr;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let array: PyReadonlyArray<'py, T, D> = given.extract()?;
        if array.as_slice().is_ok() {
            return Ok(Readable(array));
        }
        let copy = given.call_method1("copy", ("C",))?;
        Ok(Readable(copy.extract()?))
    }
}

impl<'py, T: Element, D: Dimension> Deref for Readable<'py, T, D> {
    type Target = PyReadonlyArray<'py, T, D>;

    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl<'py, T: Element, D: Dimension> IntoPyObject<'py> for Readable<'py, T, D> {
    type Target = PyArray<T, D>;
    type Output = Bound<'py, Self::Target>;
    type Error = PyErr;

    fn into_pyobject(self, _: Python<'py>) -> PyResult<Self::Output> {
        Ok(Bound::clone(&self.0))
    }
}

/// A batch of vectors of one length.
pub type Rows<'py> = Readable<'py, f64, Ix2>;
pub type Row<'py> = Readable<'py, f64, Ix1>;
pub type Numbers<'py> = Readable<'py, i64, Ix1>;

/// The numbers of a batch whose rows have `width` numbers.
pub fn rows<'a>(a: &'a Rows, width: usize, name: &str) -> PyResult<&'a [f64]> {
    if a.as_array().ncols() != width {
        let message = format!("{name} must have {width} columns, got {}", a.as_array().ncols());
        return Err(PyValueError::new_err(message));
    }
    Ok(a.as_slice()?)
}

/// The numbers of a vector of `width` numbers.
pub fn row<'a>(a: &'a Row, width: usize, name: &str) -> PyResult<&'a [f64]> {
    let slice = a.as_slice()?;
    if slice.len() != width {
        return Err(PyValueError::new_err(format!("{name} must have {width} numbers, got {}", slice.len())));
    }
    Ok(slice)
}

pub fn matrix<'py>(py: Python<'py>, data: Vec<f64>, columns: usize) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let count = data.len().checked_div(columns).unwrap_or(0);
    data.into_pyarray(py).reshape([count, columns])
}

pub fn tensor<'py>(py: Python<'py>, data: Vec<f64>, (r, c): (usize, usize)) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let count = data.len() / (r * c);
    data.into_pyarray(py).reshape([count, r, c])
}

/// Numbers for a field that Python hands over, too.
pub fn line(py: Python<'_>, data: Vec<f64>) -> Row<'_> {
    Readable(vector(py, data).readonly())
}

pub fn vector(py: Python<'_>, data: Vec<f64>) -> Bound<'_, PyArray1<f64>> {
    data.into_pyarray(py)
}
