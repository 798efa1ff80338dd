//! `[line.<name>]`: the hose or pipe between the valve and one side of a cylinder.

use std::f64::consts::FRAC_PI_4;

use crate::errors::ErrorKind;
use crate::model::{Cylinder, Fluid, Line};
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::resistance::{self, Bore};
use crate::sections::{on_a_side, Result};

/// Assigns each line to its cylinder.
pub fn read<T: Number>(root: &Reader, cylinders: &mut [Cylinder<T>], fluid: &Fluid<T>) -> Result<()> {
    for (_, table) in root.named_tables("line")? {
        let (cylinder, side) = on_a_side::place(&table, cylinders)?;
        let bore = bore(&table)?;
        let held = cylinder.ports.holding[side].is_some();
        if held {
            refuse_oil(&table)?;
        }
        let line = Line {
            volume: if held { T::c(0.0) } else { volume(&table, bore.as_ref())? },
            compliance: table.quantity_or_default("compliance")?,
            resistance: resistance::read(&table, bore.as_ref(), fluid)?,
        };
        if line.resistance.is_some() {
            refuse_return_pressure(&table, cylinder, side)?;
        } else if held {
            return Err(table.missing("nominal-flow", "a line on a side whose load is held has a resistance alone"));
        }
        on_a_side::put(&table, &cylinder.name, &mut cylinder.ports.lines[side], line)?;
    }
    Ok(())
}

/// The valve that holds a load stands at the cylinder: the oil behind it is not that of the chamber.
fn refuse_oil(table: &Reader) -> Result<()> {
    let Some(key) = ["volume", "length", "inner-diameter", "compliance"].into_iter().find(|key| table.has(key)) else {
        return Ok(());
    };
    let message = "the valve that holds the load of this side stands at the cylinder, and the oil behind it would need a pressure of its own";
    Err(table
        .error(ErrorKind::ConflictingKeys, key, message)
        .help("leave it out, and give `nominal-flow` and `nominal-pressure-drop`, which act; or leave the line out"))
}

/// The spool of the return senses its port, whose pressure a resistance would raise above the one it senses.
fn refuse_return_pressure<T>(table: &Reader, cylinder: &Cylinder<T>, side: usize) -> Result<()> {
    if cylinder.valve.meter_out[side].is_none() {
        return Ok(());
    }
    let message = "the valve keeps the pressure of this side by a spool of its own (`return-pressure`), which a line with a resistance would mislead";
    Err(table
        .error(ErrorKind::ConflictingKeys, "nominal-flow", message)
        .help("leave the resistance out, or `return-pressure` of this side"))
}

/// `None` where the line is described in another way.
fn bore<T: Number>(table: &Reader) -> Result<Option<Bore<T>>> {
    Ok(match table.either([&["length", "inner-diameter"], &["volume"]])? {
        Some(0) => Some(Bore { length: table.quantity("length")?, inner_diameter: table.quantity("inner-diameter")? }),
        _ => None,
    })
}

fn volume<T: Number>(table: &Reader, bore: Option<&Bore<T>>) -> Result<T> {
    match bore {
        Some(bore) => Ok(bore.inner_diameter.square() * FRAC_PI_4 * bore.length),
        None if table.has("volume") => table.quantity("volume"),
        None => Err(table.missing("length", "give it with `inner-diameter`, or `volume`")),
    }
}
