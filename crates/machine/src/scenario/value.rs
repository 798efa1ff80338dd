//! Check of a single value of a scenario, with the rules of the file reader.

use super::Result;
use crate::keys;
use crate::model::Unusual;
use crate::reading::reader::{Log, Reader};
use crate::text::document::{Node, NodeKind, Place};
use crate::text::merge::{apply_override, Override, OverrideValue};
use std::sync::Arc;

/// Refuses a quantity (SI) that a scenario file may not have at `key`, such as `controller.period` or
/// `phase.<name>.time`, and returns what a file with it is warned of.
///
/// # Errors
/// That of the reader.
///
/// # Panics
/// If no quantity is declared there.
pub fn check_quantity(key: &str, value: f64) -> Result<Option<Unusual>> {
    let place = Place::Override(key.into());
    let mut tree = Node { place: place.clone(), kind: NodeKind::Table(Arc::default()) };
    // A table in which any name may stand has one.
    let named = key.replace("<name>", "any");
    apply_override(&mut tree, &Override { key: named.clone(), value: OverrideValue::Number(value), place })?;
    let log = Log::new(false);
    let root = Reader::root(&tree, keys::SCENARIO, &log)?;
    let quantity = |table: &Reader, key: &str| table.quantity::<f64>(key).map(drop);
    let read = match named.split('.').collect::<Vec<_>>()[..] {
        [table, key] => quantity(&root.table_or_empty(table)?, key),
        [tables, _, key] => root.named_tables(tables)?.iter().try_for_each(|(_, table)| quantity(table, key)),
        _ => panic!("`{key}` is not in any table"),
    };
    read.map_err(|error| error.at_key(key))?;
    Ok(log.unusual().pop().map(|unusual| Unusual { key: key.into(), ..unusual }))
}

/// The choices that are declared at `key`; of a key below a table with a name of its own, `table.<name>.key`.
///
/// # Panics
/// If nothing is declared there.
pub fn choices(key: &str) -> &'static [&'static str] {
    let (mut keys, mut names) = (keys::SCENARIO, key.split('.'));
    loop {
        let name = names.next().unwrap_or_else(|| panic!("`{key}` is a table"));
        let found = keys::find(keys, name).unwrap_or_else(|| panic!("`{key}` is not declared"));
        keys = match found.value {
            keys::Value::Table(below) => below,
            keys::Value::Tables(below) => {
                names.next();
                below
            }
            _ => return found.choices(),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_refused_as_in_a_file() {
        for (key, good, bad) in [
            ("scenario.duration", 5.0, 0.0),
            ("controller.period", 1e-4, 0.99e-4),
            ("controller.delay", 0.0, -1e-3),
            ("phase.<name>.time", 1.0, 0.0),
            ("solver.rtol", 1e-12, f64::NAN),
        ] {
            assert!(check_quantity(key, good).is_ok(), "{key}");
            let error = check_quantity(key, bad).expect_err(key);
            assert_eq!(error.key(), Some(key));
            assert!(error.cure().is_some(), "{error}");
        }
    }

    #[test]
    fn a_value_is_doubted_as_in_a_file() {
        let unusual = check_quantity("solver.rtol", 2.0).unwrap().expect("a warning");
        assert_eq!((&*unusual.key, &*unusual.text), ("solver.rtol", "2; usual is 1e-12 to 0.1"));
    }

    #[test]
    fn choices_are_those_of_the_declarations() {
        assert_eq!(choices("controller.sensors"), ["ideal", "data-sheet"]);
        assert_eq!(choices("sensor-fault.<name>.kind"), ["freeze", "jump", "drop-out"]);
        assert_eq!(choices("solver.method"), super::super::METHODS);
    }
}
