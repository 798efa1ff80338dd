//! What standard runs cost: a change that makes the solver work more, or no longer harder where it must, shows here.

use hydrocrane_machine::load;
use hydrocrane_sim::integrator::Tolerances;
use hydrocrane_sim::{build, simulate, Commands, EquilibriumMode, Run, RunOptions};

/// The laboratory crane lifts for a second, holds, and lets its tip swing out; spools step twice.
fn lift(method: &str) -> Run {
    let model = build(&load("rottne-f9-lab", &[]).expect("a bundled machine")).expect("it can be built");
    let q = [100f64.to_radians(), 100f64.to_radians(), 0.0];
    let start = model.equilibrium(&q, EquilibriumMode::Hold, 0.0).expect("a pose inside the limits");
    let times = vec![0.0, 0.3, 1.3];
    let commands = Commands { times, values: vec![0.0, 0.0, 0.0, 0.03, 0.01, -0.01, 0.0, 0.0, 0.0], linear: false };
    let options = RunOptions {
        method: method.to_string(),
        tolerances: Tolerances { relative: 1e-4, absolute: 1e-4, max_step: 0.05 },
        payload: 0.0,
        payload_changes: Vec::new(),
        ledger: false,
        max_steps: 100_000,
    };
    simulate(model.as_ref(), &start, 2.0, &commands, &[2.0], &options, &mut |_| true)
}

/// Measured numbers of accepted and rejected steps, with room for what rounding does to a step size.
fn assert_near(run: &Run, measured: [u64; 2]) {
    let found = [run.accepted, run.rejected];
    let near = |(found, measured): (u64, u64)| found.abs_diff(measured) <= 4 + measured / 20;
    assert!(found.into_iter().zip(measured).all(near), "accepted and rejected: {found:?}, measured {measured:?}");
}

#[test]
fn a_stiff_lift_takes_its_number_of_steps() {
    assert_near(&lift("rodas5p"), [252, 5]);
}

#[test]
fn an_explicit_lift_takes_its_number_of_steps() {
    assert_near(&lift("tsit5"), [658, 48]);
}

#[test]
fn a_stiff_attempt_costs_seven_right_hand_sides_and_one_factorisation() {
    let run = lift("rodas5p");
    let attempts = run.accepted + run.rejected;
    assert_eq!(run.effort.factorisations, attempts);
    assert_eq!(run.effort.derivatives, 7 * attempts);
    // One linearisation for each state that a step starts from.
    assert_eq!(run.effort.jacobians, run.accepted);
}
