//! The page sends the tip to a point: refused where it cannot go, ended by a stick, saved and repeated to the bit.

use crate::common::{opened, simulated, tip};
use hydrocrane_machine::parse_scenario;
use serde_json::json;

/// A drive of the tip, and where it begins.
fn begun() -> (hydrocrane_web::Cockpit, serde_json::Value, [f64; 2]) {
    let (mut cockpit, description) =
        opened(json!({ "machine": "rottne-f9-lab", "full-speed": 0.2, "dead-zone": 0.05 }));
    let start = tip(&mut cockpit, &description);
    (cockpit, description, start)
}

fn told(cockpit: &mut hydrocrane_web::Cockpit) -> Vec<String> {
    let news = cockpit.events();
    let events = news["events"].as_array().expect("a list");
    events.iter().map(|event| event["text"].as_str().expect("a text").to_string()).collect()
}

#[test]
fn a_drive_with_goals_and_precision_is_saved_and_repeated_to_the_bit() {
    let (mut cockpit, description, [x, z]) = begun();
    cockpit.set_sticks(&[0.0, 0.5]);
    cockpit.advance(500);
    cockpit.set_sticks(&[0.0, 0.0]);
    cockpit.advance(500);
    cockpit.go_to([x - 0.1, z + 0.2]).expect("a free place");
    cockpit.advance(300);
    cockpit.set_precision(0.25);
    cockpit.advance(700);
    cockpit.set_precision(1.0);
    cockpit.advance(5000);
    let there = tip(&mut cockpit, &description);
    assert!((there[0] - x + 0.1).hypot(there[1] - z - 0.2) < 1e-3, "{there:?}");
    assert!(told(&mut cockpit)[0].starts_with("the tip has reached its goal"));
    // Another goal, under way when a knob is turned.
    cockpit.go_to([x, z]).expect("a free place");
    cockpit.advance(500);
    let other = json!({ "machine": "rottne-f9-lab", "full-speed": 0.1, "dead-zone": 0.05, "keep-state": true });
    cockpit.open(&other.to_string()).expect("the same machine");
    cockpit.advance(1501);
    let end = tip(&mut cockpit, &description);
    assert!(end != there, "it goes on to its goal");
    let scenario = parse_scenario(&cockpit.save().expect("a drive"), "drive.toml", &[]).expect("a scenario");
    assert_eq!((scenario.goals.len(), scenario.phases.len()), (2, 1));
    let (time, again) = simulated(&scenario);
    let (mut replayed, description) = opened(json!({ "scenario": cockpit.save().expect("a drive") }));
    replayed.advance((1000.0 * time).round() as u32);
    assert_eq!(tip(&mut replayed, &description), again);
}

#[test]
fn a_goal_that_cannot_be_is_refused_and_a_stick_ends_one() {
    let (mut cockpit, description, [x, z]) = begun();
    cockpit.advance(100);
    for (place, why) in [([9.0, 0.0], "out of reach"), ([x, -1.3], "keep-out region"), ([f64::NAN, z], "finite")] {
        let problem = cockpit.go_to(place).expect_err("no such place");
        assert!(problem.message().contains(why), "{}", problem.message());
    }
    cockpit.go_to([x - 0.3, z]).expect("a free place");
    cockpit.advance(800);
    cockpit.set_sticks(&[0.0, 1.0]);
    cockpit.advance(300);
    cockpit.set_sticks(&[0.0, 0.0]);
    cockpit.advance(3000);
    assert!(told(&mut cockpit)[0].starts_with("the stick takes over"));
    assert!(tip(&mut cockpit, &description)[0] > x - 0.25);

    // Dropped, it comes to rest on its way.
    let from = tip(&mut cockpit, &description);
    cockpit.go_to([x - 0.3, z]).expect("a free place");
    cockpit.advance(600);
    cockpit.drop_goal();
    cockpit.advance(3000);
    let news = told(&mut cockpit);
    assert!(news[0].starts_with("the goal is cancelled") && news.len() == 1, "{news:?}");
    let stopped = tip(&mut cockpit, &description);
    assert!(stopped[0] < from[0] - 0.01 && stopped[0] > x - 0.29, "{stopped:?}");
    let scenario = parse_scenario(&cockpit.save().expect("a drive"), "drive.toml", &[]).expect("a scenario");
    assert!(scenario.goals[1].until.is_some() && scenario.goals[0].until.is_none());

    let (mut levers, ..) = opened(json!({ "machine": "rottne-f9-lab", "controller": "lever" }));
    levers.advance(100);
    assert!(levers.go_to([x, z]).expect_err("levers").message().contains("only the controller `tip`"));
}
