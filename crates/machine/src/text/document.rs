//! A parsed file as a tree; every key and value has its place and its provenance.
//!
//! Provenance is resolved within each file before files are merged: `class` and `source` apply to the values of their
//! table and below it, never to the values of another file.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use toml_edit::{Document, Item, TableLike, Value};

use crate::errors::{ErrorKind, FilePosition, Location, MachineError};
use crate::keys;
use crate::names::{escaped, is_strange, name_fault, text_fault};
use crate::nearest::suggestion;

/// A file's name and text.
#[derive(Debug)]
pub struct SourceFile {
    pub name: String,
    pub text: String,
}

/// Place of a key or value. Its line is counted when somebody asks for it.
#[derive(Clone)]
pub enum Place {
    File { file: Arc<SourceFile>, span: Range<usize> },
    Override(Arc<str>),
}

/// Provenance of a value; each text has its place, for error messages.
#[derive(Debug, Clone, Default)]
pub struct Origin {
    pub class: Option<(String, Place)>,
    pub source: String,
    /// What the file states in the place of an override.
    pub of_file: Option<Scalar>,
}

#[derive(Debug, Clone)]
pub struct Node {
    pub place: Place,
    pub kind: NodeKind,
}

#[derive(Debug, Clone)]
pub enum NodeKind {
    /// Shared, so that a tree with an override copies no more than the tables above it.
    Table(Arc<Vec<Entry>>),
    Value {
        value: Scalar,
        origin: Arc<Origin>,
    },
}

#[derive(Debug, Clone)]
pub enum Scalar {
    Text(String),
    Number(f64),
    Bool(bool),
    List(Vec<(Scalar, Place)>),
    /// A TOML date or time; no key accepts one.
    Date,
}

#[derive(Debug, Clone)]
pub struct Entry {
    pub key: String,
    pub place: Place,
    pub node: Node,
}

impl PartialEq for Place {
    fn eq(&self, other: &Self) -> bool {
        self.locate() == other.locate()
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.locate().fmt(f)
    }
}

impl fmt::Debug for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&self.to_string(), f)
    }
}

impl Place {
    pub fn locate(&self) -> Location {
        match self {
            Self::File { file, span } => Location::Position(position(file, span)),
            Self::Override(key) => Location::Override(key.to_string()),
        }
    }

    pub fn error(&self, kind: ErrorKind, key: &str, message: impl Into<String>) -> MachineError {
        MachineError::new(kind, self.locate(), message).at_key(key)
    }
}

impl Node {
    pub fn kind_name(&self) -> &'static str {
        match &self.kind {
            NodeKind::Table(_) => "a table",
            NodeKind::Value { value, .. } => value.kind_name(),
        }
    }

    pub fn entries(&self) -> Option<&[Entry]> {
        match &self.kind {
            NodeKind::Table(entries) => Some(entries),
            NodeKind::Value { .. } => None,
        }
    }
}

impl Scalar {
    pub fn kind_name(&self) -> &'static str {
        match self {
            Self::Text(_) => "a text",
            Self::Number(_) => "a plain number",
            Self::Bool(_) => "true or false",
            Self::List(_) => "a list",
            Self::Date => "a date",
        }
    }

    /// An error if a text in it has a character that no text has.
    pub fn check(&self, key: &str, place: &Place) -> Result<(), MachineError> {
        match self {
            // A text may have several lines.
            Self::Text(text) => check_text(&text.replace("\r\n", " ").replace(['\n', '\t'], " "), key, place),
            Self::List(items) => items.iter().try_for_each(|(item, place)| item.check(key, place)),
            _ => Ok(()),
        }
    }
}

/// An error if it is no name.
pub fn check_name(name: &str, key: &str, place: &Place) -> Result<(), MachineError> {
    match name_fault(name) {
        None => Ok(()),
        Some((fault, cure)) => Err(place.error(ErrorKind::BadName, &escaped(key), fault).help(cure)),
    }
}

/// An error if it is no text of one line.
pub fn check_text(text: &str, key: &str, place: &Place) -> Result<(), MachineError> {
    match text_fault(text) {
        None => Ok(()),
        Some(fault) => Err(place.error(ErrorKind::NotText, &escaped(key), fault).help("leave it out")),
    }
}

/// Most characters after the place that errors quote.
const LONGEST_EXCERPT: usize = 160;

/// Line and column of a span, counted from one in characters, with the text of the line.
fn position(file: &SourceFile, span: &Range<usize>) -> FilePosition {
    let text = file.text.as_str();
    let mut start = span.start.min(text.len());
    while !text.is_char_boundary(start) {
        start -= 1;
    }
    let line_start = text[..start].rfind('\n').map_or(0, |newline| newline + 1);
    let line_end = text[start..].find('\n').map_or(text.len(), |newline| start + newline);
    let mut end = span.end.clamp(start, line_end.max(start));
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    let column = text[line_start..start].chars().count() + 1;
    FilePosition {
        file: file.name.clone(),
        line: text[..line_start].matches('\n').count() + 1,
        column,
        excerpt: if is_ours(text) { excerpt(text[line_start..line_end].trim_end(), column) } else { String::new() },
        width: text[start..end.max(start)].chars().count().min(LONGEST_EXCERPT),
    }
}

/// Whether a text begins as a machine or scenario file does, with a table or key that these have. Of another one errors quote nothing:
/// whoever wrote the path of somebody else's file shall not read it in an error.
fn is_ours(text: &str) -> bool {
    let mut lines = text.trim_start_matches('\u{feff}').lines().map(str::trim);
    let Some(first) = lines.find(|line| !line.is_empty() && !line.starts_with('#')) else { return false };
    let heading = first.strip_prefix('[');
    let first = heading.map_or(first, |rest| rest.trim_start_matches(['[', ' ']));
    let (name, rest) =
        first.split_at(first.find(|c: char| !c.is_ascii_alphanumeric() && c != '-').unwrap_or(first.len()));
    let is_table =
        |key: &keys::Key| matches!(key.value, keys::Value::Table(_) | keys::Value::Tables(_) | keys::Value::Overrides);
    let mut declared = keys::MACHINE.iter().chain(keys::SCENARIO).filter(|key| key.name == name);
    match heading {
        Some(_) => declared.any(is_table) && (rest.is_empty() || rest.trim_start().starts_with([']', '.'])),
        None => declared.next().is_some() && rest.trim_start().starts_with(['=', '.']),
    }
}

/// A line as quoted in errors, cut after `column`; empty if the line is too long.
fn excerpt(line: &str, column: usize) -> String {
    if column > LONGEST_EXCERPT {
        return String::new();
    }
    let most = column + LONGEST_EXCERPT;
    // Tabs would shift the caret away from its column.
    let mut quoted: String = line.chars().take(most).map(|c| if is_strange(c) { ' ' } else { c }).collect();
    if line.chars().nth(most).is_some() {
        quoted.push('…');
    }
    quoted
}

/// Longest text of a file, bytes: a drive of an hour with its sticks.
pub const LONGEST_TEXT: usize = 16 << 20;
/// Most keys of one table.
const MOST_KEYS: usize = 2000;

/// Largest [`weight`] of a text, about half a gigabyte of memory while it is read.
const MOST_WEIGHT: usize = 2_000_000;

/// Cost of reading a text, in units of a list value: a list costs four, a key eight.
fn weight(text: &str) -> usize {
    let cost = |byte: u8| match byte {
        b',' => 1,
        b'[' => 4,
        b'=' => 8,
        _ => 0,
    };
    text.bytes().map(cost).sum()
}

/// The error of a file that is longer than [`LONGEST_TEXT`].
pub fn too_long(file: &Arc<SourceFile>, what: &str) -> MachineError {
    let place = Place::File { file: file.clone(), span: 0..0 };
    let message = format!("{what} longer than {} MiB", LONGEST_TEXT >> 20);
    MachineError::new(ErrorKind::TooLarge, place.locate(), message).help("is it a machine or scenario file?")
}

/// What has been read so far of files that belong together. One that extends and includes others takes no more with these than one alone.
#[derive(Default)]
pub struct Budget {
    bytes: usize,
    weight: usize,
}

impl Budget {
    /// Parses a further file's text into a tree.
    pub fn parse(&mut self, file: &Arc<SourceFile>) -> Result<Node, MachineError> {
        let alone = self.bytes == 0;
        self.bytes += file.text.len();
        self.weight += weight(&file.text);
        if self.bytes > LONGEST_TEXT {
            return Err(too_long(
                file,
                if alone { "the text is" } else { "this file and those that belong to it are" },
            ));
        }
        if self.weight > MOST_WEIGHT {
            let place = Place::File { file: file.clone(), span: 0..0 };
            let what = if alone { "the text holds" } else { "this file and those that belong to it hold" };
            return Err(MachineError::new(ErrorKind::TooLarge, place.locate(), format!("{what} too many values"))
                .help("give shorter lists, and omit what is not needed"));
        }
        tree(file)
    }
}

/// Parses a file's text into a tree.
pub fn parse(file: &Arc<SourceFile>) -> Result<Node, MachineError> {
    Budget::default().parse(file)
}

fn tree(file: &Arc<SourceFile>) -> Result<Node, MachineError> {
    let document = Document::parse(file.text.as_str()).map_err(|error| syntax_error(file, &error))?;
    if document.as_table().is_empty() {
        let place = Place::File { file: file.clone(), span: 0..0 };
        return Err(MachineError::new(ErrorKind::EmptyFile, place.locate(), "the file holds no keys")
            .help("start from a copy of a bundled machine or scenario"));
    }
    let builder = Builder { file };
    let root = document.as_table();
    // The topmost default of every value is in [machine].
    let machine = root.get("machine").and_then(Item::as_table_like);
    let origin = match machine {
        Some(table) => builder.origin(table, &Arc::default(), "machine")?,
        None => Arc::default(),
    };
    builder.table(root, Place::File { file: file.clone(), span: 0..0 }, &origin, "")
}

fn syntax_error(file: &Arc<SourceFile>, error: &toml_edit::TomlError) -> MachineError {
    let span = error.span().unwrap_or(0..0);
    let message = error.message().trim().replace('\n', ", ");
    let place = Place::File { file: file.clone(), span };
    if message.contains("duplicate key") {
        return MachineError::new(ErrorKind::DuplicateKey, place.locate(), "the name is given twice")
            .help("keep one of the two, or rename the second");
    }
    MachineError::new(ErrorKind::Syntax, place.locate(), format!("not valid TOML: {message}"))
        .help("values with units are texts in quotes, tables are headed by [name]")
}

struct Builder<'a> {
    file: &'a Arc<SourceFile>,
}

impl Builder<'_> {
    fn place(&self, span: Option<Range<usize>>) -> Option<Place> {
        span.map(|span| Place::File { file: self.file.clone(), span })
    }

    fn start(&self) -> Place {
        Place::File { file: self.file.clone(), span: 0..0 }
    }

    /// The provenance that applies inside `table`.
    fn origin(&self, table: &dyn TableLike, outer: &Arc<Origin>, path: &str) -> Result<Arc<Origin>, MachineError> {
        let class = self.text_of(table, "class", path)?;
        let source = self.text_of(table, "source", path)?;
        if class.is_none() && source.is_none() {
            return Ok(outer.clone());
        }
        Ok(Arc::new(Origin {
            class: class.or_else(|| outer.class.clone()),
            source: source.map_or_else(|| outer.source.clone(), |(text, _)| text),
            of_file: None,
        }))
    }

    fn text_of(&self, table: &dyn TableLike, key: &str, path: &str) -> Result<Option<(String, Place)>, MachineError> {
        let Some(item) = table.get(key) else { return Ok(None) };
        let place = self.place(item.span()).unwrap_or_else(|| self.start());
        match item.as_str() {
            Some(text) => {
                Scalar::Text(text.into()).check(&join(path, key), &place)?;
                Ok(Some((text.to_string(), place)))
            }
            None => {
                let found = format!("expected a text, found {}", item.type_name());
                Err(place.error(ErrorKind::WrongType, &join(path, key), found).help("put it in quotes"))
            }
        }
    }

    fn table(
        &self,
        table: &dyn TableLike,
        place: Place,
        outer: &Arc<Origin>,
        path: &str,
    ) -> Result<Node, MachineError> {
        let origin = self.origin(table, outer, path)?;
        if table.len() > MOST_KEYS {
            let message = format!("{} keys in one table; at most {MOST_KEYS} are read", table.len());
            return Err(place.error(ErrorKind::TooLarge, path, message).help("leave out what is not needed"));
        }
        let mut entries = Vec::new();
        for (key, item) in table.iter() {
            if key == "class" || key == "source" {
                continue;
            }
            let key_span = table.key(key).and_then(toml_edit::Key::span);
            let place = self.place(key_span).or_else(|| self.place(item.span())).unwrap_or_else(|| self.start());
            check_text(key, &join(path, key), &place)?;
            let node = self.item(item, place.clone(), &origin, &join(path, key))?;
            entries.push(Entry { key: key.to_string(), place, node });
        }
        Ok(Node { place, kind: NodeKind::Table(entries.into()) })
    }

    fn item(&self, item: &Item, key_place: Place, origin: &Arc<Origin>, path: &str) -> Result<Node, MachineError> {
        let place = self.place(item.span()).unwrap_or(key_place);
        if let Some(table) = item.as_table_like() {
            if table.contains_key("value") {
                return self.annotated(table, place, origin, path);
            }
            return self.table(table, place, origin, path);
        }
        let value = match item {
            Item::Value(value) => self.scalar(value),
            _ => Scalar::List(Vec::new()),
        };
        value.check(path, &place)?;
        Ok(Node { place, kind: NodeKind::Value { value, origin: origin.clone() } })
    }

    /// `{ value = ..., class = ..., source = ... }`: a value with its own provenance.
    fn annotated(
        &self,
        table: &dyn TableLike,
        place: Place,
        outer: &Arc<Origin>,
        path: &str,
    ) -> Result<Node, MachineError> {
        const KEYS: [&str; 3] = ["value", "class", "source"];
        if let Some((key, _)) = table.iter().find(|(key, _)| !KEYS.contains(key)) {
            let place = self.place(table.key(key).and_then(toml_edit::Key::span)).unwrap_or(place);
            return Err(place
                .error(ErrorKind::UnknownKey, &join(path, key), "unknown key")
                .help(suggestion(key, KEYS)));
        }
        let origin = self.origin(table, outer, path)?;
        match table.get("value") {
            Some(Item::Value(value)) if !value.is_inline_table() => {
                let place = self.place(value.span()).unwrap_or(place);
                let value = self.scalar(value);
                value.check(path, &place)?;
                Ok(Node { place, kind: NodeKind::Value { value, origin } })
            }
            _ => Err(place
                .error(ErrorKind::WrongType, &join(path, "value"), "expected a value, found a table")
                .help("`value` is a reserved key: it holds the number or text itself")),
        }
    }

    fn scalar(&self, value: &Value) -> Scalar {
        match value {
            Value::String(text) => Scalar::Text(text.value().clone()),
            Value::Integer(number) => Scalar::Number(*number.value() as f64),
            Value::Float(number) => Scalar::Number(*number.value()),
            Value::Boolean(flag) => Scalar::Bool(*flag.value()),
            Value::Datetime(_) => Scalar::Date,
            Value::Array(array) => Scalar::List(array.iter().map(|item| self.list_item(item)).collect()),
            // Only reached inside a list; no key accepts a list of tables.
            Value::InlineTable(_) => Scalar::List(Vec::new()),
        }
    }

    fn list_item(&self, item: &Value) -> (Scalar, Place) {
        (self.scalar(item), self.place(item.span()).unwrap_or_else(|| self.start()))
    }
}

/// Dotted path of `key` inside `path`.
pub fn join(path: &str, key: &str) -> String {
    if path.is_empty() {
        key.to_string()
    } else {
        // Called for every key of a file; `format!` takes several times as long.
        [path, ".", key].concat()
    }
}
