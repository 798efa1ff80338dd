//! Keeps the provenance of the values that were read, and the numbers among them.

use std::cell::RefCell;
use std::collections::HashMap;

use crate::document::{join, Node, Origin, Place};
use crate::errors::{ErrorKind, MachineError};
use crate::model::{Number, Provenance, ProvenanceClass};
use crate::nearest::choose;

const CLASSES: [(&str, ProvenanceClass); 5] = [
    ("measured", ProvenanceClass::Measured),
    ("fitted", ProvenanceClass::Fitted),
    ("literature", ProvenanceClass::Literature),
    ("assumed", ProvenanceClass::Assumed),
    ("setting", ProvenanceClass::Setting),
];

/// Provenance of the values read so far. A log that demands none serves scenario files.
pub struct Log {
    demands_class: bool,
    seen: RefCell<HashMap<String, (ProvenanceClass, String)>>,
    numbers: RefCell<HashMap<String, Number>>,
}

impl Log {
    pub fn new(demands_class: bool) -> Self {
        Self { demands_class, seen: RefCell::default(), numbers: RefCell::default() }
    }

    /// What was read, in the order of the tree.
    pub fn in_order_of(&self, root: &Node) -> Vec<Provenance> {
        let seen = self.seen.borrow();
        let provenance = |(key, (class, source)): (&String, &(ProvenanceClass, String))| Provenance {
            key: key.clone(),
            class: *class,
            source: source.clone(),
        };
        keys(root).iter().filter_map(|key| seen.get_key_value(key).map(provenance)).collect()
    }

    /// The numbers that were read, in the order of the tree.
    pub fn numbers_in_order_of(&self, root: &Node) -> Vec<Number> {
        let numbers = self.numbers.borrow();
        keys(root).iter().filter_map(|key| numbers.get(key).cloned()).collect()
    }

    /// Notes where the value at `key` comes from; demanding logs refuse a value without a class.
    pub fn record(&self, key: &str, place: &Place, origin: &Origin) -> Result<(), MachineError> {
        if !self.demands_class {
            return Ok(());
        }
        let Some((text, class_place)) = &origin.class else {
            return Err(place
                .error(ErrorKind::MissingClass, key, "the value has no provenance class, here or in any table above")
                .help("add `class = \"...\"` (measured, fitted, literature, assumed, setting) to its table or to [machine]"));
        };
        let class = choose(text, &CLASSES).map_err(|help| {
            let message = format!("`{text}` is no provenance class");
            class_place.error(ErrorKind::InvalidChoice, &format!("{key} (its class)"), message).help(help)
        })?;
        self.seen.borrow_mut().insert(key.into(), (class, origin.source.clone()));
        Ok(())
    }

    /// Notes the numbers at `key`.
    pub fn note(&self, number: Number) {
        self.numbers.borrow_mut().insert(number.key.clone(), number);
    }
}

/// Dotted paths of everything below `root`, in the order of the tree.
fn keys(root: &Node) -> Vec<String> {
    fn collect(node: &Node, path: &str, found: &mut Vec<String>) {
        for entry in node.entries().unwrap_or_default() {
            let key = join(path, &entry.key);
            found.push(key.clone());
            collect(&entry.node, &key, found);
        }
    }
    let mut found = Vec::new();
    collect(root, "", &mut found);
    found
}
