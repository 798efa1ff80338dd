//! Text tables of data loggers.

use crate::arrays::vector;
use hydrocrane_logs::{Content, DateOrder, Form, Format, Loss, Note};
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Name, unit, values or why there are none, the word that stands in their place, the first of dates (s since 1970; not a number where
/// the order of day and month is open), and notes.
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
            let reason = [&loss.text(), cure(&loss)].join("; ");
            let start = matches!(loss, Loss::Dates).then_some(f64::NAN);
            let word = if let Loss::Words(word) = loss { word } else { String::new() };
            (column.name, column.unit, None, reason, word, start, vec![])
        }
    });
    Ok((columns.collect(), table.comments, table.notes))
}

fn cure(loss: &Loss) -> &'static str {
    match loss {
        Loss::Undecided(_) => "say number_format = \"1,234.5\" or \"1.234,5\"",
        Loss::Mixed(..) => "export it with one of them",
        Loss::Dates => "say [time] date-order = \"day-month\" or \"month-day\"",
        Loss::Words(_) => "export it as numbers if it is needed",
        Loss::NoCells => "is the header that of another table?",
    }
}

/// The name of a column and the unit behind it.
#[pyfunction]
pub fn split_name(text: &str) -> (&str, &str) {
    hydrocrane_logs::split_name(text)
}
