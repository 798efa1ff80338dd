//! Values of keys, from Python and to it.

use hydrocrane_machine::OverrideValue;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyList, PyString};

/// A bool, a text, a number, or a list of these.
pub fn value(v: &Bound<'_, PyAny>) -> PyResult<OverrideValue> {
    if let Some(single) = single(v)? {
        return Ok(single);
    }
    let items = v.try_iter().map_err(|_| no_value(v))?;
    let item = |item: PyResult<Bound<'_, PyAny>>| item.and_then(|item| single(&item)?.ok_or_else(|| no_value(&item)));
    Ok(OverrideValue::List(items.map(item).collect::<PyResult<_>>()?))
}

/// `None` for what is no single value.
fn single(v: &Bound<'_, PyAny>) -> PyResult<Option<OverrideValue>> {
    if v.is_instance_of::<PyBool>() {
        return Ok(Some(OverrideValue::Bool(v.extract()?)));
    }
    // A text that cannot become UTF-8 is an error, and no list of letters, each of which is a text again.
    if let Ok(text) = v.cast::<PyString>() {
        return Ok(Some(OverrideValue::Text(text.to_str()?.into())));
    }
    Ok(v.extract().ok().map(OverrideValue::Number))
}

fn no_value(v: &Bound<'_, PyAny>) -> PyErr {
    PyValueError::new_err(format!(
        "cannot use {v} as the value of a key: give a number, a text, a bool or a list of these"
    ))
}

pub fn overrides(pairs: &Bound<'_, PyList>) -> PyResult<Vec<(String, OverrideValue)>> {
    pairs.iter().map(|pair| Ok((pair.get_item(0)?.extract()?, value(&pair.get_item(1)?)?))).collect()
}

fn to_python<'py>(py: Python<'py>, v: &OverrideValue) -> PyResult<Bound<'py, PyAny>> {
    Ok(match v {
        OverrideValue::Number(x) => x.into_pyobject(py)?.into_any(),
        OverrideValue::Text(s) => s.into_pyobject(py)?.into_any(),
        OverrideValue::Bool(b) => PyBool::new(py, *b).to_owned().into_any(),
        OverrideValue::List(items) => {
            let items: PyResult<Vec<_>> = items.iter().map(|i| to_python(py, i)).collect();
            PyList::new(py, items?)?.into_any()
        }
    })
}

pub fn pairs_of<'py>(py: Python<'py>, changes: &[(String, OverrideValue)]) -> PyResult<Bound<'py, PyList>> {
    let pairs: PyResult<Vec<_>> = changes.iter().map(|(key, value)| Ok((key, to_python(py, value)?))).collect();
    PyList::new(py, pairs?)
}
