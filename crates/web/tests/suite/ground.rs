//! Drives on the ground that is drawn, in the cockpit's core and natively.

use crate::common::{index, opened, simulated, tip};
use hydrocrane_machine::parse_scenario;
use hydrocrane_web::Cockpit;
use serde_json::{json, Value};

/// The drive that lowers the boom with its lever until the ground carries, and stays there: its end.
fn lowered(cockpit: &mut Cockpit) {
    cockpit.set_sticks(&[-0.4, 0.0, 0.0]);
    assert!(cockpit.advance(9000), "{}", cockpit.events());
    cockpit.set_sticks(&[0.0; 3]);
    assert!(cockpit.advance(2001), "{}", cockpit.events());
}

#[test]
fn the_ground_that_is_drawn_carries_and_a_saved_drive_takes_it_along() {
    let bunk =
        json!({ "ground.support.bunk.height": -0.86, "ground.support.bunk.from": 1.3, "ground.support.bunk.to": 1.9 });
    let request = json!({
        "machine": "rottne-f9-lab", "controller": "lever", "payload": 80, "ground": true, "overrides": bunk,
    });
    let (mut cockpit, description) = opened(request.clone());
    assert_eq!(description["ground"]["height"], -1.21);
    assert_eq!(description["ground"]["supports"][0]["name"], "bunk");
    assert_eq!(description["hang"], json!([0.32, 0.044]));
    lowered(&mut cockpit);
    let z = tip(&mut cockpit, &description)[1];
    let up = cockpit.frame()[index(&description, "tip.contact.z")];
    // 80 kg hang 0.714 m below the tip; the ground gives way by its spring.
    let depth = -1.21 + 0.32 + 0.044 * 80f64.sqrt() - z;
    assert!(up > 500.0 && (depth - up / 2e5 - 1e-3).abs() < 5e-4, "{depth} m deep under {up} N");
    let text = cockpit.save().expect("a drive");
    let (_, simulated) = simulated(&parse_scenario(&text, "drive.toml", &[]).expect("a scenario"));
    assert!((simulated[1] - z).abs() < 1e-6, "{simulated:?} {z}");
    let (_, replayed) = opened(json!({ "scenario": text }));
    assert_eq!(replayed["ground"], description["ground"]);

    // Nothing carries where nobody asks for it, nor where a machine has no ground drawn.
    let bare = json!({ "machine": "rottne-f9-lab", "controller": "lever", "payload": 80 });
    let (mut sinking, without) = opened(bare);
    assert_eq!(without["ground"], Value::Null);
    lowered(&mut sinking);
    assert!(tip(&mut sinking, &without)[1] < z - 0.1);
    let (_, rig) = opened(json!({ "machine": "single-cylinder", "controller": "lever", "ground": true }));
    assert_eq!(rig["ground"], Value::Null);
}

#[test]
fn a_heavy_load_starts_above_the_ground_unless_the_pose_is_stated() {
    let loaded = json!({ "machine": "rottne-f9-lab", "controller": "lever", "payload": 600, "ground": true });
    let (mut cockpit, description) = opened(loaded.clone());
    let hang = 0.32 + 0.044 * 600f64.sqrt();
    assert!(tip(&mut cockpit, &description)[1] - hang > -1.21);
    let mut stated = loaded;
    stated["joints"] = json!({ "boom": 1.5 });
    let problem = Cockpit::default().open(&stated.to_string()).expect_err("in the ground");
    assert!(problem.message().contains("raise the tip"), "{}", problem.message());
}

#[test]
fn tip_control_with_real_sensors_presses_a_log_down_and_lifts_it_again() {
    let (mut cockpit, description) = opened(json!({
        "machine": "rottne-f9-lab", "payload": 80, "ground": true, "full-speed": 0.3, "real-sensors": true, "seed": 2,
    }));
    let up = index(&description, "tip.contact.z");
    let mut most = 0f64;
    for (z, parts) in [(-0.6, 60), (0.0, 20), (0.6, 40)] {
        cockpit.set_sticks(&[0.0, z]);
        for _ in 0..parts {
            assert!(cockpit.advance(100), "{}", cockpit.events());
            most = most.max(cockpit.frame()[up]);
        }
    }
    assert!(most > 500.0, "the ground carries {most} N at most");
    let hang = 0.32 + 0.044 * 80f64.sqrt();
    let [_, z] = tip(&mut cockpit, &description);
    assert!(cockpit.frame()[up] == 0.0 && z - hang > -1.1, "lifted to {z} m");
}
