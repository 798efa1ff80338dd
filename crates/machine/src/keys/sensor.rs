//! `[sensor]`.

use super::Sign::{Any, Positive};
use super::{Key, Kind, Usual};
use crate::units::quantities::{ANGLE, FORCE, LENGTH, NUMBER, PRESSURE, TIME, VOLTAGE};

/// What analogue sensors measure.
const MEASURED: &[Kind] = &[PRESSURE, FORCE, LENGTH];
/// Errors and noise as shares of the range: cheap sensors have 2.5 %.
const SHARE: &[Usual] = &[("0", "0.025", 40.0)];
const RANGE: &str = "one of `range`, `full-scale`, `span`";

pub static SENSOR: &[Key] = &[
    Key::text("measures")
        .required()
        .means("The signal: `joint.<name>.q`, `.qd`, or `cylinder.<name>.x`, `.v`, `.p1`, `.p2`, `.force`."),
    Key::choice("kind", &["incremental-encoder", "pressure-transmitter", "load-cell", "wire-potentiometer"])
        .required()
        .means("The kind of sensor."),
    Key::quantity("range", MEASURED, Positive)
        .otherwise(RANGE)
        .means("Analogue sensors: range, in the unit of the measured quantity."),
    Key::quantity("full-scale", MEASURED, Positive)
        .otherwise(RANGE)
        .means("The same, named as in data sheets of load cells."),
    Key::quantity("span", MEASURED, Positive)
        .otherwise(RANGE)
        .means("The same, named as in data sheets of potentiometers."),
    Key::quantity("offset", &[LENGTH], Any)
        .defaults(&["0 m"])
        .means("Wire potentiometers: position in the middle of the range.")
        .source("theory/sensor/wire_potentiometer.md"),
    Key::quantity("pulses", &[NUMBER], Positive)
        .otherwise("this, or `resolution`")
        .usual(&[("50", "1e7", 500.0)])
        .means("Encoders: pulses per turn.")
        .source("theory/sensor/encoder.md"),
    Key::quantity("resolution", &[ANGLE], Positive)
        .otherwise("this, or `pulses`")
        .usual(&[("0 deg", "1.8 deg", 500.0)])
        .means("Encoders: angle of one count.")
        .source("theory/sensor/encoder.md"),
    Key::quantity("division-error", &[ANGLE], Positive)
        .otherwise("none")
        .means("Encoders: error of the division, in electrical degrees, 360 to a pulse.")
        .source("theory/sensor/encoder.md"),
    Key::quantity("accuracy", &[NUMBER], Positive)
        .otherwise("none")
        .usual(SHARE)
        .means("Accuracy, share of the range."),
    Key::quantity("linearity", &[NUMBER], Positive)
        .otherwise("none")
        .usual(SHARE)
        .means("Linearity error, share of the range."),
    Key::quantity("repeatability", &[NUMBER], Positive)
        .otherwise("none")
        .usual(SHARE)
        .means("Repeatability, share of the range; of wire potentiometers a hysteresis."),
    Key::quantity("noise", &[NUMBER], Positive)
        .otherwise("none")
        .usual(SHARE)
        .means("Analogue sensors: standard deviation of the noise, share of the range.")
        .source("theory/sensor/analogue.md"),
    Key::quantity("bits", &[NUMBER], Positive)
        .otherwise("no converter")
        .usual(&[("6", "32", 10.0)])
        .means("Analogue sensors: bits of the converter, a whole number up to 32.")
        .source("theory/sensor/converter.md"),
    Key::quantity("live-zero", &[NUMBER], Positive)
        .otherwise("0")
        .means("Pressure transmitters: output without pressure, share of the supply voltage, below one half."),
    Key::quantity("sensitivity", &[NUMBER, Kind { name: "sensitivity", unit: "1/m" }], Positive)
        .otherwise("none")
        .means("Output per supply voltage, at full scale or (wire potentiometers) per length; kept for the record."),
    Key::quantity("rise-time", &[TIME], Positive)
        .otherwise("none")
        .usual(&[("0.001 ms", "0.2 s", 500.0)])
        .means("Pressure transmitters: time from 10 to 90 % of a step."),
    Key::quantity("supply-voltage", &[VOLTAGE], Positive)
        .otherwise("none")
        .usual(&[("0.1 V", "1000 V", 1e3)])
        .means("Supply voltage; kept for the record."),
];
