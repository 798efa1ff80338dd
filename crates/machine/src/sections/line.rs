//! `[line.<name>]`: the hose or pipe between the valve and one side of a cylinder.

use std::f64::consts::FRAC_PI_4;

use crate::errors::ErrorKind;
use crate::model::{Cylinder, Line};
use crate::number::Number;
use crate::reader::Reader;
use crate::sections::{on_a_side, Result};

/// Assigns each line to its cylinder.
pub fn read<T: Number>(root: &Reader, cylinders: &mut [Cylinder<T>]) -> Result<()> {
    for (_, table) in root.named_tables("line")? {
        let (cylinder, side) = on_a_side::place(&table, cylinders)?;
        if cylinder.holding[side].is_some() {
            let message = "the valve that holds the load of this side stands at the cylinder, and the line behind it would need a pressure of its own";
            return Err(table
                .error(ErrorKind::ConflictingKeys, "side", message)
                .help("leave the line out: it does not act on the chamber while the load is held"));
        }
        let line = Line { volume: volume(&table)?, compliance: table.quantity_or_default("compliance")? };
        on_a_side::put(&table, &cylinder.name, &mut cylinder.lines[side], line)?;
    }
    Ok(())
}

fn volume<T: Number>(table: &Reader) -> Result<T> {
    match table.either([&["length", "inner-diameter"], &["volume"]])? {
        Some(0) => {
            let [length, diameter]: [T; 2] = [table.quantity("length")?, table.quantity("inner-diameter")?];
            Ok(diameter.square() * FRAC_PI_4 * length)
        }
        Some(_) => table.quantity("volume"),
        None => Err(table.missing("length", "give it with `inner-diameter`, or `volume`")),
    }
}
