//! Logs that a scenario names: text files with columns, beside the scenario or passed with it.

use crate::errors::ErrorKind;
pub use crate::errors::Problem;
use crate::load::given;
use crate::nearest::suggestion;
use crate::reading::field::{Field, MOST_ROWS};
use crate::text::disk;
use crate::units::log_columns::{counted_in, first_of, split_name, time_column, unit_of, TIME_NAMES};
use crate::units::log_units::{in_si, unit_of_signal, ATMOSPHERE};
use crate::units::quantities::{PRESSURE, TIME};
use crate::units::Quantity;
use hydrocrane_logs::{Column, Content, Form, Format, Loss, Table};
use std::cell::RefCell;
use std::path::Path;

/// Whether this build reads logs; the page's first core does not.
pub const LOGS: bool = cfg!(feature = "logs");

/// Places of the files that a scenario names.
#[derive(Clone, Copy)]
pub struct Files<'a> {
    /// The scenario's own; `None`: it is bundled, or a text in memory, and opens none.
    pub folder: Option<&'a Path>,
    /// Names and texts that were passed with it.
    pub given: &'a [(String, String)],
}

/// Suffixes of logs that are text.
const TEXTS: [&str; 6] = ["csv", "txt", "tsv", "dat", "log", "exp"];

/// Whether a log is text by the suffix of its name.
pub fn is_text(name: &str) -> bool {
    TEXTS.iter().any(|suffix| name.to_ascii_lowercase().ends_with(&format!(".{suffix}")))
}

impl Files<'_> {
    /// A path relative to the scenario file.
    pub fn beside(&self, name: &str) -> Result<String, Problem> {
        let Some(folder) = self.folder else { return Ok(name.into()) };
        match disk::path_fault(name) {
            None => Ok(folder.join(name).display().to_string()),
            Some((fault, cure)) => Err((ErrorKind::UnreadableFile, format!("`{name}` {fault}"), cure)),
        }
    }

    /// The text that was passed under this name.
    pub fn given(&self, name: &str) -> Option<&str> {
        given(self.given, name).map(|(_, text)| text.as_str())
    }

    /// The table in the file `name`, which writes numbers like this.
    fn table(&self, name: &str, numbers: Option<Format>) -> Result<Table, Problem> {
        let wrong = |what: String| {
            (ErrorKind::UnreadableFile, format!("`{name}` {what}"), "check the name and the folder".into())
        };
        if let Some(text) = self.given(name) {
            return table_of(text, numbers);
        }
        if self.folder.is_none() {
            let cure = format!("choose `{name}` together with the file that names it");
            return Err((ErrorKind::UnreadableFile, format!("`{name}` is not among the files at hand"), cure));
        }
        let bytes =
            disk::read(Path::new(&self.beside(name)?)).map_err(|error| wrong(format!("cannot be read: {error}")))?;
        let text = hydrocrane_logs::decoded(&bytes).map_err(|what| wrong(what.into()))?;
        table_of(&text, numbers)
    }
}

/// The table of a text. What its reader would only note is an error, without a cell of a file that may be no log.
fn table_of(text: &str, numbers: Option<Format>) -> Result<Table, Problem> {
    let form = Form { numbers, ..Form::default() };
    let table = hydrocrane_logs::read(text.trim_start_matches('\u{feff}'), &form)
        .map_err(|fault| (ErrorKind::BadSeries, format!("the log {}", fault.what), fault.cure.into()))?;
    if table.rows > MOST_ROWS {
        let message = format!("the log has {} rows, more than {MOST_ROWS}", table.rows);
        return Err((ErrorKind::TooLarge, message, "save fewer samples, or only a part of the log".into()));
    }
    let Some((kind, _)) = table.notes.first() else { return Ok(table) };
    let (message, cure) = match *kind {
        "truncated" => ("the last line of the log is cut off", "complete it, or leave it out"),
        _ => (
            "rows of the log have more or fewer cells than its header",
            "give each column a name, and export with semicolons",
        ),
    };
    Err((ErrorKind::BadSeries, message.into(), cure.into()))
}

/// A log with its times.
pub struct Log {
    columns: Vec<Column>,
    /// s
    pub time: Vec<f64>,
    /// What was decided on the columns that were read, and what to do for no question.
    decided: RefCell<Vec<(String, &'static str)>>,
}

impl Log {
    /// Reads the log `name`; `time` is its column of times, `numbers` how it writes them if its cells do not say.
    #[inline(always)]
    pub fn open(name: &str, time: Option<&str>, numbers: Option<Format>, files: &Files) -> Result<Self, Problem> {
        // Where no log is opened, nothing that comes after it is compiled.
        if !LOGS {
            return Err((ErrorKind::UnreadableFile, "logs are not read here".into(), "choose another program".into()));
        }
        Self::read(name, time, numbers, files)
    }

    fn read(name: &str, time: Option<&str>, numbers: Option<Format>, files: &Files) -> Result<Self, Problem> {
        if !is_text(name) {
            let message = format!("`{name}` is not a log in text form");
            let cure = format!("save it as CSV; suffixes of texts are {}", TEXTS.join(", "));
            return Err((ErrorKind::UnreadableFile, message, cure));
        }
        let columns = files.table(name, numbers)?.columns;
        let mut log = Log { columns, time: Vec::new(), decided: RefCell::default() };
        let index = log.clock(time)?;
        log.time = log.values(index, None, &TIME.quantity())?;
        if let Some(pair) = log.time.windows(2).find(|pair| pair[1] <= pair[0]) {
            let message = format!("the times of the log do not increase: {} s follows {} s", pair[1], pair[0]);
            return Err((ErrorKind::BadSeries, message, "sort its rows, each time once".into()));
        }
        Ok(log)
    }

    /// Warns on what was decided on the columns that were read.
    pub fn tell(&self, field: &Field) {
        for (text, cure) in self.decided.borrow().iter() {
            field.warn(format!("a log: {text}"), (*cure).into());
        }
    }

    /// The column of the times: the `wanted` one, else the usual one, which says why if it cannot be read.
    fn clock(&self, wanted: Option<&str>) -> Result<usize, Problem> {
        let found = match wanted {
            Some(name) => self.find(&[name])?,
            None => match time_column(&self.columns, &[]).map_err(several)? {
                None => self.find(&TIME_NAMES)?,
                found => found,
            },
        };
        found.ok_or_else(|| self.without_times(wanted.unwrap_or("time")))
    }

    /// The column with one of these names, with or without its unit, in any case.
    fn find(&self, wanted: &[&str]) -> Result<Option<usize>, Problem> {
        let of = |lost: bool| -> Vec<(usize, &str)> {
            let is = |column: &Column| matches!(column.content, Content::Lost(_)) == lost;
            let named = self.columns.iter().map(|column| (column.name.as_str(), is(column))).enumerate();
            named.filter_map(|(at, (name, is))| is.then_some((at, name))).collect()
        };
        match first_of(&of(false), wanted) {
            Ok(None) => first_of(&of(true), wanted),
            found => found,
        }
        .map_err(several)
    }

    fn names(&self) -> Vec<&str> {
        self.columns.iter().map(|column| split_name(&column.name).0).filter(|name| !name.is_empty()).collect()
    }

    /// The column of one of these names, in SI, if there is one. Its unit is the given `unit`, else that of the log, else SI.
    pub fn column(&self, names: &[&str], unit: Option<&str>, quantity: &Quantity) -> Result<Option<Vec<f64>>, Problem> {
        self.find(names)?.map(|index| self.values(index, unit, quantity)).transpose()
    }

    /// The error of a log without a column of this `name`, whose purpose `what` states.
    pub fn without(&self, name: &str, what: &str) -> Problem {
        let message = format!("the log has no column `{name}` for {what}");
        (ErrorKind::UnknownReference, message, suggestion(name, self.names()))
    }

    fn values(&self, index: usize, unit: Option<&str>, quantity: &Quantity) -> Result<Vec<f64>, Problem> {
        let column = &self.columns[index];
        let name = split_name(&column.name).0;
        let (values, dated) = match &column.content {
            Content::Numbers { values, start, notes } => {
                let note = |(_, text): &(_, String)| {
                    (format!("column `{name}` {text}"), "write its numbers without marks of thousands")
                };
                self.decided.borrow_mut().extend(notes.iter().map(note));
                (values, start.is_some())
            }
            Content::Lost(loss) => {
                let message = format!("column `{name}` of the log has no numbers: {}", loss.text());
                return Err((ErrorKind::BadSeries, message, cure_of(loss).into()));
            }
        };
        let own = if dated { "s" } else { unit_of(&column.name, &column.unit) };
        let stated = unit.filter(|_| !dated).unwrap_or(own);
        let expected = if quantity.unit.is_empty() { "1" } else { quantity.unit.as_ref() };
        let counts = counted_in(values).filter(|_| stated.is_empty() && quantity.name == TIME.name);
        if let Some(counts) = counts {
            let message = format!("time column `{name}` cannot be in seconds, it seems to count {counts}");
            let cure = format!("call it `{name} [{counts}]`, or `{name} [s]` if it is in seconds");
            return Err((ErrorKind::MissingUnit, message, cure));
        }
        let values = if stated.is_empty() {
            values.clone()
        } else {
            let refused = |(kind, what, cure): Problem| match unit {
                None if kind == ErrorKind::UnknownUnit => {
                    let message = format!("the unit `{stated}` of column `{name}` is not known");
                    (kind, message, format!("it must be one of {expected}"))
                }
                _ => (kind, format!("column `{name}` unit: {what}"), cure),
            };
            let found = unit_of_signal(stated, name, &[expected]).map_err(refused)?;
            if found.absolute {
                let air = ATMOSPHERE / 1e5;
                let text = format!("column `{name}` is absolute; {air} bar of standard atmosphere are subtracted");
                self.decided.borrow_mut().push((text, "log gauge pressure if the air pressure is another"));
            }
            in_si(stated, values, quantity.name == PRESSURE.name).map_err(refused)?
        };
        match values.iter().position(|value| !value.is_finite()) {
            Some(row) => {
                let message = format!("column `{name}` of the log has no number in row {}", row + 1);
                Err((ErrorKind::NotFinite, message, "fill the gap, or cut the log there".into()))
            }
            None => Ok(values),
        }
    }

    /// The error of a log that has no column of any of these names.
    pub fn without_columns<'n>(&self, wanted: impl Iterator<Item = &'n str>, what: &str) -> Problem {
        let wanted: Vec<&str> = wanted.collect();
        let message = format!("the log has no column of a {what}; it has {}", self.names().join(", "));
        let cure = format!("name its columns {}, or state which is which", wanted.join(", "));
        (ErrorKind::UnknownReference, message, cure)
    }

    /// The error of a log without times. That may be any file, whose first line is not for those who named it: only a near name is told.
    fn without_times(&self, wanted: &str) -> Problem {
        let message = format!("the log has no column `{wanted}` for the times");
        let near = Some(suggestion(wanted, self.names())).filter(|near| near.starts_with("did"));
        let cure = near.unwrap_or_else(|| "is it a log? Call the column `time`, or state its name".into());
        (ErrorKind::UnknownReference, message, cure)
    }
}

/// The error of a log of which several columns may be meant.
fn several((kind, names, cure): Problem) -> Problem {
    (kind, format!("the log {names}"), cure)
}

fn cure_of(loss: &Loss) -> &'static str {
    match loss {
        Loss::Undecided(_) => "beside `log`, say number-format = \"1,234.5\" or \"1.234,5\"",
        Loss::Mixed(..) => "write decimals with a point everywhere, and no marks of thousands",
        Loss::Dates | Loss::OfNoDay(_) => "write dates as 2024-05-01T12:30:00.25",
        Loss::DateOf(_) => "name the column with the times of day",
        Loss::Words(_) | Loss::NoCells => "give one number for each time",
    }
}
