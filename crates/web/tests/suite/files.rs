//! Files that a drive begins with: the machine that a scenario names, what it extends, and bundled machines.

use crate::common::{opened, tip};
use hydrocrane_web::Cockpit;
use serde_json::{json, Value};

const SIXTY_BAR: &str = "extends = \"rottne-f9-lab\"\n[supply]\nclass = \"setting\"\npressure = \"60 bar\"\n";
const UP: &str = "[scenario]\nname = \"up\"\nmachine = \"./b.toml\"\nduration = \"2 s\"\n[initial.joint]\nboom = \"100 deg\"\n\
                  jib = \"100 deg\"\nextension = \"0 mm\"\n[joystick]\ntime = [\"0.1 s\"]\nz = [1]\nfull-speed = \"0.1 m/s\"\n";

#[test]
fn a_replay_is_on_the_machine_that_its_scenario_names_or_refused() {
    let (mut cockpit, _) = opened(json!({ "machine": "a.toml", "text": "extends = \"rottne-f9-lab\"\n" }));
    for files in [json!({}), json!({ "a.toml": "extends = \"rottne-f9-lab\"\n" })] {
        let request = json!({ "scenario": UP, "scenario-name": "needs-b.toml", "files": files }).to_string();
        let problem = cockpit.open(&request).expect_err("another machine");
        assert!(problem.message().contains("needs-b.toml:3") && problem.message().contains("b.toml"), "{problem:?}");
    }
    let (mut cockpit, told) = opened(json!({ "scenario": UP, "files": { "b.toml": SIXTY_BAR } }));
    assert_eq!((&told["machine"]["source"], &told["supply"]), (&json!("b.toml"), &json!(60e5)));
    cockpit.advance(1000);
    let saved = cockpit.save().expect("a drive");
    assert!(saved.contains("./b.toml"), "{saved}");
    let again =
        |text: &str| Cockpit::default().open(&json!({ "scenario": saved, "files": { "b.toml": text } }).to_string());
    assert!(again(SIXTY_BAR).is_ok());
    let other = again(&SIXTY_BAR.replace("60", "140")).expect_err("other contents");
    assert!(other.message().contains("recorded on another"), "{other:?}");
}

#[test]
fn a_machine_that_extends_a_file_is_opened_with_it() {
    let request = json!({ "machine": "c.toml", "text": "extends = \"./b.toml\"\n", "files": { "b.toml": SIXTY_BAR } });
    let (_, told) = opened(request);
    assert_eq!(told["supply"], 60e5);
}

#[test]
fn an_empty_tool_has_room_at_the_start() {
    for (machine, ground) in [("hiab-xs031", -0.3), ("rottne-f9-pump", -1.21), ("rottne-f9-lab", -1.21)] {
        let (mut cockpit, told) = opened(json!({ "machine": machine, "ground": true }));
        let hang: Vec<f64> = told["hang"].as_array().expect("two").iter().filter_map(Value::as_f64).collect();
        assert!(tip(&mut cockpit, &told)[1] - ground > hang[0] + hang[1] * 40f64.sqrt(), "{machine}");
        assert_eq!(told["tool"], "grapple");
    }
}

#[test]
fn a_bundled_machine_begins_without_a_warning() {
    for (machine, _) in hydrocrane_machine::bundled_machines() {
        let mut cockpit = Cockpit::default();
        // Rigs have no tip to be moved.
        if cockpit.open(&json!({ "machine": machine, "ground": true, "controller": "lever" }).to_string()).is_ok() {
            cockpit.advance(100);
            let events = cockpit.events();
            assert!(events["events"].as_array().expect("a list").iter().all(|e| e["warning"].is_null()), "{events}");
        }
    }
}
