//! Logs as text: numbers in columns under a line of names.
//!
//! Columns are separated by comma, semicolon, tab or spaces.
//! Units follow the names, as in `x [mm]`, or are in a separate line below them. Lines that begin with `#`, `%` or `//`
//! are comments.

use crate::cells::{each_cell, readings, Cells, Decision, Table};
use crate::errors::ErrorKind;
use crate::field::MOST_ROWS;
use crate::nearest::suggestion;
use crate::units::{parse_unit, with_article, Quantity};

/// An error of a log: kind, message and cure.
pub type Problem = (ErrorKind, String, String);

/// A log's columns by name.
pub struct Columns {
    pub names: Vec<String>,
    /// As stated in the log; empty if not stated.
    units: Vec<String>,
    cells: Vec<Cells>,
}

/// Most columns of a log.
const MOST_COLUMNS: usize = 2000;

impl Columns {
    /// Reads the text of a log.
    ///
    /// # Errors
    /// The first line that does not belong in a log.
    pub fn read(text: &str) -> Result<Self, Problem> {
        let lines: Vec<(usize, &str)> = text.trim_start_matches('\u{feff}').lines().enumerate().collect();
        let mut lines = lines.into_iter().filter(|(_, line)| !is_comment(line)).peekable();
        let Some((_, head)) = lines.next() else {
            let cure = "give a line of names and a line of numbers for each time";
            return Err((ErrorKind::BadSeries, "the log is empty".into(), cure.into()));
        };
        let delimiter = delimiter(head);
        let mut units = Vec::new();
        let named = names_of(head, delimiter);
        if named.iter().all(|cell| readings(cell) > 0) {
            let message = "the first line of the log has numbers where names of columns are expected".to_string();
            return Err((ErrorKind::BadSeries, message, "begin with a line like time, lift".into()));
        }
        if named.len() > MOST_COLUMNS {
            let message = format!("the log has {} columns; at most {MOST_COLUMNS} are read", named.len());
            return Err((ErrorKind::TooLarge, message, "save the columns that are needed".into()));
        }
        let mut names = Vec::new();
        for cell in &named {
            let (name, unit) = with_unit(cell);
            names.push(name.to_string());
            units.push(unit.to_string());
        }
        let own = |line: &str| names_of(line, delimiter).iter().all(|cell| readings(cell) == 0);
        if let Some((_, line)) = lines.next_if(|(_, line)| own(line)) {
            let stated = names_of(line, delimiter);
            for (unit, cell) in units.iter_mut().zip(&stated).filter(|(unit, _)| unit.is_empty()) {
                *unit = cell.trim_matches(['[', ']', '(', ')', ' ']).to_string();
            }
        }
        let mut table = Table::new(delimiter, None);
        for (row, (at, line)) in lines.enumerate() {
            if row >= MOST_ROWS {
                let message = format!("the log has more than {MOST_ROWS} rows");
                return Err((ErrorKind::TooLarge, message, "save fewer samples, or only a part of the log".into()));
            }
            let (width, filled) = table.push(line);
            // A delimiter at the end of each line is usual.
            if filled > names.len() || width < names.len() {
                let message = format!("line {} of the log: {width} cells for {} columns", at + 1, names.len());
                return Err((
                    ErrorKind::BadSeries,
                    message,
                    "give one number for each column, or omit the line".into(),
                ));
            }
        }
        Ok(Columns { names, units, cells: table.finish() })
    }

    /// The column with one of these names.
    pub fn find(&self, wanted: &[&str]) -> Option<usize> {
        wanted.iter().find_map(|name| self.names.iter().position(|own| own.eq_ignore_ascii_case(name)))
    }

    /// As [`Self::find`] for a required column; `what` states its purpose.
    pub fn index(&self, wanted: &[&str], what: &str) -> Result<usize, Problem> {
        self.find(wanted).ok_or_else(|| {
            let message = format!("the log has no column `{}` for {what}", wanted[0]);
            let near = suggestion(wanted[0], self.names.iter().map(String::as_str));
            (ErrorKind::UnknownReference, message, near)
        })
    }

    /// A column converted to SI; its unit is the given `unit`, else that of the log, else SI.
    pub fn column(&self, index: usize, unit: Option<&str>, quantity: &Quantity) -> Result<Vec<f64>, Problem> {
        let name = &self.names[index];
        let unit = unit.unwrap_or(&self.units[index]);
        let unknown = |_| {
            let message = format!("column `{name}` of the log has the unknown unit `{unit}`");
            (ErrorKind::UnknownUnit, message, format!("state its unit, for example \"{}\"", quantity.unit))
        };
        let scale = match unit {
            "" | "1" | "-" => None,
            _ => Some(parse_unit(unit).map_err(unknown)?),
        };
        if scale.is_some_and(|scale| scale.dimension != quantity.dimension) {
            let message =
                format!("column `{name}` of the log is in `{unit}`; it must be {}", with_article(quantity.name));
            let cure = format!("give a column in {}, or state the right unit", quantity.example());
            return Err((ErrorKind::WrongDimension, message, cure));
        }
        let Some(cells) = self.cells.get(index) else { return Ok(Vec::new()) };
        let unclear = match &cells.decision {
            Decision::Undecided(cell) => {
                format!("`{cell}`, which may mean decimals or thousands, and nothing says which")
            }
            Decision::Mixed(point, comma) => format!("`{point}` and `{comma}`, with two decimal marks"),
            Decision::Own | Decision::Thousands(_) => String::new(),
        };
        if !unclear.is_empty() {
            let message = format!("column `{name}` of the log has {unclear}");
            let cure = "write decimals with a point everywhere, and no marks of thousands".to_string();
            return Err((ErrorKind::BadSeries, message, cure));
        }
        let values: Vec<f64> = cells.values.iter().map(|value| scale.map_or(*value, |s| s.to_si(*value))).collect();
        match values.iter().position(|value| !value.is_finite()) {
            Some(row) => {
                let message = format!("column `{name}` of the log has no number in row {}", row + 1);
                Err((ErrorKind::NotFinite, message, "fill the gap, or cut the log there".into()))
            }
            None => Ok(values),
        }
    }
}

fn is_comment(line: &str) -> bool {
    let line = line.trim();
    line.is_empty() || ["#", "%", "//"].iter().any(|mark| line.starts_with(mark))
}

fn delimiter(head: &str) -> char {
    ['\t', ';', ','].into_iter().find(|mark| head.contains(*mark)).unwrap_or(' ')
}

/// The cells of a line of names; between blanks a unit belongs to the name before it.
fn names_of(line: &str, delimiter: char) -> Vec<String> {
    let mut cells: Vec<String> = Vec::new();
    each_cell(line, delimiter, |cell| match cells.last_mut().filter(|_| delimiter == ' ' && cell.starts_with('[')) {
        Some(name) => *name = format!("{name} {cell}"),
        None => cells.push(cell.into()),
    });
    cells
}

fn with_unit(cell: &str) -> (&str, &str) {
    match cell.split_once('[') {
        Some((name, unit)) if unit.ends_with(']') => (name.trim(), unit.trim_end_matches(']').trim()),
        _ => (cell.trim(), ""),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantities::{LENGTH, TIME};

    fn lift(text: &str) -> Result<Vec<f64>, Problem> {
        let columns = Columns::read(text)?;
        columns.column(columns.index(&["lift"], "a test")?, None, &LENGTH.quantity())
    }

    #[test]
    fn usual_ways_to_write_a_log_say_the_same() {
        for text in [
            "time,lift\n0,0.001\n1,-0.002\n",
            "# made by hand\ntime [s],lift [mm]\n0,1\n1,-2\n",
            "time;lift\ns;mm\n0;1,0\n\n1;-2,0\n",
            "\u{feff}t\tLift [m]\r\n0\t1e-3\r\n1\t-2e-3\r\n",
            "time  lift\n 0.0  0.001\n 1.0 -0.002\n",
            "\"time\",\"lift [mm]\",\n0,1,\n1,-2,\n",
            "time;lift [um]\n0.0;1,000\n1.0;-2,000\n",
            "time,lift [um]\n0.0,\"1,000\"\n1.0,\"-2,000\"\n",
            "time;lift [um]\n0,0;1.000\n1,0;-2.000\n",
        ] {
            assert_eq!(lift(text).unwrap_or_else(|e| panic!("{text}: {e:?}")), [0.001, -0.002], "{text}");
        }
    }

    #[test]
    fn what_is_no_log_is_told() {
        for (text, told) in [
            ("", "empty"),
            ("# nothing\n", "empty"),
            ("0,1\n1,2\n", "names of columns"),
            ("time,tilt\n0,1\n", "no column `lift`"),
            ("time,lift\n0\n", "line 2 of the log: 1 cells for 2 columns"),
            ("time,lift [bar]\n0,1\n", "must be a"),
            ("time,lift [furlong]\n0,1\n", "unknown unit"),
            ("time,lift\n0,1\n1,\n", "row 2"),
            ("time;lift\n0;1,500\n1;2,500\n", "`1,500`, which may mean decimals or thousands"),
            ("time;lift\n0;1.500\n1;2,5\n2;2.5\n", "two decimal marks"),
        ] {
            let (_, message, cure) = lift(text).expect_err(text);
            assert!(message.contains(told) && !cure.is_empty(), "{text}: {message}");
        }
    }

    #[test]
    fn a_stated_unit_counts_before_that_of_the_log() {
        let columns = Columns::read("t [s]\n1\n").unwrap();
        assert_eq!(columns.column(0, Some("ms"), &TIME.quantity()).unwrap(), [1e-3]);
    }
}
