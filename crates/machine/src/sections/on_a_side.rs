//! Valves at one side of a cylinder, at most one of a kind per side.

use crate::errors::ErrorKind;
use crate::model::Cylinder;
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::{reference, Result};

/// Index of the cylinder, and its side: 0 of the piston, 1 of the rod.
pub fn find<T>(table: &Reader, cylinders: &[Cylinder<T>]) -> Result<(usize, usize)> {
    let names: Vec<&str> = cylinders.iter().map(|cylinder| cylinder.name.as_str()).collect();
    let index = reference::index(&table.required("cylinder", "the name of its cylinder")?, "cylinder", &names)?;
    Ok((index, table.choice("side", &[0, 1])?))
}

/// The cylinder and its side, likewise.
pub fn place<'c, T: Number>(table: &Reader, cylinders: &'c mut [Cylinder<T>]) -> Result<(&'c mut Cylinder<T>, usize)> {
    let (index, side) = find(table, cylinders)?;
    Ok((&mut cylinders[index], side))
}

/// Assigns a valve; a second one of its kind is refused.
pub fn put<V>(table: &Reader, cylinder: &str, place: &mut Option<V>, valve: V) -> Result<()> {
    if place.is_some() {
        let message = format!("cylinder `{cylinder}` has one on this side already");
        return Err(table.error(ErrorKind::NotOneToOne, "side", message).help("keep one on each side"));
    }
    *place = Some(valve);
    Ok(())
}
