//! `[control]`: the sample period, and the gains of each controller in `[control.<controller>]`.

use crate::model::{Control, Joint, ThesisSteps};
use crate::quantities::time;
use crate::reader::{Reader, Sign};
use crate::sections::Result;
use crate::units::Quantity;

/// A controller's name, and the key and SI unit of each of its gains; an empty unit is a plain number.
type Known = (&'static str, &'static [(&'static str, &'static str)]);

/// The controllers that a scenario can name, with the gains that a machine file can give them.
pub const CONTROLLERS: [Known; 2] = [("tip", &TIP), ("heinze-pid", &HEINZE_PID)];

const TIP: [(&str, &str); 16] = [
    ("full-speed", "m/s"),
    ("stick-bandwidth", "rad/s"),
    ("path-rate", "1/s"),
    ("limit-rate", "1/s"),
    ("keep-out-margin", "m"),
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

const HEINZE_PID: [(&str, &str); 4] =
    [("full-speed", "m/s"), ("set-point-interval", "s"), ("limit-rate", "1/s"), ("keep-out-margin", "m")];

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

/// What `[control.heinze-pid]` chooses: its two switches, and the tables of a weight per joint.
const HEINZE_SWITCHES: [&str; 2] = ["working-area", "extension"];
const HEINZE_WEIGHTS: [&str; 2] = ["motion-weight", "middle-weight"];

pub fn read(root: &Reader, joints: &[Joint]) -> Result<Control> {
    let names = CONTROLLERS.map(|(name, _)| name);
    let known: Vec<&str> = ["period"].into_iter().chain(names).chain([PLAUSIBILITY.0]).collect();
    let Some(table) = root.table("control", &known)? else { return Ok(Control::default()) };
    let mut control =
        Control { period: table.optional_quantity("period", &time(), Sign::Positive)?, ..Control::default() };
    for (name, keys) in CONTROLLERS.into_iter().chain([PLAUSIBILITY]) {
        let thesis = name == "heinze-pid";
        let more = HEINZE_SWITCHES.into_iter().chain(HEINZE_WEIGHTS).filter(|_| thesis);
        let known: Vec<&str> = keys.iter().map(|(key, _)| *key).chain(more).collect();
        let Some(own) = table.table(name, &known)? else { continue };
        let mut gains = read_gains(&own, keys)?;
        if thesis {
            gains.extend(read_weights(&own, joints)?);
            control.thesis = read_switches(&own)?;
        }
        control.gains.push((name.to_string(), gains));
    }
    Ok(control)
}

fn read_switches(table: &Reader) -> Result<ThesisSteps> {
    let default = ThesisSteps::default();
    let areas = [("limited", true), ("none", false)];
    let extensions = [("penalty", true), ("zero", false)];
    Ok(ThesisSteps {
        working_area: table.choice_or("working-area", &areas, default.working_area)?,
        penalty: table.choice_or("extension", &extensions, default.penalty)?,
    })
}

/// One weight per joint, by the joint's name.
fn read_weights(table: &Reader, joints: &[Joint]) -> Result<Vec<(String, f64)>> {
    let names: Vec<&str> = joints.iter().map(|joint| joint.name.as_str()).collect();
    let mut weights = Vec::new();
    for key in HEINZE_WEIGHTS {
        let Some(own) = table.table(key, &names)? else { continue };
        for name in &names {
            if let Some(weight) = own.optional_quantity(name, &Quantity::number(), Sign::NonNegative)? {
                weights.push((format!("{key}.{name}"), weight));
            }
        }
    }
    Ok(weights)
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
