//! The cockpit against the native run: a drive that is saved and simulated ends in the same place.

use crate::common::{built, index, opened, simulated, tip};
use hydrocrane_machine::scenario::{Interpolation, Scenario, Solver, Stage};
use hydrocrane_machine::{parse_scenario, parse_scenario_with, OverrideValue};
use hydrocrane_web::Cockpit;
use serde_json::{json, Value};

/// Period of the controllers in ticks.
const SAMPLE: u32 = 10;
/// Where the joints stand in the frames.
const JOINTS: usize = 8;

/// Ten seconds of a restless operator, told at odd instants, with a log taken up and let go: where the tip ends.
fn drive(cockpit: &mut Cockpit, description: &Value, axes: usize) -> [f64; 2] {
    let mut ticks = 0;
    for part in 0..143u32 {
        let deflections: Vec<f64> = (0..axes).map(|axis| (0.37 * f64::from(part) + axis as f64).sin() * 0.8).collect();
        cockpit.set_sticks(&deflections);
        match part {
            40 => cockpit.carry(60.0),
            90 => cockpit.carry(0.0),
            _ => {}
        }
        ticks += 67 + part % 7;
        assert!(cockpit.advance(67 + part % 7), "{}", cockpit.events());
    }
    assert!(cockpit.advance(SAMPLE - ticks % SAMPLE));
    let end = tip(cockpit, description);
    // The drive is written down until its last sample, which the next step takes.
    assert!(cockpit.advance(1));
    end
}

/// Drives, saves and simulates.
fn repeats(request: Value, axes: usize) {
    let (mut cockpit, description) = opened(request);
    let start = tip(&mut cockpit, &description);
    let driven = drive(&mut cockpit, &description, axes);
    let text = cockpit.save().expect("a drive from a fresh start");
    let (time, simulated) = simulated(&parse_scenario(&text, "drive.toml", &[]).expect("a scenario"));
    assert!(time > 9.9 && (driven[0] - start[0]).hypot(driven[1] - start[1]) > 0.01, "{time} {start:?} {driven:?}");
    assert_eq!(driven, simulated);
}

#[test]
fn a_saved_drive_of_the_tip_is_repeated_to_the_last_bit() {
    let machine =
        json!({ "machine": "rottne-f9-lab", "full-speed": 0.3, "payload": 20, "dead-zone": 0.05, "ramp": 0.2 });
    repeats(machine, 2);
}

#[test]
fn a_saved_drive_with_levers_real_sensors_and_changed_laws_is_repeated_too() {
    repeats(
        json!({
            "machine": "rottne-f9-lab", "controller": "lever", "real-sensors": true, "seed": 3, "friction": 1.5,
            "delay": 0.0023, "overrides": { "supply.pressure": 1.6e7 }, "joints": { "boom": 1.8 },
        }),
        3,
    );
}

#[test]
fn a_saved_drive_is_replayed_until_somebody_takes_over() {
    let (mut cockpit, description) =
        opened(json!({ "machine": "rottne-f9-lab", "full-speed": 0.3, "dead-zone": 0.05, "ramp": 0.2 }));
    let driven = drive(&mut cockpit, &description, 2);
    let text = cockpit.save().expect("a drive from a fresh start");
    let (mut again, told) = opened(json!({ "scenario": text }));
    assert_eq!(told["recorded-by"], told["version"]);
    let length = (1000.0 * parse_scenario(&text, "drive.toml", &[]).expect("a scenario").duration).round() as u32;
    // Hands that do not touch the sticks change nothing.
    again.set_sticks(&[0.0, 0.0]);
    assert!(again.advance(length));
    assert_eq!(tip(&mut again, &description), driven);
    assert!(again.advance(1), "the sample at the end");
    let (kept, mut saved) = (stick_of(&text), stick_of(&again.save().expect("the same drive")));
    // It goes on with the sticks let go.
    saved.time.truncate(kept.time.len());
    assert_eq!(saved.time, kept.time);

    let (mut other, _) = opened(json!({ "scenario": text }));
    other.advance(2000);
    assert_eq!(other.events()["replaying"], true);
    other.set_sticks(&[0.0, -1.0]);
    other.advance(2000);
    assert_eq!(other.events()["replaying"], false);
    let changed = parse_scenario(&other.save().expect("a drive"), "drive.toml", &[]).expect("a scenario");
    assert_eq!(changed.joystick.expect("one").axes[1].last(), Some(&-1.0));
    assert!(changed.load.changes.is_empty(), "the log of the replay was still to come");
}

/// Straight sticks in two phases, the second with levers and samples of its own rhythm.
const STRAIGHT: &str = r#"
[scenario]
name = "straight"
title = "Sticks that move in straight lines"
machine = "rottne-f9-lab"
duration = "6 s"
payload = "0 kg"

[initial]
pressures = "equilibrium"

[initial.joint]
boom = "100 deg"
jib = "100 deg"
extension = "0 m"

[controller]
name = "tip"

[joystick]
mode = "tip"
interpolation = "linear"
dead-zone = 0.05
ramp = "0.2 s"
time = ["0.123 s", "1.2 s", "5 s"]
x = [0.0, 0.4, -0.4]
z = [-0.3, 0.7, 0.1]

[phase.levers]
time = "2 s"

[phase.levers.controller]
name = "lever"
period = "7 ms"

[phase.levers.joystick]
mode = "lever"
interpolation = "linear"
time = ["2 s", "3 s", "6 s"]
lift = [0.0, 0.5, -0.5]
jib = [0.2, -0.3, 0.3]
extension = [0.0, 0.0, 0.3]
"#;

#[test]
fn straight_sticks_are_saved_as_they_are_and_as_samples_saw_them_where_somebody_took_over() {
    // Where somebody takes over (ms), a sample at the end (ms), and which phases are straight when they are saved.
    let cases =
        [(None, 4296, vec![true, true]), (Some(1300), 4300, vec![false]), (Some(3300), 4296, vec![true, false])];
    for (taken_over, end, straight) in cases {
        let (mut cockpit, _) = opened(json!({ "scenario": STRAIGHT }));
        if let Some(ticks) = taken_over {
            assert!(cockpit.advance(ticks), "{}", cockpit.events());
            cockpit.set_sticks(&[0.3, -0.6]);
        }
        assert!(cockpit.advance(end - taken_over.unwrap_or(0)), "{}", cockpit.events());
        let joints = cockpit.frame()[JOINTS..JOINTS + 3].to_vec();
        // The drive is written down until its last sample, which the next step takes.
        assert!(cockpit.advance(1));
        let text = cockpit.save().expect("straight sticks too");
        let scenario = parse_scenario(&text, "drive.toml", &[]).expect("a scenario");
        let later = scenario.phases.iter().filter_map(|phase| phase.joystick.as_ref());
        let sticks = scenario.joystick.iter().chain(later);
        assert_eq!(sticks.map(|s| s.interpolation == Interpolation::Linear).collect::<Vec<_>>(), straight);
        let (time, simulated) = simulated(&scenario);
        assert_eq!(time, f64::from(end) / 1000.0);
        assert_eq!(built("rottne-f9-lab", &[]).tip_in_plane(&joints), simulated, "{taken_over:?}");
    }
}

#[test]
fn a_phase_that_cannot_begin_ends_the_replay_with_the_reason_and_a_cure() {
    let text = STRAIGHT.replace(
        "[phase.levers.controller]",
        "[phase.levers.overrides]\n\"friction.lift.model\" = \"static\"\n\n[phase.levers.controller]",
    );
    let (mut cockpit, _) = opened(json!({ "scenario": text }));
    assert!(!cockpit.advance(3000));
    let ended = cockpit.events()["ended"].clone();
    let message = ended["message"].as_str().expect("a message");
    assert_eq!((ended["kind"].as_str(), ended["time"].as_f64()), (Some("bad-state"), Some(2.0)));
    assert!(
        message.contains("other states") && message.ends_with("move a stick before that time to take over"),
        "{message}"
    );
}

fn stick_of(text: &str) -> hydrocrane_machine::scenario::Joystick {
    parse_scenario(text, "drive.toml", &[]).expect("a scenario").joystick.expect("with a joystick")
}

fn bundled(name: &str) -> &'static str {
    let mut bundled = hydrocrane_machine::bundled_scenarios().iter();
    bundled.find(|(known, _)| *known == name).expect("a bundled scenario").1
}

/// Levers that are moved, on a crane that does not start at rest, with a wrong model, faults and an unusual monitor.
const EVERYTHING: &str = r#"
    [scenario]
    name = "everything"
    machine = "rottne-f9-lab"
    duration = "3 s"
    seed = 5
    [initial.joint]
    boom = "100 deg"
    jib = "100 deg"
    extension = "0 mm"
    [initial.pressure]
    lift = ["60 bar", "20 bar"]
    jib = ["40 bar", "40 bar"]
    extension = ["30 bar", "35 bar"]
    [supply]
    time = ["0 s", "0.4 s", "2 s"]
    pressure = ["150 bar", "110 bar", "130 bar"]
    [controller]
    name = "tip"
    monitor = "off"
    sensors = "data-sheet"
    [controller.model]
    "payload.mass" = "80 kg"
    [joystick]
    log = "sticks.csv"
    interpolation = "hold"
    [sensor-fault.angle]
    signal = "joint.boom.q"
    kind = "jump"
    size = "1 deg"
    from = "1 s"
    until = "2 s"
    [solver]
    method = "hc-rosenbrock-3"
    step = "1 ms"
"#;
const STICKS: &str = "time [s],x,z\n0,0.5,0\n0.7,0,0.4\n2,0,0\n";

/// Replays for `seconds`, saves, and simulates what was saved and what was replayed; all end in the same place.
fn replayed_and_saved(request: &Value, scenario: &Scenario) {
    let (mut cockpit, description) = opened(request.clone());
    let ticks = (1000.0 * scenario.duration).round() as u32;
    assert!(cockpit.advance(ticks), "{}", cockpit.events());
    let driven = tip(&mut cockpit, &description);
    assert_eq!(simulated(scenario), (scenario.duration, driven));
    let text = cockpit.save().expect("a drive");
    let saved = parse_scenario(&text, "drive.toml", &[]).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let start = |scenario: &Scenario| (scenario.initial.joints.clone(), scenario.initial.pressures.clone());
    assert_eq!((start(&saved), &saved.commands), (start(scenario), &scenario.commands));
    assert_eq!((&saved.faults.sensors, &saved.supply), (&scenario.faults.sensors, &scenario.supply));
    let written = |scenario: &Scenario| scenario.controller.clone().map(|choice| (choice.model, choice.monitor));
    assert_eq!(written(&saved), written(scenario));
    let to_its_end = Scenario { duration: saved.duration, ..scenario.clone() };
    assert_eq!(simulated(&saved), simulated(&to_its_end), "{text}");
}

#[test]
fn whatever_a_scenario_states_is_driven_and_saved() {
    let logs = [("sticks.csv".to_string(), STICKS.to_string())];
    let scenario = parse_scenario_with(EVERYTHING, "everything.toml", &logs).expect("a scenario");
    replayed_and_saved(&json!({ "scenario": EVERYTHING, "files": { "sticks.csv": STICKS } }), &scenario);

    let text = bundled("vertical-lift-open-loop");
    let solver = Solver { method: "hc-rosenbrock-3".into(), step: Some(1e-3), ..scenario.solver };
    let open_loop = Scenario { solver, ..parse_scenario(text, "open.toml", &[]).expect("a scenario") };
    replayed_and_saved(&json!({ "scenario": text }), &open_loop);
}

#[test]
fn what_no_knob_shows_stays_where_a_knob_is_turned_in_a_replay() {
    let request = json!({ "scenario": EVERYTHING, "files": { "sticks.csv": STICKS } });
    let (mut cockpit, told) = opened(request);
    assert!(cockpit.advance(500));
    let mut turned = told["request"].clone();
    turned["dead-zone"] = json!(0.1);
    turned["keep-state"] = json!(true);
    cockpit.open(&turned.to_string()).expect("the same machine");
    assert!(cockpit.advance(500), "{}", cockpit.events());
    let saved = parse_scenario(&cockpit.save().expect("a drive"), "drive.toml", &[]).expect("a scenario");
    let [first, second] = &saved.stages()[..] else { panic!("{:?}", saved.phases) };
    let kept = |stage: &Stage| stage.controller.clone().map(|choice| (choice.model, choice.monitor));
    assert_eq!(kept(second), kept(first));
    assert_eq!((second.joystick.as_ref().map(|stick| stick.dead_zone), saved.faults.sensors.len()), (Some(0.1), 1));
}

#[test]
fn levers_take_over_from_spool_commands() {
    let (mut cockpit, told) = opened(json!({ "scenario": bundled("vertical-lift-open-loop") }));
    assert_eq!(told["controller"], "lever");
    assert!(cockpit.advance(1000));
    assert_eq!(cockpit.events()["replaying"], true);
    cockpit.set_sticks(&[-0.5, 0.2, 0.0]);
    assert!(cockpit.advance(2000), "{}", cockpit.events());
    let (driven, told) = (tip(&mut cockpit, &told), cockpit.events());
    assert_eq!((&told["replaying"], told["changed"].is_null()), (&json!(false), false));
    let saved = parse_scenario(&cockpit.save().expect("a drive"), "drive.toml", &[]).expect("a scenario");
    assert_eq!((saved.commands.is_empty(), saved.phases.len()), (false, 1));
    let (_, again) = simulated(&Scenario { duration: 3.0, ..saved });
    let apart = (again[0] - driven[0]).hypot(again[1] - driven[1]);
    assert!(apart < 1e-4, "steps before the levers end elsewhere: {apart} m");
}

#[test]
fn a_scenario_that_cannot_be_driven_is_told_with_its_place() {
    let (mut cockpit, _) = opened(json!({ "machine": "single-cylinder" }));
    for (scenario, told) in [
        ("[scenario]\nname = 1\n".to_string(), "drive.toml:"),
        (EVERYTHING.to_string(), "sticks.csv"),
        (EVERYTHING.replace("sticks.csv", "sticks.mat"), "save sticks.mat as CSV"),
    ] {
        let problem = cockpit.open(&json!({ "scenario": scenario }).to_string()).expect_err("no drive");
        assert!(problem.message().contains(told), "{}", problem.message());
    }
}

/// A drive with two changes of mode, weaker supply, more friction and back, real sensors, and a load; where it ends.
fn switching(cockpit: &mut Cockpit) -> [f64; 2] {
    let settings = [
        json!({ "controller": "tip" }),
        json!({ "controller": "lever" }),
        json!({ "controller": "lever", "overrides": { "supply.pressure": 1.1e7 }, "friction": 1.7 }),
        json!({ "controller": "tip", "overrides": { "supply.pressure": 1.1e7 }, "real-sensors": true }),
        json!({ "controller": "tip", "overrides": { "control.tip.reserve": 0.2 }, "full-speed": 0.2 }),
    ];
    let mut description = Value::Null;
    for (part, setting) in settings.iter().enumerate() {
        let mut request = json!({
            "machine": "rottne-f9-lab", "full-speed": 0.3, "dead-zone": 0.05, "ramp": 0.3, "delay": 0.002, "seed": 4,
            "keep-state": true,
        });
        let wanted = setting.as_object().expect("settings").clone();
        request.as_object_mut().expect("an object").extend(wanted);
        let before = cockpit.frame().to_vec();
        description = cockpit.open(&request.to_string()).expect("the same machine");
        if part > 0 {
            let went = cockpit.frame()[0] - before[0];
            assert!(went > 0.0 && went < 0.0101, "a change waits for the next sample: {went}");
        }
        for move_ in 0..12u32 {
            cockpit
                .set_sticks(&[0, 1, 2].map(|axis| (1.3 * f64::from(move_ + 12 * part as u32) + f64::from(axis)).sin()));
            if (part, move_) == (2, 5) {
                cockpit.carry(50.0);
            }
            assert!(cockpit.advance(163 + move_), "{}", cockpit.events());
        }
    }
    let ticks = (1000.0 * cockpit.frame()[0]).round() as u32;
    assert!(cockpit.advance(SAMPLE - ticks % SAMPLE));
    let end = tip(cockpit, &description);
    assert!(cockpit.advance(1));
    end
}

#[test]
fn a_drive_with_changes_on_the_way_is_repeated_and_replayed_to_the_last_bit() {
    let mut cockpit = Cockpit::default();
    let driven = switching(&mut cockpit);
    let text = cockpit.save().expect("a drive in phases");
    let scenario = parse_scenario(&text, "drive.toml", &[]).expect("a scenario");
    assert_eq!(scenario.phases.len(), 4);
    assert_eq!(
        scenario.stages().iter().map(|stage| stage.controller.clone().map(|choice| choice.name)).collect::<Vec<_>>()
            [2..4],
        [Some("lever".to_string()), Some("tip".to_string())]
    );
    let (time, simulated) = simulated(&scenario);
    assert!(time > 9.9);
    assert_eq!(driven, simulated);

    let (mut again, told) = opened(json!({ "scenario": text }));
    assert_eq!(told["axes"].as_array().map(Vec::len), Some(2));
    let mut described = told.clone();
    let mut changes = 0;
    for _ in 0..(1000.0 * time).round() as u32 {
        assert!(again.advance(1), "{}", again.events());
        let news = again.events();
        if !news["changed"].is_null() {
            (described, changes) = (news["changed"].clone(), changes + 1);
        }
    }
    assert_eq!((changes, tip(&mut again, &described)), (4, driven));
    assert!(again.advance(1));
    let twice = parse_scenario(&again.save().expect("the same drive"), "drive.toml", &[]).expect("a scenario");
    assert_eq!(twice.phases.len(), 4);
    assert_eq!(self::simulated(&twice), (time, simulated));
}

#[test]
fn a_replay_in_phases_ends_where_somebody_takes_over() {
    let mut cockpit = Cockpit::default();
    switching(&mut cockpit);
    let (mut other, _) = opened(json!({ "scenario": cockpit.save().expect("a drive") }));
    other.advance(3000);
    assert_eq!(other.events()["changed"]["controller"], "lever");
    other.set_sticks(&[0.0, -1.0, 0.0]);
    assert!(other.advance(5000), "no phase of the replay is left");
    assert!(other.events()["changed"].is_null());
    let saved = parse_scenario(&other.save().expect("a drive"), "drive.toml", &[]).expect("a scenario");
    assert_eq!(saved.phases.len(), 1);
    assert!(saved.load.changes.is_empty());
}

#[test]
fn changes_while_nothing_moves_are_one_sample_apart() {
    let (mut cockpit, _) = opened(json!({ "machine": "rottne-f9-lab" }));
    for controller in ["lever", "tip", "lever"] {
        let request = json!({ "machine": "rottne-f9-lab", "controller": controller, "keep-state": true });
        cockpit.open(&request.to_string()).expect("the same machine");
    }
    assert!(cockpit.advance(500));
    let saved = parse_scenario(&cockpit.save().expect("a drive"), "drive.toml", &[]).expect("a scenario");
    assert_eq!(saved.phases.iter().map(|phase| phase.time).collect::<Vec<_>>(), [0.01, 0.02, 0.03]);
}

#[test]
fn another_machine_begins_anew() {
    let (mut cockpit, _) = opened(json!({ "machine": "rottne-f9-lab" }));
    cockpit.advance(500);
    let told = cockpit.open(&json!({ "machine": "hiab-xs031", "keep-state": true }).to_string()).expect("a machine");
    assert_eq!((told["continued"].as_bool(), cockpit.frame()[0]), (Some(false), 0.0));
}

#[test]
fn sticks_let_go_bring_the_valves_to_neutral() {
    let (mut cockpit, description) = opened(json!({ "machine": "rottne-f9-lab", "controller": "lever" }));
    let commands = ["lift", "jib", "extension"].map(|name| index(&description, &format!("command.{name}")));
    cockpit.set_sticks(&[0.5, f64::NAN, 7.0]);
    cockpit.advance(30);
    assert_eq!(commands.map(|at| cockpit.frame()[at]), [0.025, 0.0, 0.05]);
    cockpit.set_sticks(&[]);
    cockpit.advance(30);
    assert_eq!(commands.map(|at| cockpit.frame()[at]), [0.0; 3]);
}

#[test]
fn what_is_wrong_is_told_with_its_place_and_the_drive_at_hand_goes_on() {
    let (mut cockpit, _) = opened(json!({ "machine": "single-cylinder" }));
    let bad = "extends = \"rottne-f9-lab\"\n[suply]\npressure = \"90 bar\"\n";
    let problem = cockpit.open(&json!({ "machine": "my.toml", "text": bad }).to_string()).expect_err("a slip");
    assert_eq!(problem.line(), Some(2));
    assert!(problem.message().starts_with("my.toml:2:") && problem.message().contains("supply"), "{problem:?}");
    for (request, part) in [
        (json!({ "machine": "rottne" }), "rottne-f9-lab"),
        (json!({ "machine": "rottne-f9-lab", "controller": "pip" }), "lever"),
        (json!({ "machine": "rottne-f9-lab", "payload": -1 }), "zero or greater"),
        (json!({ "machine": "rottne-f9-lab", "joints": { "bom": 1 } }), "boom"),
        (json!({ "machine": "rottne-f9-lab", "friktion": 1 }), "friktion"),
        (json!({ "machine": "rottne-f9-lab", "overrides": { "supply.pressure": {} } }), "supply.pressure"),
        (json!({ "machine": "rottne-f9-lab", "joints": { "boom": 9 } }), "boom"),
    ] {
        let problem = cockpit.open(&request.to_string()).expect_err("it cannot be");
        assert!(problem.message().contains(part), "{request}: {problem:?}");
    }
    assert!(cockpit.open("nonsense").is_err() && cockpit.advance(10));
}

#[test]
fn every_bundled_machine_can_be_driven() {
    for (name, _) in hydrocrane_machine::bundled_machines() {
        for controller in ["lever", "tip"] {
            let (mut cockpit, description) = opened(json!({ "machine": name, "controller": controller }));
            cockpit.set_sticks(&[0.1; 6]);
            assert!(cockpit.advance(200), "{name} {controller}: {}", cockpit.events());
            let corners: u64 =
                description["shapes"].as_array().expect("a list").iter().filter_map(|s| s["points"].as_u64()).sum();
            let signals = description["signals"].as_array().expect("a list").len();
            let frame = cockpit.frame();
            assert_eq!(frame.len(), signals + 2 * corners as usize, "{name}");
            assert!(frame[signals..].iter().all(|corner| corner.is_finite()), "{name}");
        }
    }
}

#[test]
fn levers_that_hold_the_height_are_driven_saved_and_repeated_to_the_bit() {
    let (mut cockpit, description) = opened(json!({ "machine": "rottne-f9-lab", "controller": "height" }));
    assert_eq!(description["axes"], json!(["lift", "jib", "extension"]));
    assert!(description["gains"].as_array().is_some_and(|gains| !gains.is_empty()), "those of `tip`");
    cockpit.advance(500);
    let [x, z] = tip(&mut cockpit, &description);
    cockpit.set_sticks(&[0.0, 0.8, 0.0]);
    cockpit.advance(2000);
    cockpit.set_sticks(&[0.0; 3]);
    cockpit.advance(1501);
    let there = tip(&mut cockpit, &description);
    assert!((there[0] - x).abs() > 0.05 && (there[1] - z).abs() < 1e-3, "{there:?} from {x}, {z}");
    let saved = cockpit.save().expect("a drive");
    let (time, end) = simulated(&parse_scenario(&saved, "drive.toml", &[]).expect("a scenario"));
    let (mut replayed, description) = opened(json!({ "scenario": saved }));
    assert_eq!((&description["controller"], &description["axes"][1]), (&json!("height"), &json!("jib")));
    replayed.advance((1000.0 * time).round() as u32);
    assert_eq!(tip(&mut replayed, &description), end);
    // Whoever takes over has the levers in hand.
    replayed.set_sticks(&[0.0, -0.8, 0.0]);
    replayed.advance(1000);
    let back = tip(&mut replayed, &description);
    assert!((back[0] - x).abs() < (end[0] - x).abs() - 0.02 && (back[1] - z).abs() < 1e-3, "{back:?}");
}

#[test]
fn modes_that_a_machine_cannot_have_are_not_offered() {
    let mut cockpit = Cockpit::default();
    for (name, modes) in
        [("rig-kalmar", json!(["lever"])), ("hiab-xs031", json!(["tip", "heinze-pid", "height", "lever"]))]
    {
        let description = cockpit.open(&json!({ "machine": name }).to_string()).expect("a drive");
        assert_eq!(description["controllers"], modes, "{name}");
        assert_eq!(description["controller"], modes[0], "{name} begins in a mode that it has");
    }
    cockpit.open(&json!({ "machine": "rig-kalmar" }).to_string()).expect("a drive");
    cockpit.advance(10);
    let request = json!({ "machine": "rig-kalmar", "controller": "heinze-pid", "keep-state": true });
    let problem = cockpit.open(&request.to_string()).expect_err("one cylinder has no tip to steer");
    assert!(problem.message().contains("heinze-pid") && problem.message().contains("it has lever"), "{problem:?}");
}

#[test]
fn full_stick_is_what_the_machine_states_and_comfortable_where_it_states_nothing() {
    let own = "extends = \"rottne-f9-lab\"\n[control.tip]\nclass = \"setting\"\nfull-speed = \"0.12 m/s\"\n";
    for (request, speed) in [
        (json!({ "machine": "mine.toml", "text": own }), 0.12),
        (json!({ "machine": "mine.toml", "text": own, "full-speed": 0.5 }), 0.5),
        (json!({ "machine": "rottne-f9-lab" }), 0.15),
        (json!({ "machine": "rottne-f9-lab", "controller": "heinze-pid" }), 0.15),
    ] {
        let (_, description) = opened(request.clone());
        assert_eq!(description["full-speed"], speed, "{request}");
    }
}

/// Value that a machine key has on a drive at hand, SI.
fn coulomb(text: &str) -> f64 {
    let line = text.lines().find(|line| line.starts_with("\"friction.lift.coulomb\"")).expect("it is changed");
    line.split('"').nth(3).and_then(|value| value.split(' ').next()?.parse().ok()).unwrap_or_else(|| panic!("{line}"))
}

#[test]
fn the_friction_of_a_replay_is_the_level_that_was_set_and_further_levels_are_of_the_machine() {
    let request = json!({ "machine": "rottne-f9-lab", "full-speed": 0.3, "friction": 3.0 });
    let (mut cockpit, _) = opened(request);
    drive(&mut cockpit, &json!({ "signals": [{ "name": "tip.x" }, { "name": "tip.z" }] }), 2);
    let saved = cockpit.save().expect("a drive");
    let description = cockpit.open(&json!({ "scenario": saved }).to_string()).expect("a replay");
    assert_eq!(description["request"]["friction"], 3.0);
    cockpit.advance(50);
    assert_eq!(coulomb(&cockpit.save().expect("a drive")), coulomb(&saved), "to the last bit");
    let mut request = description["request"].clone();
    request["friction"] = json!(2.0);
    request["keep-state"] = json!(true);
    request["scenario"] = Value::Null;
    cockpit.open(&request.to_string()).expect("the knob");
    cockpit.advance(50);
    let text = cockpit.save().expect("a drive");
    let later = &text[text.find("[phase.1.overrides]").expect("a phase")..];
    assert!((coulomb(later) / coulomb(&saved) - 2.0 / 3.0).abs() < 1e-12, "{later}");
}

#[test]
fn every_machine_drives_without_friction() {
    for (name, _) in hydrocrane_machine::bundled_machines() {
        let request = json!({ "machine": name, "controller": "lever", "friction": 0.0 });
        let (mut cockpit, description) = opened(request);
        cockpit.set_sticks(&vec![0.3; description["cylinders"].as_array().map_or(1, Vec::len)]);
        assert!(cockpit.advance(1000), "{name}: {}", cockpit.events());
        for (i, signal) in description["signals"].as_array().expect("a list").iter().enumerate() {
            let name_of_it = signal["name"].as_str().expect("a name");
            let of_the_crane = name_of_it.starts_with("joint.") || name_of_it.starts_with("cylinder.");
            assert!(cockpit.frame()[i].is_finite() || !of_the_crane, "{name}: {name_of_it}");
        }
    }
}

#[test]
fn a_knob_counts_before_an_override_of_the_same_key_and_a_saved_drive_states_it_once() {
    let (mut cockpit, _) = opened(json!({
        "machine": "rottne-f9-lab", "friction": 1.5, "full-speed": 0.3,
        "overrides": { "friction.lift.coulomb": 100.0, "control.tip.full-speed": 0.5 },
    }));
    cockpit.set_sticks(&[0.5, 0.5]);
    assert!(cockpit.advance(50));
    let saved = cockpit.save().expect("a drive");
    assert_eq!(coulomb(&saved), 150.0);
    let scenario = parse_scenario(&saved, "drive.toml", &[]).expect("each key once");
    let speeds: Vec<_> = scenario.overrides.iter().filter(|(key, _)| key == "control.tip.full-speed").collect();
    assert_eq!(speeds, [&("control.tip.full-speed".to_string(), OverrideValue::Text("0.3 m/s".into()))]);
}
