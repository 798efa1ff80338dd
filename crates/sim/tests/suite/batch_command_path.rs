//! The command path of a batch.

use hydrocrane_machine::{load, Machine, OverrideValue};
use hydrocrane_plant::layout::MAX_JOINTS;
use hydrocrane_sim::batch::command_path::{BatchCommandPath, Plan};

fn machine(delays: [f64; 3]) -> Machine {
    let late = |(name, delay): (&str, f64)| (format!("valve.{name}.delay"), OverrideValue::Number(delay));
    let late: Vec<_> = ["lift", "jib", "extension"].into_iter().zip(delays).map(late).collect();
    load("rottne-f9-lab", &late).expect("a bundled machine")
}

fn path(delays: [f64; 3]) -> BatchCommandPath {
    BatchCommandPath::new(&machine(delays), 2, 0.01)
}

#[test]
fn without_delay_a_sample_is_one_stretch() {
    assert_eq!(path([0.0; 3]).plan(0), [Plan { length: 0.01, age: [0; MAX_JOINTS] }]);
}

#[test]
fn delayed_commands_arrive_within_a_later_sample() {
    let path = path([0.0, 0.004, 0.02]);
    let plan = path.plan(0);
    assert_eq!(plan.len(), 2);
    assert!((plan[0].length - 0.004).abs() < 1e-15);
    assert!((plan[1].length - 0.006).abs() < 1e-15);
    assert_eq!((plan[0].age[..3].to_vec(), plan[1].age[..3].to_vec()), (vec![0, 1, 2], vec![0, 0, 2]));
}

#[test]
fn a_crane_that_is_reset_forgets_what_was_sent() {
    let mut path = path([0.0; 3]);
    path.send(&[0.01, 0.02, 0.03, 0.01, 0.02, 0.03]);
    path.begin(1, &machine([0.0; 3]));
    let plan = path.plan(0);
    let at = |crane, cylinder| path.at_spool(&plan[0], crane, cylinder);
    assert_eq!([at(0, 0), at(0, 1), at(1, 0), at(1, 1)], [0.01, 0.02, 0.0, 0.0]);
}

#[test]
fn each_crane_has_a_hysteresis_of_its_own() {
    let machine = load("rottne-f9-lab", &[("valve.jib.command.hysteresis".to_string(), OverrideValue::Number(0.1))]);
    let machine = machine.expect("a bundled machine");
    let mut path = BatchCommandPath::new(&machine, 2, 0.01);
    let plan = path.plan(0).to_vec();
    // Half of 10 % of 50 mm on either side.
    for (rows, wanted) in [
        ([0.01, 0.02, 0.0, 0.01, 0.001, 0.0], [0.0175, 0.0]),
        ([0.01, 0.016, 0.0, 0.01, -0.004, 0.0], [0.0175, -0.0015]),
    ] {
        path.send(&rows);
        for (crane, wanted) in wanted.into_iter().enumerate() {
            assert!((path.at_spool(&plan[0], crane, 1) - wanted).abs() < 1e-15);
            assert_eq!(path.at_spool(&plan[0], crane, 0), 0.01);
        }
    }
    path.begin(0, &machine);
    path.send(&[0.0; 6]);
    assert_eq!(path.at_spool(&plan[0], 0, 1), 0.0);
}

#[test]
fn a_crane_with_another_delay_waits_for_it_and_its_neighbour_does_not() {
    let mut path = path([0.0; 3]);
    path.begin(1, &machine([0.02, 0.0, 0.0]));
    let lift = |path: &BatchCommandPath| [0, 1].map(|crane| path.at_spool(&path.plan(crane)[0], crane, 0));
    for wanted in [[0.01, 0.0], [0.01, 0.0], [0.01, 0.01]] {
        path.send(&[0.01, 0.0, 0.0, 0.01, 0.0, 0.0]);
        assert_eq!(lift(&path), wanted);
    }
    path.begin(1, &machine([0.0; 3]));
    path.send(&[0.02, 0.0, 0.0, 0.02, 0.0, 0.0]);
    assert_eq!(lift(&path), [0.02; 2]);
}

/// What differs from crane to crane is read from memory at every sample; all else should not be.
#[test]
fn a_crane_with_a_spool_of_its_own_shares_what_is_not() {
    let short = [("valve.lift.stroke".to_string(), OverrideValue::Number(0.04))];
    let mut path = path([0.0; 3]);
    path.begin(1, &load("rottne-f9-lab", &short).expect("a bundled machine"));
    path.send(&[0.05; 6]);
    let plan = path.plan(0);
    assert!(std::ptr::eq(plan, path.plan(1)), "parts of the sample of one crane twice");
    let at = |crane, cylinder| path.at_spool(&plan[0], crane, cylinder);
    assert_eq!([at(0, 0), at(1, 0), at(0, 1), at(1, 1)], [0.05, 0.04, 0.05, 0.05]);
}
