//! `[port-relief.<name>]` and `[anti-cavitation.<name>]`: valves between a side of a cylinder and the tank; `[crossover-relief.<name>]`: between
//! both sides.

use crate::errors::ErrorKind;
use crate::model::{AntiCavitation, Cylinder, PortRelief};
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::{on_a_side, Result};

/// Assigns each valve to its cylinder.
pub fn read<T: Number>(root: &Reader, cylinders: &mut [Cylinder<T>]) -> Result<()> {
    for (_, table) in root.named_tables("port-relief")? {
        let (cylinder, side) = on_a_side::place(&table, cylinders)?;
        on_a_side::put(&table, &cylinder.name, &mut cylinder.ports.valves[side].relief, relief(&table)?)?;
    }
    for (_, table) in root.named_tables("crossover-relief")? {
        let (cylinder, side) = on_a_side::place(&table, cylinders)?;
        on_a_side::put(&table, &cylinder.name, &mut cylinder.ports.crossover[side], relief(&table)?)?;
    }
    for (_, table) in root.named_tables("anti-cavitation")? {
        let (cylinder, side) = on_a_side::place(&table, cylinders)?;
        let place = &mut cylinder.ports.valves[side].anti_cavitation;
        on_a_side::put(&table, &cylinder.name, place, anti_cavitation(&table)?)?;
    }
    Ok(())
}

fn relief<T: Number>(table: &Reader) -> Result<PortRelief<T>> {
    Ok(PortRelief {
        setting: table.quantity("setting")?,
        nominal_flow: table.quantity("nominal-flow")?,
        overpressure: table.quantity_or_default("overpressure")?,
    })
}

fn anti_cavitation<T: Number>(table: &Reader) -> Result<AntiCavitation<T>> {
    let valve: AntiCavitation<T> = AntiCavitation {
        nominal_flow: table.quantity("nominal-flow")?,
        nominal_pressure_drop: table.quantity("nominal-pressure-drop")?,
        opening_pressure: table.quantity_or_default("opening-pressure")?,
    };
    if valve.opening_pressure.plain() < valve.nominal_pressure_drop.plain() {
        return Ok(valve);
    }
    let message = "the valve is still closed at its nominal pressure drop";
    Err(table
        .error(ErrorKind::OutOfRange, "nominal-pressure-drop", message)
        .help("raise it beyond `opening-pressure`, which is \"0.1 bar\" where the file states none"))
}
