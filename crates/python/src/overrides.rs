//! Values of keys, from Python and to it.

use hydrocrane_machine::OverrideValue;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyList};

pub fn value(v: &Bound<'_, PyAny>) -> PyResult<OverrideValue> {
    if v.is_instance_of::<PyBool>() {
        return Ok(OverrideValue::Bool(v.extract()?));
    }
    if let Ok(text) = v.extract::<String>() {
        return Ok(OverrideValue::Text(text));
    }
    if let Ok(number) = v.extract::<f64>() {
        return Ok(OverrideValue::Number(number));
    }
    let items = v.try_iter().map_err(|_| PyValueError::new_err(format!("cannot use {v} as the value of a key")))?;
    let items: PyResult<Vec<_>> = items.map(|item| value(&item?)).collect();
    Ok(OverrideValue::List(items?))
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

pub fn pairs_of<'py>(
    py: Python<'py>,
    changes: &[(String, OverrideValue)],
) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
    changes.iter().map(|(key, value)| Ok((key.clone(), to_python(py, value)?))).collect()
}
