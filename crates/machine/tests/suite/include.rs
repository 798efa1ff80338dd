//! `include`: tables of other files laid over a machine file.

use std::fs;
use std::path::PathBuf;

use hydrocrane_machine::model::ProvenanceClass;
use hydrocrane_machine::{load, Machine, MachineError};

const FITTED: &str = "[friction.test]\nclass = \"fitted\"\nsource = \"a.csv\"\ncoulomb = [\"111 N\", \"222 N\"]\n";

/// A folder of files of its own, for a test.
fn folder(test: &str, files: &[(&str, &str)]) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("hydrocrane-include-{}-{test}", std::process::id()));
    for (name, text) in files {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    folder
}

fn loaded(test: &str, files: &[(&str, &str)]) -> Result<Machine, MachineError> {
    let folder = folder(test, files);
    let machine = load(folder.join("mine.toml").to_str().unwrap(), &[]);
    fs::remove_dir_all(folder).unwrap();
    machine
}

#[test]
fn a_key_of_the_whole_file_in_a_table_is_told_where_it_belongs() {
    for key in ["extends = \"rig-rottne\"", "include = [\"friction.toml\"]"] {
        let text = format!("[machine]\nname = \"mine\"\n{key}\n");
        let error = hydrocrane_machine::parse(&text, "mine.toml", &[]).unwrap_err().to_string();
        assert!(error.contains("above the first table of a machine file"), "{error}");
    }
}

#[test]
fn what_is_included_lies_over_the_file_and_what_it_extends() {
    let own = "include = [\"parts/friction.toml\"]\nextends = \"rig-rottne\"\n\
               [friction.test]\ncoulomb = { value = \"5 N\", class = \"assumed\" }\n";
    let machine = loaded("over", &[("mine.toml", own), ("parts/friction.toml", FITTED)]).unwrap();
    let friction = &machine.cylinders[0].friction;
    assert_eq!(friction.coulomb, [111.0, 222.0]);
    assert_eq!(friction.breakaway, [340.0, 400.0], "keys that are not included stay");
    let origin = machine.provenance.iter().find(|p| p.key == "friction.test.coulomb").unwrap();
    assert_eq!((origin.class, origin.source.as_str()), (ProvenanceClass::Fitted, "a.csv"));
}

#[test]
fn later_files_lie_over_earlier_ones() {
    let own = "extends = \"rig-rottne\"\ninclude = [\"a.toml\", \"b.toml\"]\n";
    let second = FITTED.replace("111", "11");
    let files = [("mine.toml", own), ("a.toml", FITTED), ("b.toml", second.as_str())];
    assert_eq!(loaded("later", &files).unwrap().cylinders[0].friction.coulomb, [11.0, 222.0]);
}

#[test]
fn a_file_that_is_extended_may_include() {
    let files = [
        ("mine.toml", "extends = \"base/rig.toml\"\n"),
        ("base/rig.toml", "extends = \"rig-rottne\"\ninclude = [\"friction.toml\"]\n"),
        ("base/friction.toml", FITTED),
    ];
    assert_eq!(loaded("base", &files).unwrap().cylinders[0].friction.coulomb, [111.0, 222.0]);
}

#[test]
fn errors_name_the_included_file_or_the_line_that_includes_it() {
    let own = "extends = \"rig-rottne\"\ninclude = [\"friction.toml\"]\n";
    let with = |test: &str, text: &str| loaded(test, &[("mine.toml", own), ("friction.toml", text)]).unwrap_err();
    let wrong = with("value", &FITTED.replace("222 N", "222 m"));
    assert!(wrong.file().unwrap().ends_with("friction.toml"), "{wrong}");
    assert_eq!((wrong.slug(), wrong.line()), ("wrong-dimension", Some(4)));
    let stranger = with("stranger", &FITTED.replace("test", "tset"));
    assert!(stranger.to_string().contains("friction.tset"), "{stranger}");
    let nested = with("nested", &format!("include = [\"x.toml\"]\n{FITTED}"));
    assert_eq!((nested.slug(), nested.line()), ("conflicting-keys", Some(1)));
    let missing = loaded("missing", &[("mine.toml", own)]).unwrap_err();
    assert!(missing.file().unwrap().ends_with("mine.toml"), "{missing}");
    assert_eq!((missing.slug(), missing.line()), ("unreadable-file", Some(2)));
    for list in ["\"friction.toml\"", "[1]"] {
        let text = format!("extends = \"rig-rottne\"\ninclude = {list}\n");
        assert_eq!(loaded("list", &[("mine.toml", &text)]).unwrap_err().slug(), "wrong-type");
    }
}

#[test]
fn a_file_does_without_keys_of_the_one_it_extends() {
    let own = "extends = \"hiab-xs031\"\nwithout = [\"valve.lift.nominal-edge-pressure-drop\"]\n\
               [valve.lift]\nclass = \"assumed\"\nnominal-pressure-drop = \"20 bar\"\n";
    let machine = loaded("without", &[("mine.toml", own)]).unwrap();
    assert!(machine.provenance.iter().any(|p| p.key == "valve.lift.nominal-pressure-drop"));
    assert!(machine.provenance.iter().all(|p| p.key != "valve.lift.nominal-edge-pressure-drop"));
    for (text, slug) in [
        ("extends = \"rig-rottne\"\nwithout = [\"valve.tset.overlap\"]\n", "unknown-reference"),
        ("extends = \"rig-rottne\"\nwithout = [\"valve.test.stroke.x\"]\n", "unknown-reference"),
        ("extends = \"rig-rottne\"\nwithout = [1]\n", "wrong-type"),
        ("without = [\"valve\"]\n", "conflicting-keys"),
    ] {
        assert_eq!(loaded("without-nothing", &[("mine.toml", text)]).unwrap_err().slug(), slug, "{text}");
    }
}

#[test]
fn names_and_texts_have_no_control_characters() {
    for text in ["[machine]\nname = \"a\\u0001b\"\n", "[link.base.point]\n\"a\\u0007\" = \"(0, 0) m\"\n"] {
        let own = format!("extends = \"rig-rottne\"\n{text}");
        assert_eq!(loaded("control", &[("mine.toml", &own)]).unwrap_err().slug(), "not-text", "{text}");
    }
}
