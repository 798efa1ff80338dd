//! Quantities with their unit at the value: `"140 bar"`, `"5 N s^1.5/m^1.5"`, `"(0.199, -0.061) m"`.
//!
//! Everything becomes SI. The plane angle counts as a base dimension of its own, so that an angle, a ratio and a count
//! cannot be mistaken for each other. `Hz` means cycles per second of an angular frequency: 1 Hz = 2 pi rad/s.

pub mod log_columns;
pub mod log_units;
pub(crate) mod misread;
pub(crate) mod quantities;

use std::borrow::Cow;
use std::cell::RefCell;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::fmt;

const BASE_UNITS: [&str; 6] = ["m", "kg", "s", "K", "A", "rad"];
const MAX_NESTING: usize = 16;

/// Exponents of the base units m, kg, s, K, A, rad; fractions are allowed.
#[derive(Debug, Clone, Copy)]
pub struct Dimension(pub [f64; 6]);

impl PartialEq for Dimension {
    fn eq(&self, other: &Self) -> bool {
        self.0.iter().zip(other.0).all(|(a, b)| (a - b).abs() < 1e-9)
    }
}

impl Dimension {
    pub const NONE: Self = Self([0.0; 6]);

    pub fn combine(self, other: Self, power: f64) -> Self {
        Self(hydrocrane_num::array::from_fn(|i| self.0[i] + power * other.0[i]))
    }
}

impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let factors: Vec<String> = BASE_UNITS
            .iter()
            .zip(self.0)
            .filter(|(_, power)| power.abs() > 1e-9)
            .map(|(unit, power)| if power == 1.0 { unit.to_string() } else { format!("{unit}^{power}") })
            .collect();
        f.write_str(if factors.is_empty() { "no unit".into() } else { factors.join(" ") }.as_str())
    }
}

/// What a key expects: the quantity's name, the SI unit to show in a message, its dimension.
#[derive(Debug, Clone)]
pub struct Quantity {
    pub name: &'static str,
    pub unit: Cow<'static, str>,
    pub dimension: Dimension,
}

impl Quantity {
    /// A quantity by its name and SI unit expression.
    ///
    /// # Panics
    /// Where `unit` is not a unit; it is written in this program, never read from a file.
    pub fn new(name: &'static str, unit: impl Into<Cow<'static, str>>) -> Self {
        let unit = unit.into();
        let dimension = match unit {
            Cow::Borrowed(text) => own_unit(text).dimension,
            Cow::Owned(ref text) => parse_unit(text).expect("a unit of this program").dimension,
        };
        Self { name, unit, dimension }
    }

    pub fn number() -> Self {
        Self { name: "plain number", unit: Cow::Borrowed(""), dimension: Dimension::NONE }
    }

    pub fn is_number(&self) -> bool {
        self.dimension == Dimension::NONE
    }

    /// The unit that people write most.
    pub fn written(&self) -> &str {
        const WRITTEN: [(&str, &str); 4] =
            [("pressure", "bar"), ("length", "mm"), ("angle", "deg"), ("volume flow", "l/min")];
        WRITTEN.iter().find(|(name, _)| *name == self.name).map_or(&self.unit, |(_, unit)| unit)
    }

    /// `a pressure with its unit, for example "1 Pa"`
    pub fn example(&self) -> String {
        if self.is_number() {
            return "a plain number, for example 1.5".into();
        }
        format!("{} with its unit, for example \"1 {}\"", with_article(self.name), self.unit)
    }
}

/// The name of a quantity with its article.
pub fn with_article(name: &str) -> String {
    let article = if name.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" };
    format!("{article} {name}")
}

/// A parsed unit: SI value of one of it, and its dimension.
#[derive(Debug, Clone, Copy)]
pub struct Unit {
    pub factor: f64,
    pub dimension: Dimension,
}

impl Unit {
    /// `number` of this unit in SI. Dividing by a whole number rounds once, so that 10 um is the double nearest 1e-5.
    pub fn to_si(self, number: f64) -> f64 {
        let inverse = (1.0 / self.factor).round();
        if self.factor < 1.0 && inverse.is_finite() && 1.0 / inverse == self.factor {
            number / inverse
        } else {
            number * self.factor
        }
    }
}

/// Why a text is no quantity.
#[derive(Debug, Clone, PartialEq)]
pub enum UnitError {
    /// No number at the start, or something after it that is no unit.
    Malformed(String),
    Unknown(String),
}

/// Splits `"140 bar"` into its number and unit; without a unit the unit text is empty.
pub fn parse_scalar(text: &str) -> Result<(f64, Unit), UnitError> {
    let text = text.trim();
    let end = number_length(text);
    let number = parse_number(&text[..end])?;
    if text[end..].starts_with(',') {
        return Err(UnitError::Malformed(format!("`{text}`: write a decimal point, and no marks between thousands")));
    }
    Ok((number, parse_unit(&text[end..])?))
}

thread_local! {
    static OWN_UNITS: RefCell<HashMap<&'static str, Unit>> = RefCell::default();
}

/// A unit that stands in this program and not in a file. Each is parsed once: every value of a file is held against several.
///
/// # Panics
/// Where it is none.
pub fn own_unit(text: &'static str) -> Unit {
    let parse = || parse_unit(text).expect("a unit of this program");
    OWN_UNITS.with_borrow_mut(|known| *known.entry(text).or_insert_with(parse))
}

/// As [`own_unit`], behind a number.
pub fn own_scalar(text: &'static str) -> (f64, Unit) {
    let (number, unit) = text.split_at(number_length(text));
    (number.parse().expect("a number of this program"), own_unit(unit))
}

/// `"(0.199, -0.061) m"`: two or three numbers and their common unit.
pub fn parse_point(text: &str) -> Result<(Vec<f64>, Unit), UnitError> {
    let malformed = || UnitError::Malformed(format!("`{text}` is not a point"));
    let (inside, unit) = text.trim().strip_prefix('(').and_then(|rest| rest.split_once(')')).ok_or_else(malformed)?;
    let numbers = inside.split(',').map(|number| parse_number(number.trim())).collect::<Result<Vec<f64>, _>>()?;
    match numbers.len() {
        2 | 3 => Ok((numbers, parse_unit(unit)?)),
        _ => Err(malformed()),
    }
}

fn parse_number(text: &str) -> Result<f64, UnitError> {
    let malformed = || UnitError::Malformed(format!("`{text}` is not a number"));
    text.parse().map_err(|_| malformed())
}

/// Bytes of the number that `text` starts with: `inf` and `nan` count, so that they are reported as not finite.
pub fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |from: usize| from + bytes[from..].iter().take_while(|b| b.is_ascii_digit() || **b == b'.').count();
    let start = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
    let word = text[start..].split(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default();
    if ["inf", "nan", "infinity"].contains(&word.to_ascii_lowercase().as_str()) {
        return start + word.len();
    }
    let mantissa = digits(start);
    if !matches!(bytes.get(mantissa), Some(b'e' | b'E')) {
        return mantissa;
    }
    let sign = mantissa + 1 + usize::from(matches!(bytes.get(mantissa + 1), Some(b'+' | b'-')));
    match digits(sign.min(bytes.len())) {
        end if end > sign => end,
        _ => mantissa,
    }
}

/// Parses a unit expression; the empty text is the unit of a plain number.
pub fn parse_unit(text: &str) -> Result<Unit, UnitError> {
    parse_unit_by(text, lookup)
}

/// As [`parse_unit`], of the symbols that `lookup` knows.
pub fn parse_unit_by(text: &str, lookup: fn(&str) -> Option<Unit>) -> Result<Unit, UnitError> {
    let text = text.trim();
    let mut parser = UnitParser { text, rest: text, depth: 0, lookup };
    if parser.rest.is_empty() {
        return Ok(Unit { factor: 1.0, dimension: Dimension::NONE });
    }
    if let Some(unit) = lookup(text) {
        return Ok(unit);
    }
    let unit = parser.product()?;
    if parser.rest.is_empty() {
        Ok(unit)
    } else {
        Err(parser.malformed())
    }
}

struct UnitParser<'a> {
    text: &'a str,
    rest: &'a str,
    depth: usize,
    lookup: fn(&str) -> Option<Unit>,
}

impl UnitParser<'_> {
    fn malformed(&self) -> UnitError {
        UnitError::Malformed(format!("`{}` is no unit", self.text.trim()))
    }

    fn eat(&mut self, symbol: char) -> bool {
        self.rest = self.rest.trim_start();
        match self.rest.strip_prefix(symbol) {
            Some(rest) => {
                self.rest = rest;
                true
            }
            None => false,
        }
    }

    /// Factors joined by a space, `*` or `/`. A product after a division needs parentheses, since people read
    /// `a/b c` in two ways.
    fn product(&mut self) -> Result<Unit, UnitError> {
        let mut unit = self.power()?;
        let mut divided = false;
        loop {
            let power = if self.eat('/') {
                divided = true;
                -1.0
            } else if self.eat('*') || self.eat('·') || self.starts_factor() {
                if divided {
                    let hint = format!("`{}` is ambiguous: put the divisor in parentheses", self.text.trim());
                    return Err(UnitError::Malformed(hint));
                }
                1.0
            } else {
                return Ok(unit);
            };
            let factor = self.power()?;
            unit.factor *= libm::pow(factor.factor, power);
            unit.dimension = unit.dimension.combine(factor.dimension, power);
        }
    }

    fn starts_factor(&self) -> bool {
        let rest = self.rest.trim_start();
        rest.starts_with(|c: char| c == '(' || in_symbol(c))
    }

    /// A factor with its exponent.
    fn power(&mut self) -> Result<Unit, UnitError> {
        let base = self.factor()?;
        let exponent = if self.eat('²') {
            2.0
        } else if self.eat('³') {
            3.0
        } else if self.eat('^') {
            self.exponent()?
        } else if let Some(digit) = self.bare_exponent() {
            digit
        } else {
            return Ok(base);
        };
        Ok(Unit {
            factor: libm::pow(base.factor, exponent),
            dimension: Dimension::NONE.combine(base.dimension, exponent),
        })
    }

    /// The digit directly behind a symbol, as in `cm3` and `m/s2`.
    fn bare_exponent(&mut self) -> Option<f64> {
        let written = &self.text[..self.text.len() - self.rest.len()];
        let digit = self.rest.chars().next().filter(|c| ('2'..='9').contains(c))?;
        let alone = !self.rest[1..].starts_with(|c: char| c.is_ascii_digit() || c == '.');
        (alone && written.ends_with(char::is_alphabetic)).then(|| {
            self.rest = &self.rest[1..];
            f64::from(digit as u8 - b'0')
        })
    }

    fn exponent(&mut self) -> Result<f64, UnitError> {
        self.rest = self.rest.trim_start();
        let sign = usize::from(self.rest.starts_with(['+', '-']));
        let digits = self.rest[sign..].bytes().take_while(|b| b.is_ascii_digit() || *b == b'.').count();
        let (number, rest) = self.rest.split_at(sign + digits);
        self.rest = rest;
        number.parse().map_err(|_| self.malformed())
    }

    fn factor(&mut self) -> Result<Unit, UnitError> {
        if self.eat('(') {
            self.depth += 1;
            if self.depth > MAX_NESTING {
                return Err(self.malformed());
            }
            let inner = self.product()?;
            self.depth -= 1;
            return if self.eat(')') { Ok(inner) } else { Err(self.malformed()) };
        }
        if self.eat('1') {
            return Ok(Unit { factor: 1.0, dimension: Dimension::NONE });
        }
        self.rest = self.rest.trim_start();
        let end = self.rest.find(|c: char| !in_symbol(c)).unwrap_or(self.rest.len());
        let (symbol, rest) = self.rest.split_at(end);
        if symbol.is_empty() {
            return Err(self.malformed());
        }
        self.rest = rest;
        (self.lookup)(symbol).ok_or_else(|| UnitError::Unknown(symbol.into()))
    }
}

/// Symbol, SI factor, exponents of m, kg, s, K, A, rad.
type Known = (&'static str, f64, [i8; 6]);

/// Units that guesses of the intended unit choose from.
const UNITS: &[Known] = &[
    ("m", 1.0, [1, 0, 0, 0, 0, 0]),
    ("km", 1e3, [1, 0, 0, 0, 0, 0]),
    ("cm", 1e-2, [1, 0, 0, 0, 0, 0]),
    ("mm", 1e-3, [1, 0, 0, 0, 0, 0]),
    ("um", 1e-6, [1, 0, 0, 0, 0, 0]),
    ("µm", 1e-6, [1, 0, 0, 0, 0, 0]),
    ("s", 1.0, [0, 0, 1, 0, 0, 0]),
    ("ms", 1e-3, [0, 0, 1, 0, 0, 0]),
    ("us", 1e-6, [0, 0, 1, 0, 0, 0]),
    ("µs", 1e-6, [0, 0, 1, 0, 0, 0]),
    ("min", 60.0, [0, 0, 1, 0, 0, 0]),
    ("h", 3600.0, [0, 0, 1, 0, 0, 0]),
    ("kg", 1.0, [0, 1, 0, 0, 0, 0]),
    ("g", 1e-3, [0, 1, 0, 0, 0, 0]),
    ("t", 1e3, [0, 1, 0, 0, 0, 0]),
    ("N", 1.0, [1, 1, -2, 0, 0, 0]),
    ("kN", 1e3, [1, 1, -2, 0, 0, 0]),
    ("MN", 1e6, [1, 1, -2, 0, 0, 0]),
    ("Pa", 1.0, [-1, 1, -2, 0, 0, 0]),
    ("kPa", 1e3, [-1, 1, -2, 0, 0, 0]),
    ("MPa", 1e6, [-1, 1, -2, 0, 0, 0]),
    ("GPa", 1e9, [-1, 1, -2, 0, 0, 0]),
    ("bar", 1e5, [-1, 1, -2, 0, 0, 0]),
    ("mbar", 1e2, [-1, 1, -2, 0, 0, 0]),
    ("psi", POUND * GRAVITY / (INCH * INCH), [-1, 1, -2, 0, 0, 0]),
    ("rad", 1.0, [0, 0, 0, 0, 0, 1]),
    ("mrad", 1e-3, [0, 0, 0, 0, 0, 1]),
    ("deg", PI / 180.0, [0, 0, 0, 0, 0, 1]),
    ("Hz", TAU, [0, 0, -1, 0, 0, 1]),
    ("kHz", 1e3 * TAU, [0, 0, -1, 0, 0, 1]),
    ("rpm", TAU / 60.0, [0, 0, -1, 0, 0, 1]),
    ("l", 1e-3, [3, 0, 0, 0, 0, 0]),
    ("ml", 1e-6, [3, 0, 0, 0, 0, 0]),
    ("Nm", 1.0, [2, 1, -2, 0, 0, 0]),
    ("cSt", 1e-6, [2, 0, -1, 0, 0, 0]),
    ("J", 1.0, [2, 1, -2, 0, 0, 0]),
    ("W", 1.0, [2, 1, -3, 0, 0, 0]),
    ("kW", 1e3, [2, 1, -3, 0, 0, 0]),
    ("V", 1.0, [2, 1, -3, 0, -1, 0]),
    ("mV", 1e-3, [2, 1, -3, 0, -1, 0]),
    ("A", 1.0, [0, 0, 0, 0, 1, 0]),
    ("K", 1.0, [0, 0, 0, 1, 0, 0]),
    ("%", 1e-2, [0, 0, 0, 0, 0, 0]),
];

const POUND: f64 = 0.453_592_37;
const INCH: f64 = 0.0254;
const GRAVITY: f64 = 9.806_65;

/// Further units of the trade, read but not suggested in the place of a wrong one. Pound, inch and standard gravity are exact by
/// definition; the US gallon is 231 cubic inches.
const TRADE: &[Known] = &[
    ("L", 1e-3, [3, 0, 0, 0, 0, 0]),
    ("dm", 1e-1, [1, 0, 0, 0, 0, 0]),
    ("cc", 1e-6, [3, 0, 0, 0, 0, 0]),
    ("ccm", 1e-6, [3, 0, 0, 0, 0, 0]),
    ("lpm", 1e-3 / 60.0, [3, 0, -1, 0, 0, 0]),
    ("gpm", 231.0 * INCH * INCH * INCH / 60.0, [3, 0, -1, 0, 0, 0]),
    ("rev", TAU, [0, 0, 0, 0, 0, 1]),
    ("U", TAU, [0, 0, 0, 0, 0, 1]),
    ("r", TAU, [0, 0, 0, 0, 0, 1]),
    ("°", PI / 180.0, [0, 0, 0, 0, 0, 1]),
    ("inch", INCH, [1, 0, 0, 0, 0, 0]),
    ("sec", 1.0, [0, 0, 1, 0, 0, 0]),
    ("Pas", 1.0, [-1, 1, -1, 0, 0, 0]),
    ("mPas", 1e-3, [-1, 1, -1, 0, 0, 0]),
    ("mPa", 1e-3, [-1, 1, -2, 0, 0, 0]),
    ("P", 1e-1, [-1, 1, -1, 0, 0, 0]),
    ("cP", 1e-3, [-1, 1, -1, 0, 0, 0]),
    ("St", 1e-4, [2, 0, -1, 0, 0, 0]),
    ("in", INCH, [1, 0, 0, 0, 0, 0]),
    ("ft", 12.0 * INCH, [1, 0, 0, 0, 0, 0]),
    ("lb", POUND, [0, 1, 0, 0, 0, 0]),
    ("lbs", POUND, [0, 1, 0, 0, 0, 0]),
    ("lbf", POUND * GRAVITY, [1, 1, -2, 0, 0, 0]),
    ("kp", GRAVITY, [1, 1, -2, 0, 0, 0]),
    ("kgf", GRAVITY, [1, 1, -2, 0, 0, 0]),
    ("tf", 1e3 * GRAVITY, [1, 1, -2, 0, 0, 0]),
];

/// Exponents of m, kg, s, K, A and rad in a unit; `None` where the text is no unit.
pub fn unit_exponents(unit: &str) -> Option<[f64; 6]> {
    parse_unit(unit).ok().map(|unit| unit.dimension.0)
}

/// A known symbol in the place of an unknown one, with what the text is then.
pub struct Meant {
    pub symbol: &'static str,
    pub number: f64,
    pub unit: Unit,
}

/// Every reading of a quantity or point with a known symbol in place of the `unknown` one.
pub fn meant(text: &str, unknown: &str) -> Vec<Meant> {
    let text = text.trim();
    let start = text.find(')').map_or_else(|| number_length(text), |end| end + 1);
    let number = parse_number(&text[..number_length(text)]).unwrap_or(f64::NAN);
    // Only whole symbols: `l` is not replaced in `ml`.
    let pieces: Vec<&str> = text[start..].split_inclusive(|c| !in_symbol(c)).collect();
    let with = |symbol: &'static str| {
        let replaced: String = pieces
            .iter()
            .map(|piece| match piece.trim_end_matches(|c| !in_symbol(c)) {
                letters if letters == unknown => [symbol, &piece[letters.len()..]].concat(),
                _ => (*piece).to_string(),
            })
            .collect();
        parse_unit(&replaced).ok().map(|unit| Meant { symbol, number, unit })
    };
    symbols().filter_map(with).collect()
}

/// Every unit symbol.
pub fn symbols() -> impl Iterator<Item = &'static str> {
    usual_symbols().chain(TRADE.iter().map(|(symbol, _, _)| *symbol))
}

/// Those that are suggested in the place of a wrong unit.
pub fn usual_symbols() -> impl Iterator<Item = &'static str> {
    UNITS.iter().map(|(symbol, _, _)| *symbol)
}

/// The symbols of units of this dimension.
#[cfg(feature = "schema")]
pub fn symbols_of(dimension: Dimension) -> impl Iterator<Item = &'static str> {
    symbols().filter(move |symbol| lookup(symbol).is_some_and(|unit| unit.dimension == dimension))
}

/// Whether a character may stand in the symbol of a unit.
pub fn in_symbol(c: char) -> bool {
    c.is_alphabetic() || c == '%' || c == '°'
}

pub fn lookup(symbol: &str) -> Option<Unit> {
    // The Greek letter looks like the sign for a millionth.
    let symbol = &*symbol.replace('μ', "µ");
    let (_, factor, powers) = UNITS.iter().chain(TRADE).find(|(name, _, _)| *name == symbol)?;
    Some(Unit { factor: *factor, dimension: Dimension(powers.map(f64::from)) })
}

#[cfg(test)]
#[path = "units_tests.rs"]
mod tests;
