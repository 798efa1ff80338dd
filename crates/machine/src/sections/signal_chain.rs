//! `[valve.<name>.command]`: what lies between a controller's command and the spool.

use crate::errors::ErrorKind;
use crate::model::SignalChain;
use crate::quantities::{length, time};
use crate::reader::{Reader, Sign};
use crate::sections::Result;
use crate::units::Quantity;

const KEYS: [&str; 6] = ["offset", "gain", "dead-band", "low", "high", "delay"];

/// The chain of the valve in `valve`, whose spool moves `stroke` both ways.
pub fn read(valve: &Reader, stroke: f64) -> Result<SignalChain> {
    let identity = SignalChain { offset: 0.0, gain: 1.0, dead_band: 0.0, low: -stroke, high: stroke, delay: 0.0 };
    let Some(table) = valve.table("command", &KEYS)? else { return Ok(identity) };
    let chain = SignalChain {
        offset: table.quantity_or("offset", &length(), Sign::Any, identity.offset)?,
        gain: table.quantity_or("gain", &Quantity::number(), Sign::Any, identity.gain)?,
        dead_band: table.quantity_or("dead-band", &length(), Sign::NonNegative, identity.dead_band)?,
        low: table.quantity_or("low", &length(), Sign::Any, identity.low)?,
        high: table.quantity_or("high", &length(), Sign::Any, identity.high)?,
        delay: table.quantity_or("delay", &time(), Sign::NonNegative, identity.delay)?,
    };
    check(&table, &chain, stroke)?;
    Ok(chain)
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
