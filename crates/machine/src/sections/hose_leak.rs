//! `[hose-leak.<name>]`: a hole in the hose to one side of a cylinder.

use crate::errors::ErrorKind;
use crate::model::{Cylinder, HoseLeak};
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::{on_a_side, Result};

/// Assigns each leak to its cylinder.
pub fn read<T: Number>(root: &Reader, cylinders: &mut [Cylinder<T>]) -> Result<()> {
    for (_, table) in root.named_tables("hose-leak")? {
        let (cylinder, side) = on_a_side::place(&table, cylinders)?;
        let leak =
            HoseLeak { opening: table.quantity("opening")?, discharge_coefficient: discharge_coefficient(&table)? };
        on_a_side::put(&table, &cylinder.name, &mut cylinder.ports.leaks[side], leak)?;
    }
    Ok(())
}

/// No jet is wider than its hole.
fn discharge_coefficient<T: Number>(table: &Reader) -> Result<T> {
    let share: T = table.quantity_or_default("discharge-coefficient")?;
    if share.plain() <= 1.0 {
        return Ok(share);
    }
    let message = "exceeds 1: more would leave than the hole can pass";
    Err(table.error(ErrorKind::OutOfRange, "discharge-coefficient", message).help("give a share, some 0.6 to 0.9"))
}
