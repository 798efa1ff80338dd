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

#[test]
fn a_scenario_can_bring_the_text_of_its_machine() {
    let own = "extends = \"rottne-f9-lab\"\n[supply]\nclass = \"setting\"\npressure = \"120 bar\"\n";
    let text = HEAD.replace("\"rottne-f9-lab\"", "\"./mine.toml\"\nrecorded-by = \"0.0.1\"");
    let s = parse_scenario_with(&text, "drive.toml", Some(own), &[]).unwrap();
    assert_eq!((s.machine.as_str(), s.recorded_by.as_deref()), ("./mine.toml", Some("0.0.1")));
    let slip =
        parse_scenario_with(&text, "drive.toml", Some("extends = \"rottne-f9-lab\"\n[suply]\n"), &[]).unwrap_err();
    assert_eq!((slip.file(), slip.line()), (Some("./mine.toml"), Some(2)));
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
