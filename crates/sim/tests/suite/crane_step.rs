//! One step of a whole crane: the same in a lane of a batch, of its order, and with an estimate that tells its error.

use hydrocrane_lanes::{CraneStep, Scene};
use hydrocrane_machine::{load, model::Machine, OverrideValue};
use hydrocrane_num::{Lanes, Real};
use hydrocrane_ode::linear::rows::Cell;
use hydrocrane_ode::{StepControl, Tolerances};
use hydrocrane_plant::equations::rhs::Evaluator;
use hydrocrane_plant::precision::Precision;
use hydrocrane_plant::Crane;
use hydrocrane_sim::{build, EquilibriumMode, Layout, RunOptions, Simulator, StateSpace};

const SPOOLS: [f64; 3] = [0.02, 0.006, -0.01];

/// The laboratory crane, its pistons with bristles or with the static map.
fn machine(friction: &str) -> Machine {
    let keys = ["lift", "jib", "extension"].map(|cylinder| format!("friction.{cylinder}.model"));
    let changes = keys.map(|key| (key, OverrideValue::Text(friction.to_string())));
    load("rottne-f9-lab", &changes).expect("a valid machine")
}

fn crane(friction: &str) -> Crane<3> {
    Crane::new(&machine(friction)).expect("it can be built")
}

fn start(crane: &Crane<3>) -> Vec<f64> {
    let pose = [100f64.to_radians(), 100f64.to_radians(), 0.0];
    crane.equilibrium(&pose, EquilibriumMode::Hold, 0.0).expect("a pose inside the limits")
}

/// The state after `duration` (s) in equal steps.
fn after<T: Real + Cell<Factor = T>>(crane: &Crane<3>, duration: f64, steps: usize) -> Vec<T> {
    let plant = crane.plant().map(&mut |number| T::c(*number));
    let layout = crane.layout();
    let evaluator = Evaluator::new(&plant, layout);
    let (spools, payload) = (SPOOLS.map(T::c), T::c(0.0));
    let scene = Scene { evaluator: &evaluator, layout, spools: &spools, payload };
    let mut x: Vec<T> = start(crane).into_iter().map(T::c).collect();
    let (mut stepping, precision) = (CraneStep::new(layout), Precision::new(layout, 1.0).lift());
    for _ in 0..steps {
        stepping.attempt(&scene, T::c(duration / steps as f64), &x, &precision);
        x.copy_from_slice(stepping.reached());
    }
    x
}

#[test]
fn a_lane_of_a_batch_takes_the_steps_of_one_crane_to_the_last_bit() {
    for friction in ["lugre", "static"] {
        let crane = crane(friction);
        let (alone, batch) = (after::<f64>(&crane, 0.25, 100), after::<Lanes<f64>>(&crane, 0.25, 100));
        for (alone, lanes) in alone.iter().zip(batch) {
            let mut numbers = [0.0; 1];
            lanes.store(&mut numbers);
            assert_eq!(numbers, [*alone], "{friction}");
        }
    }
}

/// Largest difference of two states, in units of the scales.
fn difference(layout: &Layout, a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).zip(&layout.scales).map(|((a, b), scale)| ((a - b) / scale).abs()).fold(0.0, f64::max)
}

#[test]
fn steps_are_of_order_four_on_the_crane() {
    let crane = crane("lugre");
    let layout = crane.layout().clone();
    let exact = exact(&crane, 0.1);
    let error = |steps| difference(&layout, &after::<f64>(&crane, 0.1, steps), &exact);
    let (coarse, fine) = (error(200), error(400));
    assert!(coarse < 1e-3 && (10.0..24.0).contains(&(coarse / fine)), "{coarse} {fine}");
}

/// The state after `duration` by the adaptive method.
fn exact(crane: &Crane<3>, duration: f64) -> Vec<f64> {
    let options = RunOptions {
        method: "rodas5p".to_string(),
        tolerances: Tolerances { relative: 1e-11, absolute: 1e-11, max_step: 1e-3 },
        control: StepControl::Adaptive,
        payload: 0.0,
        payload_changes: Vec::new(),
        supply: None,
        ledger: false,
        max_steps: u64::MAX,
    };
    let start = start(crane);
    let model = build(&machine("lugre")).expect("it can be built");
    let mut simulator = Simulator::new(model, duration, options);
    simulator.reset(&start).expect("a good start");
    simulator.step(&SPOOLS);
    simulator.state().expect("a state").to_vec()
}

#[test]
fn the_estimate_tells_by_how_much_a_step_errs_and_that_it_leads_nowhere() {
    let crane = crane("lugre");
    let layout = crane.layout();
    let evaluator = Evaluator::new(crane.plant(), layout);
    let scene = Scene { evaluator: &evaluator, layout, spools: &SPOOLS, payload: 0.0 };
    let (mut stepping, precision) = (CraneStep::new(layout), Precision::new(layout, 1e-3));
    let moving = after::<f64>(&crane, 0.2, 200);
    let mut estimate = |h: f64, x: &[f64]| stepping.attempt(&scene, h, x, &precision).sqrt();
    // The estimate's own order is three: its error grows with the fourth power of the step.
    let (one, two) = (estimate(1e-3, &moving), estimate(2e-3, &moving));
    assert!(one > 0.0 && (10.0..24.0).contains(&(two / one)), "{one} {two}");
    let mut wild = moving.clone();
    wild[layout.qd(0)] = 1e200;
    assert!(!estimate(1e-3, &wild).is_finite());
}
