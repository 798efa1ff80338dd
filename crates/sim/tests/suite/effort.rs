//! What standard runs cost: a change that makes the solver work more, or no longer harder where it must, shows here.

use hydrocrane_machine::load;
use hydrocrane_ode::Tolerances;
use hydrocrane_sim::{build, simulate, simulate_sampled, Commands, EquilibriumMode, Model, Run, RunOptions};
use hydrocrane_sim::{SampledPlan, Sensors, StickKind, Sticks};
use std::sync::Arc;

fn crane() -> (Arc<dyn Model>, Vec<f64>) {
    let model = build(&load("rottne-f9-lab", &[]).expect("a bundled machine")).expect("it can be built");
    let q = [100f64.to_radians(), 100f64.to_radians(), 0.0];
    let start = model.equilibrium(&q, EquilibriumMode::Hold, 0.0).expect("a pose inside the limits");
    (model, start)
}

fn options(method: &str, max_step: f64) -> RunOptions {
    RunOptions {
        method: method.to_string(),
        tolerances: Tolerances { relative: 1e-4, absolute: 1e-4, max_step },
        control: crate::control(method),
        payload: 0.0,
        payload_changes: Vec::new(),
        supply: None,
        ledger: false,
        max_steps: 100_000,
    }
}

/// The laboratory crane lifts for a second, holds, and lets its tip swing out; spools step twice.
fn lift(method: &str, max_step: f64) -> Run {
    let (model, start) = crane();
    let times = vec![0.0, 0.3, 1.3];
    let commands = Commands { times, values: vec![0.0, 0.0, 0.0, 0.03, 0.01, -0.01, 0.0, 0.0, 0.0], linear: false };
    simulate(model.as_ref(), &start, 2.0, &commands, &[2.0], &options(method, max_step), &mut |_| true)
}

/// Two seconds of tip control at 100 Hz with ideal sensors: 200 samples.
fn tip_control(method: &str, max_step: f64) -> Run {
    let (model, start) = crane();
    let mut controller = model.controller("tip").expect("a controller");
    let (times, deflections) = (vec![0.2, 1.2], vec![0.0, 0.5, 0.0, 0.0]);
    let sticks = Sticks { times, deflections, ramp: 0.2, ..Sticks::centred(StickKind::Tip, 2) };
    let plan = SampledPlan { sticks, sensors: Sensors::ideal(model.as_ref()), delay: 0.0 };
    let (record, options) = ([2.0], options(method, max_step));
    let model = model.as_ref();
    simulate_sampled(model, &start, 2.0, controller.as_mut(), &plan, &record, &options, &mut |_| true).run
}

/// Measured numbers of accepted and rejected steps, with room for what rounding does to a step size.
fn assert_near(run: &Run, measured: [u64; 2]) {
    let found = [run.accepted, run.rejected];
    let near = |(found, measured): (u64, u64)| found.abs_diff(measured) <= 4 + measured / 20;
    assert!(found.into_iter().zip(measured).all(near), "accepted and rejected: {found:?}, measured {measured:?}");
}

/// A fixed step costs a Jacobian, a factorisation and, besides the one that comes with the Jacobian, one right-hand side.
fn assert_fixed(run: &Run, steps: u64) {
    let effort = run.effort;
    assert_eq!((run.accepted, run.rejected), (steps, 0), "{}", run.outcome.message);
    assert_eq!([effort.derivatives, effort.jacobians, effort.factorisations], [steps; 3]);
}

#[test]
fn a_stiff_lift_takes_its_number_of_steps() {
    assert_near(&lift("rodas5p", 0.05), [280, 11]);
}

#[test]
fn a_lift_by_the_exponential_method_takes_its_number_of_steps() {
    assert_near(&lift("hc-exponential-4", 0.05), [233, 51]);
    assert_near(&tip_control("hc-exponential-4", 0.05), [260, 60]);
}

#[test]
fn an_explicit_lift_takes_its_number_of_steps() {
    assert_near(&lift("tsit5", 0.05), [659, 51]);
}

#[test]
fn fixed_steps_divide_every_interval_between_commands() {
    // 0.3, 1 and 0.7 s.
    assert_near(&lift("hc-rosenbrock-3", 0.005), [60 + 200 + 140, 0]);
    // Long ones are divided where spools jump, and while the crane swings on its oil faster than they follow.
    assert_near(&lift("hc-rosenbrock-3", 0.02), [250, 6]);
}

#[test]
fn a_stiff_closed_loop_takes_two_steps_per_sample() {
    assert_near(&tip_control("rodas5p", 0.05), [444, 79]);
}

#[test]
fn fixed_steps_divide_every_sample() {
    assert_fixed(&tip_control("hc-rosenbrock-3", 0.005), 400);
    assert_fixed(&tip_control("hc-rosenbrock-3", 0.004), 600);
    assert_fixed(&tip_control("hc-rosenbrock-3", 1.0), 200);
}

#[test]
fn a_stiff_attempt_costs_seven_right_hand_sides_and_one_factorisation() {
    for run in [lift("rodas5p", 0.05), tip_control("rodas5p", 0.05)] {
        let attempts = run.accepted + run.rejected;
        assert_eq!(run.effort.factorisations, attempts);
        assert_eq!(run.effort.derivatives, 7 * attempts);
        // One linearisation for each state that a step starts from.
        assert_eq!(run.effort.jacobians, run.accepted);
    }
}

/// What is known at the end of a step is not computed again at the start of the next; the three intervals between commands
/// begin anew.
#[test]
fn a_step_begins_with_what_the_last_one_ended_with() {
    let explicit = lift("tsit5", 0.05);
    assert_eq!(explicit.effort.derivatives, 6 * (explicit.accepted + explicit.rejected) + 3);
    let implicit = lift("hc-exponential-4", 0.05);
    let attempts = implicit.accepted + implicit.rejected;
    let effort = implicit.effort;
    assert_eq!([effort.derivatives, effort.jacobians, effort.factorisations], [2 * attempts, attempts + 3, attempts]);
}

/// Commands that a sample changes move the spools alone: what is linearised is steered, but for the first step.
#[test]
fn a_sample_of_a_controller_does_not_linearise_anew() {
    let run = tip_control("hc-exponential-4", 0.05);
    assert_eq!(run.effort.jacobians, run.accepted + run.rejected + 1);
}
