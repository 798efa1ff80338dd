//! Phases of a scenario: what is stated, what stays, what is wrong.

use hydrocrane_machine::scenario::StickMode;
use hydrocrane_machine::{parse_scenario, parse_scenario_with, MachineError, OverrideValue, Scenario};

const HEAD: &str = "[scenario]\nname = \"t\"\nmachine = \"rottne-f9-lab\"\nduration = \"9 s\"\n\
                    [controller]\nname = \"tip\"\ndelay = \"2 ms\"\n[joystick]\ntime = [\"0 s\"]\nz = [1]\n";

fn scenario(rest: &str) -> Result<Scenario, MachineError> {
    parse_scenario(&format!("{HEAD}{rest}"), "t.toml", &[])
}

fn error(rest: &str) -> MachineError {
    scenario(rest).expect_err(rest)
}

#[test]
fn a_phase_states_what_changes_and_the_rest_stays() {
    let s = scenario(
        "[phase.weak]\ntime = \"3 s\"\noverrides.\"supply.pressure\" = \"90 bar\"\n\
         [phase.levers]\ntime = \"1 s\"\n[phase.levers.joystick]\nmode = \"lever\"\ntime = [\"2 s\"]\nlift = [0.5]\n",
    )
    .unwrap();
    let [levers, weak] = &s.phases[..] else { panic!("{:?}", s.phases) };
    assert_eq!((levers.name.as_str(), levers.time, weak.time), ("levers", 1.0, 3.0), "in order of time");
    assert_eq!((&levers.controller, &weak.controller, &weak.joystick), (&None, &None, &None), "as they were stated");
    let stages = s.stages();
    let [_, levers_on, weak_on] = &stages[..] else { panic!("{stages:?}") };
    let choice = levers_on.controller.as_ref().unwrap();
    assert_eq!((choice.name.as_str(), choice.delay), ("lever", 0.002));
    assert_eq!(weak_on.controller, levers_on.controller);
    assert_eq!(weak_on.joystick, levers.joystick);
    assert_eq!(weak_on.overrides, weak.overrides);
    assert_eq!(weak.overrides, [("supply.pressure".to_string(), OverrideValue::Text("90 bar".into()))]);
    assert!(levers.overrides.is_empty());
}

#[test]
fn another_controller_without_its_stick_centres_it() {
    let s = scenario("[phase.a]\ntime = \"1 s\"\n[phase.a.controller]\nname = \"lever\"\n").unwrap();
    let stage = &s.stages()[1];
    assert_eq!((stage.controller.as_ref().unwrap().delay, stage.joystick.as_ref()), (0.0, None));
    let s = scenario("[phase.a]\ntime = \"1 s\"\n[phase.a.controller]\nname = \"heinze-pid\"\n").unwrap();
    assert_eq!(s.stages()[1].joystick.as_ref().unwrap().mode, StickMode::Tip);
}

#[test]
fn what_is_wrong_with_a_phase_is_told_at_its_place() {
    for (rest, slug, line) in [
        ("[phase.a]\n", "missing-key", 11),
        ("[phase.a]\ntime = \"0 s\"\n", "out-of-range", 12),
        ("[phase.a]\ntime = \"1 s\"\n[phase.b]\ntime = \"1 s\"\n", "bad-series", 14),
        ("[phase.a]\ntime = \"1 s\"\nsticks = 1\n", "unknown-key", 13),
        ("[phase.a]\ntime = \"1 s\"\noverrides.\"supply.presure\" = \"90 bar\"\n", "unknown-key", 13),
        ("[phase.a]\ntime = \"1 s\"\n[phase.a.joystick]\ntime = [\"0 s\"]\nlift = [1]\n", "unknown-key", 15),
    ] {
        let found = error(rest);
        assert_eq!((found.slug(), found.line()), (slug, Some(line)), "{found}");
    }
    let open_loop =
        "[scenario]\nname = \"t\"\nmachine = \"single-cylinder\"\nduration = \"1 s\"\n[phase.a]\ntime = \"1 s\"\n";
    let found = parse_scenario(open_loop, "t.toml", &[]).unwrap_err();
    assert_eq!((found.slug(), found.line()), ("conflicting-keys", Some(5)), "{found}");
}

/// Names and texts of files.
fn files(texts: &[(&str, &str)]) -> Vec<(String, String)> {
    texts.iter().map(|(name, text)| (name.to_string(), text.to_string())).collect()
}

const OWN: &str = "extends = \"rottne-f9-lab\"\n[supply]\nclass = \"setting\"\npressure = \"120 bar\"\n";

fn on_own(more: &str) -> String {
    HEAD.replace("\"rottne-f9-lab\"", &format!("\"./mine.toml\"\n{more}"))
}

#[test]
fn a_scenario_can_bring_its_machine() {
    let text = on_own("recorded-by = \"0.0.1\"");
    let s = parse_scenario_with(&text, "drive.toml", &files(&[("mine.toml", OWN)])).unwrap();
    assert_eq!((s.machine.as_str(), s.recorded.by.as_deref()), ("./mine.toml", Some("0.0.1")));
    let slip = files(&[("mine.toml", "extends = \"rottne-f9-lab\"\n[suply]\n")]);
    let slip = parse_scenario_with(&text, "drive.toml", &slip).unwrap_err();
    assert_eq!((slip.file(), slip.line()), (Some("mine.toml"), Some(2)));
}

#[test]
fn another_machine_does_not_take_the_place_of_the_one_that_a_scenario_names() {
    for there in [vec![], files(&[("other.toml", OWN)])] {
        let refused = parse_scenario_with(&on_own(""), "chosen.toml", &there).unwrap_err();
        assert_eq!((refused.file(), refused.key()), (Some("chosen.toml"), Some("scenario.machine")), "{refused}");
        assert!(refused.to_string().contains("mine.toml"), "{refused}");
    }
}

#[test]
fn a_machine_is_read_with_the_files_that_it_extends() {
    let own = "extends = \"base.toml\"\n";
    let both = files(&[("mine.toml", own), ("base.toml", OWN)]);
    assert!(parse_scenario_with(&on_own(""), "drive.toml", &both).is_ok());
    let whole = hydrocrane_machine::whole_text_of("mine.toml", &both).unwrap();
    let contents = |text: &str| hydrocrane_machine::parse(text, "m.toml", &[]).unwrap().contents();
    assert_eq!(contents(&whole), contents(OWN));
    assert_eq!(hydrocrane_machine::whole_text_of("base.toml", &both).unwrap(), OWN);
    let alone = parse_scenario_with(&on_own(""), "drive.toml", &files(&[("mine.toml", own)])).unwrap_err();
    assert!(alone.to_string().contains("base.toml"), "{alone}");
}

#[test]
fn a_recorded_drive_is_for_the_values_that_it_was_recorded_on() {
    let contents = hydrocrane_machine::parse(OWN, "mine.toml", &[]).unwrap().contents();
    let text = on_own(&format!("recorded-on = \"{contents}\""));
    let same = OWN.replace("\"120 bar\"", "\"12 MPa\"");
    assert!(parse_scenario_with(&text, "drive.toml", &files(&[("mine.toml", &same)])).is_ok());
    let other = OWN.replace("120", "60");
    let refused = parse_scenario_with(&text, "drive.toml", &files(&[("mine.toml", &other)])).unwrap_err();
    assert_eq!(refused.key(), Some("scenario.recorded-on"), "{refused}");
}

#[test]
fn sticks_can_take_over_from_spool_commands() {
    let head = "[scenario]\nname = \"t\"\nmachine = \"rottne-f9-lab\"\nduration = \"9 s\"\n\
                [command.lift]\ntime = [\"0 s\"]\nspool = [\"5 mm\"]\n";
    let phase = "[phase.hand]\ntime = \"2 s\"\n[phase.hand.joystick]\nmode = \"lever\"\ntime = [\"2 s\"]\nlift = [1]\n";
    let stages = parse_scenario(&format!("{head}{phase}"), "t.toml", &[]).unwrap().stages();
    assert_eq!((stages[0].controller.as_ref(), stages.len()), (None, 2));
    assert_eq!(stages[1].controller.as_ref().unwrap().name, "lever");
    let bare = parse_scenario(&format!("{head}[phase.hand]\ntime = \"2 s\"\n"), "t.toml", &[]).unwrap_err();
    assert!(bare.to_string().contains("spool commands move"), "{bare}");
}
