//! The level of friction: one knob for the friction forces of all cylinders, as a share of the machine's own.

use crate::knobs::values::in_si;
use hydrocrane_machine::{Machine, OverrideValue};

/// Friction keys that grow with the level.
const FORCES: [&str; 3] = ["coulomb", "breakaway", "viscous"];

pub fn is_force(key: &str) -> bool {
    let mut parts = key.split('.');
    parts.next() == Some("friction") && parts.nth(1).is_some_and(|last| FORCES.contains(&last))
}

/// The friction forces of the machine times `level`.
pub fn changes(machine: &Machine, level: f64) -> Vec<(String, OverrideValue)> {
    let values = machine.provenance.iter().filter(|entry| is_force(&entry.key));
    values.map(|entry| (entry.key.clone(), in_si(&entry.value.si, level))).collect()
}
