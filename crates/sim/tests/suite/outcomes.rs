//! Every way a run can end, and what it leaves behind.

use hydrocrane_machine::{load, OverrideValue};
use hydrocrane_ode::{StepControl, Tolerances};
use hydrocrane_sim::{build, simulate, Commands, EquilibriumMode, Model, OutcomeKind, Run, RunOptions};
use std::sync::Arc;

fn model(name: &str, changes: &[(&str, &str)]) -> Arc<dyn Model> {
    let changes: Vec<_> = changes.iter().map(|(k, v)| (k.to_string(), OverrideValue::Text(v.to_string()))).collect();
    build(&load(name, &changes).expect("a valid machine")).expect("a machine that can be built")
}

fn options(method: &str) -> RunOptions {
    RunOptions {
        method: method.to_string(),
        tolerances: Tolerances { relative: 1e-4, absolute: 1e-4, max_step: 0.05 },
        control: StepControl::Adaptive,
        payload: 0.0,
        payload_changes: Vec::new(),
        supply: None,
        ledger: true,
        max_steps: 1_000_000,
    }
}

fn start(m: &dyn Model, degrees: [f64; 2]) -> Vec<f64> {
    m.equilibrium(&[degrees[0].to_radians(), degrees[1].to_radians(), 0.0], EquilibriumMode::Hold, 0.0)
        .expect("a pose to rest in")
}

/// Spools held at constant positions.
fn hold(spools: [f64; 3]) -> Commands {
    Commands { times: vec![0.0], values: spools.to_vec(), linear: false }
}

fn run(m: &dyn Model, x0: &[f64], end: f64, commands: &Commands, options: &RunOptions) -> Run {
    let record: Vec<f64> = (0..=(end / 0.01) as usize).map(|i| i as f64 * 0.01).collect();
    simulate(m, x0, end, commands, &record, options, &mut |_| true)
}

#[test]
fn end_stops_hold_every_piston_at_full_supply() {
    let m = model("rottne-f9-lab", &[]);
    for sign in [1.0, -1.0] {
        let run =
            run(m.as_ref(), &start(m.as_ref(), [100.0, 100.0]), 60.0, &hold([0.05 * sign; 3]), &options("rodas5p"));
        assert_eq!(run.outcome.kind, OutcomeKind::Completed, "{}", run.outcome.message);
        let last = &run.states[run.states.len() - m.layout().len()..];
        let (mut x, mut gain) = ([0.0; 3], [0.0; 3]);
        m.strokes(&last[..3], &mut x, &mut gain);
        for (x, c) in x.iter().zip(&m.machine().cylinders) {
            assert!(x.abs() < c.stroke / 2.0, "{} at {x}", c.name);
        }
    }
}

#[test]
fn printed_spring_lets_the_lift_piston_out_and_the_run_says_so() {
    // Erratum E14: the program's end stop gives way to the supply pressure, the more so with its upward gravity (E1).
    let m = model("rottne-f9-lab", &[("errata.end-stop", "as-printed"), ("errata.gravity-sign", "as-printed")]);
    let run = run(m.as_ref(), &start(m.as_ref(), [100.0, 100.0]), 40.0, &hold([0.05, 0.0, 0.0]), &options("rodas5p"));
    assert_eq!(run.outcome.kind, OutcomeKind::StrokeLimit);
    assert!(run.outcome.message.contains("lift"), "{}", run.outcome.message);
    assert!(run.outcome.time > 1.0 && run.outcome.time < 40.0);
    let recorded = *run.times.last().expect("what was computed is kept");
    assert!((recorded - run.outcome.time).abs() < 1e-9);
    assert!(run.states.iter().chain(&run.ledger).all(|v| v.is_finite()));
}

#[test]
fn impossible_starts_are_named() {
    let m = model("rottne-f9-lab", &[]);
    let commands = hold([0.0; 3]);
    let mut beyond = start(m.as_ref(), [100.0, 100.0]);
    beyond[2] = 0.4;
    let outcome = run(m.as_ref(), &beyond, 1.0, &commands, &options("rodas5p")).outcome;
    assert_eq!(outcome.kind, OutcomeKind::BadState);
    assert!(outcome.message.contains("extension"), "{}", outcome.message);

    let mut unreal = start(m.as_ref(), [100.0, 100.0]);
    unreal[7] = f64::NAN;
    let outcome = run(m.as_ref(), &unreal, 1.0, &commands, &options("rodas5p")).outcome;
    assert_eq!(outcome.kind, OutcomeKind::BadState);
    assert!(outcome.message.contains(&m.layout().names[7]));

    let outcome = run(m.as_ref(), &unreal, 1.0, &commands, &options("euler")).outcome;
    assert!(outcome.message.contains("rodas5p"), "{}", outcome.message);
}

#[test]
fn a_run_can_be_interrupted_and_keeps_its_record() {
    let m = model("rottne-f9-lab", &[]);
    let x0 = start(m.as_ref(), [100.0, 100.0]);
    let record: Vec<f64> = (0..=6000).map(|i| f64::from(i) * 0.01).collect();
    // Commands that never rest keep the steps short enough for the question to be asked.
    let times: Vec<f64> = (0..6000).map(|i| f64::from(i) * 0.01).collect();
    let values = times.iter().flat_map(|t| [0.02 * t.sin(), 0.01, 0.0]).collect();
    let commands = Commands { times, values, linear: false };
    let run = simulate(m.as_ref(), &x0, 60.0, &commands, &record, &options("rodas5p"), &mut |t| t < 1.0);
    assert_eq!(run.outcome.kind, OutcomeKind::Interrupted);
    assert!(run.outcome.time >= 1.0 && run.outcome.time < 60.0 && run.times.len() > 90);
}

#[test]
fn a_run_that_takes_too_many_steps_is_given_up_with_a_cure() {
    let m = model("rottne-f9-lab", &[]);
    let x0 = start(m.as_ref(), [100.0, 100.0]);
    let run = run(m.as_ref(), &x0, 5.0, &hold([0.03, 0.0, 0.0]), &RunOptions { max_steps: 20, ..options("tsit5") });
    assert_eq!(run.outcome.kind, OutcomeKind::SolverFailed);
    assert!(run.outcome.message.contains("tolerance"));
    assert!(!run.times.is_empty());
}

#[test]
fn both_methods_agree() {
    let m = model("rottne-f9-lab", &[]);
    let x0 = start(m.as_ref(), [100.0, 100.0]);
    let commands = Commands {
        times: vec![0.0, 0.5, 1.0],
        values: vec![0.0, 0.0, 0.0, 0.03, 0.01, -0.01, 0.0, 0.0, 0.0],
        linear: true,
    };
    let end = |method: &str| {
        let tight =
            RunOptions { tolerances: Tolerances { relative: 1e-8, absolute: 1e-8, max_step: 0.05 }, ..options(method) };
        let run = run(m.as_ref(), &x0, 2.0, &commands, &tight);
        run.states[run.states.len() - m.layout().len()..].to_vec()
    };
    for ((a, b), scale) in end("rodas5p").iter().zip(&end("tsit5")).zip(&m.layout().scales) {
        assert!((a - b).abs() < 1e-5 * scale, "{a} {b}");
    }
}

#[test]
fn a_delayed_valve_moves_later_by_its_delay() {
    let commands =
        |at: f64| Commands { times: vec![0.0, at], values: vec![0.0, 0.0, 0.0, 0.02, 0.0, 0.0], linear: false };
    let end = |m: &dyn Model, at: f64| {
        let tight = Tolerances { relative: 1e-9, absolute: 1e-9, max_step: 0.05 };
        let run = run(
            m,
            &start(m, [100.0, 100.0]),
            1.0,
            &commands(at),
            &RunOptions { tolerances: tight, ..options("rodas5p") },
        );
        run.states[run.states.len() - m.layout().len()..].to_vec()
    };
    let (prompt, delayed) = (model("rottne-f9-lab", &[]), model("rottne-f9-lab", &[("valve.lift.delay", "50 ms")]));
    let (a, b) = (end(prompt.as_ref(), 0.25), end(delayed.as_ref(), 0.2));
    for ((a, b), scale) in a.iter().zip(&b).zip(&prompt.layout().scales) {
        assert!((a - b).abs() < 1e-5 * scale, "{a} {b}");
    }
}

#[test]
fn spool_speed_limit_slows_the_opening() {
    let limited = model("rottne-f9-lab", &[("valve.lift.velocity-limit", "0.1 m/s")]);
    let opening = run(
        limited.as_ref(),
        &start(limited.as_ref(), [100.0, 100.0]),
        0.2,
        &hold([0.05, 0.0, 0.0]),
        &options("rodas5p"),
    );
    let xs = limited.layout().xs(0);
    let at = |i: usize| opening.states[i * limited.layout().len() + xs];
    // At 0.1 m/s the spool needs half a second for its 50 mm.
    assert!((at(10) - 0.01).abs() < 1e-3 && at(20) < 0.021, "{} {}", at(10), at(20));
}
