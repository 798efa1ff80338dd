//! Reads a table: its keys are checked against the known ones, its values come out typed.

use crate::document::{join, Entry, Node, NodeKind, Place};
use crate::errors::{ErrorKind, MachineError};
use crate::field::POINT_EXAMPLE;
pub use crate::field::{Field, Sign};
pub use crate::log::Log;
use crate::nearest::suggestion;
use crate::units::Quantity;

type Result<T> = std::result::Result<T, MachineError>;

/// A table whose keys have been checked against the known ones.
#[derive(Clone)]
pub struct Reader<'a> {
    entries: &'a [Entry],
    pub place: &'a Place,
    pub path: String,
    log: &'a Log,
}

impl<'a> Reader<'a> {
    /// Opens the table `node`; a key outside `known` is an error. `None` takes any key: the keys are names.
    pub fn open(node: &'a Node, path: String, known: Option<&[&str]>, log: &'a Log) -> Result<Self> {
        let Some(entries) = node.entries() else {
            let found = format!("expected a table, found {}", node.kind_name());
            return Err(node.place.error(ErrorKind::WrongType, &path, found).help(format!("head it by [{path}]")));
        };
        for entry in entries {
            if let Some(known) = known.filter(|known| !known.contains(&entry.key.as_str())) {
                let help = match entry.key.as_str() {
                    // TOML counts a key to the table above it, wherever its author wanted it.
                    key @ ("extends" | "include") => {
                        format!("`{key}` belongs above the first table of a machine file, above this [{path}]")
                    }
                    key => suggestion(key, known.iter().copied()),
                };
                let key = join(&path, &entry.key);
                return Err(entry.place.error(ErrorKind::UnknownKey, &key, "unknown key").help(help));
            }
        }
        Ok(Self { entries, place: &node.place, path, log })
    }

    fn entry(&self, key: &str) -> Option<&'a Entry> {
        self.entries.iter().find(|entry| entry.key == key)
    }

    pub fn has(&self, key: &str) -> bool {
        self.entry(key).is_some()
    }

    pub fn missing(&self, key: &str, help: impl Into<String>) -> MachineError {
        self.place.error(ErrorKind::MissingKey, &join(&self.path, key), "missing key").help(help)
    }

    /// An error about `key` (or, where it is absent, about the table).
    pub fn error(&self, kind: ErrorKind, key: &str, message: impl Into<String>) -> MachineError {
        let place = self.entry(key).map_or(self.place, |entry| &entry.node.place);
        place.error(kind, &join(&self.path, key), message)
    }

    /// As [`Self::error`], at the key itself rather than at its value.
    pub fn key_error(&self, kind: ErrorKind, key: &str, message: impl Into<String>) -> MachineError {
        let place = self.entry(key).map_or(self.place, |entry| &entry.place);
        place.error(kind, &join(&self.path, key), message)
    }

    /// A sub-table with known keys.
    pub fn table(&self, key: &str, known: &[&str]) -> Result<Option<Reader<'a>>> {
        let Some(entry) = self.entry(key) else { return Ok(None) };
        Reader::open(&entry.node, join(&self.path, key), Some(known), self.log).map(Some)
    }

    /// The named sub-tables of `[key.<name>]`, each with known keys.
    pub fn named_tables(&self, key: &str, known: &[&str]) -> Result<Vec<(&'a str, Reader<'a>)>> {
        let Some(names) = self.names(key)? else { return Ok(Vec::new()) };
        names
            .entries
            .iter()
            .map(|entry| {
                let path = join(&names.path, &entry.key);
                Ok((entry.key.as_str(), Reader::open(&entry.node, path, Some(known), self.log)?))
            })
            .collect()
    }

    /// A sub-table whose keys are names.
    pub fn names(&self, key: &str) -> Result<Option<Reader<'a>>> {
        let Some(entry) = self.entry(key) else { return Ok(None) };
        Reader::open(&entry.node, join(&self.path, key), None, self.log).map(Some)
    }

    pub fn keys(&self) -> impl Iterator<Item = &'a str> + use<'a> {
        self.entries.iter().map(|entry| entry.key.as_str())
    }

    /// Every node of the table, for free-form tables.
    pub fn nodes(&self) -> impl Iterator<Item = (&'a str, &'a Node)> + use<'a> {
        self.entries.iter().map(|entry| (entry.key.as_str(), &entry.node))
    }

    pub fn optional(&self, key: &str) -> Result<Option<Field<'a>>> {
        let Some(entry) = self.entry(key) else { return Ok(None) };
        let path = join(&self.path, key);
        match &entry.node.kind {
            NodeKind::Value { value, origin } => {
                Ok(Some(Field { path, place: &entry.node.place, value, origin, log: self.log }))
            }
            NodeKind::Table(_) => Err(entry
                .place
                .error(ErrorKind::WrongType, &path, "expected a value, found a table")
                .help(format!("write `{key} = ...` in the table above"))),
        }
    }

    pub fn required(&self, key: &str, help: &str) -> Result<Field<'a>> {
        self.optional(key)?.ok_or_else(|| self.missing(key, format!("give {help}")))
    }

    pub fn quantity(&self, key: &str, quantity: &Quantity, sign: Sign) -> Result<f64> {
        self.required(key, &quantity.example())?.quantity(quantity, sign)
    }

    pub fn optional_quantity(&self, key: &str, quantity: &Quantity, sign: Sign) -> Result<Option<f64>> {
        self.optional(key)?.map(|field| field.quantity(quantity, sign)).transpose()
    }

    pub fn quantity_or(&self, key: &str, quantity: &Quantity, sign: Sign, default: f64) -> Result<f64> {
        Ok(self.optional_quantity(key, quantity, sign)?.unwrap_or(default))
    }

    pub fn point(&self, key: &str) -> Result<[f64; 2]> {
        self.required(key, POINT_EXAMPLE)?.point()
    }

    pub fn text(&self, key: &str) -> Result<&'a str> {
        self.required(key, "a text in quotes")?.text()
    }

    pub fn text_or(&self, key: &str, default: &'a str) -> Result<&'a str> {
        self.optional(key)?.map_or(Ok(default), |field| field.text())
    }

    pub fn choice<T: Copy>(&self, key: &str, choices: &[(&str, T)]) -> Result<T> {
        let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
        self.required(key, &format!("one of {}", names.join(", ")))?.choice(choices)
    }

    pub fn choice_or<T: Copy>(&self, key: &str, choices: &[(&str, T)], default: T) -> Result<T> {
        self.optional(key)?.map_or(Ok(default), |field| field.choice(choices))
    }

    /// Which of two groups of keys the table uses: 0 or 1. Keys of both are a conflict; `None` where there are none.
    pub fn either(&self, groups: [&[&'static str]; 2]) -> Result<Option<usize>> {
        let first = |group: &[&'static str]| group.iter().copied().find(|key| self.has(key));
        match (first(groups[0]), first(groups[1])) {
            (Some(a), Some(b)) => Err(self
                .error(ErrorKind::ConflictingKeys, b, format!("excludes `{a}`, which is given too"))
                .help("keep one of the two")),
            (Some(_), None) => Ok(Some(0)),
            (None, Some(_)) => Ok(Some(1)),
            (None, None) => Ok(None),
        }
    }
}
