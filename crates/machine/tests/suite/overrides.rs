//! Extending, overriding, provenance.

use hydrocrane_machine::model::ProvenanceClass::{self, *};
use hydrocrane_machine::model::{FrictionModel, Provenance};
use hydrocrane_machine::{load, load_scenario, parse, parse_scenario, Machine, MachineError, OverrideValue};

fn with(key: &str, value: OverrideValue) -> Result<Machine, MachineError> {
    load("rottne-f9-lab", &[(key.into(), value)])
}

fn text(value: &str) -> OverrideValue {
    OverrideValue::Text(value.into())
}

fn entry<'a>(machine: &'a Machine, key: &str) -> &'a Provenance {
    machine.provenance.iter().find(|entry| entry.key == key).unwrap_or_else(|| panic!("no entry for {key}"))
}

fn tally(machine: &Machine, class: ProvenanceClass) -> usize {
    machine.provenance.iter().filter(|entry| entry.class == class).count()
}

#[test]
fn numbers_are_si_and_texts_carry_units() {
    assert_eq!(with("supply.pressure", OverrideValue::Number(1e7)).unwrap().supply.pressure, 1e7);
    assert_eq!(with("supply.pressure", text("100 bar")).unwrap().supply.pressure, 1e7);
    assert_eq!(with("supply.pressure", text("100")).unwrap_err().slug(), "missing-unit");
}

#[test]
fn points_and_pairs_may_be_lists_of_numbers() {
    let pair = OverrideValue::List(vec![OverrideValue::Number(0.5), OverrideValue::Number(-0.25)]);
    let crane = with("link.extension.point.tip", pair).unwrap();
    assert_eq!(crane.tip.position, [0.5, -0.25]);
    let pair = OverrideValue::List(vec![OverrideValue::Number(100.0), text("0.2 kN")]);
    assert_eq!(with("friction.lift.coulomb", pair).unwrap().cylinders[0].friction.coulomb, [100.0, 200.0]);
}

#[test]
fn a_switch_and_a_model_may_be_overridden() {
    assert!(!with("errata.orifice-law", text("as-printed")).unwrap().errata.orifice_law);
    let crane = with("friction.lift.model", text("static")).unwrap();
    assert_eq!(crane.cylinders[0].friction.model, FrictionModel::Static);
    assert_eq!(crane.cylinders[0].friction.bristle_stiffness, 0.0);
}

#[test]
fn a_misspelt_override_names_itself() {
    let error = with("supply.presure", OverrideValue::Number(1e7)).unwrap_err();
    let message = error.to_string();
    assert_eq!(
        message,
        "override \"supply.presure\": [unknown-key] supply.presure: unknown key; did you mean `pressure`?"
    );
    assert_eq!((error.line(), error.file()), (None, None));
}

#[test]
fn overrides_that_miss_the_tree_are_errors() {
    for (key, slug) in [
        ("supply", "wrong-type"),
        ("supply.pressure.pump", "wrong-type"),
        ("", "unknown-key"),
        ("supply..pressure", "unknown-key"),
        ("cylinder.fourth.bore", "unknown-reference"),
    ] {
        assert_eq!(with(key, OverrideValue::Number(1.0)).unwrap_err().slug(), slug, "{key}");
    }
    assert_eq!(with("supply.pressure", OverrideValue::Bool(true)).unwrap_err().slug(), "wrong-type");
    assert_eq!(with("payload.mass", OverrideValue::Number(f64::NAN)).unwrap_err().slug(), "not-finite");
    assert_eq!(with("payload.mass", OverrideValue::Number(-1.0)).unwrap_err().slug(), "out-of-range");
}

#[test]
fn an_overridden_value_is_a_setting_of_the_caller() {
    let crane = with("cylinder.lift.bore", text("110 mm")).unwrap();
    let bore = entry(&crane, "cylinder.lift.bore");
    assert_eq!((bore.class, bore.source.as_str()), (Setting, "override"));
}

#[test]
fn class_and_source_come_from_the_nearest_table_above() {
    let crane = load("rottne-f9-lab", &[]).unwrap();
    // Machine, table, value.
    assert_eq!(entry(&crane, "link.boom.mass").class, Literature);
    assert_eq!(entry(&crane, "friction.extension.coulomb").class, Fitted);
    assert_eq!(entry(&crane, "friction.extension.coulomb").source, "Heinze (2007), Table 3, Rottne 0 kg");
    let damping = entry(&crane, "friction.extension.bristle-damping");
    assert_eq!(damping.class, Assumed);
    assert!(damping.source.starts_with("critical damping"));
    // A value that states its source alone keeps the class above.
    assert_eq!(entry(&crane, "friction.extension.bristle-stiffness").class, Fitted);
}

#[test]
fn provenance_lists_each_value_once_in_file_order() {
    let crane = load("rottne-f9-lab", &[]).unwrap();
    let keys: Vec<&str> = crane.provenance.iter().map(|entry| entry.key.as_str()).collect();
    let place = |key: &str| keys.iter().position(|other| *other == key).unwrap();
    assert!(place("environment.gravity") < place("link.boom.mass"));
    assert!(place("link.boom.mass") < place("cylinder.lift.bore"));
    assert!(place("cylinder.lift.bore") < place("supply.pressure"));
    let unique: std::collections::BTreeSet<&str> = keys.iter().copied().collect();
    assert_eq!(unique.len(), keys.len());
    let classes = [Measured, Fitted, Literature, Assumed, Setting];
    assert_eq!(classes.map(|class| tally(&crane, class)).iter().sum::<usize>(), keys.len());
    // The certificates of three load cells, linearity and sensitivity each.
    assert_eq!(tally(&crane, Measured), 6);
}

#[test]
fn every_value_is_kept_in_si() {
    let crane = with("supply.pressure", text("100 bar")).unwrap();
    let kept = |key: &str| (entry(&crane, key).value.si.clone(), entry(&crane, key).value.units[0].clone());
    assert_eq!(kept("supply.pressure"), (vec![1e7], "Pa".into()));
    assert_eq!(kept("friction.lift.coulomb"), (crane.cylinders[0].friction.coulomb.to_vec(), "N".into()));
    assert_eq!(kept("link.boom.centre-of-gravity"), (crane.links[1].centre_of_gravity.to_vec(), "m".into()));
    assert!(crane.provenance.iter().all(|p| !p.value.si.is_empty() && p.value.si.iter().all(|v| v.is_finite())));
}

#[test]
fn a_file_that_extends_keeps_the_provenance_of_what_it_extends() {
    let printed = load("heinze-2007", &[]).unwrap();
    assert_eq!(entry(&printed, "supply.pressure").class, Setting);
    assert_eq!(entry(&printed, "friction.extension.coulomb").class, Literature);
    assert_eq!(entry(&printed, "friction.extension.coulomb").source, "Heinze (2007), section 7.2, program CRANE_MAIN");
    assert_eq!(entry(&printed, "link.boom.mass").source, "Heinze (2007), section 7.3, program DIMENSION");
}

#[test]
fn tables_merge_key_by_key() {
    let heavier =
        "extends = \"single-cylinder\"\n[link.mass.body.load]\nmass = { value = \"200 kg\", class = \"setting\" }";
    let machine = parse(heavier, "heavier", &[]).unwrap();
    assert!((machine.links[1].mass - 205.173).abs() < 1e-9);
    assert_eq!(machine.cylinders[0].bore, 0.05);
    assert_eq!(machine.name, "single-cylinder");
}

#[test]
fn an_error_in_an_extended_file_shows_that_file() {
    let error = parse("extends = \"rottne-f9-lab\"\n[link.boom]\nmass = \"0 kg\"", "mine.toml", &[]).unwrap_err();
    assert_eq!((error.file(), error.line()), (Some("mine.toml"), Some(3)));
    let error = load("heinze-2007", &[("cylinder.lift.rod".into(), text("boom.rod"))]).unwrap_err();
    assert!(error.to_string().starts_with("override \"cylinder.lift.rod\": [unknown-reference]"), "{error}");
}

#[test]
fn as_printed_needs_a_printed_value() {
    for key in ["orifice-law", "extension-leakage", "extension-dead-volume", "leakage-viscosity"] {
        let overrides = [(format!("errata.{key}"), text("as-printed"))];
        assert_eq!(load("hiab-xs031", &overrides).unwrap_err().slug(), "conflicting-keys", "{key}");
        assert!(load("rottne-f9-lab", &overrides).is_ok(), "{key}");
    }
}

fn scenario(body: &str) -> Result<hydrocrane_machine::Scenario, MachineError> {
    let head = "[scenario]\nname = \"s\"\nmachine = \"single-cylinder\"\nduration = \"1 s\"\n";
    parse_scenario(&format!("{head}{body}"), "s.toml", &[])
}

#[test]
fn a_scenario_s_overrides_reach_the_machine() {
    let flat = scenario("[overrides]\n\"supply.pressure\" = \"100 bar\"").unwrap();
    let nested = scenario("[overrides]\nsupply.pressure = \"100 bar\"").unwrap();
    assert_eq!(flat.overrides, [("supply.pressure".to_string(), text("100 bar"))]);
    assert_eq!(flat.overrides, nested.overrides);
    let error = scenario("[overrides]\n\"supply.pressure\" = \"100 m\"").unwrap_err();
    assert_eq!((error.slug(), error.line(), error.column()), ("wrong-dimension", Some(6), Some(21)));
    assert_eq!(scenario("[overrides]\n\"supply.pressure\" = 100").unwrap_err().slug(), "missing-unit");
}

#[test]
fn a_scenario_is_checked_against_its_machine() {
    for (body, slug, line) in [
        ("[initial.joint]\nslid = \"1 mm\"", "unknown-reference", 6),
        ("[initial.joint]\nslide = \"1 deg\"", "wrong-dimension", 6),
        ("[command.tset]\ntime = [\"0 s\"]\nspool = [\"1 mm\"]", "unknown-reference", 5),
        ("[command.test]\ntime = [\"0 s\"]\nspool = [\"60 mm\"]", "out-of-range", 7),
        ("[command.test]\ntime = [\"0 s\"]\nspool = [\"6 mm\", \"7 mm\"]", "bad-series", 7),
        ("[command.test]\ntime = []\nspool = []", "bad-series", 6),
        ("[initial.pressure]\ntest = [\"1 bar\"]", "wrong-type", 6),
        ("[solver]\nmethod = \"euler\"", "invalid-choice", 6),
    ] {
        let error = scenario(body).unwrap_err();
        assert_eq!((error.slug(), error.line()), (slug, Some(line)), "{error}");
    }
}

#[test]
fn a_caller_may_override_a_scenario() {
    let overrides = [("scenario.duration".to_string(), OverrideValue::Number(2.0))];
    assert_eq!(load_scenario("single-cylinder-step", &overrides).unwrap().duration, 2.0);
    let overrides = [("scenario.seed".to_string(), OverrideValue::Number(1.5))];
    assert_eq!(load_scenario("single-cylinder-step", &overrides).unwrap_err().slug(), "out-of-range");
}

#[test]
fn a_scenario_with_an_unknown_machine_points_at_the_name() {
    let error = parse_scenario("[scenario]\nname = \"s\"\nmachine = \"rotne-f9-lab\"", "s.toml", &[]).unwrap_err();
    assert_eq!((error.slug(), error.line(), error.column()), ("unknown-source", Some(3), Some(11)));
}
