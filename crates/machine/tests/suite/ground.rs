//! `[ground]`, its supports, and how loads hang.

use hydrocrane_machine::model::{Ground, Payload};
use hydrocrane_machine::{parse, Machine, MachineError, OverrideValue};

fn machine(rest: &str) -> Result<Machine, MachineError> {
    parse(&format!("extends = \"rottne-f9-lab\"\n[machine]\nclass = \"setting\"\n{rest}"), "own.toml", &[])
}

fn ground(rest: &str) -> Option<Ground> {
    machine(rest).unwrap_or_else(|error| panic!("{error}")).ground
}

#[test]
fn a_height_is_enough_and_the_soil_is_firm() {
    assert_eq!(ground(""), None);
    let plain = ground("[ground]\nheight = \"-1.21 m\"\n").unwrap();
    assert_eq!((plain.height, plain.stiffness, plain.damping, plain.friction), (-1.21, 2e5, 5.0, 0.5));
    assert!(plain.supports.is_empty());
    let own = "stiffness = \"50 kN/m\"\ndamping = \"2 s/m\"\nfriction = 0.3\n";
    let soft = ground(&format!("[ground]\nheight = \"0 m\"\n{own}")).unwrap();
    assert_eq!((soft.stiffness, soft.damping, soft.friction), (5e4, 2.0, 0.3));
    assert_eq!(ground("[ground]\nheight = \"0 m\"\nstatus = \"inactive\"\n"), None);
}

const BUNK: &str =
    "[ground]\nheight = \"-1.21 m\"\n[ground.support.bunk]\nheight = \"-860 mm\"\nfrom = \"1.4 m\"\nto = \"2 m\"\n";

#[test]
fn supports_stand_on_the_ground() {
    let [bunk] = &ground(BUNK).unwrap().supports[..] else { panic!("one support") };
    assert_eq!((bunk.name.as_str(), bunk.height, bunk.from, bunk.to, bunk.edge), ("bunk", -0.86, 1.4, 2.0, 0.1));
    assert!(ground(&format!("{BUNK}status = \"inactive\"\n")).unwrap().supports.is_empty());
    let changed = |key: &str, value: f64| {
        let text = format!("extends = \"rottne-f9-lab\"\n[machine]\nclass = \"setting\"\n{BUNK}");
        parse(&text, "own.toml", &[(key.to_string(), OverrideValue::Number(value))])
    };
    let cases =
        [("height", -1.5, "below the ground"), ("to", 1.0, "exchange `from` and `to`"), ("edge", 0.0, "greater")];
    for (key, value, part) in cases {
        let error = changed(&format!("ground.support.bunk.{key}"), value).unwrap_err();
        assert_eq!(error.slug(), "out-of-range");
        assert!(error.to_string().contains(part), "{error}");
    }
    // A request may add one of its own.
    let more: Vec<(String, OverrideValue)> = ["height", "from", "to"]
        .into_iter()
        .zip([0.5, 3.0, 4.0])
        .map(|(key, value)| (format!("ground.support.box.{key}"), OverrideValue::Number(value)))
        .collect();
    let text = format!("extends = \"rottne-f9-lab\"\n[machine]\nclass = \"setting\"\n{BUNK}");
    assert_eq!(parse(&text, "own.toml", &more).unwrap().ground.unwrap().supports.len(), 2);
}

#[test]
fn what_is_wrong_with_the_ground_is_told_with_its_place() {
    let slug = |rest: &str| machine(rest).expect_err(rest).slug();
    assert_eq!(slug("[ground]\nstiffness = \"200 kN/m\"\n"), "missing-key");
    assert_eq!(slug("[ground]\nheight = 1\n"), "missing-unit");
    assert_eq!(slug("[ground]\nheight = \"0 m\"\nstiffness = \"200 kN\"\n"), "wrong-dimension");
    assert_eq!(slug("[ground]\nheight = \"0 m\"\nstiffness = \"0 N/m\"\n"), "out-of-range");
    assert_eq!(slug("[ground]\nheight = \"0 m\"\ndamping = \"-1 s/m\"\n"), "out-of-range");
    assert_eq!(slug("[ground]\nheight = \"0 m\"\nstatus = \"of\"\n"), "invalid-choice");
    assert_eq!(slug("[ground]\nheigth = \"0 m\"\n"), "unknown-key");
    let five: String = (0..5)
        .map(|i| format!("[ground.support.s{i}]\nheight = \"1 m\"\nfrom = \"{i} m\"\nto = \"{i}.5 m\"\n"))
        .collect();
    assert_eq!(slug(&format!("[ground]\nheight = \"0 m\"\n{five}")), "too-large");
    let error =
        machine("[ground]\nheight = \"-1 m\"\n[ground.support.b]\nheight = \"-2 m\"\nfrom = \"0 m\"\nto = \"1 m\"\n");
    assert_eq!(error.unwrap_err().line(), Some(7));
}

#[test]
fn loads_hang_as_far_down_as_the_file_says() {
    let load = |rest: &str| machine(rest).unwrap_or_else(|error| panic!("{error}")).payload;
    assert_eq!(load(""), Payload { mass: 0.0, hang: 0.0, hang_growth: 0.0, tool: "grapple" });
    let hung = load("[payload]\nhang = \"32 cm\"\nhang-growth = \"0.044 m/kg^0.5\"\n");
    assert_eq!((hung.hang, hung.hang_growth), (0.32, 0.044));
}
