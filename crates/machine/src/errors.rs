//! One error says what is wrong, where, the nearest valid choice and the cure.

use std::borrow::Cow;
use std::fmt;

/// Most letters of a passage in backticks, of a key or of a name, and of a whole message or cure, because errors quote
/// values of any length.
const LONGEST_QUOTE: usize = 200;
const LONGEST_TEXT: usize = 1500;

macro_rules! kinds {
    ($($(#[$doc:meta])* $name:ident = $slug:literal,)*) => {
        /// Kind of an error. The slug is stable, so programs may match on it.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum ErrorKind { $($(#[$doc])* $name,)* }

        impl ErrorKind {
            pub fn slug(self) -> &'static str {
                match self { $(Self::$name => $slug,)* }
            }
        }

        /// Every slug a [`MachineError`] can carry.
        pub const ERROR_SLUGS: &[&str] = &[$($slug,)*];
    };
}

kinds! {
    /// The file cannot be opened or read.
    UnreadableFile = "unreadable-file",
    /// Neither a bundled name nor a path.
    UnknownSource = "unknown-source",
    /// A machine in place of a scenario, or vice versa.
    WrongKindOfFile = "wrong-kind-of-file",
    /// A name that is none on some system or in some format.
    BadName = "bad-name",
    /// The bytes are not UTF-8 text, or it has a character that no text has.
    NotText = "not-text",
    /// The file has no key.
    EmptyFile = "empty-file",
    /// Not valid TOML.
    Syntax = "syntax",
    DuplicateKey = "duplicate-key",
    /// A file extends itself, directly or through others.
    ExtendsCycle = "extends-cycle",
    UnknownKey = "unknown-key",
    MissingKey = "missing-key",
    /// Two keys that exclude each other, or a group given only in part.
    ConflictingKeys = "conflicting-keys",
    /// A string where a table is needed, and the like.
    WrongType = "wrong-type",
    /// A word outside the list of choices.
    InvalidChoice = "invalid-choice",
    /// A value without a provenance class.
    MissingClass = "missing-class",
    /// Text that is not a number with a unit, or not a point.
    BadQuantity = "bad-quantity",
    MissingUnit = "missing-unit",
    UnknownUnit = "unknown-unit",
    WrongDimension = "wrong-dimension",
    NotFinite = "not-finite",
    /// Negative, zero or beyond a bound by another value.
    OutOfRange = "out-of-range",
    CrossedLimits = "crossed-limits",
    /// A link, point, joint or cylinder that does not exist.
    UnknownReference = "unknown-reference",
    /// The joints do not form one serial chain.
    NotAChain = "not-a-chain",
    /// A joint without exactly one cylinder, a cylinder without exactly one valve or friction table.
    NotOneToOne = "not-one-to-one",
    /// Cylinder pins that are not on the two links of the cylinder's joint.
    MisplacedPin = "misplaced-pin",
    /// A linkage that cannot close in any position of its joint.
    CannotClose = "cannot-close",
    /// More text, tables, values or nested files than allowed.
    TooLarge = "too-large",
    /// Command series with different lengths or with times that do not increase.
    BadSeries = "bad-series",
}

/// An error without its place: kind, message and cure.
pub type Problem = (ErrorKind, String, String);

/// Place in a file: name, line and column counted from one, the text of the line, and how many columns to underline.
#[derive(Debug, Clone, PartialEq)]
pub struct FilePosition {
    pub file: String,
    pub line: usize,
    pub column: usize,
    pub excerpt: String,
    pub width: usize,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Location {
    Position(FilePosition),
    /// A whole file or a source name.
    Source(String),
    /// An override given by the caller, by its key.
    Override(String),
}

#[derive(Debug, Clone, PartialEq)]
struct Details {
    kind: ErrorKind,
    location: Location,
    key: Option<String>,
    message: String,
    help: Option<String>,
}

/// A description that cannot be used, and the cure.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineError(Box<Details>);

impl MachineError {
    pub(crate) fn new(kind: ErrorKind, location: Location, message: impl Into<String>) -> Self {
        let message = shortened(&message.into());
        Self(Box::new(Details { kind, location, key: None, message, help: None }))
    }

    /// States the dotted key the error is about.
    pub(crate) fn at_key(mut self, key: impl Into<String>) -> Self {
        self.0.key = Some(cut(&key.into(), LONGEST_QUOTE).into_owned());
        self
    }

    /// States the cure.
    pub(crate) fn help(mut self, help: impl Into<String>) -> Self {
        self.0.help = Some(shortened(&help.into()));
        self
    }

    pub fn kind(&self) -> ErrorKind {
        self.0.kind
    }

    pub fn slug(&self) -> &'static str {
        self.0.kind.slug()
    }

    /// The message without place and cure.
    pub fn message(&self) -> &str {
        &self.0.message
    }

    pub fn location(&self) -> &Location {
        &self.0.location
    }

    pub fn file(&self) -> Option<&str> {
        match &self.0.location {
            Location::Position(position) => Some(&position.file),
            Location::Source(name) => Some(name),
            Location::Override(_) => None,
        }
    }

    /// Line in the file, from one.
    pub fn line(&self) -> Option<usize> {
        self.position().map(|position| position.line)
    }

    /// Column in the line, from one, counted in characters.
    pub fn column(&self) -> Option<usize> {
        self.position().map(|position| position.column)
    }

    /// Dotted path of the offending key.
    pub fn key(&self) -> Option<&str> {
        self.0.key.as_deref()
    }

    /// The cure: nearest valid name, expected form.
    pub fn cure(&self) -> Option<&str> {
        self.0.help.as_deref()
    }

    fn position(&self) -> Option<&FilePosition> {
        match &self.0.location {
            Location::Position(position) => Some(position),
            _ => None,
        }
    }
}

impl fmt::Display for MachineError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: [{}] ", self.0.location, self.slug())?;
        if let Some(key) = self.key() {
            write!(f, "{key}: ")?;
        }
        write!(f, "{}", self.message())?;
        if let Some(help) = self.cure() {
            write!(f, "; {help}")?;
        }
        if let Some(p) = self.position().filter(|p| !p.excerpt.trim().is_empty()) {
            let number = p.line.to_string();
            let gutter = " ".repeat(number.len());
            let indent = " ".repeat(p.column - 1);
            write!(f, "\n{number} | {}\n{gutter} | {indent}{}", p.excerpt, "^".repeat(p.width.max(1)))?;
        }
        Ok(())
    }
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Location::Position(p) => write!(f, "{}:{}:{}", cut(&p.file, LONGEST_QUOTE), p.line, p.column),
            Location::Source(name) => f.write_str(&cut(name, LONGEST_QUOTE)),
            Location::Override(key) => write!(f, "override \"{}\"", cut(key, LONGEST_QUOTE)),
        }
    }
}

impl std::error::Error for MachineError {}

/// A message with long quotations, and itself, cut in the middle.
pub fn shortened(text: &str) -> String {
    // Every other passage is between backticks.
    let passages = text.split('`').enumerate();
    let cut_quotes = passages.map(|(i, passage)| if i % 2 == 1 { cut(passage, LONGEST_QUOTE) } else { passage.into() });
    cut(&cut_quotes.collect::<Vec<_>>().join("`"), LONGEST_TEXT).into_owned()
}

/// Head and tail of a text of more than `most` letters.
fn cut(text: &str, most: usize) -> Cow<'_, str> {
    let letters = text.chars().count();
    if letters <= most {
        return text.into();
    }
    let head: String = text.chars().take(most / 2).collect();
    let tail: String = text.chars().skip(letters - most / 2).collect();
    format!("{head} ... {tail}").into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_quotes_lose_their_middle_and_messages_keep_both_ends() {
        let short = "unknown `key`; did you mean `pay`?";
        assert_eq!(shortened(short), short);
        let quoted = shortened(&format!("no crane `{}end`; choose `a`", "ö".repeat(300_000)));
        assert!(quoted.starts_with("no crane `öö") && quoted.ends_with("öend`; choose `a`"), "{quoted}");
        assert!(quoted.contains("ö ... ö") && quoted.chars().count() < 300);
        let bare = shortened(&format!("got {} here", "long ".repeat(60_000)));
        assert!(bare.starts_with("got long") && bare.ends_with("here") && bare.chars().count() < LONGEST_TEXT + 10);
    }

    #[test]
    fn every_part_of_an_error_is_short() {
        let long = "long ".repeat(60_000);
        let place = FilePosition { file: long.clone(), line: 1, column: 1, excerpt: String::new(), width: 1 };
        for location in [Location::Source(long.clone()), Location::Override(long.clone()), Location::Position(place)] {
            let error = MachineError::new(ErrorKind::UnknownSource, location, format!("no `{long}`"));
            let text = error.at_key(&long).help(&long).to_string();
            assert!(text.chars().count() < 3000, "{}", text.len());
        }
    }
}
