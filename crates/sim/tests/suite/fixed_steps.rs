//! Fixed steps on the crane: order, stability, static friction by its secant, and how a run ends that cannot go on.

use hydrocrane_machine::{load, OverrideValue};
use hydrocrane_ode::BlockArrow;
use hydrocrane_ode::Tolerances;
use hydrocrane_sim::{build, simulate, Commands, EquilibriumMode, Model, OutcomeKind, Run, RunOptions};
use std::sync::Arc;

const CYLINDERS: [&str; 3] = ["lift", "jib", "extension"];

fn crane(changes: &[(String, OverrideValue)]) -> Arc<dyn Model> {
    build(&load("rottne-f9-lab", changes).expect("a valid machine")).expect("it can be built")
}

fn static_friction() -> Vec<(String, OverrideValue)> {
    CYLINDERS.map(|c| (format!("friction.{c}.model"), OverrideValue::Text("static".into()))).to_vec()
}

fn run(model: &dyn Model, commands: &Commands, end: f64, method: &str, tolerance: f64, max_step: f64) -> Run {
    let options = RunOptions {
        method: method.to_string(),
        tolerances: Tolerances { relative: tolerance, absolute: tolerance, max_step },
        control: crate::control(method),
        payload: 0.0,
        payload_changes: Vec::new(),
        supply: None,
        ledger: false,
        max_steps: 10_000_000,
    };
    let q = [100f64.to_radians(), 100f64.to_radians(), 0.0];
    let start = model.equilibrium(&q, EquilibriumMode::Hold, 0.0).expect("a pose inside the limits");
    let record: Vec<f64> = (0..=100).map(|i| end * f64::from(i) / 100.0).collect();
    simulate(model, &start, end, commands, &record, &options, &mut |_| true)
}

/// Starts, stops and reversals of all cylinders.
fn to_and_fro() -> Commands {
    let rows = [[0.02, 0.006, -0.01], [0.0; 3], [-0.01, 0.01, 0.01], [0.0; 3]];
    Commands { times: vec![0.1, 0.8, 1.2, 1.8], values: rows.concat(), linear: false }
}

/// Largest distance of the tips at the recorded times, m.
fn distance(model: &dyn Model, a: &Run, b: &Run) -> f64 {
    assert_eq!(a.times, b.times, "{} / {}", a.outcome.message, b.outcome.message);
    let n = model.layout().len();
    let tips = a
        .states
        .chunks_exact(n)
        .zip(b.states.chunks_exact(n))
        .map(|(a, b)| [model.tip_in_plane(a), model.tip_in_plane(b)]);
    tips.map(|[a, b]| (a[0] - b[0]).hypot(a[1] - b[1])).fold(0.0, f64::max)
}

#[test]
fn halving_the_step_divides_the_error_of_the_tip_by_eight() {
    // A ramp, without corners but its ends, and steps short against the spool's lag.
    let commands = Commands { times: vec![0.0, 0.4], values: [[0.0; 3], [0.02, 0.006, -0.01]].concat(), linear: true };
    let model = crane(&[]);
    let exact = run(model.as_ref(), &commands, 0.4, "rodas5p", 1e-12, 0.05);
    let errors = [4e-4, 2e-4, 1e-4].map(|step| {
        let end = run(model.as_ref(), &commands, 0.4, "hc-rosenbrock-3", 1e-4, step);
        distance(model.as_ref(), &end, &exact)
    });
    let order = (errors[0] / errors[2]).log2() / 2.0;
    assert!((order - 3.0).abs() < 0.2, "{order}: {errors:?}");
}

#[test]
fn long_steps_stay_stable_and_near_with_either_friction() {
    for changes in [vec![], static_friction()] {
        let model = crane(&changes);
        let exact = run(model.as_ref(), &to_and_fro(), 2.5, "rodas5p", 1e-7, 0.05);
        for (step, most) in [(0.01, 1e-3), (0.005, 6e-4), (0.001, 4e-4)] {
            let fixed = run(model.as_ref(), &to_and_fro(), 2.5, "hc-rosenbrock-3", 1e-4, step);
            let worst = distance(model.as_ref(), &fixed, &exact);
            assert!(
                fixed.warnings.iter().all(|warning| warning.kind != "step-inexact"),
                "{step}: {:?}",
                fixed.warnings
            );
            assert!(worst < most, "{} at {step}: {worst}", model.layout().len());
        }
    }
}

#[test]
fn a_run_whose_steps_are_too_long_for_its_mains_says_so() {
    // Return pressures of their own and a pump that senses the load: mains of 0.4 l answer within a few milliseconds.
    let of = |valve| format!("[valve.{valve}]\nreturn-area-ratio = 1\nreturn-pressure = [\"60 bar\", \"6 bar\"]\n");
    let model = crate::extended("rottne-f9-ls", &CYLINDERS.map(of).concat());
    let m = model.as_ref();
    let commands = Commands {
        times: vec![0.0, 0.1, 0.3],
        values: [[0.0; 3], [0.0; 3], [0.03, -0.03, 0.02]].concat(),
        linear: true,
    };
    let mains = m.layout().mains().expect("mains");
    let exact = run(m, &commands, 1.5, "rodas5p", 1e-7, 0.05);
    for step in [0.05, 0.02, 0.01, 0.001] {
        let fixed = run(m, &commands, 1.5, "hc-rosenbrock-3", 1e-4, step);
        let n = m.layout().len();
        let rows = fixed.states.chunks_exact(n).zip(exact.states.chunks_exact(n)).skip(50);
        let off = rows.map(|(a, b)| (a[mains] / b[mains] - 1.0).abs()).sum::<f64>() / 51.0;
        let warnings: Vec<_> = fixed.warnings.iter().filter(|warning| warning.kind == "step-inexact").collect();
        println!("{:.0} ms: {:.2} % off in the mean, {warnings:?}", 1e3 * step, 100.0 * off);
        assert!(off <= 0.01 || warnings.len() == 1, "{step}: {off}");
        assert!(step > 0.01 || warnings.is_empty(), "{step}: {warnings:?}");
        assert!(warnings.iter().all(|warning| warning.cure.contains("step") && warning.time < 1.0), "{warnings:?}");
    }
    // Without a fixed step there is no such estimate, however loose the tolerance.
    let loose = run(m, &commands, 1.5, "rodas5p", 1e-2, 0.05);
    assert!(loose.warnings.iter().all(|warning| warning.kind != "step-inexact"));
}

#[test]
fn secants_replace_the_slope_of_static_friction_alone() {
    for changes in [vec![], static_friction()] {
        let model = crane(&changes);
        let layout = model.layout();
        let mut x = vec![0.0; layout.len()];
        let q = [100f64.to_radians(), 100f64.to_radians(), 0.0];
        x.copy_from_slice(&model.equilibrium(&q, EquilibriumMode::Hold, 0.0).expect("a pose inside the limits"));
        let (mut position, mut gain) = ([0.0; 3], [0.0; 3]);
        model.strokes(&q, &mut position, &mut gain);
        // The telescope retracts through the steep part of its map, at one and a half times its width.
        let v = -1.5e-3;
        x[layout.qd(2)] = v / gain[2];
        let derivatives = |secants: bool| {
            let mut derivatives = BlockArrow { secants, ..BlockArrow::new(layout.blocks()) };
            model.linearise(&x, &[0.0; 3], 0.0, &mut vec![0.0; layout.len()], &mut derivatives);
            let mut dense = vec![0.0; layout.len() * layout.len()];
            derivatives.write_dense(layout.len(), &mut dense);
            (derivatives.cylinders[2].force.qd, dense)
        };
        let ((tangent, exact), (secant, other)) = (derivatives(false), derivatives(true));
        let changed: Vec<usize> =
            (0..exact.len()).filter(|&i| exact[i] != other[i]).map(|i| i / layout.len()).collect();
        if changes.is_empty() {
            assert!(changed.is_empty());
            continue;
        }
        let friction = |v: f64| model.steady_friction(2, v);
        let steep = (friction(v + 1e-7) - friction(v - 1e-7)) / 2e-7;
        let less = (tangent - secant) / gain[2] - (friction(v) / v - steep);
        assert!(less.abs() < 1e-4 * (friction(v) / v), "{less}");
        let accelerations = layout.qd(0)..layout.qd(0) + 3;
        assert!(!changed.is_empty() && changed.iter().all(|row| accelerations.contains(row)), "{changed:?}");
    }
}

#[test]
fn the_printed_jump_of_friction_is_crossed_without_chatter() {
    let model = build(&load("heinze-2007", &[]).expect("a bundled machine")).expect("it can be built");
    let loose = run(model.as_ref(), &to_and_fro(), 1.0, "hc-rosenbrock-3", 1e-4, 2e-3);
    let fine = run(model.as_ref(), &to_and_fro(), 1.0, "hc-rosenbrock-3", 1e-4, 5e-5);
    assert_eq!(loose.outcome.kind, OutcomeKind::Completed, "{}", loose.outcome.message);
    assert!((500..=510).contains(&(loose.accepted + loose.rejected)), "{} {}", loose.accepted, loose.rejected);
    let apart = distance(model.as_ref(), &loose, &fine);
    assert!(apart < 2e-3, "{apart}");
}

#[test]
fn a_run_that_cannot_go_on_says_so_and_keeps_what_it_has() {
    let model = crane(&[]);
    let out = Commands { times: vec![0.0], values: vec![0.05; 3], linear: false };
    let long = run(model.as_ref(), &out, 60.0, "hc-rosenbrock-3", 1e-4, 5.0);
    assert!(long.outcome.kind != OutcomeKind::Completed && !long.times.is_empty());
    assert!(long.states.iter().all(|v| v.is_finite()), "{}", long.outcome.message);
    assert!(!long.outcome.message.is_empty() && long.rejected <= 64 * 12, "{}", long.rejected);
}

#[test]
fn a_step_is_cut_where_a_chamber_cavitates_and_the_work_stays_bounded() {
    let model = build(&load("hiab-xs031", &[]).expect("a bundled machine")).expect("it can be built");
    let start = model.equilibrium(&[0.939, -1.279, 0.55], EquilibriumMode::Hold, 300.0).expect("a pose");
    let options = |method: &str, tolerance: f64, max_step: f64| RunOptions {
        method: method.to_string(),
        tolerances: Tolerances { relative: tolerance, absolute: tolerance, max_step },
        control: crate::control(method),
        payload: 300.0,
        payload_changes: Vec::new(),
        supply: None,
        ledger: true,
        max_steps: 10_000_000,
    };
    let lower = Commands { times: vec![0.0], values: vec![-0.01, 0.0, 0.0], linear: false };
    let record: Vec<f64> = (0..=100).map(|i| 0.01 * f64::from(i)).collect();
    let go = |o: RunOptions| simulate(model.as_ref(), &start, 1.0, &lower, &record, &o, &mut |_| true);
    let exact = go(options("rodas5p", 1e-8, 0.05));
    for (step, most) in [(1e-3, 5e-4), (5e-3, 5e-3)] {
        let even = go(options("hc-rosenbrock-3", 1e-4, step));
        assert_eq!(even.outcome.kind, OutcomeKind::Completed, "{}", even.outcome.message);
        let apart = distance(model.as_ref(), &even, &exact);
        assert!(apart < most, "{step}: {apart}");
        let of_the_machine = ["pressure-above-rating", "cavitation", "start-not-held"];
        assert!(even.warnings.iter().all(|w| of_the_machine.contains(&w.kind)), "{:?}", even.warnings);
        assert!((even.accepted + even.rejected) as f64 <= 1.4 / step, "{} {}", even.accepted, even.rejected);
    }
}
