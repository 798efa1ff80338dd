//! Units of data loggers: those of machine files in more spellings, gauge and absolute pressure, degrees.

use crate::errors::{ErrorKind, Problem};
use crate::units::misread::{said, split_zero};
use crate::units::{lookup, number_length, own_scalar, own_unit, parse_unit, parse_unit_by, Unit, UnitError};

/// Standard atmosphere, Pa: difference of absolute and gauge pressure if no other is stated.
pub const ATMOSPHERE: f64 = 101_325.0;
/// Least SI value of one unit; its inverse is the greatest.
const LEAST: f64 = 1e-30;

/// A unit of a log.
#[derive(Debug, Clone, Copy)]
pub struct LogUnit {
    pub unit: Unit,
    /// SI value of the reading 0: 273.15 K for degC; 0 for every other unit.
    pub zero: f64,
    /// Whether it is a pressure relative to vacuum.
    pub absolute: bool,
}

/// Numbers of a unit in SI. Of a signal that is `gauge`, absolute pressures lose the standard atmosphere.
///
/// # Errors
/// If it is no unit, or one of it is so small or large that numbers lose precision.
pub fn in_si(text: &str, numbers: &[f64], gauge: bool) -> Result<Vec<f64>, Problem> {
    let LogUnit { unit, zero, absolute } = log_unit(text)?;
    let zero = zero - if absolute && gauge { ATMOSPHERE } else { 0.0 };
    if (LEAST..=1.0 / LEAST).contains(&unit.factor.abs()) {
        return Ok(numbers.iter().map(|number| unit.to_si(*number) + zero).collect());
    }
    let cure = "give a unit of 1e-30 to 1e+30 in SI".into();
    Err((ErrorKind::OutOfRange, format!("one `{text}` is {:e} in SI", unit.factor), cure))
}

/// A unit as it stands beside a column or behind its name, without brackets; empty if it says that there is none.
pub fn bare_unit(text: &str) -> &str {
    let text = text.trim();
    let bare = if bracket(text) == Some(0) { &text[1..text.len() - 1] } else { text };
    // NetCDF has times as "seconds since 2024-05-01".
    match bare.split(" since ").next().unwrap_or_default().trim() {
        "-" => "",
        unit => unit,
    }
}

/// Where the bracket opens that the last letter closes.
pub fn bracket(text: &str) -> Option<usize> {
    match text.as_bytes().last() {
        Some(b']') => text.rfind('['),
        Some(b')') => opening(text),
        // Angles also stand around other things.
        Some(b'>') => text.rfind('<').filter(|at| log_unit(&text[at + 1..text.len() - 1]).is_ok()),
        _ => None,
    }
}

/// As [`bracket`] for a round one; one pair more may lie inside.
fn opening(text: &str) -> Option<usize> {
    let mut depth = 0;
    for (at, letter) in text.bytes().enumerate().rev() {
        match letter {
            b')' => depth += 1,
            b'(' => depth -= 1,
            _ => {}
        }
        if depth == 0 || depth > 2 {
            return Some(at).filter(|_| depth == 0);
        }
    }
    None
}

/// The unit that a log or a mapping states, `psig`, `in/s`, `40 bar`.
///
/// # Errors
/// If it is none.
pub fn log_unit(text: &str) -> Result<LogUnit, Problem> {
    let text = bare_unit(text);
    let starts = text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    let (number, rest) = text.split_at(if starts { number_length(text) } else { 0 });
    // `in.` and `sec.` are abbreviations.
    let rest = rest.trim().trim_end_matches('.');
    let wrong = |error| {
        let (what, cure) = said(error, &format!("1 {rest}"), None);
        let cure = if cure.is_empty() { "write it as in mm, l/min or N s/m".into() } else { cure };
        (ErrorKind::UnknownUnit, what, cure)
    };
    let letters: String = rest.chars().filter(|c| !" _()[]".contains(*c)).collect();
    let kelvin = |factor| Unit { factor, ..own_unit("K") };
    let (unit, zero, absolute) = match (rest, split_zero(&letters, symbol)) {
        ("degC" | "°C" | "ºC" | "deg C" | "C", _) => (kelvin(1.0), 273.15, false),
        ("degF" | "°F" | "ºF" | "deg F" | "F", _) => (kelvin(5.0 / 9.0), 273.15 - 32.0 * 5.0 / 9.0, false),
        (_, Some((_, pressure, above_vacuum))) => (pressure, 0.0, above_vacuum),
        _ => {
            let one = if rest.starts_with('/') { "1" } else { "" };
            (parse_unit_by(&[one, rest].concat(), symbol).map_err(wrong)?, 0.0, false)
        }
    };
    if number.is_empty() {
        return Ok(LogUnit { unit, zero, absolute });
    }
    let number = number.parse().map_err(|_| wrong(UnitError::Malformed(format!("`{text}` is no unit"))))?;
    Ok(LogUnit { unit: Unit { factor: unit.to_si(number), ..unit }, zero, absolute })
}

/// A symbol of a log; a pound is a force, and `lbm` a mass.
fn symbol(name: &str) -> Option<Unit> {
    match name {
        "d" => one("86400 s"),
        "ns" => one("1e-9 s"),
        "msec" => one("1 ms"),
        "usec" => one("1 us"),
        "º" => one("1 deg"),
        "inches" | "\"" => one("1 in"),
        "feet" => one("1 ft"),
        "ips" => one("1 in/s"),
        "lb" | "lbs" => one("1 lbf"),
        "lbm" => one("1 lb"),
        "mA" => one("1e-3 A"),
        "uA" => one("1e-6 A"),
        "counts" => one("1"),
        _ => lookup(name).or_else(|| spelled(name)),
    }
}

/// A unit of this program.
fn one(text: &'static str) -> Option<Unit> {
    let (number, unit) = own_scalar(text);
    Some(Unit { factor: unit.to_si(number), ..unit })
}

/// A unit written out in any case, `Millimetres` or `BAR`: a prefix, a name and the plural.
fn spelled(name: &str) -> Option<Unit> {
    const PREFIXES: [(&str, f64); 8] = [
        ("nano", 1e-9),
        ("micro", 1e-6),
        ("milli", 1e-3),
        ("centi", 1e-2),
        ("kilo", 1e3),
        ("mega", 1e6),
        ("giga", 1e9),
        ("", 1.0),
    ];
    const NAMES: [(&str, &str); 25] = [
        ("metre", "1 m"),
        ("meter", "1 m"),
        ("inch", "1 in"),
        ("sec", "1 s"),
        ("second", "1 s"),
        ("minute", "1 min"),
        ("hour", "1 h"),
        ("day", "86400 s"),
        ("gram", "1 g"),
        ("litre", "1 l"),
        ("liter", "1 l"),
        ("newton", "1 N"),
        ("pascal", "1 Pa"),
        ("bar", "1 bar"),
        ("psi", "1 psi"),
        ("volt", "1 V"),
        ("amp", "1 A"),
        ("ampere", "1 A"),
        ("kelvin", "1 K"),
        ("watt", "1 W"),
        ("hertz", "1 Hz"),
        ("rpm", "1 rpm"),
        ("radian", "1 rad"),
        ("degree", "1 deg"),
        ("percent", "1 %"),
    ];
    let low = name.to_lowercase();
    let (prefix, factor) = PREFIXES.iter().find(|(prefix, _)| low.starts_with(prefix))?;
    let name = &low[prefix.len()..];
    let (_, text) = NAMES.iter().find(|(known, _)| *known == name || name.strip_suffix('s') == Some(known))?;
    let unit = one(text)?;
    Some(Unit { factor: unit.factor * factor, ..unit })
}

/// The unit of the numbers of the signal `name`, which has one of the `expected` SI units, or any if there are none.
///
/// # Errors
/// If it is no unit, or none of the signal.
pub fn unit_of_signal(text: &str, name: &str, expected: &[&str]) -> Result<LogUnit, Problem> {
    let found = log_unit(text)?;
    let is = |unit: &str| parse_unit(unit).is_ok_and(|unit| unit.dimension == found.unit.dimension);
    if expected.is_empty() || expected.iter().any(|unit| is(unit)) {
        return Ok(found);
    }
    let mut cure = format!("give one of {}", expected.join(" or "));
    if is("V") || is("A") || text.contains("count") {
        cure +=
            ". These are the sensor's raw output: say what one volt, milliampere or count means, unit = \"25 bar\" \
                 for 4 to 20 mA over 400 bar, and in a mapping offset = \"-100 bar\"";
    }
    Err((ErrorKind::WrongDimension, format!("`{text}` is not a unit of `{name}`"), cure))
}
