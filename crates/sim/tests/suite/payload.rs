//! Loads that come and go in a run: what jumps, what stays, and that every way of running agrees.

use crate::ledger;
use hydrocrane_control::interface::controller::{Controller, Fault, Measurement, Stick};
use hydrocrane_machine::load;
use hydrocrane_ode::{StepControl, Tolerances};
use hydrocrane_sim::{
    build, simulate, simulate_sampled, Commands, EquilibriumMode, Model, OutcomeKind, PayloadChange, Run, RunOptions,
    SampledPlan, Sensors, Simulator, StickKind, Sticks,
};
use std::sync::Arc;

const SPOOLS: [f64; 3] = [0.02, -0.01, 0.015];
/// Picked up between two commands and two recorded rows, put down at the time of a row.
const PICKED: f64 = 0.4035;
const DROPPED: f64 = 0.7;
const END: f64 = 1.0;

/// Held commands as a controller.
struct Hold;

impl Controller for Hold {
    fn period(&self) -> f64 {
        0.01
    }
    fn reset(&mut self, _first: &Measurement) {}
    fn step(&mut self, _measured: &Measurement, _stick: Stick, spool: &mut [f64]) -> Result<(), Fault> {
        spool.copy_from_slice(&SPOOLS);
        Ok(())
    }
    fn set_point(&self) -> Option<[f64; 2]> {
        None
    }
}

fn model() -> Arc<dyn Model> {
    build(&load("rottne-f9-lab", &[]).expect("a bundled machine")).expect("a machine that can be built")
}

fn start(m: &dyn Model) -> Vec<f64> {
    m.equilibrium(&[100f64.to_radians(), 100f64.to_radians(), 0.0], EquilibriumMode::Hold, 0.0).expect("a pose")
}

fn options(changes: &[(f64, f64)]) -> RunOptions {
    RunOptions {
        method: "rodas5p".into(),
        tolerances: Tolerances { relative: 1e-7, absolute: 1e-7, max_step: 0.01 },
        control: StepControl::Adaptive,
        payload: 0.0,
        payload_changes: changes.iter().map(|&(time, mass)| PayloadChange { time, mass }).collect(),
        supply: None,
        ledger: true,
        max_steps: 1_000_000,
    }
}

fn open_loop(m: &dyn Model, record: &[f64], changes: &[(f64, f64)]) -> Run {
    let commands = Commands { times: vec![0.0], values: SPOOLS.to_vec(), linear: false };
    simulate(m, &start(m), END, &commands, record, &options(changes), &mut |_| true)
}

fn row<'a>(m: &dyn Model, run: &'a Run, i: usize) -> &'a [f64] {
    &run.states[i * m.layout().len()..(i + 1) * m.layout().len()]
}

#[test]
fn only_the_joint_rates_jump_and_only_at_the_pick_up() {
    let m = model();
    let m = m.as_ref();
    let after = 1e-9;
    let record = [PICKED, PICKED + after, DROPPED, DROPPED + after];
    let run = open_loop(m, &record, &[(PICKED, 150.0), (DROPPED, 30.0)]);
    assert_eq!(run.outcome.kind, OutcomeKind::Completed, "{}", run.outcome.message);
    assert_eq!(run.payloads, [0.0, 150.0, 150.0, 30.0]);
    for (i, name) in m.layout().names.iter().enumerate() {
        let [jump, continuous] = [0, 2].map(|k| row(m, &run, k + 1)[i] - row(m, &run, k)[i]);
        // In a nanosecond accelerations of some 10 rad/s^2 and pressure rates of some GPa/s do little.
        let least = if name.ends_with("p1") || name.ends_with("p2") { 10.0 } else { 1e-6 };
        assert!(continuous.abs() < least, "{name} {continuous}");
        assert_eq!(jump.abs() < least, !name.ends_with(".qd"), "{name} {jump}");
    }
    let mut rates = [0.0; 3];
    let (q, qd) = (&row(m, &run, 0)[..3], &row(m, &run, 0)[3..6]);
    let loss = m.attach(q, qd, 0.0, 150.0, &mut rates);
    for (jumped, law) in row(m, &run, 1)[3..6].iter().zip(rates) {
        assert!((jumped - law).abs() < 1e-6, "{jumped} {law}");
    }
    let [up, down] = run.payload_events[..] else { panic!("two events, not {:?}", run.payload_events) };
    assert_eq!((up.time, up.mass, down.time, down.mass), (PICKED, [0.0, 150.0], DROPPED, [150.0, 30.0]));
    assert!((up.loss - loss).abs() < 1e-12 && loss > 0.0 && down.loss == 0.0);
    assert_eq!(up.tip_velocity, [m.tip_velocity(q, qd), m.tip_velocity(q, &rates)]);
    assert_eq!(down.tip_velocity[0], down.tip_velocity[1]);
}

#[test]
fn the_account_explains_what_the_states_store() {
    let m = model();
    let m = m.as_ref();
    let record: Vec<f64> = (0..=200).map(|i| f64::from(i) * 5e-3).collect();
    let run = open_loop(m, &record, &[(0.2, 200.0), (PICKED, 50.0), (0.6, 120.0), (DROPPED, 0.0)]);
    let (worst, impacts) = (ledger::gap(m, &run), ledger::at_end(m, &run, "payload.impact"));
    assert!(impacts > 0.05, "the impacts cost {impacts} J");
    assert!(worst < 2e-4 * impacts, "{worst} J of {impacts} J");
}

#[test]
fn a_controller_and_single_steps_see_the_same_loads() {
    let m = model();
    let changes = [(0.4, 150.0), (DROPPED, 30.0)];
    let record: Vec<f64> = (0..=100).map(|i| f64::from(i) * 0.01).collect();
    let run = open_loop(m.as_ref(), &record, &changes);
    let plan =
        SampledPlan { sticks: Sticks::centred(StickKind::Tip, 2), sensors: Sensors::ideal(m.as_ref()), delay: 0.0 };
    let x0 = start(m.as_ref());
    let options = options(&changes);
    let sampled = simulate_sampled(m.as_ref(), &x0, END, &mut Hold, &plan, &record, &options, &mut |_| true).run;
    assert_eq!(sampled.payloads, run.payloads);
    for (a, b) in sampled.payload_events.iter().zip(&run.payload_events) {
        assert!((a.loss - b.loss).abs() < 1e-6 && a.time == b.time, "{a:?} {b:?}");
    }

    let mut stepped = Simulator::new(m.clone(), 0.01, options);
    stepped.reset(&x0).expect("a state to start from");
    for i in 0..100 {
        // A row at the instant of a change has the state before it, as the simulator has until it is told.
        let reference = row(m.as_ref(), &run, i);
        let state = stepped.state().expect("a state");
        let worst = state.iter().zip(reference).zip(&m.layout().scales).map(|((a, b), scale)| (a - b).abs() / scale);
        assert!(worst.fold(0.0, f64::max) < 1e-4, "row {i}");
        if let Some((_, mass)) = changes.iter().find(|(time, _)| (time - stepped.time()).abs() < 1e-9) {
            stepped.set_payload(*mass).expect("a simulation that has begun");
        }
        assert_eq!(stepped.step(&SPOOLS).kind, OutcomeKind::Completed);
    }
    assert_eq!(stepped.payload(), 30.0);
    stepped.reset(&x0).expect("a state to start from");
    assert_eq!(stepped.payload(), 0.0, "a reset goes back to the payload of the start");
}

#[test]
fn payloads_that_cannot_be_are_named() {
    let m = model();
    for (changes, part) in [
        (&[(0.5, -1.0)][..], "a payload of -1 kg at 0.5 s"),
        (&[(0.5, f64::NAN)], "a payload of NaN kg"),
        (&[(0.0, 10.0)], "its times must be positive and increasing"),
        (&[(0.5, 10.0), (0.5, 0.0)], "at 0.5 s after 0.5 s"),
    ] {
        let run = open_loop(m.as_ref(), &[0.0], changes);
        assert_eq!(run.outcome.kind, OutcomeKind::BadState);
        assert!(run.outcome.message.contains(part), "{}", run.outcome.message);
    }
}
