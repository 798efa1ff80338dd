//! Hoses that burst during a drive: the run of the same scenario, whatever the operator does beside it.

use crate::common::{index, opened, simulated, tip};
use hydrocrane_machine::parse_scenario;
use hydrocrane_machine::scenario::{Burst, Faults, Scenario, Side};
use serde_json::{json, Value};

const TIP: &str = r#"
    [scenario]
    name = "torn"
    machine = "rottne-f9-lab"
    duration = "2 s"
    [initial.joint]
    boom = "100 deg"
    jib = "100 deg"
    extension = "0 mm"
    [controller]
    name = "tip"
    [joystick]
    time = ["0 s", "1 s"]
    x = [0.0, 0.3]
    z = [0.2, 0.0]
    [burst.lift]
    cylinder = "lift"
    side = "piston-side"
    time = "0.7034 s"
    opening = "20 mm^2"
    [burst.jib]
    cylinder = "jib"
    side = "rod-side"
    time = "1.3 s"
    opening = "3 mm^2"
    [solver]
    method = "hc-rosenbrock-3"
    step = "1 ms"
"#;
/// The second hose bursts in it.
const PHASE: &str = "[phase.weak]\ntime = \"1 s\"\noverrides = { supply.pressure = \"100 bar\" }\n";
const LOST: [&str; 2] = ["cylinder.lift.lost1", "cylinder.jib.lost2"];

fn read(text: &str) -> Scenario {
    parse_scenario(text, "torn.toml", &[]).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn torn() -> [Burst; 2] {
    let burst = |cylinder: &str, side, time, opening| Burst { cylinder: cylinder.into(), side, time, opening };
    [burst("lift", Side::Piston, 0.7034, 20e-6), burst("jib", Side::Rod, 1.3, 3e-6)]
}

#[test]
fn a_replay_lets_hoses_burst_as_a_run_does_and_is_saved_with_them() {
    let commanded = TIP.split("[controller]").next().expect("a head").to_string()
        + "[command.lift]\ntime = [\"0 s\", \"0.5 s\"]\nspool = [\"0 mm\", \"0.5 mm\"]\n"
        + &TIP[TIP.find("[burst.lift]").expect("a burst")..];
    for text in [TIP.to_string(), TIP.to_string() + PHASE, commanded] {
        let scenario = read(&text);
        let (mut cockpit, told) = opened(json!({ "scenario": text }));
        let lost = LOST.map(|name| index(&told, name));
        for (until, torn) in [(0.703, 0), (1.0, 1), (1.299, 1), (1.302, 2)] {
            let ticks = (1e3 * (until - cockpit.frame()[0])).round() as u32;
            assert!(cockpit.advance(ticks), "{}", cockpit.events());
            let frame = cockpit.frame();
            assert_eq!(lost.map(|i| frame[i] > 0.0), [torn > 0, torn > 1], "{until}: {}", frame[0]);
        }
        assert!(cockpit.advance(698), "{}", cockpit.events());
        let driven = tip(&mut cockpit, &told);
        assert_eq!(simulated(&scenario), (2.0, driven));
        assert!(cockpit.events()["events"]
            .as_array()
            .expect("a list")
            .iter()
            .any(|event| event["warning"] == "oil-lost"));

        let saved = read(&cockpit.save().expect("a drive"));
        assert_eq!(saved.faults.bursts, torn());
        assert!(saved.overrides.iter().all(|(key, _)| !key.starts_with("hose-leak")), "{:?}", saved.overrides);
        let to_its_end = Scenario { duration: saved.duration, ..scenario };
        assert_eq!(simulated(&saved), simulated(&to_its_end));
    }
}

#[test]
fn hoses_burst_beside_an_operator_and_stay_torn_when_a_knob_is_turned() {
    let request = json!({
        "machine": "rottne-f9-lab", "joints": { "boom": 1.745, "jib": 1.745, "extension": 0.0 }, "full-speed": 0.3,
        "bursts": [["lift", "piston-side", 0.7034, 20e-6], ["jib", "rod-side", 1.3, 3e-6]],
    });
    let (mut cockpit, told) = opened(request.clone());
    assert_eq!(told["request"]["bursts"], request["bursts"]);
    cockpit.set_sticks(&[0.1, 0.4]);
    assert!(cockpit.advance(500));
    for at in [100, 400] {
        assert!(cockpit.advance(at));
        // Whoever asks for a change of a knob does not mend the hoses by leaving them out.
        let turned =
            json!({ "controller": "lever", "dead-zone": 1e-4 * f64::from(at), "keep-state": true, "bursts": [] });
        let mut all = request.clone();
        all.as_object_mut().expect("an object").extend(turned.as_object().expect("settings").clone());
        let description = cockpit.open(&all.to_string()).expect("the same machine");
        assert_eq!(description["continued"], true);
    }
    cockpit.set_sticks(&[0.2, -0.1, 0.0]);
    let ticks = (1000.0 * (2.0 - cockpit.frame()[0])).round() as u32;
    assert!(cockpit.advance(ticks), "{}", cockpit.events());
    let (driven, frame) = (tip(&mut cockpit, &told), cockpit.frame().to_vec());
    assert!(LOST.iter().all(|name| frame[index(&told, name)] > 0.0));
    assert!(cockpit.advance(1));
    let saved = read(&cockpit.save().expect("a drive"));
    assert_eq!((saved.phases.len(), &saved.faults.bursts[..]), (2, &torn()[..]));
    assert_eq!(simulated(&saved), (2.0, driven));
    let mended = simulated(&Scenario { faults: Faults::default(), ..saved }).1;
    assert!(mended[1] - driven[1] > 0.01, "{mended:?} {driven:?}");
}

#[test]
fn hoses_that_cannot_burst_are_told() {
    let refused = |request: Value| {
        let mut cockpit = hydrocrane_web::Cockpit::default();
        cockpit.open(&request.to_string()).expect_err("no drive").message().to_string()
    };
    let asked = |bursts: Value| refused(json!({ "machine": "rottne-f9-lab", "bursts": bursts }));
    let torn = json!(["lift", "piston-side", 0.5, 20e-6]);
    assert!(
        asked(json!([torn, torn])).contains("the hose to the piston-side of cylinder `lift` bursts twice; keep one")
    );
    assert!(asked(json!([["lfit", "piston-side", 0.5, 20e-6]])).contains("`lift`"));
    assert!(asked(json!([["lift", "rod", 0.5, 20e-6]])).contains("`rod-side`"));
    assert!(asked(json!([["lift", "rod-side", 0.5, -1.0]])).contains("greater"));
    let again = "[burst.again]\ncylinder = \"jib\"\nside = \"rod-side\"\ntime = \"1 s\"\nopening = \"1 mm^2\"\n";
    let message = refused(json!({ "scenario": TIP.to_string() + again }));
    assert!(message.contains("drive.toml:") && message.contains("bursts twice"), "{message}");
}
