//! Logs that a scenario names: text files with columns, beside the scenario or passed with it.

use crate::columns::{Columns, Problem};
use crate::disk;
use crate::errors::ErrorKind;
use crate::load::given;
use crate::nearest::suggestion;
use crate::quantities::TIME;
use crate::units::Quantity;
use std::path::Path;

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
/// Names of a column of times.
const TIMES: [&str; 2] = ["time", "t"];

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

    /// The text of the file `name`.
    fn text(&self, name: &str) -> Result<String, Problem> {
        if let Some(text) = self.given(name) {
            return Ok(text.into());
        }
        let wrong = |what: String| {
            (ErrorKind::UnreadableFile, format!("`{name}` {what}"), "check the name and the folder".into())
        };
        if self.folder.is_none() {
            let cure = format!("choose `{name}` together with the file that names it");
            return Err((ErrorKind::UnreadableFile, format!("`{name}` is not among the files at hand"), cure));
        }
        let bytes =
            disk::read(Path::new(&self.beside(name)?)).map_err(|error| wrong(format!("cannot be read: {error}")))?;
        String::from_utf8(bytes).map_err(|_| wrong("is not UTF-8 text".into()))
    }
}

/// A log with its times.
pub struct Log {
    columns: Columns,
    /// s
    pub time: Vec<f64>,
}

impl Log {
    /// Reads the log `name`; `time` is its column of times.
    pub fn open(name: &str, time: Option<&str>, files: &Files) -> Result<Self, Problem> {
        if !is_text(name) {
            let message = format!("`{name}` is not a log in text form");
            let cure = format!("save it as CSV; suffixes of texts are {}", TEXTS.join(", "));
            return Err((ErrorKind::UnreadableFile, message, cure));
        }
        let columns = Columns::read(&files.text(name)?)?;
        let names = time.map_or_else(|| TIMES.to_vec(), |time| vec![time]);
        let index = columns.find(&names).ok_or_else(|| without_times(&columns, names[0]))?;
        let time = columns.column(index, None, &TIME.quantity())?;
        if time.is_empty() {
            let cure = "give a line of numbers for each time".to_string();
            return Err((ErrorKind::BadSeries, "the log has no rows".into(), cure));
        }
        if let Some(pair) = time.windows(2).find(|pair| pair[1] <= pair[0]) {
            let message = format!("the times of the log do not increase: {} s follows {} s", pair[1], pair[0]);
            return Err((ErrorKind::BadSeries, message, "sort its rows, each time once".into()));
        }
        Ok(Log { columns, time })
    }

    pub fn has(&self, names: &[&str]) -> bool {
        self.columns.find(names).is_some()
    }

    /// The column of one of these names, in SI; `what` states its purpose.
    pub fn column(
        &self,
        names: &[&str],
        what: &str,
        unit: Option<&str>,
        quantity: &Quantity,
    ) -> Result<Vec<f64>, Problem> {
        self.columns.column(self.columns.index(names, what)?, unit, quantity)
    }

    /// The error of a log that has no column of any of these names.
    pub fn without_columns<'n>(&self, wanted: impl Iterator<Item = &'n str>, what: &str) -> Problem {
        let wanted: Vec<&str> = wanted.collect();
        let message = format!("the log has no column of a {what}; it has {}", self.columns.names.join(", "));
        let cure = format!("name its columns {}, or state which is which", wanted.join(", "));
        (ErrorKind::UnknownReference, message, cure)
    }
}

/// The error of a log without times. That may be any file, whose first line is not for those who named it: only a near name is told.
fn without_times(columns: &Columns, wanted: &str) -> Problem {
    let message = format!("the log has no column `{wanted}` for the times");
    let near =
        Some(suggestion(wanted, columns.names.iter().map(String::as_str))).filter(|near| near.starts_with("did"));
    let cure = near.unwrap_or_else(|| "is it a log? Call the column `time`, or state its name".into());
    (ErrorKind::UnknownReference, message, cure)
}
