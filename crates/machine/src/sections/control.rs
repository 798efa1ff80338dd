//! `[control]`: the sample period, and the gains of each controller in `[control.<controller>]`.

use crate::model::Control;
use crate::quantities::time;
use crate::reader::{Reader, Sign};
use crate::sections::Result;
use crate::units::Quantity;

/// A controller's name, and the key and SI unit of each of its gains; an empty unit is a plain number.
type Known = (&'static str, &'static [(&'static str, &'static str)]);

/// The controllers that a scenario can name, with the gains that a machine file can give them.
pub const CONTROLLERS: [Known; 2] = [("tip", &TIP), ("heinze-pid", &HEINZE_PID)];

const TIP: [(&str, &str); 15] = [
    ("full-speed", "m/s"),
    ("stick-bandwidth", "rad/s"),
    ("path-rate", "1/s"),
    ("limit-rate", "1/s"),
    ("telescope-centring", "1/m"),
    ("position-gain", "1/s"),
    ("damping", "1/s"),
    ("damping-low", "rad/s"),
    ("damping-high", "rad/s"),
    ("observer-bandwidth", "rad/s"),
    ("pressure-bandwidth", "rad/s"),
    ("reserve", ""),
    ("rest-band", "m"),
    ("lag-limit", "m"),
    ("settling-time", "s"),
];

const HEINZE_PID: [(&str, &str); 2] = [("full-speed", "m/s"), ("set-point-interval", "s")];

/// Thresholds of the monitor of the sensors.
pub const PLAUSIBILITY: Known = ("plausibility", &THRESHOLDS);

const THRESHOLDS: [(&str, &str); 8] = [
    ("jump", "m"),
    ("frozen", "m"),
    ("frozen-pressure", "m"),
    ("flow-tolerance", ""),
    ("pressure-tolerance", ""),
    ("stroke-margin", ""),
    ("pressure-limit", ""),
    ("recovery-time", "s"),
];

pub fn read(root: &Reader) -> Result<Control> {
    let tables = || CONTROLLERS.into_iter().chain([PLAUSIBILITY]);
    let known: Vec<&str> = ["period"].into_iter().chain(tables().map(|(name, _)| name)).collect();
    let Some(table) = root.table("control", &known)? else { return Ok(Control::default()) };
    let mut gains = Vec::new();
    for (name, keys) in tables() {
        let known: Vec<&str> = keys.iter().map(|(key, _)| *key).collect();
        if let Some(own) = table.table(name, &known)? {
            gains.push((name.to_string(), read_gains(&own, keys)?));
        }
    }
    Ok(Control { period: table.optional_quantity("period", &time(), Sign::Positive)?, gains })
}

fn read_gains(table: &Reader, known: &[(&'static str, &'static str)]) -> Result<Vec<(String, f64)>> {
    let mut gains = Vec::new();
    for (key, unit) in known {
        let quantity = if unit.is_empty() { Quantity::number() } else { Quantity::new("gain", unit) };
        if let Some(value) = table.optional_quantity(key, &quantity, Sign::NonNegative)? {
            gains.push((key.to_string(), value));
        }
    }
    Ok(gains)
}
