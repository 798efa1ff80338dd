//! `[sensor.<name>]`: measured signals and errors of their sensors.

use crate::errors::ErrorKind;
use crate::model::{Cylinder, Joint, JointKind, Sensor, RANGES};
use crate::nearest::suggestion;
use crate::reading::reader::{Field, Reader};
use crate::sections::Result;
use crate::text::document::join;
use crate::units::quantities::{ANGLE, FORCE, LENGTH, PRESSURE, TIME, VOLTAGE};
use crate::units::{with_article, Quantity};
use std::f64::consts::TAU;

/// Kinds, the signals that each can measure, and its property keys besides the common ones.
const KINDS: [(&str, &[&str], &[&str]); 4] = [
    ("incremental-encoder", &["q", "qd"], &["pulses", "resolution", "division-error"]),
    ("pressure-transmitter", &["p1", "p2"], &["range", "full-scale", "span", "noise", "bits", "live-zero"]),
    ("load-cell", &["force"], &["range", "full-scale", "span", "sensitivity", "noise", "bits"]),
    (
        "wire-potentiometer",
        &["q", "qd", "x", "v"],
        &["range", "full-scale", "span", "offset", "sensitivity", "noise", "bits"],
    ),
];
const COMMON: [&str; 5] = ["accuracy", "linearity", "repeatability", "rise-time", "supply-voltage"];
const JOINT_SIGNALS: [&str; 2] = ["q", "qd"];
const CYLINDER_SIGNALS: [&str; 5] = ["x", "v", "p1", "p2", "force"];

pub fn read<T>(root: &Reader, joints: &[Joint<T>], cylinders: &[Cylinder<T>]) -> Result<Vec<Sensor>> {
    let signals = signals(joints, cylinders);
    let mut measured: Vec<String> = Vec::new();
    let read = |(name, table): (&str, Reader)| {
        let (kind, of_kind, own) = table.choice("kind", &KINDS)?;
        let measures = table.required("measures", "a signal, for example \"joint.boom.q\"")?;
        check_signal(&measures, &signals)?;
        check_kind(&measures, kind, of_kind, joints)?;
        let signal = measures.text()?.to_string();
        if measured.contains(&signal) {
            let text = format!("`{signal}`, which another sensor measures too: that one is read");
            measures.warn(text, "check the signal of both; leave out one of the two".into());
        }
        measured.push(signal);
        let properties = properties(&table, kind, own)?;
        let range = RANGES.iter().find(|key| table.has(key)).copied().unwrap_or("measures");
        let Field { path: key, place, .. } = table.required(range, "")?;
        Ok(Sensor {
            name: name.into(),
            measures: measures.text()?.into(),
            kind: kind.into(),
            properties,
            key,
            place: place.clone(),
        })
    };
    root.named_tables("sensor")?.into_iter().map(read).collect()
}

fn properties(table: &Reader, kind: &str, own: &[&str]) -> Result<Vec<(String, f64)>> {
    let mut properties = Vec::new();
    for key in table.keys().filter(|key| !["kind", "measures"].contains(key)) {
        if !own.contains(&key) && !COMMON.contains(&key) {
            let help = format!("its properties: {}, {}", own.join(", "), COMMON.join(", "));
            return Err(table.error(ErrorKind::ConflictingKeys, key, format!("not a property of a {kind}")).help(help));
        }
        properties.push((key.to_string(), table.quantity_of(key, &property(kind, key))?));
    }
    check_complete(table, kind)?;
    Ok(properties)
}

/// Required properties of a sensor, and the limits of a converter.
fn check_complete(table: &Reader, kind: &str) -> Result<()> {
    if kind == "incremental-encoder" {
        if !table.has("pulses") && !table.has("resolution") {
            return Err(table.missing("pulses", "give the pulses per turn, for example 1000"));
        }
        counts_agree(table)?;
    } else if !RANGES.iter().any(|key| table.has(key)) {
        return Err(table.missing("range", format!("give {}", property(kind, "range").example())));
    }
    let live_zero = table.optional_quantity("live-zero")?.unwrap_or(0.0_f64);
    if live_zero >= MOST_LIVE_ZERO {
        let message = format!("a live zero of {live_zero} leaves no output for the range");
        return Err(table.error(ErrorKind::OutOfRange, "live-zero", message).help("give for example \"10 %\""));
    }
    let bits = table.optional_quantity("bits")?.unwrap_or(1.0_f64);
    if bits.fract() == 0.0 && bits <= MOST_BITS {
        return Ok(());
    }
    let message = format!("must be a whole number of bits up to {MOST_BITS}, found {bits}");
    Err(table.error(ErrorKind::OutOfRange, "bits", message).help("give for example 12"))
}

/// A pulse is four counts.
fn counts_agree(table: &Reader) -> Result<()> {
    let [pulses, resolution] = ["pulses", "resolution"].map(|key| table.optional_quantity::<f64>(key));
    let (Some(pulses), Some(resolution)) = (pulses?, resolution?) else { return Ok(()) };
    let counted = TAU / (COUNTS * pulses);
    if (resolution / counted - 1.0).abs() <= ROUNDED {
        return Ok(());
    }
    let degrees = [resolution, counted].map(f64::to_degrees);
    let message = format!("{:.4} deg, but {pulses} pulses a turn have counts of {:.4} deg", degrees[0], degrees[1]);
    Err(table.error(ErrorKind::ConflictingKeys, "resolution", message).help("give one of the two"))
}

/// Counts of a pulse, and the share by which a data sheet's resolution may be rounded.
const COUNTS: f64 = 4.0;
const ROUNDED: f64 = 0.1;
/// Half of the output below zero and half above full scale.
const MOST_LIVE_ZERO: f64 = 0.5;
/// Finer than any converter.
const MOST_BITS: f64 = 32.0;

fn property(kind: &str, key: &str) -> Quantity {
    let measured = match kind {
        "incremental-encoder" => ANGLE.quantity(),
        "pressure-transmitter" => PRESSURE.quantity(),
        "load-cell" => FORCE.quantity(),
        _ => LENGTH.quantity(),
    };
    match key {
        "range" | "full-scale" | "span" | "offset" | "resolution" => measured,
        // Electrical degrees: 360 to a pulse.
        "division-error" => ANGLE.quantity(),
        "rise-time" => TIME.quantity(),
        "supply-voltage" => VOLTAGE.quantity(),
        // Output per supply voltage and unit of what is measured, for potentiometers; per full scale for load cells.
        "sensitivity" if kind == "wire-potentiometer" => Quantity::new("sensitivity", "1/m"),
        _ => Quantity::number(),
    }
}

/// `joint.<name>.<signal>` and `cylinder.<name>.<signal>` of this machine.
fn signals<T>(joints: &[Joint<T>], cylinders: &[Cylinder<T>]) -> Vec<String> {
    let joint_signals = joints.iter().flat_map(|joint| JOINT_SIGNALS.map(|s| join(&join("joint", &joint.name), s)));
    let cylinder_signals =
        cylinders.iter().flat_map(|cylinder| CYLINDER_SIGNALS.map(|s| join(&join("cylinder", &cylinder.name), s)));
    joint_signals.chain(cylinder_signals).collect()
}

/// Whether a sensor of this kind can measure the signal: encoders angles, potentiometers lengths.
fn check_kind<T>(field: &Field, kind: &str, of_kind: &[&str], joints: &[Joint<T>]) -> Result<()> {
    let text = field.text()?;
    let (of, signal) = text.rsplit_once('.').unwrap_or_default();
    let slides = joints.iter().any(|joint| {
        matches!(joint.kind, JointKind::Prismatic { .. }) && of.strip_prefix("joint.") == Some(&joint.name)
    });
    let turns = of.starts_with("joint.") && !slides;
    let fits = match kind {
        "incremental-encoder" => turns,
        "wire-potentiometer" => !turns,
        _ => true,
    };
    if fits && of_kind.contains(&signal) {
        return Ok(());
    }
    let message = format!("{} cannot measure `{text}`", with_article(kind));
    let help = "encoders measure angles of joints, wire potentiometers positions of sliding joints and pistons, load cells `force`, \
                pressure transmitters `p1` and `p2`";
    Err(field.error(ErrorKind::ConflictingKeys, message).help(help))
}

fn check_signal(field: &Field, signals: &[String]) -> Result<()> {
    let text = field.text()?;
    if signals.iter().any(|signal| signal == text) {
        return Ok(());
    }
    let help = suggestion(text, signals.iter().map(String::as_str));
    Err(field.error(ErrorKind::UnknownReference, format!("there is no signal `{text}`")).help(help))
}
