//! Extending one file by another, and overrides by dotted key.

use std::sync::Arc;

use crate::errors::{ErrorKind, MachineError};
use crate::nearest::suggestion;
use crate::text::document::{check_text, join, Entry, Node, NodeKind, Origin, Place, Scalar};

/// A caller's value that replaces that of a file. Numbers are SI, texts carry units.
#[derive(Debug, Clone, PartialEq)]
pub enum OverrideValue {
    Number(f64),
    Text(String),
    Bool(bool),
    List(Vec<OverrideValue>),
}

/// Tables are merged key by key; anything else in `over` replaces the value in `base`.
pub fn merge(base: Node, over: Node) -> Node {
    match (base.kind, over.kind) {
        (NodeKind::Table(entries), NodeKind::Table(additions)) => {
            let mut entries = Arc::unwrap_or_clone(entries);
            for addition in Arc::unwrap_or_clone(additions) {
                match entries.iter().position(|entry| entry.key == addition.key) {
                    Some(index) => {
                        let node = entries[index].node.clone();
                        entries[index] = Entry { node: merge(node, addition.node), ..addition };
                    }
                    None => entries.push(addition),
                }
            }
            Node { place: over.place, kind: NodeKind::Table(entries.into()) }
        }
        (_, kind) => Node { place: over.place, kind },
    }
}

/// Takes the value or table at the dotted `key` out of `tree`; `place` is where that is asked for.
pub fn take_out(tree: &mut Node, key: &str, place: &Place) -> Result<(), MachineError> {
    let (above, name) = key.rsplit_once('.').unwrap_or(("", key));
    let mut node = tree;
    let mut path = String::new();
    for segment in above.split('.').filter(|segment| !segment.is_empty()).chain([name]) {
        let NodeKind::Table(entries) = &mut node.kind else { return Err(nothing_at(key, &path, segment, &[], place)) };
        let entries = Arc::make_mut(entries);
        let Some(index) = entries.iter().position(|entry| entry.key == segment) else {
            return Err(nothing_at(key, &path, segment, entries, place));
        };
        path = join(&path, segment);
        if path == key {
            entries.remove(index);
            return Ok(());
        }
        node = &mut entries[index].node;
    }
    Err(nothing_at(key, &path, name, &[], place))
}

fn nothing_at(key: &str, path: &str, segment: &str, entries: &[Entry], place: &Place) -> MachineError {
    let message = format!("the file that this one extends has no `{key}`");
    let names = entries.iter().map(|entry| join(path, &entry.key)).collect::<Vec<_>>();
    let nearest = suggestion(&join(path, segment), names.iter().map(String::as_str));
    place.error(ErrorKind::UnknownReference, "without", message).help(nearest)
}

/// A value for a dotted key, with its place.
#[derive(Debug, Clone)]
pub struct Override {
    pub key: String,
    pub value: OverrideValue,
    pub place: Place,
}

impl Override {
    /// An override given by a caller.
    pub fn from_caller((key, value): &(String, OverrideValue)) -> Self {
        Self { key: key.clone(), value: value.clone(), place: Place::Override(key.as_str().into()) }
    }
}

/// Tables of named parts. An override changes an existing part; a new name is an error.
const COLLECTIONS: [&str; 7] = ["link", "joint", "cylinder", "valve", "friction", "sensor", "keep-out"];

/// A value of a file as one that a caller could give; `None` for a date.
pub fn override_value(value: &Scalar) -> Option<OverrideValue> {
    Some(match value {
        Scalar::Text(text) => OverrideValue::Text(text.clone()),
        Scalar::Number(number) => OverrideValue::Number(*number),
        Scalar::Bool(flag) => OverrideValue::Bool(*flag),
        Scalar::List(items) => {
            OverrideValue::List(items.iter().map(|(item, _)| override_value(item)).collect::<Option<_>>()?)
        }
        Scalar::Date => return None,
    })
}

/// Puts the override's value at its key; missing tables are made, so that the check for unknown keys finds a mistake.
pub fn apply_override(root: &mut Node, change: &Override) -> Result<(), MachineError> {
    let Override { key, value, place } = change;
    let mut node = root;
    let mut path = String::new();
    let segments: Vec<&str> = key.split('.').map(str::trim).collect();
    if segments.iter().any(|segment| segment.is_empty()) {
        return Err(place
            .error(ErrorKind::UnknownKey, key, "this is not a dotted key")
            .help("write it like `supply.pressure`"));
    }
    for (depth, segment) in segments.iter().copied().enumerate() {
        let NodeKind::Table(entries) = &mut node.kind else {
            return Err(place
                .error(ErrorKind::WrongType, &path, "a value, not a table: it has no keys below it")
                .help(format!("override `{path}` itself")));
        };
        let entries = Arc::make_mut(entries);
        if depth == 1 && COLLECTIONS.contains(&segments[0]) && !entries.iter().any(|entry| entry.key == segment) {
            let names = entries.iter().map(|entry| entry.key.as_str());
            return Err(place
                .error(ErrorKind::UnknownReference, key, format!("there is no {path} `{segment}`"))
                .help(suggestion(segment, names)));
        }
        path = join(&path, segment);
        let index = entries.iter().position(|entry| entry.key == segment).unwrap_or_else(|| {
            let node = Node { place: place.clone(), kind: NodeKind::Table(Arc::default()) };
            entries.push(Entry { key: segment.into(), place: place.clone(), node });
            entries.len() - 1
        });
        node = &mut entries[index].node;
    }
    check_text(key, key, place)?;
    if matches!(&node.kind, NodeKind::Table(entries) if !entries.is_empty()) {
        return Err(place
            .error(ErrorKind::WrongType, key, "a table, not a value")
            .help("name one of the values below it"));
    }
    let of_file = match &node.kind {
        NodeKind::Value { value, origin } => origin.of_file.clone().or_else(|| Some(value.clone())),
        NodeKind::Table(_) => None,
    };
    let origin = Origin { class: Some(("setting".into(), place.clone())), source: "override".into(), of_file };
    let value = scalar(value, place);
    value.check(key, place)?;
    node.kind = NodeKind::Value { value, origin: Arc::new(origin) };
    node.place = place.clone();
    Ok(())
}

fn scalar(value: &OverrideValue, place: &Place) -> Scalar {
    match value {
        OverrideValue::Number(number) => Scalar::Number(*number),
        OverrideValue::Text(text) => Scalar::Text(text.clone()),
        OverrideValue::Bool(flag) => Scalar::Bool(*flag),
        OverrideValue::List(list) => {
            Scalar::List(list.iter().map(|item| (scalar(item, place), place.clone())).collect())
        }
    }
}
