//! `[tank-line]`: the line through which oil returns to the tank.

use crate::errors::ErrorKind;
use crate::model::{FilterBypass, Fluid, ReturnFilter, Supply, TankLine};
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::{resistance, Result};

/// Adds the tank line to the mains, if there is one.
pub fn read<T: Number>(root: &Reader, fluid: &Fluid<T>, supply: &mut Supply<T>) -> Result<()> {
    let Some(table) = root.table("tank-line")? else { return Ok(()) };
    let Some(mains) = &mut supply.mains else {
        let message = "only a machine whose pump determines the pressure has a return pressure";
        return Err(root
            .error(ErrorKind::ConflictingKeys, "tank-line", message)
            .help("add a [pump.<name>] with [mains], or state the return pressure as `supply.tank-pressure`"));
    };
    let line = TankLine {
        volume: table.quantity("volume")?,
        compliance: table.quantity_or_default("hose-compliance")?,
        resistance: resistance::read(&table, None, fluid)?,
        filter: table.table("filter")?.map(|table| filter(&table)).transpose()?,
    };
    if line.resistance.is_none() && line.filter.is_none() {
        let help = "give the flow of `nominal-pressure-drop`, or a [tank-line.filter], or leave the table out";
        return Err(table.missing("nominal-flow", help));
    }
    mains.tank_line = Some(line);
    Ok(())
}

fn filter<T: Number>(table: &Reader) -> Result<ReturnFilter<T>> {
    Ok(ReturnFilter {
        nominal_flow: table.quantity("nominal-flow")?,
        nominal_pressure_drop: table.quantity("nominal-pressure-drop")?,
        bypass: bypass(table)?,
    })
}

fn bypass<T: Number>(table: &Reader) -> Result<Option<FilterBypass<T>>> {
    match table.optional_quantity("bypass-pressure")? {
        Some(pressure) => {
            Ok(Some(FilterBypass { pressure, overpressure: table.quantity_or_default("bypass-overpressure")? }))
        }
        None if table.has("bypass-overpressure") => {
            let message = "counts for nothing without `bypass-pressure`";
            Err(table
                .error(ErrorKind::ConflictingKeys, "bypass-overpressure", message)
                .help("give `bypass-pressure`, or leave it out"))
        }
        None => Ok(None),
    }
}
