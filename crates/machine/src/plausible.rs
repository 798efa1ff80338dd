//! What values are usual, key by key: outside this range a value draws a warning, far outside an error.
//!
//! Ranges are of the magnitude. Zero is always usual: where a key excludes it, its section says so.

use std::sync::OnceLock;

use crate::units::{self, Dimension, Quantity};

/// Keys (`*` is any name), the lowest and the highest usual value, and by which factor a value may lie outside before it
/// is refused. A range without a unit is in SI; of rows with the same key the one of the value's dimension counts.
const RANGES: &[(&str, &str, &str, f64)] = &[
    ("environment.gravity", "1 m/s^2", "30 m/s^2", 100.0),
    ("link.*.axis", "0 deg", "720 deg", 100.0),
    ("link.*.mass", "0.1 kg", "20 t", 1e3),
    ("link.*.body.*.mass", "1 g", "20 t", 1e3),
    ("link.*.inertia", "0.0001 kg m^2", "1e7 kg m^2", 1e3),
    ("link.*.body.*.inertia", "1e-6 kg m^2", "1e7 kg m^2", 1e3),
    ("link.*.centre-of-gravity", "0 m", "30 m", 30.0),
    ("link.*.body.*.centre-of-gravity", "0 m", "30 m", 30.0),
    ("link.*.outline", "0 m", "30 m", 30.0),
    ("link.*.point.*", "0 m", "30 m", 30.0),
    ("joint.*.direction", "0 deg", "720 deg", 100.0),
    ("joint.*.zero", "0 deg", "720 deg", 100.0),
    ("joint.*.zero", "0 m", "30 m", 30.0),
    ("joint.*.limits", "0 deg", "720 deg", 100.0),
    ("joint.*.limits", "0 m", "30 m", 30.0),
    ("joint.*.dead-centre-margin", "0.01 deg", "45 deg", 1e3),
    ("joint.*.dead-centre-margin", "0.01 mm", "500 mm", 1e3),
    ("cylinder.*.bore", "10 mm", "600 mm", 1e3),
    ("cylinder.*.rod-diameter", "3 mm", "500 mm", 1e3),
    ("cylinder.*.barrel-length", "20 mm", "20 m", 50.0),
    ("cylinder.*.piston-length", "2 mm", "1 m", 1e3),
    ("cylinder.*.rod-length", "10 mm", "20 m", 50.0),
    ("cylinder.*.barrel-offset", "1 mm", "5 m", 200.0),
    ("cylinder.*.rod-offset", "1 mm", "5 m", 200.0),
    ("cylinder.*.stroke", "10 mm", "15 m", 60.0),
    ("cylinder.*.closed-length", "30 mm", "20 m", 50.0),
    ("cylinder.*.port-diameter", "1 mm", "150 mm", 1e3),
    ("cylinder.*.dead-length", "1 mm", "20 m", 50.0),
    ("cylinder.*.dead-volume", "0.1 ml", "50 l", 1e3),
    ("cylinder.*.printed.dead-volume", "0.1 ml", "50 l", 1e3),
    ("cylinder.*.gland-length", "1 mm", "1 m", 1e3),
    ("cylinder.*.leakage-gap", "0.5 um", "0.5 mm", 1e6),
    ("cylinder.*.internal-leakage", "0 m^3/(s Pa)", "1e-10 m^3/(s Pa)", 1e3),
    ("cylinder.*.external-leakage", "0 m^3/(s Pa)", "1e-10 m^3/(s Pa)", 1e3),
    ("cylinder.*.end-stop.zone", "0.5 mm", "500 mm", 100.0),
    ("cylinder.*.end-stop.stiffness", "100 kN/m", "10 MN/mm", 1e4),
    ("cylinder.*.end-stop.damping", "100 N s/m", "100 MN s/m", 100.0),
    ("cylinder.*.linkage.rocker-length", "10 mm", "10 m", 100.0),
    ("cylinder.*.linkage.coupler-length", "10 mm", "10 m", 100.0),
    ("valve.*.stroke", "0.1 mm", "100 mm", 1e3),
    ("valve.*.nominal-flow", "0.1 l/min", "5000 l/min", 1e3),
    ("valve.*.nominal-pressure-drop", "0.5 bar", "400 bar", 100.0),
    ("valve.*.nominal-edge-pressure-drop", "0.5 bar", "400 bar", 100.0),
    ("valve.*.transition-pressure", "0.001 bar", "50 bar", 100.0),
    ("valve.*.printed.blend-low", "0.001 bar", "50 bar", 100.0),
    ("valve.*.printed.blend-high", "0.001 bar", "50 bar", 100.0),
    ("valve.*.natural-frequency", "1 Hz", "1000 Hz", 100.0),
    ("valve.*.damping-ratio", "0.05", "10", 100.0),
    ("valve.*.overlap", "1 um", "20 mm", 1e3),
    ("valve.*.leakage", "0 m^3/(s Pa)", "1e-10 m^3/(s Pa)", 1e3),
    ("valve.*.velocity-limit", "1 mm/s", "100 m/s", 1e3),
    ("valve.*.acceleration-limit", "0.1 m/s^2", "1e6 m/s^2", 1e3),
    ("valve.*.delay", "0.1 ms", "2 s", 30.0),
    ("valve.*.command.delay", "0.1 ms", "2 s", 30.0),
    ("valve.*.command.gain", "0.01", "100", 1e3),
    ("friction.*.coulomb", "0.1 N", "100 kN", 1e6),
    ("friction.*.breakaway", "0.1 N", "100 kN", 1e6),
    ("friction.*.stribeck-velocity", "0.01 mm/s", "1 m/s", 1e6),
    ("friction.*.stribeck-exponent", "0.1", "10", 1.0),
    ("friction.*.viscous", "0.1", "1e7", 1e6),
    ("friction.*.viscous-exponent", "0.1", "10", 1.0),
    ("friction.*.smoothing-velocity", "0.001 mm/s", "0.1 m/s", 1e6),
    ("friction.*.bristle-stiffness", "1000 N/m", "1000 MN/m", 1e6),
    ("friction.*.bristle-damping", "0.1 N s/m", "10 MN s/m", 1e6),
    ("friction.*.bristle-damping-velocity", "0.1 mm/s", "10 m/s", 1e6),
    ("fluid.density", "500 kg/m^3", "2000 kg/m^3", 100.0),
    ("fluid.bulk-modulus", "100 MPa", "10 GPa", 10.0),
    ("fluid.bulk-modulus-max", "200 MPa", "20 GPa", 20.0),
    ("fluid.bulk-c1", "0", "10000", 1e3),
    ("fluid.bulk-c2", "1.1", "1000", 1e3),
    ("fluid.bulk-reference-pressure", "10 bar", "2000 bar", 100.0),
    ("fluid.vacuum", "0.5 bar", "1.1 bar", 10.0),
    ("fluid.viscosity", "0.0005 Pa s", "5 Pa s", 1e3),
    ("fluid.printed.leakage-viscosity", "0.0005 Pa s", "5 Pa s", 1e3),
    ("supply.pressure", "5 bar", "500 bar", 4.0),
    ("supply.tank-pressure", "0.01 bar", "50 bar", 40.0),
    ("payload.mass", "0.01 kg", "50 t", 1e3),
    ("payload.hang", "0 m", "20 m", 50.0),
    ("payload.hang-growth", "0 m/kg^0.5", "1 m/kg^0.5", 100.0),
    ("ground.height", "0 m", "30 m", 30.0),
    ("ground.stiffness", "10 kN/m", "100 MN/m", 1e3),
    ("ground.damping", "0.1 s/m", "100 s/m", 100.0),
    ("ground.friction", "0.05", "2", 50.0),
    ("ground.support.*.height", "0 m", "30 m", 30.0),
    ("ground.support.*.from", "0 m", "50 m", 20.0),
    ("ground.support.*.to", "0 m", "50 m", 20.0),
    ("ground.support.*.edge", "5 mm", "2 m", 50.0),
    ("equilibrium.back-pressure", "0.01 bar", "200 bar", 5.0),
    ("keep-out.*.outline", "0 m", "50 m", 20.0),
    ("sensor.*.pulses", "1", "1e7", 10.0),
    ("sensor.*.rise-time", "0.001 ms", "10 s", 10.0),
    ("sensor.*.supply-voltage", "0.1 V", "1000 V", 1e3),
    ("control.period", "0.2 ms", "1 s", 2.0),
    ("control.*.full-speed", "1 mm/s", "10 m/s", 100.0),
    ("controller.period", "0.2 ms", "1 s", 2.0),
    ("controller.delay", "0.1 ms", "1 s", 60.0),
    ("phase.*.controller.period", "0.2 ms", "1 s", 2.0),
    ("phase.*.controller.delay", "0.1 ms", "1 s", 60.0),
    ("initial.pressure.*", "0 bar", "1000 bar", 2.0),
    ("initial.joint.*", "0 deg", "360 deg", 100.0),
    // Sliding joints reach as far as the bounds of cylinders let them.
    ("initial.joint.*", "0 m", "100 m", 50.0),
    ("scenario.payload", "0.01 kg", "50 t", 1e3),
    ("scenario.duration", "1 ms", "100000 s", 100.0),
    ("scenario.record-interval", "0.1 ms", "10000 s", 1e3),
    ("solver.rtol", "1e-12", "0.1", 1e3),
    ("solver.atol", "1e-15", "1", 1e3),
    ("solver.max-step", "0.01 ms", "1 s", 1e3),
    ("solver.step", "0.01 ms", "100 ms", 100.0),
    // Any other key of these dimensions.
    ("", "0 m", "100 m", 10.0),
    ("", "0 deg", "720 deg", 100.0),
    ("", "0 s", "1e6 s", 1e3),
    ("", "0 bar", "2000 bar", 10.0),
    ("", "0 kg", "50 t", 1e3),
];

/// Magnitudes that no key may have, where no range says more, SI.
const LEAST: f64 = 1e-18;
const MOST: f64 = 1e15;

/// Units that people write beside those with a symbol of their own, to guess which one was meant.
const WRITTEN_UNITS: [&str; 8] = ["l/min", "mm/s", "N/mm", "kN/mm", "kN s/m", "kg/l", "g/l", "kg mm^2"];

/// A row of the table, SI.
#[derive(Debug)]
struct Range {
    key: &'static str,
    /// `None`: of any.
    dimension: Option<Dimension>,
    low: f64,
    high: f64,
    margin: f64,
    /// As they are written in the table.
    texts: [&'static str; 2],
}

impl Range {
    fn of_row(&(key, low, high, margin): &(&'static str, &'static str, &'static str, f64)) -> Self {
        let ends = [low, high].map(|text| units::parse_scalar(text).expect("a range of this program"));
        let [from, to] = ends.map(|(number, unit)| unit.to_si(number));
        let dimension = low.contains(' ').then_some(ends[0].1.dimension);
        Range { key, dimension, low: from, high: to, margin, texts: [low, high] }
    }
}

/// How a value lies to its range.
#[derive(Debug, Clone, PartialEq)]
pub enum Verdict {
    Usual,
    /// A warning: what is usual, and the cure.
    Unusual(String, String),
    /// An error: what is allowed, and the cure.
    Refused(String, String),
}

/// Judges the value `si` of `key`, written as `number` in some unit. A positive one may be too small for any use.
pub fn judge(key: &str, quantity: &Quantity, number: f64, si: f64, positive: bool) -> Verdict {
    let magnitude = si.abs();
    if magnitude == 0.0 {
        return Verdict::Usual;
    }
    let Some(range) = range_of(key, quantity.dimension) else {
        let allowed = magnitude <= MOST && !(positive && magnitude < LEAST);
        let unit = if quantity.is_number() { String::new() } else { format!(" {}", quantity.unit) };
        let limits = format!("must lie between {LEAST:e} and {MOST:e}{unit}");
        return if allowed { Verdict::Usual } else { Verdict::Refused(limits, "check the value and its unit".into()) };
    };
    // A rounding error is no reason to warn.
    let outside = |margin: f64| (range.low / magnitude).max(magnitude / range.high) > margin * (1.0 + 1e-9);
    let too_large = magnitude > range.high;
    if !outside(1.0) {
        return Verdict::Usual;
    }
    let usual = format!("usual is {} to {}", range.texts[0], range.texts[1]);
    let cure = likely(range, quantity.dimension, number).unwrap_or_else(|| "check the value and its unit".into());
    if (too_large || positive) && outside(range.margin) {
        return Verdict::Refused(usual, cure);
    }
    Verdict::Unusual(usual, cure)
}

fn range_of(key: &str, dimension: Dimension) -> Option<&'static Range> {
    static READ: OnceLock<Vec<Range>> = OnceLock::new();
    let rows = READ.get_or_init(|| RANGES.iter().map(Range::of_row).collect());
    // The first letter spares most comparisons.
    let first = key.as_bytes().first();
    let names_it = |row: &Range| row.key.is_empty() || (row.key.as_bytes().first() == first && matches(row.key, key));
    rows.iter().find(|row| names_it(row) && row.dimension.is_none_or(|of_row| of_row == dimension))
}

/// Whether the dotted `key` is one of `pattern`.
fn matches(pattern: &str, key: &str) -> bool {
    let mut names = key.split('.');
    pattern.split('.').all(|part| names.next().is_some_and(|name| part == "*" || part == name))
        && names.next().is_none()
}

/// The number with the unit that was probably meant: the one that brings it nearest to the middle of the range.
fn likely(range: &Range, dimension: Dimension, number: f64) -> Option<String> {
    let distance = |si: f64| libm::log(si * si / (range.low.max(1e-3 * range.high) * range.high)).abs();
    let meant = units::symbols().chain(WRITTEN_UNITS).filter_map(|symbol| {
        let unit = units::parse_unit(symbol).expect("a unit of this program");
        let si = unit.to_si(number).abs();
        let fits = unit.dimension == dimension && (range.low..=range.high).contains(&si);
        fits.then_some((symbol, distance(si)))
    });
    let (symbol, _) = meant.min_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(format!("did you mean \"{} {symbol}\"?", short(number)))
}

/// A number as people write it.
pub fn short(number: f64) -> String {
    let magnitude = number.abs();
    if magnitude != 0.0 && !(1e-4..1e7).contains(&magnitude) {
        return format!("{number:e}");
    }
    format!("{number}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantities;

    #[test]
    fn each_range_is_ordered_and_in_one_unit() {
        for (key, low, high, margin) in RANGES {
            let [from, to] = [low, high].map(|text| units::parse_scalar(text).expect("a quantity"));
            assert!(from.1.dimension == to.1.dimension, "{key}");
            assert!(from.1.to_si(from.0) < to.1.to_si(to.0) && *margin >= 1.0, "{key}");
        }
    }

    #[test]
    fn a_wrong_unit_is_guessed() {
        let bore = |number: f64, si: f64| judge("cylinder.lift.bore", &quantities::length(), number, si, true);
        assert_eq!(bore(63.0, 0.063), Verdict::Usual);
        for number in [63.0, 100.0] {
            let meant = format!("did you mean \"{number} mm\"?");
            assert_eq!(bore(number, number), Verdict::Unusual("usual is 10 mm to 600 mm".into(), meant));
        }
        assert!(matches!(bore(1e5, 1e5), Verdict::Refused(..)));
        assert!(matches!(bore(1e-9, 1e-9), Verdict::Refused(..)));
        let pressure = judge("supply.pressure", &quantities::pressure(), 100.0, 100.0, false);
        assert_eq!(pressure, Verdict::Unusual("usual is 5 bar to 500 bar".into(), "did you mean \"100 bar\"?".into()));
    }

    #[test]
    fn keys_without_a_range_are_bounded_too() {
        for (number, refused) in [(1e-300, true), (0.5, false), (1e300, true)] {
            let verdict = judge("sensor.lift.noise", &Quantity::number(), number, number, true);
            assert_eq!(matches!(verdict, Verdict::Refused(..)), refused, "{number}");
        }
    }
}
