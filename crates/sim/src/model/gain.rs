//! Declared defaults of controllers and of the sensor monitor.

use hydrocrane_machine::Machine;

/// A gain of a controller, or a threshold of the sensor monitor, that has a declared default.
///
/// # Panics
/// If none is declared.
pub(crate) fn gain(machine: &Machine, controller: &str, key: &str) -> f64 {
    let value = machine.control.gain(controller, key);
    value.unwrap_or_else(|| panic!("`control.{controller}.{key}` is declared without a default"))
}
