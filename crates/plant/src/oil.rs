//! Tables of oils, shared by all machines with the same oil, because they take longer than a run of a few seconds.

use hydrocrane_physics::hydraulics::fluid::{Fluid, OilTables};
use std::sync::{Arc, Mutex, PoisonError};

/// Number of oils in the cache, the last used ones; a third of a megabyte each.
pub const MOST: usize = 16;

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
    if let Some(tables) = last_used(&mut KNOWN.lock().unwrap_or_else(PoisonError::into_inner), &key) {
        return tables;
    }
    // Without the lock, so that other threads can make theirs.
    let tables = Arc::new(OilTables::new(*fluid));
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    // Another thread may have made the same ones meanwhile.
    if let Some(tables) = last_used(&mut known, &key) {
        return tables;
    }
    if known.len() >= MOST {
        known.remove(0);
    }
    known.push((key, tables.clone()));
    tables
}

/// The cached table, which becomes the last used one.
fn last_used(known: &mut [(Key, Arc<OilTables>)], key: &Key) -> Option<Arc<OilTables>> {
    let index = known.iter().position(|(other, _)| other == key)?;
    known[index..].rotate_left(1);
    known.last().map(|(_, tables)| tables.clone())
}
