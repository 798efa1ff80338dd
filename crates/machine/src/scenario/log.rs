//! Logs that a scenario names: text files with columns, beside the scenario or passed with it.

use crate::columns::{Columns, Problem};
use crate::document::LONGEST_TEXT;
use crate::errors::ErrorKind;
use crate::load::given;
use crate::quantities::TIME;
use crate::units::Quantity;
use std::io::Read;
use std::path::Path;

/// Places of the files that a scenario names.
#[derive(Clone, Copy, Default)]
pub struct Files<'a> {
    /// The scenario's own; `None`: it is bundled, or a text in memory.
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
    pub fn beside(&self, name: &str) -> String {
        self.folder.map_or_else(|| name.into(), |folder| folder.join(name).display().to_string())
    }

    /// The text that was passed under this name.
    pub fn given(&self, name: &str) -> Option<&str> {
        given(self.given, name).map(|(_, text)| text.as_str())
    }

    /// The text of the file `name`, or the reason why it cannot be read.
    fn text(&self, name: &str) -> std::result::Result<String, String> {
        if let Some(text) = self.given(name) {
            return Ok(text.into());
        }
        let mut bytes = Vec::new();
        let file = std::fs::File::open(self.beside(name));
        let read = file.and_then(|file| file.take(LONGEST_TEXT as u64 + 1).read_to_end(&mut bytes));
        read.map_err(|error| format!("`{name}` cannot be read: {error}"))?;
        if bytes.len() > LONGEST_TEXT {
            return Err(format!("`{name}` is longer than {} MiB", LONGEST_TEXT >> 20));
        }
        String::from_utf8(bytes).map_err(|_| format!("`{name}` is not UTF-8 text"))
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
        let unreadable = |message| (ErrorKind::UnreadableFile, message, "check the name and the folder".to_string());
        let columns = Columns::read(&files.text(name).map_err(unreadable)?)?;
        let names = time.map_or_else(|| TIMES.to_vec(), |time| vec![time]);
        let time = columns.column(columns.index(&names, "the times")?, None, &TIME.quantity())?;
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
