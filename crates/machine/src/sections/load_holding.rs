//! `[counterbalance.<name>]`, `[pilot-check.<name>]` and `[hose-burst.<name>]`: load-holding valves on one side of a
//! cylinder.

use crate::errors::ErrorKind;
use crate::model::{Counterbalance, Cylinder, HoldingKind, HoseBurst, LoadHolding, PilotCheck, ValveKind};
use crate::number::Number;
use crate::reading::reader::{Field, Reader};
use crate::sections::{on_a_side, Result};

/// Assigns each valve to its cylinder.
pub fn read<T: Number>(root: &Reader, cylinders: &mut [Cylinder<T>]) -> Result<()> {
    for (_, table) in root.named_tables("counterbalance")? {
        put(&table, cylinders, counterbalance)?;
    }
    for (_, table) in root.named_tables("pilot-check")? {
        put(&table, cylinders, pilot_check)?;
    }
    for (_, table) in root.named_tables("hose-burst")? {
        put(&table, cylinders, hose_burst)?;
    }
    Ok(())
}

fn put<T: Number>(
    table: &Reader,
    cylinders: &mut [Cylinder<T>],
    kind: impl Fn(&Reader) -> Result<HoldingKind<T>>,
) -> Result<()> {
    let (cylinder, side) = on_a_side::place(table, cylinders)?;
    if side == 1 && cylinder.valve.kind == ValveKind::Regenerative {
        let message = "the regenerative valve of this cylinder returns the oil of the rod side to the mains";
        return Err(table.error(ErrorKind::ConflictingKeys, "side", message).help("put it at the piston side"));
    }
    if cylinder.valve.meter_out[side].is_some() {
        let message = "the valve keeps the pressure of this side by a spool of its own (`return-pressure`)";
        return Err(table.error(ErrorKind::ConflictingKeys, "side", message).help("keep one of the two"));
    }
    let valve = LoadHolding {
        nominal_flow: table.quantity("nominal-flow")?,
        nominal_pressure_drop: table.quantity("nominal-pressure-drop")?,
        kind: kind(table)?,
    };
    on_a_side::put(table, &cylinder.name, &mut cylinder.ports.holding[side], valve)
}

fn counterbalance<T: Number>(table: &Reader) -> Result<HoldingKind<T>> {
    let Field { path: key, place, .. } = table.required("setting", "a pressure")?;
    Ok(HoldingKind::Counterbalance(Counterbalance {
        key,
        place: place.clone(),
        setting: table.quantity("setting")?,
        pilot_ratio: table.quantity("pilot-ratio")?,
        opening_pressure: table.quantity_or_default("opening-pressure")?,
    }))
}

/// The pilot works against the load on the seat: below a ratio of 1 it would need more pressure than the load has.
fn pilot_check<T: Number>(table: &Reader) -> Result<HoldingKind<T>> {
    let pilot_ratio: T = table.quantity("pilot-ratio")?;
    if pilot_ratio.plain() <= 1.0 {
        let message = "the pilot piston is not larger than the seat: the pilot needs more pressure than the load has";
        return Err(table.error(ErrorKind::OutOfRange, "pilot-ratio", message).help("data sheets state some 3 to 10"));
    }
    Ok(HoldingKind::PilotCheck(PilotCheck {
        pilot_ratio,
        spring_pressure: table.quantity_or_default("spring-pressure")?,
        opening_pressure: table.quantity_or_default("opening-pressure")?,
    }))
}

fn hose_burst<T: Number>(table: &Reader) -> Result<HoldingKind<T>> {
    let (closing_flow, bleed): (T, T) = (table.quantity("closing-flow")?, table.quantity_or_default("bleed")?);
    if bleed.plain() < 1.0 {
        return Ok(HoldingKind::HoseBurst(HoseBurst { closing_flow, bleed }));
    }
    let message = "the valve leaves all of its opening, and never closes";
    Err(table.error(ErrorKind::OutOfRange, "bleed", message).help("give a share below 1, some 1 % or none"))
}
