//! Logs that a scenario names: text files with columns, beside the scenario or passed with it.

use crate::disk;
use crate::errors::ErrorKind;
use crate::field::{Field, MOST_ROWS};
use crate::load::given;
use crate::nearest::suggestion;
use crate::quantities::TIME;
use crate::units::{parse_unit, with_article, Quantity};
use hydrocrane_logs::{column_named, split_name, time_column, Column, Content, Form, Format, Loss, Table};
use std::cell::RefCell;
use std::path::Path;

/// An error of a log: kind, message and cure.
pub type Problem = (ErrorKind, String, String);

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
const TEXTS: [&str; 5] = ["csv", "txt", "tsv", "dat", "log"];

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
    if !LOGS {
        return Err((ErrorKind::UnreadableFile, "logs are not read here".into(), "choose another program".into()));
    }
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
    /// What was decided on the columns that were read.
    decided: RefCell<Vec<String>>,
}

impl Log {
    /// Reads the log `name`; `time` is its column of times, `numbers` how it writes them if its cells do not say.
    pub fn open(name: &str, time: Option<&str>, numbers: Option<Format>, files: &Files) -> Result<Self, Problem> {
        if !is_text(name) {
            let message = format!("`{name}` is not a log in text form");
            let cure = format!("save it as CSV; suffixes of texts are {}", TEXTS.join(", "));
            return Err((ErrorKind::UnreadableFile, message, cure));
        }
        let mut log =
            Log { columns: files.table(name, numbers)?.columns, time: Vec::new(), decided: RefCell::default() };
        let found = time.map_or_else(|| time_column(&log.columns), |time| log.find(&[time]));
        let index = found.ok_or_else(|| log.without_times(time.unwrap_or("time")))?;
        log.time = log.values(index, None, &TIME.quantity())?;
        if let Some(pair) = log.time.windows(2).find(|pair| pair[1] <= pair[0]) {
            let message = format!("the times of the log do not increase: {} s follows {} s", pair[1], pair[0]);
            return Err((ErrorKind::BadSeries, message, "sort its rows, each time once".into()));
        }
        Ok(log)
    }

    /// Warns on what was decided on the columns that were read.
    pub fn tell(&self, field: &Field) {
        for text in self.decided.borrow().iter() {
            field.warn(format!("a log: {text}"), "write its numbers without marks of thousands".into());
        }
    }

    pub fn has(&self, names: &[&str]) -> bool {
        self.find(names).is_some()
    }

    /// The column with one of these names, with or without its unit, in any case.
    fn find(&self, wanted: &[&str]) -> Option<usize> {
        wanted.iter().find_map(|wanted| column_named(&self.columns, wanted))
    }

    fn names(&self) -> Vec<&str> {
        self.columns.iter().map(|column| split_name(&column.name).0).filter(|name| !name.is_empty()).collect()
    }

    /// The column of one of these names, in SI; `what` states its purpose. Its unit is the given `unit`, else that of the log, else SI.
    pub fn column(
        &self,
        names: &[&str],
        what: &str,
        unit: Option<&str>,
        quantity: &Quantity,
    ) -> Result<Vec<f64>, Problem> {
        let index = self.find(names).ok_or_else(|| {
            let message = format!("the log has no column `{}` for {what}", names[0]);
            (ErrorKind::UnknownReference, message, suggestion(names[0], self.names()))
        })?;
        self.values(index, unit, quantity)
    }

    fn values(&self, index: usize, unit: Option<&str>, quantity: &Quantity) -> Result<Vec<f64>, Problem> {
        let column = &self.columns[index];
        let (name, of_name) = split_name(&column.name);
        let values = match &column.content {
            Content::Numbers { values, notes, .. } => {
                self.decided.borrow_mut().extend(notes.iter().map(|(_, text)| format!("column `{name}` {text}")));
                values
            }
            Content::Lost(loss) => {
                let message = format!("column `{name}` of the log has no numbers: {}", loss.text());
                return Err((ErrorKind::BadSeries, message, cure_of(loss).into()));
            }
        };
        let bare = column.unit.trim_matches(['[', ']', '(', ')', ' ']);
        let stated = unit.unwrap_or(if bare.is_empty() { of_name } else { bare });
        let scale = match stated {
            "" | "1" | "-" => None,
            _ => Some(parse_unit(stated).map_err(|_| {
                let message = format!("column `{name}` of the log has the unknown unit `{stated}`");
                (ErrorKind::UnknownUnit, message, format!("state its unit, for example \"{}\"", quantity.unit))
            })?),
        };
        if scale.is_some_and(|scale| scale.dimension != quantity.dimension) {
            let message =
                format!("column `{name}` of the log is in `{stated}`; it must be {}", with_article(quantity.name));
            let cure = format!("give a column in {}, or state the right unit", quantity.example());
            return Err((ErrorKind::WrongDimension, message, cure));
        }
        let values: Vec<f64> = values.iter().map(|value| scale.map_or(*value, |scale| scale.to_si(*value))).collect();
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

fn cure_of(loss: &Loss) -> &'static str {
    match loss {
        Loss::Undecided(_) => "beside `log`, say number-format = \"1,234.5\" or \"1.234,5\"",
        Loss::Mixed(..) => "write decimals with a point everywhere, and no marks of thousands",
        Loss::Dates => "write dates as 2024-05-01T12:30:00.25",
        Loss::Words(_) | Loss::NoCells => "give one number for each time",
    }
}
