//! Values of a machine as overrides.

use hydrocrane_machine::{Machine, OverrideValue};

pub fn in_si(values: &[f64], factor: f64) -> OverrideValue {
    let si: Vec<OverrideValue> = values.iter().map(|v| OverrideValue::Number(v * factor)).collect();
    if let [one] = si.as_slice() {
        one.clone()
    } else {
        OverrideValue::List(si)
    }
}

/// The numbers that the machine states for a key.
pub fn stated(machine: &Machine, key: &str) -> Option<OverrideValue> {
    let entry = machine.provenance.iter().find(|entry| entry.key == key && !entry.value.si.is_empty())?;
    Some(in_si(&entry.value.si, 1.0))
}
