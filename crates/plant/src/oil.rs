//! Tables of oils, shared by all machines with the same oil, because they take longer than a run of a few seconds.

use hydrocrane_physics::hydraulics::fluid::{Fluid, OilTables};
use std::sync::{Arc, Mutex, PoisonError};

/// Number of oils in the cache, the last used ones; a third of a megabyte each.
const MOST: usize = 16;

/// Key of the cache: the parameters of an oil, bit for bit.
type Key = ([u64; 5], bool);

static KNOWN: Mutex<Vec<(Key, Arc<OilTables>)>> = Mutex::new(Vec::new());

fn key(fluid: &Fluid<f64>) -> Key {
    let Fluid { density, bulk_max, rise, c2, vacuum, ignore_cavitation } = *fluid;
    ([density, bulk_max, rise, c2, vacuum].map(f64::to_bits), ignore_cavitation)
}

/// The tables of an oil.
pub fn tables(fluid: &Fluid<f64>) -> Arc<OilTables> {
    let key = key(fluid);
    if let Some(tables) = known(&key) {
        return tables;
    }
    // Without the lock, so that other threads can make theirs.
    let tables = Arc::new(OilTables::new(*fluid));
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    if known.len() >= MOST {
        known.remove(0);
    }
    known.push((key, tables.clone()));
    tables
}

/// The cached table, which becomes the last used one.
fn known(key: &Key) -> Option<Arc<OilTables>> {
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let index = known.iter().position(|(other, _)| other == key)?;
    known[index..].rotate_left(1);
    known.last().map(|(_, tables)| tables.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_oil_has_its_own_tables_and_few_are_kept() {
        let oil = |c2: f64| Fluid {
            density: 1000.0,
            bulk_max: 1e9,
            rise: 4.5e-6,
            c2,
            vacuum: -1e5,
            ignore_cavitation: false,
        };
        let first = tables(&oil(3.0));
        assert!(Arc::ptr_eq(&first, &tables(&oil(3.0))));
        for i in 0..2 * MOST {
            let other = oil(3.0 + 0.01 * (i + 1) as f64);
            let (own, afresh) = (tables(&other), OilTables::new(other));
            assert_eq!(own.energy_density(1e7), afresh.energy_density(1e7));
            assert_ne!(own.energy_density(1e7), first.energy_density(1e7));
            // Tables in regular use stay in the cache.
            assert!(Arc::ptr_eq(&first, &tables(&oil(3.0))));
        }
        assert!(KNOWN.lock().unwrap().len() <= MOST);
    }
}
