//! Columns of numbers as rows of text, which Python writes to files: its own texts of numbers take seven times as long.

use crate::arrays::Row;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::fmt::Write;

/// A column of numbers, or of texts as they shall stand.
#[derive(FromPyObject)]
pub enum Cells<'py> {
    Numbers(Row<'py>),
    Texts(Vec<String>),
}

/// The rows of `columns`, UTF-8: each begins with the first of `marks`, has the second between its cells and ends with
/// the third. A number has the shortest text that reads back as the same number; one that is missing (NaN) is `missing`.
#[pyfunction]
pub fn text_rows<'py>(
    py: Python<'py>,
    columns: Vec<Cells<'py>>,
    marks: (String, String, String),
    missing: &str,
) -> PyResult<Bound<'py, PyBytes>> {
    let cells = columns.iter().map(|column| match column {
        Cells::Numbers(row) => Ok(Slice::Numbers(row.as_slice()?)),
        Cells::Texts(texts) => Ok(Slice::Texts(texts)),
    });
    let cells = cells.collect::<PyResult<Vec<_>>>()?;
    let text = py.detach(|| rows(&cells, &marks, missing));
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

fn rows(columns: &[Slice], (begin, between, end): &(String, String, String), missing: &str) -> String {
    let count = columns.iter().map(Slice::len).min().unwrap_or(0);
    let mut text = String::with_capacity(count * columns.len() * (20 + between.len()));
    for row in 0..count {
        text.push_str(begin);
        for (number, column) in columns.iter().enumerate() {
            if number > 0 {
                text.push_str(between);
            }
            match column {
                Slice::Texts(texts) => text.push_str(&texts[row]),
                Slice::Numbers(values) if values[row].is_nan() => text.push_str(missing),
                Slice::Numbers(values) => push_number(&mut text, values[row]),
            }
        }
        text.push_str(end);
    }
    text
}

/// As Python writes numbers: `0.1`, `1e-05`, `1.5e+16`.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_as_python_writes_them() {
        for (value, wanted) in [
            (0.0, "0.0"),
            (-0.0, "-0.0"),
            (0.1, "0.1"),
            (1e-4, "0.0001"),
            (9.999e-5, "9.999e-05"),
            (1e-300, "1e-300"),
            (5e-324, "5e-324"),
            (123456789.0, "123456789.0"),
            (9999999999999998.0, "9999999999999998.0"),
            (1e16, "1e+16"),
            (-1.5e22, "-1.5e+22"),
            (f64::INFINITY, "inf"),
            (f64::NEG_INFINITY, "-inf"),
        ] {
            let mut text = String::new();
            push_number(&mut text, value);
            assert_eq!(text, wanted);
        }
    }

    #[test]
    fn a_missing_number_and_texts_stand_as_they_are_given() {
        let texts = ["a".to_string(), "\"b,c\"".to_string()];
        let columns = [Slice::Numbers(&[1.0, f64::NAN]), Slice::Texts(&texts)];
        let marks = (String::new(), ",".to_string(), "\n".to_string());
        assert_eq!(rows(&columns, &marks, ""), "1.0,a\n,\"b,c\"\n");
    }
}
