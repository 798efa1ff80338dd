//! One error says what is wrong, where, the nearest valid choice and the cure.

use std::fmt;

macro_rules! kinds {
    ($($(#[$doc:meta])* $name:ident = $slug:literal,)*) => {
        /// What went wrong. The slug is stable: programs may match on it.
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
    /// The bytes are not UTF-8 text.
    NotText = "not-text",
    /// The file holds no key at all.
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
    /// A value whose provenance class is stated nowhere.
    MissingClass = "missing-class",
    /// Text that is not a number with a unit, or not a point.
    BadQuantity = "bad-quantity",
    MissingUnit = "missing-unit",
    UnknownUnit = "unknown-unit",
    WrongDimension = "wrong-dimension",
    NotFinite = "not-finite",
    /// Negative, zero or beyond a bound that another value sets.
    OutOfRange = "out-of-range",
    CrossedLimits = "crossed-limits",
    /// A link, point, joint or cylinder that does not exist.
    UnknownReference = "unknown-reference",
    /// The joints do not form one serial chain.
    NotAChain = "not-a-chain",
    /// A joint without exactly one cylinder, a cylinder without exactly one valve or friction table.
    NotOneToOne = "not-one-to-one",
    /// Cylinder pins that do not sit on the two links of the cylinder's joint.
    MisplacedPin = "misplaced-pin",
    /// A linkage that closes in no position of its joint.
    CannotClose = "cannot-close",
    /// Command series whose lengths differ or whose times do not grow.
    BadSeries = "bad-series",
}

/// Where in a file: name, line and column counted from one, the text of the line, and how many columns to underline.
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
        Self(Box::new(Details { kind, location, key: None, message: message.into(), help: None }))
    }

    /// States the dotted key the error is about.
    pub(crate) fn at_key(mut self, key: impl Into<String>) -> Self {
        self.0.key = Some(key.into());
        self
    }

    /// States the cure.
    pub(crate) fn help(mut self, help: impl Into<String>) -> Self {
        self.0.help = Some(help.into());
        self
    }

    pub fn kind(&self) -> ErrorKind {
        self.0.kind
    }

    pub fn slug(&self) -> &'static str {
        self.0.kind.slug()
    }

    /// What is wrong, without place and cure.
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
        match &self.0.location {
            Location::Position(p) => write!(f, "{}:{}:{}: ", p.file, p.line, p.column)?,
            Location::Source(name) => write!(f, "{name}: ")?,
            Location::Override(key) => write!(f, "override \"{key}\": ")?,
        }
        write!(f, "[{}] ", self.slug())?;
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

impl std::error::Error for MachineError {}
