//! Units, names and clocks of logs.

use hydrocrane_logs::{Column, Content};
use hydrocrane_machine::units::log_columns::{counted_in, first_of, split_name, time_column, unit_of, Found};
use hydrocrane_machine::units::log_units::{bare_unit, in_si, log_unit, unit_of_signal};

#[test]
fn units_stand_behind_names() {
    for (text, wanted) in [
        ("x [mm]", ("x", "mm")),
        ("time[s]", ("time", "s")),
        (" p1 (bar(g)) ", ("p1", "bar(g)")),
        ("q (l/min)", ("q", "l/min")),
        ("p[2]", ("p[2]", "")),
        ("[mm]", ("[mm]", "")),
        ("x", ("x", "")),
        ("x [ ]", ("x", "")),
        ("x [-]", ("x", "")),
        ("a) b)", ("a) b)", "")),
        ("U (°F)", ("U", "°F")),
        ("x in mm", ("x", "mm")),
        ("x in 2 mm", ("x in 2 mm", "")),
        ("p1 in bar(g)", ("p1", "bar(g)")),
        ("valve in use", ("valve in use", "")),
        ("valve in use [mm]", ("valve in use", "mm")),
        ("time [seconds since 2024-05-01]", ("time", "seconds")),
        ("p1 <bar>", ("p1", "bar")),
        ("p1 <raw>", ("p1 <raw>", "")),
        ("t/s", ("t", "s")),
        ("Zeit/s", ("Zeit", "s")),
        ("p1/bar", ("p1", "bar")),
        ("v/(m/s)", ("v", "m/s")),
        ("Kraft / kN", ("Kraft", "kN")),
        ("m/s", ("m/s", "")),
        ("boom/A", ("boom/A", "")),
        ("/crane/lift/p1", ("/crane/lift/p1", "")),
        ("q/l [mm]", ("q/l", "mm")),
    ] {
        assert_eq!(split_name(text), wanted);
    }
    assert_eq!([bare_unit("[bar]"), bare_unit("(bar(g))"), bare_unit("(N s)/(m)")], ["bar", "bar(g)", "(N s)/(m)"]);
    assert_eq!([unit_of("x [mm]", ""), unit_of("x [mm]", "[m]"), unit_of("x [mm]", "-")], ["mm", "m", "mm"]);
}

#[test]
fn a_unit_of_a_log_may_be_spelled_in_many_ways() {
    for (text, factor, zero, absolute) in [
        ("Bar", 1e5, 0.0, false),
        ("barg", 1e5, 0.0, false),
        ("BARA", 1e5, 0.0, true),
        ("kPa (abs)", 1e3, 0.0, true),
        ("0.1 mm", 1e-4, 0.0, false),
        ("25 bar", 25e5, 0.0, false),
        ("-2 mm", -2e-3, 0.0, false),
        ("minutes", 60.0, 0.0, false),
        ("mm/sec", 1e-3, 0.0, false),
        ("1/s", 1.0, 0.0, false),
        ("d", 86_400.0, 0.0, false),
        ("\"", 0.0254, 0.0, false),
        ("lb", 0.453_592_37 * 9.806_65, 0.0, false),
        ("lbm", 0.453_592_37, 0.0, false),
        ("°C", 1.0, 273.15, false),
        ("in.", 0.0254, 0.0, false),
        ("0.02 sec", 0.02, 0.0, false),
        ("Millimeters", 1e-3, 0.0, false),
        ("KILOPASCALS", 1e3, 0.0, false),
        ("Newton", 1.0, 0.0, false),
        ("litres/minute", 1e-3 / 60.0, 0.0, false),
        ("C", 1.0, 273.15, false),
        ("counts", 1.0, 0.0, false),
        ("", 1.0, 0.0, false),
    ] {
        let found = log_unit(text).unwrap_or_else(|error| panic!("{text}: {error:?}"));
        assert_eq!((found.unit.factor, found.zero, found.absolute), (factor, zero, absolute), "{text}");
    }
    assert_eq!(in_si("psia", &[0.0], true).unwrap(), [-101_325.0]);
    assert_eq!(in_si("psia", &[0.0], false).unwrap(), [0.0]);
    assert_eq!(in_si("10 um", &[1.0], true).unwrap(), [1e-5]);
    assert_eq!(in_si("1e-31 m", &[1.0], true).unwrap_err().1, "one `1e-31 m` is 1e-31 in SI");
    for (text, told) in [("barr", "did you mean `bar`?"), ("Bar/furlong", "unknown unit `furlong`"), ("mm)", "no unit")]
    {
        let (_, what, cure) = log_unit(text).expect_err(text);
        assert!(format!("{what}; {cure}").contains(told) && !cure.is_empty(), "{text}: {what}; {cure}");
    }
    for (text, told, raw) in [
        ("bar", "`bar` is not a unit of `x`", false),
        ("mA", "`mA` is not a unit of `x`", true),
        ("counts", "`counts` is not a unit of `x`", true),
        ("furlong", "unknown unit `furlong`", false),
    ] {
        let (_, what, cure) = unit_of_signal(text, "x", &["m"]).expect_err(text);
        assert!(what.contains(told) && cure.contains("raw output") == raw, "{what}; {cure}");
    }
    assert!(unit_of_signal("mA", "x", &[]).is_ok());
}

fn column(name: &str, start: Option<f64>, values: &[f64]) -> Column {
    let content = Content::Numbers { values: values.to_vec(), start, notes: Vec::new() };
    Column { name: name.into(), unit: String::new(), content }
}

/// The index of the column of times by names alone.
fn clock(names: &[&str]) -> Found {
    time_column(&names.iter().map(|name| column(name, None, &[])).collect::<Vec<_>>(), &[])
}

#[test]
fn the_times_are_found_in_the_languages_of_makers() {
    for name in ["Zeit", "Zeit [s]", "TEMPS (s)", "tid", "time in ms"] {
        assert_eq!(clock(&["lift", name]), Ok(Some(1)), "{name}");
    }
    assert_eq!(clock(&["lift", "way"]), Ok(None));
}

#[test]
fn a_t_that_may_be_a_temperature_is_no_clock_beside_another() {
    for (names, wanted) in [
        (["T", "timestamp"], Some(1)),
        (["T", "Zeit [s]"], Some(1)),
        (["T", "t"], Some(1)),
        (["T", "x"], Some(0)),
        (["TIME", "time"], Some(1)),
        (["t [degC]", "timestamp"], Some(1)),
        (["t [degC]", "x"], None),
    ] {
        assert_eq!(clock(&names), Ok(wanted), "{names:?}");
    }
    for names in [["TIME", "Time"], ["time [s]", "time [ms]"]] {
        let (_, which, cure) = clock(&names).expect_err("two clocks");
        assert_eq!(which, format!("has `{}` and `{}`", names[0], names[1]));
        assert_eq!(cure, "say by its full name which is `time`");
    }
    let day = column("Date", Some(1e9 - 1e9 % 86_400.0), &[0.0, 0.0]);
    let columns = [day, column("Uhrzeit", Some(43_200.0), &[0.0, 1.0]), column("b.clock", None, &[])];
    assert_eq!(time_column(&columns, &[2]), Ok(Some(1)));
    assert_eq!(time_column(&columns[..1], &[]), Ok(None));
    assert_eq!(time_column(&columns[2..], &[0]), Ok(Some(0)));
}

#[test]
fn a_column_has_a_name_as_it_is_written_or_in_any_case() {
    let found =
        |names: &[&'static str], wanted| first_of(&names.iter().copied().enumerate().collect::<Vec<_>>(), wanted);
    let names = ["x [mm]", "X [m]", "Lift", "ÖL"];
    assert_eq!(found(&names, &["x"]), Ok(Some(0)));
    assert_eq!(found(&names, &["way", "lift"]), Ok(Some(2)));
    assert_eq!(found(&names, &["öl"]), Ok(Some(3)));
    assert_eq!(found(&names, &["X [m]"]), Ok(Some(1)));
    assert_eq!(found(&["X", "X [m]"], &["y"]), Ok(None));
    assert!(found(&["P [bar]", "P [Pa]"], &["p"]).is_err());
}

#[test]
fn times_that_cannot_be_seconds_are_recognised() {
    let counted = |zero: f64, step: f64| counted_in(&(0..9).map(|i| zero + step * f64::from(i)).collect::<Vec<_>>());
    assert_eq!(counted(0.0, 0.01), None);
    assert_eq!(counted(1.7e9, 0.01), None);
    assert_eq!(counted(1.7e12, 10.0), Some("ms"));
    assert_eq!(counted(1.7e15, 1e4), Some("1e-6 s"));
    assert_eq!(counted(1.7e18, 1e7), Some("1e-9 s"));
    assert_eq!(counted(739_000.5, 0.02 / 86_400.0), Some("d"));
    assert_eq!(counted(45_000.0, 1.0), None);
    assert_eq!(counted(0.0, 1e-7), Some("d"));
    assert_eq!((counted_in(&[]), counted_in(&[f64::NAN, 3.0])), (None, None));
}
