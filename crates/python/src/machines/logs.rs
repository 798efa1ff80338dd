//! Text tables of data loggers.

use crate::handed::arrays::{vector, Row};
use hydrocrane_logs::{Column, Content, DateOrder, Form, Format, Loss, Note};
use hydrocrane_machine::{
    units::{log_columns, log_units},
    Problem,
};
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Name, unit, values or why there are none, the word that stands in their place, the first of dates (s since 1970), and notes.
type ReadColumn<'py> = (String, String, Option<Bound<'py, PyArray1<f64>>>, String, String, Option<f64>, Vec<Note>);

/// The bytes of a text as columns, comment lines, and notes on the whole. `numbers` is "1,234.5" or "1.234,5", `dates` "day-month" or
/// "month-day"; with `names`, every line is a row.
#[pyfunction]
#[pyo3(signature = (data, numbers=None, dates=None, delimiter=None, names=vec![]))]
pub fn read_text<'py>(
    py: Python<'py>,
    data: &[u8],
    numbers: Option<&str>,
    dates: Option<&str>,
    delimiter: Option<u8>,
    names: Vec<String>,
) -> PyResult<(Vec<ReadColumn<'py>>, Vec<String>, Vec<Note>)> {
    let numbers = numbers.map(|text| if text == "1.234,5" { Format::Comma } else { Format::Point });
    let dates = dates.map(|text| if text == "day-month" { DateOrder::DayMonth } else { DateOrder::MonthDay });
    let form = Form { numbers, dates, delimiter, names };
    let table = py.detach(|| {
        let text = hydrocrane_logs::decoded(data)
            .map_err(|what| format!("{what}; is it a CSV table? Give it the suffix of its format"))?;
        hydrocrane_logs::read(&text, &form).map_err(|fault| fault.to_string())
    });
    let table = table.map_err(PyValueError::new_err)?;
    let columns = table.columns.into_iter().map(|column| match column.content {
        Content::Numbers { values, start, notes } => {
            (column.name, column.unit, Some(vector(py, values)), String::new(), String::new(), start, notes)
        }
        Content::Lost(loss) => {
            let reason = reason(&loss);
            let word = if let Loss::Words(word) = loss { word } else { String::new() };
            (column.name, column.unit, None, reason, word, None, vec![])
        }
    });
    Ok((columns.collect(), table.comments, table.notes))
}

fn reason(loss: &Loss) -> String {
    let cure = match loss {
        Loss::Undecided(_) => "say number_format = \"1,234.5\" or \"1.234,5\"",
        Loss::Mixed(..) => "export it with one of them",
        Loss::Dates | Loss::OfNoDay(_) => "say [time] date-order = \"day-month\" or \"month-day\"",
        Loss::DateOf(_) => return loss.text(),
        Loss::Words(_) => "export it as numbers if it is needed",
        Loss::NoCells => "is the header that of another table?",
    };
    format!("{}; {cure}", loss.text())
}

/// The name of a column and the unit behind it.
#[pyfunction]
pub fn split_name(text: &str) -> (&str, &str) {
    log_columns::split_name(text)
}

/// The unit of a column by what its source states beside it, or behind its name; empty if there is none.
#[pyfunction]
pub fn unit_of(name: String, beside: String) -> String {
    log_columns::unit_of(&name, &beside).into()
}

/// Index of the first column with one of the `wanted` names.
#[pyfunction]
pub fn first_of(columns: Vec<String>, wanted: Vec<String>) -> PyResult<Option<usize>> {
    let columns: Vec<_> = columns.iter().map(String::as_str).enumerate().collect();
    log_columns::first_of(&columns, &texts(&wanted)).map_err(refused)
}

fn refused((_, what, cure): Problem) -> PyErr {
    PyValueError::new_err(format!("{what}; {cure}"))
}

/// A column by its name, the unit beside it, and dates as their first moment and seconds from it.
type Head<'py> = (String, String, Option<(f64, Row<'py>)>);

/// Index of the column with the times, of these and those that are clocks of others.
#[pyfunction]
pub fn time_column(columns: Vec<Head<'_>>, clocks: Vec<usize>) -> PyResult<Option<usize>> {
    let column = |(name, unit, moments): Head<'_>| -> PyResult<Column> {
        let (start, values) = match &moments {
            Some((start, seconds)) => (Some(*start), seconds.as_slice()?.to_vec()),
            None => (None, Vec::new()),
        };
        Ok(Column { name, unit, content: Content::Numbers { values, start, notes: Vec::new() } })
    };
    let columns: Vec<Column> = columns.into_iter().map(column).collect::<PyResult<_>>()?;
    log_columns::time_column(&columns, &clocks).map_err(refused)
}

/// The likely unit of times without a unit, if they cannot be seconds.
#[pyfunction]
pub fn counted_in(times: Row) -> PyResult<Option<&'static str>> {
    Ok(log_columns::counted_in(times.as_slice()?))
}

/// A unit of a log: SI value of one, dimension, SI value of the reading 0, and whether it is a pressure relative to vacuum. With
/// `expected` SI units it must be one of the signal `name`.
#[pyfunction]
#[pyo3(signature = (text, name="", expected=vec![]))]
pub fn log_unit(text: &str, name: &str, expected: Vec<String>) -> PyResult<(f64, String, f64, bool)> {
    let found = log_units::unit_of_signal(text, name, &texts(&expected)).map_err(refused)?;
    Ok((found.unit.factor, found.unit.dimension.to_string(), found.zero, found.absolute))
}

fn texts(given: &[String]) -> Vec<&str> {
    given.iter().map(String::as_str).collect()
}

/// Numbers of a unit in SI; absolute pressures of a signal that is `gauge` lose the standard atmosphere.
#[pyfunction]
pub fn in_si<'py>(py: Python<'py>, numbers: Row<'py>, unit: &str, gauge: bool) -> PyResult<Bound<'py, PyArray1<f64>>> {
    Ok(vector(py, log_units::in_si(unit, numbers.as_slice()?, gauge).map_err(refused)?))
}
