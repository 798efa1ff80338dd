//! Controllers by name and the gains of the machine file.

use hydrocrane_machine::{load, OverrideValue, CONTROLLERS as IN_FILES};
use hydrocrane_sim::model::controllers::{heinze_settings, tip_gain_units, tip_settings, CONTROLLERS, LEVER};
use hydrocrane_sim::{controller_model, Crane, Model, StateSpace};

fn crane(changes: &[(String, OverrideValue)]) -> Crane<3> {
    Crane::new(&load("rottne-f9-lab", changes).unwrap()).unwrap()
}

#[test]
fn every_controller_of_the_file_format_can_be_built_and_no_other() {
    let crane = crane(&[]);
    assert_eq!(IN_FILES.map(|(name, _)| name), CONTROLLERS);
    for (name, _) in IN_FILES {
        assert!(crane.controller(name).unwrap().period() > 0.0);
    }
    let message = crane.controller("tipp").err().unwrap();
    assert!(message.contains("tip, heinze-pid, lever"), "{message}");
}

#[test]
fn every_controller_takes_the_period_of_the_machine() {
    let crane = crane(&[("control.period".into(), OverrideValue::Number(0.02))]);
    for name in [LEVER, "tip", "heinze-pid"] {
        assert_eq!(crane.controller(name).unwrap().period(), 0.02, "{name}");
    }
}

#[test]
fn every_gain_of_the_file_format_changes_its_controller() {
    let settings = |name: &str, key: &str, value: f64| {
        let searched = ("control.heinze-pid.extension".to_string(), OverrideValue::Text("penalty".into()));
        let gain = (format!("control.{name}.{key}"), OverrideValue::Number(value));
        let crane = crane(&[searched, gain]);
        let (machine, controller_model) = (crane.machine(), controller_model(&crane));
        format!("{:?} {:?}", tip_settings(machine, &controller_model), heinze_settings(machine, &controller_model))
    };
    let weights = ["motion-weight.boom", "middle-weight.extension"].map(|key| ("heinze-pid", key));
    let gains = IN_FILES
        .iter()
        .flat_map(|(name, keys)| keys.iter().filter(|key| key.kind().is_some()).map(move |key| (*name, key.name)));
    for (name, key) in gains.chain(weights) {
        assert_ne!(settings(name, key, 1.2), settings(name, key, 2.4), "{name}.{key}");
    }
    let units: Vec<_> = tip_gain_units().collect();
    assert!(units.contains(&("position-gain", "1/s")) && units.contains(&("reserve", "")) && units.len() == 14);
}
