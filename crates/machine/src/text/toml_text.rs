//! Values as the text of a file, with all digits of their numbers.

use crate::text::merge::OverrideValue;
use std::borrow::Cow;
use std::fmt::Write;

/// A number with its unit, or a plain number.
pub fn quantity(value: f64, unit: &str) -> String {
    if unit.is_empty() {
        format!("{value:?}")
    } else {
        format!("\"{value:?} {unit}\"")
    }
}

pub fn list(values: &[f64], unit: &str) -> String {
    format!("[{}]", values.iter().map(|value| quantity(*value, unit)).collect::<Vec<_>>().join(", "))
}

/// `units` are those of the numbers, or one for all; plain numbers have none.
pub fn written(value: &OverrideValue, units: &[Cow<str>]) -> String {
    match value {
        OverrideValue::Number(number) => quantity(*number, units.first().map_or("", AsRef::as_ref)),
        OverrideValue::Text(text) => quoted(text),
        OverrideValue::Bool(flag) => flag.to_string(),
        OverrideValue::List(items) => {
            let unit_of = |i: usize| units.get(i..).filter(|rest| !rest.is_empty()).unwrap_or(units);
            let items = items.iter().enumerate().map(|(i, item)| written(item, unit_of(i)));
            format!("[{}]", items.collect::<Vec<_>>().join(", "))
        }
    }
}

/// A name as a key: in quotes where it is no bare one.
pub fn key(name: &str) -> String {
    let bare = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_');
    if bare {
        name.into()
    } else {
        quoted(name)
    }
}

/// A basic string of TOML.
pub fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => {
                let _ = write!(quoted, "\\U{:08X}", c as u32);
            }
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}
