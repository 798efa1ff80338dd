//! Logs that a scenario names: text files with columns, beside the scenario or handed over with it.

use super::{check_series, Result};
use crate::columns::{Columns, Problem};
use crate::document::LONGEST_TEXT;
use crate::errors::{ErrorKind, MachineError};
use crate::quantities::TIME;
use crate::reader::Field;
use crate::units::Quantity;
use std::io::Read;
use std::path::Path;

/// Where the files are that a scenario names.
#[derive(Clone, Copy, Default)]
pub struct Files<'a> {
    /// The scenario's own; `None`: it is bundled, or a text in memory.
    pub folder: Option<&'a Path>,
    /// Names and texts that were handed over with it.
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

    /// The text that was handed over under this name; a leading `./` is none of it.
    pub fn given(&self, name: &str) -> Option<&str> {
        let plain = |name: &str| name.trim_start_matches("./").to_string();
        self.given.iter().find(|(own, _)| plain(own) == plain(name)).map(|(_, text)| text.as_str())
    }

    /// The text of the file `name`, or why there is none.
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
        String::from_utf8(bytes).map_err(|_| format!("`{name}` is no UTF-8 text"))
    }
}

/// A log that was read.
pub struct Log<'a> {
    field: Field<'a>,
    columns: Columns,
    /// s
    pub time: Vec<f64>,
}

impl<'a> Log<'a> {
    /// Reads the log that `field` names; `time` is its column of times.
    pub fn open(field: &Field<'a>, time: Option<&str>, files: &Files) -> Result<Self> {
        let name = field.text()?;
        if !is_text(name) {
            let message = format!("`{name}` is no log as text");
            let cure = format!("save it as CSV; suffixes of texts are {}", TEXTS.join(", "));
            return Err(field.error(ErrorKind::UnreadableFile, message).help(cure));
        }
        let unreadable =
            |message| field.error(ErrorKind::UnreadableFile, message).help("check the name and the folder");
        let text = files.text(name).map_err(unreadable)?;
        let wrong = |problem| at(field, problem);
        let columns = Columns::read(&text).map_err(wrong)?;
        let names = time.map_or_else(|| TIMES.to_vec(), |time| vec![time]);
        let index = columns.index(&names, "the times").map_err(wrong)?;
        let time = columns.column(index, None, &TIME.quantity()).map_err(wrong)?;
        check_series(&time, &vec![0.0; columns.len()], field, field)?;
        Ok(Log { field: field.clone(), columns, time })
    }

    pub fn has(&self, names: &[&str]) -> bool {
        self.columns.find(names).is_some()
    }

    /// The column of one of these names, in SI; `what` says what for.
    pub fn column(&self, names: &[&str], what: &str, unit: Option<&str>, quantity: &Quantity) -> Result<Vec<f64>> {
        let index = self.columns.index(names, what);
        index.and_then(|index| self.columns.column(index, unit, quantity)).map_err(|problem| at(&self.field, problem))
    }

    /// The error of a log that has no column of any of these names.
    pub fn without_columns<'n>(&self, wanted: impl Iterator<Item = &'n str>, what: &str) -> MachineError {
        let wanted: Vec<&str> = wanted.collect();
        let message = format!("the log has no column of a {what}; it has {}", self.columns.names.join(", "));
        let help = format!("name its columns {}, or say which is which", wanted.join(", "));
        self.field.error(ErrorKind::UnknownReference, message).help(help)
    }
}

fn at(field: &Field, (kind, message, cure): Problem) -> MachineError {
    field.error(kind, message).help(cure)
}
