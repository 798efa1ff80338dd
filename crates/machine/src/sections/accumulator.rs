//! `[accumulator.<name>]`: gas under the pressure of the mains.

use crate::errors::ErrorKind;
use crate::model::{Accumulator, Mains, Supply};
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::Result;

/// The accumulator on the mains, if there is one.
pub fn read<T: Number>(root: &Reader, supply: &Supply<T>, mains: &Mains<T>) -> Result<Option<Accumulator<T>>> {
    let tables = root.named_tables("accumulator")?;
    let (_, table) = match &tables[..] {
        [] => return Ok(None),
        [one] => one,
        [_, (second, _), ..] => {
            let message = format!("a second accumulator, `{second}`: the mains have one");
            return Err(root.error(ErrorKind::TooLarge, "accumulator", message).help("join their volumes in one"));
        }
    };
    let accumulator: Accumulator<T> = Accumulator {
        volume: table.quantity("volume")?,
        precharge: table.quantity("precharge")?,
        polytropic_exponent: table.quantity_or_default("polytropic-exponent")?,
    };
    if accumulator.polytropic_exponent.plain() < 1.0 {
        let message = "below 1: the gas would cool down as it is pressed together";
        return Err(table.error(ErrorKind::OutOfRange, "polytropic-exponent", message).help("give 1 to 1.4"));
    }
    let highest = supply.pressure.plain().max(mains.relief_pressure.plain());
    if accumulator.precharge.plain() >= highest {
        table.required("precharge", "a pressure")?.warn(
            format!("high: the mains never exceed {:.0} bar by much, so that it stays without oil", highest / 1e5),
            "set it to some 0.6 to 0.9 of the lowest working pressure".into(),
        );
    }
    Ok(Some(accumulator))
}

/// Refuses an accumulator without mains of variable pressure.
pub fn refuse_without_mains<T>(root: &Reader) -> Result<Option<Mains<T>>> {
    if root.named_tables("accumulator")?.is_empty() {
        return Ok(None);
    }
    let message = "the supply has a constant pressure, which an accumulator does not change";
    Err(root
        .error(ErrorKind::ConflictingKeys, "accumulator", message)
        .help("add a [pump.<name>] with [mains], or leave it out"))
}
