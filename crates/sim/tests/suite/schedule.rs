//! Spool commands against time, on the command path.

use hydrocrane_machine::model::{SignalChain, Valve};
use hydrocrane_sim::inputs::command_path::{at_spool, follow};
use hydrocrane_sim::runs::schedule::Column;

fn valve(chain: SignalChain) -> Valve {
    let machine = hydrocrane_machine::load("rottne-f9-lab", &[]).expect("a bundled machine");
    Valve { command: chain, stroke: 0.05, delay: 0.0, ..machine.cylinders[0].valve.clone() }
}

const CHAIN: SignalChain =
    SignalChain { offset: 0.001, gain: 0.8, dead_band: 0.004, low: -0.03, high: 0.02, play: 0.0, delay: 0.1 };

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

#[test]
fn with_hysteresis_a_ramp_up_and_down_has_its_corners_where_they_are_by_hand() {
    let chain = SignalChain { offset: 0.0, gain: 1.0, dead_band: 0.0, low: -0.05, high: 0.05, play: 0.002, delay: 0.1 };
    let column = Column::new(vec![0.0, 1.0, 2.0], vec![0.0, 0.02, 0.0], true, &valve(chain));
    // It stands for 2 mm at 20 mm/s, rises to 18 mm, stands for 4 mm at the top and falls to 2 mm.
    for (t, value, slope) in [
        (0.05, 0.0, 0.0),
        (0.15, 0.0, 0.0),
        (0.3, 0.002, 0.02),
        (1.0, 0.016, 0.02),
        (1.2, 0.018, 0.0),
        (1.5, 0.014, -0.02),
        (3.0, 0.002, 0.0),
    ] {
        let (found, rate) = column.at(t);
        assert!((found - value).abs() < 1e-12 && (rate - slope).abs() < 1e-9, "{t}: {found} {rate}");
    }
    let corners = [0.1, 0.2, 1.1, 1.3, 2.1];
    assert_eq!(column.breaks.len(), corners.len(), "{:?}", column.breaks);
    for (found, corner) in column.breaks.iter().zip(corners) {
        assert!((found - corner).abs() < 1e-12, "{found} {corner}");
    }
}

#[test]
fn a_ramp_with_hysteresis_takes_the_same_path_as_small_steps() {
    let chain = SignalChain { play: 0.003, ..CHAIN };
    let values = vec![-0.05, 0.03, 0.01, 0.012, -0.02, -0.05];
    let column = Column::new((0..6).map(f64::from).collect(), values.clone(), true, &valve(chain));
    let mut spool = 0.0;
    for i in 0..50_000 {
        let t = 1e-4 * f64::from(i);
        let (k, share) = (t as usize, t.fract());
        let u = values[k] + share * (values.get(k + 1).unwrap_or(&values[k]) - values[k]);
        spool = follow(&chain, spool, at_spool(&chain, 0.05, u));
        let (found, _) = column.at(t + 0.1);
        assert!((found - spool).abs() < 1e-9, "{t}: {found} {spool}");
    }
}
