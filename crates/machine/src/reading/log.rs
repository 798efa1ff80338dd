//! Record of the values that were read: their provenance, and which of them are independent variables.

use std::cell::RefCell;

use crate::errors::{ErrorKind, MachineError};
use crate::model::{Provenance, ProvenanceClass, Unusual};
use crate::nearest::choose;
use crate::number::{Number, Variable};
use crate::text::document::{Node, NodeKind, Origin, Place, Scalar};

pub const CLASSES: [(&str, ProvenanceClass); 5] = [
    ("measured", ProvenanceClass::Measured),
    ("fitted", ProvenanceClass::Fitted),
    ("literature", ProvenanceClass::Literature),
    ("assumed", ProvenanceClass::Assumed),
    ("setting", ProvenanceClass::Setting),
];

/// Provenance of the values read so far. A log without required provenance is for scenario files.
pub struct Log {
    demands_class: bool,
    /// By the place of the value in the tree.
    seen: RefCell<Vec<(*const Scalar, Provenance)>>,
    unusual: RefCell<Vec<Unusual>>,
    words: RefCell<Vec<(String, String)>>,
    /// The independent variables, in the order of the derivatives.
    variables: Vec<Variable>,
}

impl Log {
    pub fn new(demands_class: bool) -> Self {
        // A large machine has about three hundred values.
        let seen = RefCell::new(Vec::with_capacity(if demands_class { 512 } else { 0 }));
        Self { demands_class, seen, unusual: RefCell::default(), words: RefCell::default(), variables: Vec::new() }
    }

    /// The same log for numbers with derivatives by `variables`.
    pub fn with_variables(self, variables: &[Variable]) -> Self {
        Self { variables: variables.to_vec(), ..self }
    }

    /// The value that was read at `key`, or as one `element` of a pair there, as a number.
    pub fn number<T: Number>(&self, key: &str, element: Option<usize>, value: f64) -> T {
        let here =
            |variable: &Variable| variable.key == key && (variable.element.is_none() || variable.element == element);
        T::read(value, || self.variables.iter().position(here))
    }

    /// The values in the order of the tree.
    pub fn in_order_of(self, root: &Node) -> Vec<Provenance> {
        let mut seen: Vec<_> = self.seen.into_inner().into_iter().map(|(value, entry)| (value, Some(entry))).collect();
        // Stable: the last entry of a value that was read several times counts.
        seen.sort_by_key(|(value, _)| *value);
        let mut ordered = Vec::with_capacity(seen.len());
        collect(&mut seen, root, &mut ordered);
        ordered
    }

    /// The class of the value at `key`; if it is required, a value without one is refused.
    pub fn class(&self, key: &str, place: &Place, origin: &Origin) -> Result<Option<ProvenanceClass>, MachineError> {
        if !self.demands_class {
            return Ok(None);
        }
        let Some((text, class_place)) = &origin.class else {
            return Err(place
                .error(ErrorKind::MissingClass, key, "the value has no provenance class, here or in any table above")
                .help("add `class = \"...\"` (measured, fitted, literature, assumed, setting) to its table or to [machine]"));
        };
        let class = choose(text, &CLASSES).map_err(|help| {
            let message = format!("`{text}` is not a provenance class");
            class_place.error(ErrorKind::InvalidChoice, &format!("{key} (its class)"), message).help(help)
        })?;
        Ok(Some(class))
    }

    /// Records a value outside its usual range, one per key.
    pub fn warn(&self, unusual: Unusual) {
        let mut noted = self.unusual.borrow_mut();
        if !noted.iter().any(|known| known.key == unusual.key) {
            noted.push(unusual);
        }
    }

    /// Whether a value at or below this path was found to be outside its usual range.
    pub fn doubts(&self, path: &str) -> bool {
        let below = |key: &str| key.strip_prefix(path).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
        self.unusual.borrow().iter().any(|known| below(&known.key))
    }

    /// The values outside their usual ranges.
    pub fn unusual(&self) -> Vec<Unusual> {
        self.unusual.borrow().clone()
    }

    /// Records the name or choice at `key`; the last one counts.
    pub fn word(&self, key: &str, word: &str) {
        if !self.demands_class {
            return;
        }
        let mut words = self.words.borrow_mut();
        match words.iter_mut().rev().find(|(known, _)| known == key) {
            Some((_, old)) => word.clone_into(old),
            None => words.push((key.into(), word.into())),
        }
    }

    /// The names and choices that were read, in this order.
    pub fn words(&self) -> Vec<(String, String)> {
        self.words.borrow().clone()
    }

    /// Records a value of the tree.
    pub fn keep(&self, value: *const Scalar, entry: Provenance) {
        self.seen.borrow_mut().push((value, entry));
    }
}

fn collect(seen: &mut [(*const Scalar, Option<Provenance>)], node: &Node, ordered: &mut Vec<Provenance>) {
    match &node.kind {
        NodeKind::Table(entries) => entries.iter().for_each(|entry| collect(seen, &entry.node, ordered)),
        NodeKind::Value { value, .. } => {
            let value: *const Scalar = value;
            let end = seen.partition_point(|(known, _)| *known <= value);
            let last = seen[..end].last_mut().filter(|(known, _)| *known == value);
            ordered.extend(last.and_then(|(_, entry)| entry.take()));
        }
    }
}
