//! Columns of numbers as rows of text, which Python writes to files: its own texts of numbers take ten times as long.

use crate::handed::arrays::Row;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::fmt::Write;

/// A column of numbers, or of texts as they shall stand.
#[derive(FromPyObject)]
pub enum Cells<'py> {
    Numbers(Row<'py>),
    Texts(Vec<String>),
}

/// The rows of `columns` as CSV, UTF-8. A number has the shortest text that reads back as the same number; one that is
/// missing (NaN) has none.
#[pyfunction]
pub fn csv_rows<'py>(py: Python<'py>, columns: Vec<Cells<'py>>) -> PyResult<Bound<'py, PyBytes>> {
    let cells = columns.iter().map(|column| match column {
        Cells::Numbers(row) => Ok(Slice::Numbers(row.as_slice()?)),
        Cells::Texts(texts) => Ok(Slice::Texts(texts)),
    });
    let cells = cells.collect::<PyResult<Vec<_>>>()?;
    let text = py.detach(|| csv(&cells));
    Ok(PyBytes::new(py, text.as_bytes()))
}

enum Slice<'a> {
    Numbers(&'a [f64]),
    Texts(&'a [String]),
}

impl Slice<'_> {
    fn len(&self) -> usize {
        match self {
            Slice::Numbers(values) => values.len(),
            Slice::Texts(texts) => texts.len(),
        }
    }
}

fn csv(columns: &[Slice]) -> String {
    let count = columns.iter().map(Slice::len).min().unwrap_or(0);
    let mut text = String::with_capacity(count * columns.len() * 20);
    for row in 0..count {
        for (number, column) in columns.iter().enumerate() {
            if number > 0 {
                text.push(',');
            }
            match column {
                Slice::Texts(texts) => text.push_str(&texts[row]),
                Slice::Numbers(values) if values[row].is_nan() => {}
                Slice::Numbers(values) => push_number(&mut text, values[row]),
            }
        }
        text.push('\n');
    }
    text
}

/// In the notation of Python: `0.1`, `1e-05`, `1.5e+16`.
fn push_number(text: &mut String, value: f64) {
    let size = value.abs();
    let result = if !(1e-4..1e16).contains(&size) && size != 0.0 && size.is_finite() {
        let short = format!("{value:e}");
        let (digits, power) = short.split_once('e').unwrap_or((&short, "0"));
        let (sign, power) = power.strip_prefix('-').map_or(('+', power), |power| ('-', power));
        write!(text, "{digits}e{sign}{power:0>2}")
    } else {
        write!(text, "{value:?}")
    };
    debug_assert!(result.is_ok(), "a String takes all that is written to it");
}
