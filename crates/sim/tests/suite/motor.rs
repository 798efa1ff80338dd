//! A motor that slews an excavator: oil, pressures and torque by hand, energy accounted for.

use crate::ledger;
use crate::supply::{options, output};
use hydrocrane_machine::load;
use hydrocrane_sim::{build, simulate, Commands, EquilibriumMode, Model, OutcomeKind};
use std::f64::consts::TAU;
use std::sync::Arc;

const PAYLOAD: f64 = 60.0;
/// What the file states.
const PER_RADIAN: f64 = 23.6e-6 * 134.0 / TAU;
const SIDE: f64 = 1.005e-3;

fn excavator() -> Arc<dyn Model> {
    build(&load("sany-sy19e", &[]).unwrap_or_else(|error| panic!("{error}"))).expect("it can be built")
}

fn start(m: &dyn Model, slew: f64) -> Vec<f64> {
    let pose = [slew, 30f64.to_radians(), 30f64.to_radians(), 10f64.to_radians()];
    m.equilibrium(&pose, EquilibriumMode::Hold, PAYLOAD).expect("a pose inside the limits")
}

fn derivative(m: &dyn Model, x: &[f64]) -> Vec<f64> {
    let mut dx = vec![0.0; x.len()];
    m.derivative(x, &[0.0; 4], PAYLOAD, &mut dx);
    dx
}

#[test]
fn its_sides_stay_as_large_as_they_are() {
    let m = excavator();
    let at = m.layout();
    let (speed, rates) = (0.3, [-1.0, 1.0]);
    for slew in [-1.5, 0.0, 0.7] {
        let mut x = start(m.as_ref(), slew);
        (x[at.p1(0)], x[at.p2(0)]) = (60e5, 45e5);
        let rest = derivative(m.as_ref(), &x);
        x[at.qd(0)] = speed;
        let moved = derivative(m.as_ref(), &x);
        for (i, p) in [at.p1(0), at.p2(0)].into_iter().enumerate() {
            let by_hand = rates[i] * m.bulk_modulus(x[p]) / SIDE * PER_RADIAN * speed;
            let found = moved[p] - rest[p];
            assert!((found / by_hand - 1.0).abs() < 1e-9, "side {i} at {slew} rad: {found} Pa/s, by hand {by_hand}");
        }
    }
}

#[test]
fn the_difference_of_its_pressures_is_its_torque() {
    let m = excavator();
    let at = m.layout();
    let mut x = start(m.as_ref(), 0.2);
    x[at.qd(0)] = 0.2;
    let radius = 0.25;
    let force = |p1: f64| {
        let mut x = x.clone();
        (x[at.p1(0)], x[at.p2(0)]) = (p1, 40e5);
        output(m.as_ref(), &x, "cylinder.slew.force")
    };
    let (found, by_hand) = (radius * (force(90e5) - force(40e5)), PER_RADIAN * 50e5);
    assert!((found / by_hand - 1.0).abs() < 1e-9, "{found} N m, by hand {by_hand}");
}

#[test]
fn a_working_cycle_accounts_for_its_energy() {
    let m = excavator();
    let (bucket, slew, boom) = ([0.0, 0.0, 0.0, 2e-3], [3e-3, 0.0, 0.0, 0.0], [0.0, 3e-3, 0.0, 0.0]);
    let (back, still) = (bucket.map(|u| -u), [0.0; 4]);
    let commands = Commands {
        times: vec![0.0, 0.5, 0.75, 1.25, 1.75, 2.0, 2.5, 4.0, 4.5, 5.0, 5.5, 6.0],
        values: [still, bucket, bucket, back, back, still, slew, slew, still, boom, boom, still].concat(),
        linear: true,
    };
    let mut options = options("rodas5p");
    options.payload = PAYLOAD;
    let record: Vec<f64> = (0..=160).map(|i| f64::from(i) / 20.0).collect();
    let run = simulate(m.as_ref(), &start(m.as_ref(), 0.0), 8.0, &commands, &record, &options, &mut |_| true);
    assert_eq!(run.outcome.kind, OutcomeKind::Completed, "{}", run.outcome.message);
    let (gap, given) = (ledger::gap(m.as_ref(), &run), ledger::at_end(m.as_ref(), &run, "supply"));
    assert!(gap < 1e-5 * given && given > 1e3, "{gap} J of {given} J are not accounted for");
    let turned = run.states[run.states.len() - m.layout().len()];
    assert!(turned > 1.4, "{turned} rad");
}
