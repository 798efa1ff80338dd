//! Reader of a table: keys are checked against the declared ones, values are typed.
//!
//! Values are read by name, as declared in [`crate::keys`]. A request for an undeclared key is a bug and panics.

use crate::errors::{ErrorKind, MachineError};
use crate::keys::{find, Key, Value, SCENARIO};
use crate::nearest::suggestion;
use crate::number::Number;
pub use crate::reading::field::Field;
use crate::reading::field::POINT_EXAMPLE;
pub use crate::reading::log::Log;
use crate::text::document::{check_name, check_text, join, Entry, Node, NodeKind, Place};
use crate::units::Quantity;

type Result<T> = std::result::Result<T, MachineError>;

/// A table whose keys have been checked against the declared ones.
#[derive(Clone)]
pub struct Reader<'a> {
    entries: &'a [Entry],
    pub place: &'a Place,
    pub path: String,
    log: &'a Log,
    keys: &'static [Key],
}

/// A table of scenario files with this name, or their key in one of these.
fn of_a_scenario(name: &str) -> Option<String> {
    let within = |table: &Key| match table.value {
        _ if table.name == name => Some(name.to_string()),
        Value::Table(keys) => keys.iter().any(|key| key.name == name).then(|| format!("{}.{name}", table.name)),
        _ => None,
    };
    SCENARIO.iter().find_map(within)
}

impl<'a> Reader<'a> {
    /// A whole file with these `keys` at its top.
    pub fn root(tree: &'a Node, keys: &'static [Key], log: &'a Log) -> Result<Self> {
        Self::open(tree, String::new(), keys, log)
    }

    /// Opens the table `node`; a key that is not declared is an error.
    fn open(node: &'a Node, path: String, keys: &'static [Key], log: &'a Log) -> Result<Self> {
        let reader = Self::unchecked(node, path, keys, log)?;
        if !keys.iter().any(Key::is_for_any_name) {
            let known: Vec<&str> = keys.iter().map(|key| key.name).collect();
            reader.check_keys(&known)?;
        }
        Ok(reader)
    }

    fn unchecked(node: &'a Node, path: String, keys: &'static [Key], log: &'a Log) -> Result<Self> {
        let Some(entries) = node.entries() else {
            let found = format!("expected a table, found {}", node.kind_name());
            return Err(node.place.error(ErrorKind::WrongType, &path, found).help(format!("head it by [{path}]")));
        };
        Ok(Self { entries, place: &node.place, path, log, keys })
    }

    /// A key outside `known` is an error.
    fn check_keys(&self, known: &[&str]) -> Result<()> {
        let Some(entry) = self.entries.iter().find(|entry| !known.contains(&entry.key.as_str())) else {
            return Ok(());
        };
        let help = match entry.key.as_str() {
            // In TOML a key belongs to the table above it, whatever the author intended.
            key @ ("extends" | "include" | "without") => {
                format!("`{key}` belongs above the first table of a machine file, above this [{}]", self.path)
            }
            key => {
                let near = suggestion(key, known.iter().copied());
                let elsewhere =
                    if self.path.is_empty() && !near.starts_with("did") { of_a_scenario(key) } else { None };
                elsewhere.map_or(near, |of| format!("`{of}` is a key of scenario files: change it there"))
            }
        };
        Err(entry.place.error(ErrorKind::UnknownKey, &join(&self.path, &entry.key), "unknown key").help(help))
    }

    /// The declaration of `key`.
    ///
    /// # Panics
    /// If there is none.
    fn declared(&self, key: &str) -> &'static Key {
        let declared = find(self.keys, key).unwrap_or_else(|| panic!("`{}` is not declared", join(&self.path, key)));
        #[cfg(test)]
        crate::keys::asked::note(declared);
        declared
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

    /// An error about `key`, or about the table if the key is absent.
    pub fn error(&self, kind: ErrorKind, key: &str, message: impl Into<String>) -> MachineError {
        let place = self.entry(key).map_or(self.place, |entry| &entry.node.place);
        place.error(kind, &join(&self.path, key), message)
    }

    /// As [`Self::error`], at the key itself and not at its value.
    pub fn key_error(&self, kind: ErrorKind, key: &str, message: impl Into<String>) -> MachineError {
        let place = self.entry(key).map_or(self.place, |entry| &entry.place);
        place.error(kind, &join(&self.path, key), message)
    }

    /// Whether a value of this table was found to be outside its usual range.
    pub fn is_doubted(&self) -> bool {
        self.log.doubts(&self.path)
    }

    /// A sub-table.
    pub fn table(&self, key: &str) -> Result<Option<Reader<'a>>> {
        let keys = self.keys_below(key);
        let Some(entry) = self.entry(key) else { return Ok(None) };
        Reader::open(&entry.node, join(&self.path, key), keys, self.log).map(Some)
    }

    /// A sub-table; an empty one if the file has none.
    pub fn table_or_empty(&self, key: &str) -> Result<Reader<'a>> {
        let empty = || Reader { entries: &[], path: join(&self.path, key), keys: self.keys_below(key), ..self.clone() };
        Ok(self.table(key)?.unwrap_or_else(empty))
    }

    /// A sub-table in which only the keys `known` are allowed, of those that are declared.
    pub fn table_of(&self, key: &str, known: &[&str]) -> Result<Option<Reader<'a>>> {
        let Some(table) = self.names(key)? else { return Ok(None) };
        table.check_keys(known)?;
        Ok(Some(table))
    }

    /// The named sub-tables of `[key.<name>]`.
    pub fn named_tables(&self, key: &str) -> Result<Vec<(&'a str, Reader<'a>)>> {
        let keys = self.keys_below(key);
        let Some(names) = self.names(key)? else { return Ok(Vec::new()) };
        names
            .entries
            .iter()
            .map(|entry| {
                let path = join(&names.path, &entry.key);
                check_name(&entry.key, &path, &entry.place)?;
                Ok((entry.key.as_str(), Reader::open(&entry.node, path, keys, self.log)?))
            })
            .collect()
    }

    /// A sub-table whose keys are not checked: they are names, or checked elsewhere.
    pub fn names(&self, key: &str) -> Result<Option<Reader<'a>>> {
        let keys = self.keys_below(key);
        let Some(entry) = self.entry(key) else { return Ok(None) };
        Reader::unchecked(&entry.node, join(&self.path, key), keys, self.log).map(Some)
    }

    /// The keys of a table, or of each of several tables with names.
    fn keys_below(&self, key: &str) -> &'static [Key] {
        match self.declared(key).value {
            Value::Table(keys) | Value::Tables(keys) => keys,
            _ => &[],
        }
    }

    /// The keys that are declared by name.
    pub fn known(&self) -> impl Iterator<Item = &'static str> {
        self.keys.iter().filter(|key| !key.is_for_any_name()).map(|key| key.name)
    }

    /// The declared choices of a key.
    pub fn choices(&self, key: &str) -> &'static [&'static str] {
        self.declared(key).choices()
    }

    pub fn keys(&self) -> impl Iterator<Item = &'a str> + use<'a> {
        self.entries.iter().map(|entry| entry.key.as_str())
    }

    /// Every node of the table, for free-form tables.
    pub fn nodes(&self) -> impl Iterator<Item = (&'a str, &'a Node)> + use<'a> {
        self.entries.iter().map(|entry| (entry.key.as_str(), &entry.node))
    }

    pub fn optional(&self, key: &str) -> Result<Option<Field<'a>>> {
        let declared = self.declared(key);
        let Some(entry) = self.entry(key) else { return Ok(None) };
        let path = join(&self.path, key);
        match &entry.node.kind {
            NodeKind::Value { value, origin } => {
                Ok(Some(Field { path, place: &entry.node.place, value, origin, log: self.log, key: declared }))
            }
            NodeKind::Table(_) => Err(entry
                .place
                .error(ErrorKind::WrongType, &path, "expected a value, found a table")
                .help(format!("write `{key} = ...` in the table above"))),
        }
    }

    pub fn required(&self, key: &str, help: &str) -> Result<Field<'a>> {
        self.required_as(key, || help.into())
    }

    /// As [`Self::required`], with a help text that is made only if needed.
    fn required_as(&self, key: &str, help: impl FnOnce() -> String) -> Result<Field<'a>> {
        self.optional(key)?.ok_or_else(|| self.missing(key, format!("give {}", help())))
    }

    /// The declared quantity.
    fn quantity_at(&self, key: &str) -> Quantity {
        let kind = self.declared(key).kind();
        kind.unwrap_or_else(|| panic!("`{}` is declared as no quantity", join(&self.path, key))).quantity()
    }

    pub fn quantity<T: Number>(&self, key: &str) -> Result<T> {
        self.quantity_of(key, &self.quantity_at(key))
    }

    /// As [`Self::quantity`] with a quantity that depends on other values.
    pub fn quantity_of<T: Number>(&self, key: &str, quantity: &Quantity) -> Result<T> {
        self.required_as(key, || quantity.example())?.quantity_of(quantity)
    }

    pub fn optional_quantity<T: Number>(&self, key: &str) -> Result<Option<T>> {
        self.optional(key)?.map(|field| field.quantity_of(&self.quantity_at(key))).transpose()
    }

    /// The quantity at `key`, or its declared default.
    pub fn quantity_or_default<T: Number>(&self, key: &str) -> Result<T> {
        self.quantity_or_default_of(key, &self.quantity_at(key))
    }

    pub fn quantity_or_default_of<T: Number>(&self, key: &str, quantity: &Quantity) -> Result<T> {
        match self.optional(key)? {
            Some(field) => field.quantity_of(quantity),
            None => Ok(T::c(self.default_of(key, quantity))),
        }
    }

    fn default_of(&self, key: &str, quantity: &Quantity) -> f64 {
        let default = self.declared(key).default_in(quantity.dimension);
        default.unwrap_or_else(|| panic!("`{}` is declared without a default", join(&self.path, key)))
    }

    pub fn pair<T: Number>(&self, key: &str) -> Result<[T; 2]> {
        let quantity = self.quantity_at(key);
        self.required_as(key, || quantity.example())?.pair_of([&quantity, &quantity])
    }

    /// A point as x, y, z, m.
    pub fn point<T: Number>(&self, key: &str) -> Result<[T; 3]> {
        self.required(key, POINT_EXAMPLE)?.point()
    }

    pub fn text(&self, key: &str) -> Result<&'a str> {
        self.required(key, "a text in quotes")?.text()
    }

    /// A name as [`crate::names`] allows it.
    pub fn name(&self, key: &str) -> Result<&'a str> {
        let field = self.required(key, "a name in quotes")?;
        let name = field.text()?;
        check_name(name, &field.path, field.place)?;
        Ok(name)
    }

    /// A text of one line; empty without the key.
    pub fn line(&self, key: &str) -> Result<&'a str> {
        let Some(field) = self.optional(key)? else { return Ok("") };
        let line = field.text()?;
        check_text(line, &field.path, field.place)?;
        Ok(line)
    }

    pub fn text_or(&self, key: &str, default: &'a str) -> Result<&'a str> {
        self.optional(key)?.map_or(Ok(default), |field| field.text())
    }

    /// The declared choice that the key names; `values` are the meanings of the choices, in their order.
    pub fn choice<T: Copy>(&self, key: &str, values: &[T]) -> Result<T> {
        let help = || format!("one of {}", self.choices(key).join(", "));
        self.required_as(key, help)?.choice(values)
    }

    pub fn optional_choice<T: Copy>(&self, key: &str, values: &[T]) -> Result<Option<T>> {
        self.optional(key)?.map(|field| field.choice(values)).transpose()
    }

    pub fn choice_or_default<T: Copy>(&self, key: &str, values: &[T]) -> Result<T> {
        let declared = self.declared(key);
        let default = declared.choices().iter().position(|choice| declared.defaults.contains(choice));
        let default = default.unwrap_or_else(|| panic!("`{}` is declared without a default", join(&self.path, key)));
        Ok(self.optional_choice(key, values)?.unwrap_or(values[default]))
    }

    /// Which of two groups of keys the table uses: 0 or 1. Keys of both are a conflict; `None` without any.
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
