//! `[valve.<name>.command]`: the signal chain between a controller's command and the spool.

use crate::errors::ErrorKind;
use crate::model::SignalChain;
use crate::reading::reader::Reader;
use crate::sections::Result;

/// The chain of the valve in `valve`, whose spool moves by `stroke` in both directions.
pub fn read(valve: &Reader, stroke: f64) -> Result<SignalChain> {
    let table = valve.table_or_empty("command")?;
    let chain = SignalChain {
        offset: table.quantity_or_default("offset")?,
        gain: table.quantity_or_default("gain")?,
        dead_band: table.quantity_or_default("dead-band")?,
        low: table.optional_quantity("low")?.unwrap_or(-stroke),
        high: table.optional_quantity("high")?.unwrap_or(stroke),
        play: 0.5 * hysteresis(&table)? * stroke,
        delay: table.quantity_or_default("delay")?,
    };
    check(&table, &chain, stroke)?;
    Ok(chain)
}

/// Width of the loop as a share of the stroke.
fn hysteresis(table: &Reader) -> Result<f64> {
    let share: f64 = table.quantity_or_default("hysteresis")?;
    if share < 1.0 {
        return Ok(share);
    }
    let message = "as wide as the stroke: the spool would hardly move";
    Err(table
        .error(ErrorKind::OutOfRange, "hysteresis", message)
        .help("give a share of the full stroke, as data sheets do: 0.03, or \"3 %\""))
}

fn check(table: &Reader, chain: &SignalChain, stroke: f64) -> Result<()> {
    if chain.low >= chain.high {
        let message = "`low` is not below `high`";
        return Err(table.error(ErrorKind::CrossedLimits, "low", message).help("exchange the two"));
    }
    let beyond = [("low", chain.low), ("high", chain.high), ("offset", chain.offset), ("dead-band", chain.dead_band)];
    match beyond.iter().find(|(_, value)| value.abs() > stroke * (1.0 + 1e-9)) {
        Some((key, value)) => {
            let message = format!("{value} m exceeds the spool stroke of {stroke} m");
            Err(table.error(ErrorKind::OutOfRange, key, message).help("stay within plus and minus the stroke"))
        }
        None => Ok(()),
    }
}
