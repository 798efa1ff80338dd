//! Values that all tables of a kind share but one: by the ratio of two units, its own was mistaken.

use super::digits;
use crate::reading::reader::Reader;
use crate::sections::Result;
use std::f64::consts::PI;

/// Kinds of tables, their table below, and keys that are often copied from one to the next.
const COPIED: [(&str, Option<&str>, &[&str]); 4] = [
    (
        "valve",
        None,
        &[
            "nominal-pressure-drop",
            "nominal-edge-pressure-drop",
            "compensator-setting",
            "compensator-time-constant",
            "transition-pressure",
            "natural-frequency",
            "stroke",
            "overlap",
            "velocity-limit",
            "delay",
            "leakage",
        ],
    ),
    (
        "cylinder",
        None,
        &["leakage-gap", "piston-length", "gland-length", "dead-length", "internal-leakage", "pressure-rating"],
    ),
    ("cylinder", Some("end-stop"), &["zone", "damping"]),
    ("friction", None, &["bristle-damping", "bristle-damping-velocity", "smoothing-velocity"]),
];
/// Ratios of units that are taken for each other: bar and MPa, cm and m, mm and m, minutes and seconds, hours and seconds, inches and mm, psi and bar, rad/s and
/// Hz, rpm and rad/s, degrees and radians.
const RATIOS: [f64; 10] = [10.0, 100.0, 1e3, 60.0, 3.6e3, 25.4, 14.5038, 2.0 * PI, 30.0 / PI, 180.0 / PI];
/// Of a ratio: numbers are written with three digits or more.
const ROUNDED: f64 = 2e-3;

pub fn check(root: &Reader) -> Result<()> {
    for (kind, below, keys) in COPIED {
        let named = root.named_tables(kind)?;
        let mut tables = Vec::new();
        for (name, table) in named {
            let table = match below {
                Some(below) => table.table(below)?,
                None => Some(table),
            };
            tables.extend(table.map(|table| (name, table)));
        }
        for key in keys {
            let mut stated = Vec::new();
            for (name, table) in &tables {
                stated.extend(table.optional_quantity::<f64>(key)?.map(|value| (*name, table, value)));
            }
            judge(kind, key, &stated)?;
        }
    }
    Ok(())
}

/// Names the one of at least three values that differs from all others, which are alike.
fn judge(kind: &str, key: &str, stated: &[(&str, &Reader, f64)]) -> Result<()> {
    for (place, (_, table, own)) in stated.iter().enumerate() {
        let others = || stated.iter().enumerate().filter(move |(other, _)| *other != place).map(|(_, of)| of);
        let Some((first, _, common)) = others().next() else { return Ok(()) };
        let alike = others().all(|(_, _, value)| value == common);
        let ratio = (own / common).max(common / own);
        let mistaken = RATIOS.iter().any(|of| (ratio / of - 1.0).abs() < ROUNDED);
        if stated.len() < 3 || !alike || !mistaken || table.is_doubted() {
            continue;
        }
        let field = table.required(key, "a quantity")?;
        field.warn(
            format!(
                "{}: {} times as {} as in {kind}.{first} and in all others, which are alike",
                if own > common { "large" } else { "small" },
                digits(ratio),
                if own > common { "large" } else { "small" },
            ),
            format!("check its unit; {kind}.{first} has the value that is meant?"),
        );
        return Ok(());
    }
    Ok(())
}
