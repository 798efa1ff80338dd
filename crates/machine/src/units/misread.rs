//! Quantities that are not read, and what was probably meant.

use crate::nearest::symbol_suggestion;
use crate::units::{
    in_symbol, lookup, meant, number_length, own_unit, parse_scalar, parse_unit, Dimension, Meant, Unit, UnitError,
};

/// Symbols of what they measure (as a unit), with the cure.
const UNREAD: &[(&[&str], &str, &str)] = &[
    (&["grad", "gon"], "rad", "write deg: a grad is 1 deg to some, and a gon, 0.9 deg, to others"),
    (&["SSU", "SUS", "SFU", "SFS", "°E"], "m^2/s", "write cSt, from a table of conversions: no factor leads there"),
];

/// Ends of the symbols of pressures, and whether they mean above vacuum.
const ZEROS: [(&str, bool); 5] = [("gauge", false), ("g", false), ("absolute", true), ("abs", true), ("a", true)];

/// What to write in the place of the quantity `text`; nothing where its unit is none of these, or not of the `expected` dimension.
pub fn instead(text: &str, expected: Option<Dimension>) -> Option<String> {
    let (number, unit) = text.trim().split_at(number_length(text.trim()));
    let wanted = |of: &'static str| expected.is_none_or(|dimension| own_unit(of).dimension == dimension);
    let symbols = || unit.split(|c| !in_symbol(c));
    let held = |names: &[&str]| symbols().any(|symbol| names.iter().any(|name| name.eq_ignore_ascii_case(symbol)));
    // A viscosity of oil may be stated as either.
    let viscosity = |of: &str| of == "m^2/s" && wanted("Pa s");
    if let Some((.., cure)) = UNREAD.iter().find(|(names, of, _)| held(names) && (wanted(of) || viscosity(of))) {
        return Some((*cure).into());
    }
    let bare: String = unit.chars().filter(|c| c.is_alphabetic()).collect();
    let (symbol, _, above_vacuum) = split_zero(&bare, lookup).filter(|_| wanted("Pa"))?;
    Some(if above_vacuum {
        format!("pressures here are gauge: write what is above the atmosphere, 1.01325 bar, in {symbol}")
    } else {
        format!("pressures here are gauge: write \"{number} {symbol}\"")
    })
}

/// Symbol and unit of a pressure that says above which zero it is, and whether that is vacuum.
pub fn split_zero(letters: &str, lookup: fn(&str) -> Option<Unit>) -> Option<(&str, Unit, bool)> {
    let split = |(end, above_vacuum): (&str, bool)| {
        let (symbol, rest) = letters.split_at_checked(letters.len().checked_sub(end.len())?)?;
        let unit = lookup(symbol).filter(|unit| unit.dimension == own_unit("Pa").dimension)?;
        rest.eq_ignore_ascii_case(end).then_some((symbol, unit, above_vacuum))
    };
    ZEROS.into_iter().find_map(split)
}

/// What is wrong with the quantity `text`, and what was probably meant, of the `expected` dimension; no cure where the first says it.
pub fn said(error: UnitError, text: &str, expected: Option<Dimension>) -> (String, String) {
    match error {
        UnitError::Malformed(message) => (message, String::new()),
        UnitError::Unknown(symbol) => {
            let fits = |meant: &Meant| expected.is_none_or(|dimension| meant.unit.dimension == dimension);
            let fitting = meant(text, &symbol).into_iter().filter(fits).map(|meant| (meant.symbol, 0));
            let near = || symbol_suggestion(&symbol, &fitting.collect::<Vec<_>>());
            (format!("unknown unit `{symbol}`"), instead(text, expected).unwrap_or_else(near))
        }
    }
}

/// `"140 bar"` as its SI value and the name of its dimension, for readers of other files than machines; the error
/// says what is wrong and what was probably meant, in units of the same dimension as `expected`, if it is given.
pub fn quantity(text: &str, expected: Option<&str>) -> Result<(f64, String), String> {
    let (number, unit) = parse_scalar(text).map_err(|error| {
        let expected = expected.and_then(|unit| parse_unit(unit).ok()).map(|unit| unit.dimension);
        let (what, cure) = said(error, text, expected);
        if cure.is_empty() {
            what
        } else {
            format!("{what}; {cure}")
        }
    })?;
    let value = unit.to_si(number);
    if value.is_finite() {
        Ok((value, unit.dimension.to_string()))
    } else {
        Err(format!("`{}` is not finite", text.trim()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn a_quantity_of_another_file_names_its_dimension_or_its_error() {
        assert_eq!(quantity("140 bar", None), Ok((140e5, "m^-1 kg s^-2".into())));
        assert_eq!(quantity("2 mm", None).unwrap().1, quantity("-1 km", None).unwrap().1);
        assert_eq!(quantity("1 kHz", None), Ok((1e3 * TAU, "s^-1 rad".into())));
        assert_eq!(quantity("3", None).unwrap().1, "no unit");
        assert!(quantity("1 bars", None).unwrap_err().contains("did you mean `bar`"));
        assert!(quantity("inf mm", None).unwrap_err().contains("not finite"));
        assert!(quantity("mm", None).is_err());
    }

    #[test]
    fn a_suggestion_is_of_the_expected_dimension() {
        for (text, expected, wanted) in [
            ("40 lqm", "m^3/s", "did you mean `lpm`?"),
            ("40 mpa s", "Pa s", "did you mean `mPa`?"),
            ("1 barr", "Pa", "did you mean `bar`?"),
        ] {
            let found = quantity(text, Some(expected)).unwrap_err();
            assert!(found.ends_with(wanted), "{text}: {found}");
        }
        assert!(!quantity("40 lxm", Some("kg")).unwrap_err().contains("rpm"));
    }
}
