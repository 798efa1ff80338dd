use super::*;
use std::f64::consts::FRAC_PI_2;

fn si(text: &str) -> f64 {
    let (number, unit) = parse_scalar(text).unwrap();
    unit.to_si(number)
}

fn dimension(unit: &str) -> Dimension {
    parse_unit(unit).unwrap().dimension
}

fn close(value: f64, expected: f64) -> bool {
    (value - expected).abs() <= 1e-12 * expected.abs()
}

#[test]
fn common_units_become_si() {
    for (text, expected) in [
        ("140 bar", 140e5),
        ("1 psi", 6894.757293168361),
        ("6 l/min", 1e-4),
        ("180 deg", PI),
        ("161.2 Hz", TAU * 161.2),
        ("-61mm", -0.061),
        ("+2.5e-3 m", 2.5e-3),
        ("1.2e5 N/m", 1.2e5),
        ("12 cm²", 12e-4),
        ("3 cm³", 3e-6),
        ("0.04 Pa s", 0.04),
        ("0.04 Pa*s", 0.04),
        ("0.04 Pa·s", 0.04),
        ("1e-16 m^3/(s Pa)", 1e-16),
        ("9.81 m/s^2", 9.81),
        ("2 kg m^-1", 2.0),
        ("5 %", 0.05),
        ("1 mV/V", 1e-3),
        ("2 1/s", 2.0),
        ("28 cm3", 28e-6),
        ("28 cm³/r", 28e-6 / TAU),
        ("90°", FRAC_PI_2),
        ("40 μs", 40e-6),
        ("9.81 m/s2", 9.81),
        ("0.87 g/cm3", 870.0),
        ("45 cc", 45e-6),
        ("45 ccm", 45e-6),
        ("40 lpm", 40e-3 / 60.0),
        ("40 L/min", 40e-3 / 60.0),
        ("10 gpm", 6.30901964e-4),
        ("46 cSt", 46e-6),
        ("40 cP", 0.04),
        ("40 mPa s", 0.04),
        ("2.5 in", 0.0635),
        ("100 kp", 980.665),
        ("100 lbf", 444.822_161_526_05),
        ("60 Nm", 60.0),
        ("1450 rev/min", TAU * 1450.0 / 60.0),
        ("7", 7.0),
    ] {
        assert!(close(si(text), expected), "{text} gave {}", si(text));
    }
}

#[test]
fn small_units_round_once() {
    assert_eq!(si("10 um"), 1e-5);
    assert_eq!(si("0.43 mm"), 0.43e-3);
}

#[test]
fn derived_units_have_their_dimension() {
    assert_eq!(dimension("Pa"), dimension("N/m^2"));
    assert_eq!(dimension("W"), dimension("Pa m^3/s"));
    assert_eq!(dimension("J"), dimension("N m"));
    assert_eq!(dimension("Hz"), dimension("rad/s"));
    assert_eq!(dimension("W"), dimension("V A"));
    assert_ne!(dimension("rad"), dimension("%"));
    assert_ne!(dimension("Hz"), dimension("1/s"));
}

#[test]
fn exponents_may_be_fractional() {
    let unit = parse_unit("N s^1.5/m^1.5").unwrap();
    assert_eq!(unit.dimension, Dimension([-0.5, 1.0, -0.5, 0.0, 0.0, 0.0]));
    let converted = parse_unit("N s^1.5/mm^1.5").unwrap();
    assert!(close(converted.factor, 1e3f64.powf(1.5)));
}

#[test]
fn a_product_after_a_division_is_refused() {
    assert!(matches!(parse_unit("m^3/s Pa"), Err(UnitError::Malformed(text)) if text.contains("ambiguous")));
    assert_eq!(dimension("m/s/s"), dimension("m/s^2"));
}

#[test]
fn a_number_before_a_unit_with_e_is_split_rightly() {
    for text in ["10 e", "1e", "1e m"] {
        assert!(matches!(parse_scalar(text), Err(UnitError::Unknown(symbol)) if symbol == "e"), "{text}");
    }
}

#[test]
fn points_have_one_unit() {
    let (point, unit) = parse_point("(0.199, -6.1e-2) m").unwrap();
    assert_eq!(point, [0.199, -0.061]);
    assert_eq!(unit.factor, 1.0);
    assert_eq!(parse_point("(1, -2, 3) mm").unwrap().0, [1.0, -2.0, 3.0]);
    for bad in ["0.1, 0.2 m", "(0.1 0.2) m", "(a, b) m", "(1, 2", "(1, 2) m, 3", "(1) m", "(1, 2, 3, 4) m"] {
        assert!(matches!(parse_point(bad), Err(UnitError::Malformed(_))), "{bad}");
    }
}

#[test]
fn nonsense_is_an_error_and_never_a_panic() {
    for bad in
        ["", " ", "bar", "1 bar^", "1 (m", "1 m)", "1 m^x", "--1 m", "1..2 m", "1 m //s", "1 m/", "1 ²", "é", "1 é"]
    {
        assert!(parse_scalar(bad).is_err(), "`{bad}` was accepted");
    }
    assert!(parse_unit(&"(".repeat(100_000)).is_err());
}

#[test]
fn infinity_is_read_so_that_it_can_be_reported() {
    assert_eq!(parse_scalar("inf m").unwrap().0, f64::INFINITY);
    assert!(parse_scalar("-nan m").unwrap().0.is_nan());
    assert_eq!(parse_scalar("1e400 m").unwrap().0, f64::INFINITY);
}

#[test]
fn dimensions_read_as_base_units() {
    assert_eq!(dimension("bar").to_string(), "m^-1 kg s^-2");
    assert_eq!(Dimension::NONE.to_string(), "no unit");
}

#[test]
fn a_digit_is_an_exponent_only_directly_behind_its_symbol() {
    assert_eq!(dimension("cm3/rev"), dimension("m^3/rad"));
    for bad in ["1 m 3", "1 m33", "1 m3.5", "1 m1", "1 (m)3"] {
        assert!(parse_scalar(bad).is_err(), "`{bad}` was accepted");
    }
}

#[test]
fn the_reference_lists_every_unit() {
    let page = include_str!("../../../../docs/reference/machine-file.md");
    let (_, list) = page.split_once("\nUnits: ").unwrap();
    let listed: Vec<&str> = list.split(". ").next().unwrap().split([' ', ',', '\n']).collect();
    let missing: Vec<&str> = symbols().filter(|symbol| !listed.contains(symbol)).collect();
    assert!(missing.is_empty(), "{missing:?}");
}
