//! Values far from usual are refused, unusual ones are noted, and everything that a file can ask for has a bound.

use hydrocrane_machine::{bundled_machines, load, load_scenario, parse, parse_scenario, Machine, OverrideValue};

fn with(key: &str, value: &str) -> Result<Machine, hydrocrane_machine::MachineError> {
    load("rottne-f9-lab", &[(key.into(), OverrideValue::Text(value.into()))])
}

#[test]
fn no_machine_of_ours_is_unusual() {
    let more = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/two-telescopes.toml");
    for name in bundled_machines().iter().map(|(name, _)| *name).chain([more]) {
        assert_eq!(load(name, &[]).unwrap().warnings, [], "{name}");
    }
}

#[test]
fn a_wrong_unit_is_noted_with_the_one_that_was_meant() {
    for (key, value, cure) in [
        ("cylinder.lift.bore", "100 m", "did you mean \"100 mm\"?"),
        ("cylinder.lift.bore", "63 m", "did you mean \"63 mm\"?"),
        ("supply.pressure", "16 MPa", ""),
        ("supply.pressure", "1400 bar", "check the value and its unit"),
        ("payload.mass", "200 t", "did you mean \"200 kg\"?"),
        ("fluid.density", "870 g/l", ""),
        ("fluid.viscosity", "40 Pa s", "did you mean \"40 mPa s\"?"),
        ("friction.lift.breakaway", "700 kN", "did you mean \"700 N\"?"),
        ("valve.lift.nominal-flow", "100 l/s", "did you mean \"100 l/min\"?"),
    ] {
        let crane = with(key, value).unwrap_or_else(|error| panic!("{error}"));
        let found = crane.warnings.first().map_or("", |warning| warning.cure.as_str());
        assert_eq!(found, cure, "{key} = {value}: {:?}", crane.warnings);
        if let Some(warning) = crane.warnings.first() {
            assert_eq!((warning.key.as_str(), warning.place.as_str()), (key, &*format!("override \"{key}\"")));
            assert!(warning.text.starts_with(value) && warning.text.contains("usual is"), "{}", warning.text);
        }
    }
}

#[test]
fn a_note_names_the_line() {
    let text = "extends = \"single-cylinder\"\n[machine]\nclass = \"assumed\"\n[cylinder.test]\nbore = \"63 m\"\n";
    let crane = parse(text, "mine.toml", &[]).unwrap();
    assert_eq!(crane.warnings[0].place, "mine.toml:5:8");
}

#[test]
fn values_beyond_any_use_are_refused() {
    for (key, value) in [
        ("fluid.bulk-modulus-max", "0.1 MPa"),
        ("fluid.bulk-modulus-max", "9 MPa"),
        ("fluid.bulk-c2", "1.001"),
        ("fluid.vacuum", "-1e-9 bar"),
        ("equilibrium.back-pressure", "150000 bar"),
        ("supply.pressure", "1e9 bar"),
        ("cylinder.lift.bore", "1e-9 m"),
        ("link.jib.mass", "1e300 kg"),
        ("link.extension.point.tip", "(1e6, 0) m"),
        ("control.period", "1e-9 s"),
        ("valve.lift.delay", "1e9 s"),
        ("sensor.lift-p1.noise", "1e-300"),
    ] {
        let error = with(key, value).unwrap_err();
        assert!(["out-of-range", "unknown-reference"].contains(&error.slug()), "{key}: {error}");
        assert!(error.cure().is_some());
    }
    for corner in ["1e6", "1e300"] {
        let text = format!("extends = \"rottne-f9-lab\"\n[machine]\nclass = \"assumed\"\n[keep-out.far]\noutline = [\"(0, 0) m\", \"({corner}, 0) m\", \"(0, 1) m\"]\n");
        let error = parse(&text, "far.toml", &[]).unwrap_err();
        assert_eq!((error.slug(), error.line()), ("out-of-range", Some(5)), "{error}");
    }
}

#[test]
fn keep_out_regions_have_a_bound_on_their_corners() {
    let ring: String =
        (0..1001).map(|i| format!("\"({}, {}) m\", ", f64::from(i) * 0.01, f64::from(i * i % 7))).collect();
    let text =
        format!("extends = \"rottne-f9-lab\"\n[machine]\nclass = \"assumed\"\n[keep-out.far]\noutline = [{ring}]\n");
    let error = parse(&text, "far.toml", &[]).unwrap_err();
    assert_eq!((error.slug(), error.line()), ("too-large", Some(5)), "{error}");
}

fn scenario(more: &str) -> String {
    format!(
        "[scenario]\nname = \"s\"\nmachine = \"single-cylinder\"\nduration = \"1 s\"\n{more}\n[joystick]\ntime = [\"0 s\"]\nx = [0]\n"
    )
}

#[test]
fn what_a_scenario_asks_for_has_bounds() {
    let phases: String = (1..=1001).map(|i| format!("[phase.p{i}]\ntime = \"{i} ms\"\n")).collect();
    let rows = format!("[payload]\ntime = [{}]\nmass = []\n", "\"1 s\", ".repeat(400_001));
    for (more, slug) in [
        ("[controller]\nperiod = \"1e-9 s\"", "out-of-range"),
        ("[controller]\ndelay = \"1e9 s\"", "out-of-range"),
        ("[solver]\nmethod = \"hc-rosenbrock-3\"\nstep = \"1e-300 s\"", "out-of-range"),
        (phases.as_str(), "too-large"),
        (rows.as_str(), "too-large"),
    ] {
        let error = parse_scenario(&scenario(more), "s.toml", &[]).unwrap_err();
        assert_eq!(error.slug(), slug, "{error}");
        assert!(error.line().is_some() && error.cure().is_some());
    }
}

#[test]
fn a_thousand_phases_are_read_in_seconds() {
    let phases: String = (1..=1000)
        .map(|i| format!("[phase.p{i}]\ntime = \"{i} ms\"\noverrides.\"supply.pressure\" = \"{} bar\"\n", 100 + i % 9))
        .collect();
    let began = std::time::Instant::now();
    assert_eq!(parse_scenario(&scenario(&phases), "s.toml", &[]).unwrap().phases.len(), 1000);
    assert!(began.elapsed().as_secs() < 20, "{:?}", began.elapsed());
}

#[test]
fn texts_tables_and_files_have_bounds() {
    let long = format!("# {}\n[machine]", "x".repeat(17 << 20));
    let wide = format!("[link]\n{}", (0..2001).map(|i| format!("a{i} = 1\n")).collect::<String>());
    let many = ["[1],", "1,"].map(|item| format!("a = [{}]", item.repeat(2_000_000)));
    for text in [long, wide].into_iter().chain(many) {
        let error = parse(&text, "big.toml", &[]).unwrap_err();
        assert_eq!((error.slug(), error.cure().is_some()), ("too-large", true));
    }
    let folder = std::env::temp_dir().join(format!("hydrocrane-chain-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    for i in 0..40 {
        std::fs::write(folder.join(format!("m{i}.toml")), format!("extends = \"m{}.toml\"\n", i + 1)).unwrap();
    }
    let error = load(&folder.join("m0.toml").display().to_string(), &[]).unwrap_err();
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(error.slug(), "too-large", "{error}");
}

#[test]
fn two_places_that_state_the_same_must_agree() {
    let overridden = |key: &str, value: &str, more: &str| {
        let text = scenario(more) + &format!("{}\n[overrides]\n\"{key}\" = \"{value}\"\n", "");
        parse_scenario(&text, "s.toml", &[])
    };
    for (key, value, more) in [
        ("payload.mass", "20 kg", "payload = \"10 kg\""),
        ("control.period", "20 ms", "[controller]\nperiod = \"10 ms\""),
    ] {
        let error = overridden(key, value, more).unwrap_err();
        assert_eq!(error.slug(), "conflicting-keys", "{error}");
        assert!(error.to_string().contains(key) && error.line().is_some(), "{error}");
    }
    assert!(overridden("payload.mass", "10 kg", "payload = \"0.01 t\"").is_ok());
    let phase = "[phase.late]\ntime = \"0.5 s\"\noverrides.\"payload.mass\" = \"5 kg\"";
    assert!(parse_scenario(&scenario(phase), "s.toml", &[]).unwrap_err().to_string().contains("[payload]"));
}

#[test]
fn a_later_override_counts_before_an_earlier_table() {
    let more =
        "[controller]\nperiod = \"10 ms\"\n[phase.late]\ntime = \"0.5 s\"\noverrides.\"control.period\" = \"5 ms\"";
    let found = parse_scenario(&scenario(more), "s.toml", &[]).unwrap();
    let then = found.stages()[1].controller.clone();
    assert_eq!((found.controller.unwrap().period, then.unwrap().period), (Some(0.01), None));
}

#[test]
fn one_kind_of_file_in_place_of_the_other_is_told() {
    let machine = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/two-telescopes.toml");
    let error = load_scenario(machine, &[]).unwrap_err();
    assert_eq!(error.slug(), "wrong-kind-of-file");
    assert!(error.to_string().contains("this is a machine file"), "{error}");
    let error = parse(&scenario(""), "s.toml", &[]).unwrap_err();
    assert!(error.to_string().contains("this is a scenario"), "{error}");
    let error = load_scenario("rottne-f9-lab", &[]).unwrap_err();
    assert!(error.to_string().contains("is a bundled machine"), "{error}");
}

#[test]
fn a_start_may_lie_where_the_longest_cylinder_reaches() {
    let file = |place: &str| {
        format!("[scenario]\nname = \"s\"\nmachine = \"rottne-f9-lab\"\nduration = \"1 s\"\n[initial.joint]\nextension = \"{place}\"\n")
    };
    let said = |place: &str| {
        let read = hydrocrane_machine::parse_scenario(&file(place), "s.toml", &[]);
        read.err().map_or(String::new(), |error| error.to_string())
    };
    assert!(!said("-1001 m").contains("beyond any use"), "{}", said("-1001 m"));
    assert!(said("-1e6 m").contains("beyond any use"), "{}", said("-1e6 m"));
}
