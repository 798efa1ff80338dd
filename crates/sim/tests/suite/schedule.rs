//! Spool commands against time, on the command path.

use hydrocrane_machine::model::{SignalChain, Valve};
use hydrocrane_sim::command_path::at_spool;
use hydrocrane_sim::schedule::Column;

fn valve(chain: SignalChain) -> Valve {
    let machine = hydrocrane_machine::load("rottne-f9-lab", &[]).expect("a bundled machine");
    Valve { command: chain, stroke: 0.05, delay: 0.0, ..machine.cylinders[0].valve.clone() }
}

const CHAIN: SignalChain =
    SignalChain { offset: 0.001, gain: 0.8, dead_band: 0.004, low: -0.03, high: 0.02, delay: 0.1 };

/// From end to end in one second.
fn ramp(chain: SignalChain) -> Column {
    Column::new(vec![0.0, 1.0], vec![-0.05, 0.05], true, &valve(chain))
}

#[test]
fn a_ramp_takes_the_same_path_as_a_command_that_is_held() {
    let column = ramp(CHAIN);
    for t in (0..1000).map(|i| 0.1 + 1e-3 * f64::from(i)) {
        let wanted = at_spool(&CHAIN, 0.05, -0.05 + 0.1 * (t - 0.1));
        assert!((column.at(t).0 - wanted).abs() < 1e-12, "{t}");
    }
}

#[test]
fn between_its_bends_a_ramp_is_straight() {
    let column = ramp(CHAIN);
    // Start, lower limit, both ends of the dead band, upper limit, end.
    assert_eq!(column.breaks.len(), 6);
    for pair in column.breaks.windows(2) {
        let (value, slope) = column.at(pair[0]);
        for share in [0.1, 0.5, 0.9] {
            let t = pair[0] + share * (pair[1] - pair[0]);
            assert!((value + slope * (t - pair[0]) - column.at(t).0).abs() < 1e-12, "{t}");
        }
    }
}

#[test]
fn nothing_arrives_before_the_first_time_and_the_delay() {
    let column = Column::new(vec![0.5], vec![0.01], false, &valve(CHAIN));
    assert_eq!(column.at(0.0), (0.0, 0.0));
    assert_eq!(column.at(0.59), (0.0, 0.0));
    assert_eq!(column.at(0.6), (0.001 + 0.8 * 0.006, 0.0));
}
