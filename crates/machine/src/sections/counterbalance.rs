//! `[counterbalance.<name>]`: a counterbalance valve on one side of a cylinder.

use crate::errors::ErrorKind;
use crate::model::{Counterbalance, Cylinder, ValveKind};
use crate::number::Number;
use crate::reader::Reader;
use crate::sections::{reference, Result};

/// Puts each valve at its cylinder.
pub fn read<T: Number>(root: &Reader, cylinders: &mut [Cylinder<T>]) -> Result<()> {
    for (_, table) in root.named_tables("counterbalance")? {
        let names: Vec<&str> = cylinders.iter().map(|cylinder| cylinder.name.as_str()).collect();
        let index = reference::index(&table.required("cylinder", "the name of its cylinder")?, "cylinder", &names)?;
        let (cylinder, side) = (&mut cylinders[index], table.choice("side", &[0, 1])?);
        if side == 1 && cylinder.valve.kind == ValveKind::Regenerative {
            let message = "the regenerative valve of this cylinder returns the oil of the rod side to the mains";
            return Err(table.error(ErrorKind::ConflictingKeys, "side", message).help("put it at the piston side"));
        }
        if cylinder.valve.meter_out[side].is_some() {
            let message = "the valve keeps the pressure of this side by a spool of its own (`return-pressure`)";
            return Err(table.error(ErrorKind::ConflictingKeys, "side", message).help("keep one of the two"));
        }
        let place = &mut cylinder.counterbalances[side];
        if place.is_some() {
            let message = format!("cylinder `{}` has one on this side already", cylinder.name);
            return Err(table.error(ErrorKind::NotOneToOne, "side", message).help("keep one on each side"));
        }
        *place = Some(Counterbalance {
            setting: table.quantity("setting")?,
            pilot_ratio: table.quantity("pilot-ratio")?,
            opening_pressure: table.quantity_or_default("opening-pressure")?,
            nominal_flow: table.quantity("nominal-flow")?,
            nominal_pressure_drop: table.quantity("nominal-pressure-drop")?,
        });
    }
    Ok(())
}
