//! The ground in a whole machine: every right-hand side agrees, energies close, what is set down comes to rest on it.

use crate::ledger;
use hydrocrane_machine::{load, OverrideValue};
use hydrocrane_ode::Tolerances;
use hydrocrane_sim::{build, simulate, Commands, EquilibriumMode, Model, OutcomeKind, PayloadChange, Run, RunOptions};
use std::sync::Arc;

/// Surface of the laboratory's floor, m; what hangs at the tip of a load of 300 kg reaches 1.082 m down.
const FLOOR: f64 = -1.21;
const STIFFNESS: f64 = 2e5;
/// Depth over which the spring begins, m.
const SOFT: f64 = 1e-3;

fn overrides() -> Vec<(String, OverrideValue)> {
    let number = |key: &str, value: f64| (key.to_string(), OverrideValue::Number(value));
    vec![
        number("ground.height", FLOOR),
        number("payload.hang", 0.32),
        number("payload.hang-growth", 0.044),
        number("ground.support.bunk.height", FLOOR + 0.35),
        number("ground.support.bunk.from", 1.4),
        number("ground.support.bunk.to", 2.0),
    ]
}

fn model(name: &str, overrides: &[(String, OverrideValue)]) -> Arc<dyn Model> {
    build(&load(name, overrides).expect("a machine")).expect("a machine that can be built")
}

fn lab() -> Arc<dyn Model> {
    model("rottne-f9-lab", &overrides())
}

/// A repeatable stream of numbers in (-1, 1).
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// Chains with sliding joints and without, each with a ground at the height of its tip in `q` less `above` and a support
/// under it whose edge the tip stands on. The base stands on a `slope`, rad.
fn touching(name: &str, q: &[f64], above: f64, slope: f64) -> Arc<dyn Model> {
    let [x, z] = model(name, &[]).tip_in_plane(q);
    let number = |key: &str, value: f64| (key.to_string(), OverrideValue::Number(value));
    model(
        name,
        &[
            number("environment.slope", slope),
            number("ground.height", z - above - 0.03),
            number("payload.hang", 0.02),
            number("payload.hang-growth", 0.001),
            number("ground.support.box.height", z - above + 0.1),
            number("ground.support.box.from", x + 0.06),
            number("ground.support.box.to", x + 0.5),
        ],
    )
}

/// A state near the middle of the joint limits, in slow motion.
fn some_state(m: &dyn Model, noise: &mut Noise) -> Vec<f64> {
    let n = m.layout().joints();
    let mut x = vec![0.0; m.layout().len()];
    for (i, l) in m.joint_limits().iter().enumerate() {
        x[i] = 0.5 * (l.lower + l.upper + 0.9 * noise.next() * (l.upper - l.lower));
        x[n + i] = 0.05 * noise.next();
    }
    for (i, name) in m.layout().names.iter().enumerate() {
        if name.ends_with("p1") || name.ends_with("p2") {
            x[i] = 75e5 + 60e5 * noise.next();
        }
    }
    x
}

const MACHINES: [&str; 3] = ["rottne-f9-lab", "hiab-xs031", "single-cylinder"];

/// `check` of machines whose ground bears in the state, of those whose ground the tip has not reached, with a payload.
fn everywhere(mut check: impl FnMut(&dyn Model, &[f64], f64)) {
    let mut bearing = 0;
    for name in MACHINES {
        let free = model(name, &[]);
        let mut noise = Noise(3);
        for i in 0..60 {
            let x = some_state(free.as_ref(), &mut noise);
            let n = free.layout().joints();
            let slope = if i % 2 == 0 { 0.0 } else { 0.3 * noise.next() };
            let m = touching(name, &x[..n], 0.05 * noise.next(), slope);
            let payload = if i % 3 == 0 { 0.0 } else { 60.0 * noise.next().abs() };
            let mut outputs = vec![0.0; m.output_info().len()];
            m.outputs_without_oil(&x, payload, &mut outputs);
            let up = m.output_info().iter().position(|o| o.name == "tip.contact.z").expect("an output of the ground");
            bearing += usize::from(outputs[up] > 100.0);
            check(m.as_ref(), &x, payload);
        }
    }
    assert!(bearing > 60, "the ground bears in {bearing} cases only");
}

#[test]
fn the_right_hand_side_equals_the_reference_on_the_ground() {
    everywhere(|m, x, payload| {
        let u = vec![0.004; m.layout().joints()];
        let mut fast = vec![0.0; x.len()];
        m.derivative(x, &u, payload, &mut fast);
        let slow = m.reference_derivative(x, &u, payload).expect("a corrected machine");
        for ((a, b), state) in fast.iter().zip(&slow).zip(&m.layout().names) {
            assert!((a - b).abs() <= 1e-9 * a.abs() + 1e-9, "{} {state}: {a} {b}", m.machine().name);
        }
    });
}

#[test]
fn the_jacobian_equals_central_differences_of_the_reference_on_the_ground() {
    everywhere(|m, x, payload| {
        let (n, u) = (m.layout().len(), vec![0.004; m.layout().joints()]);
        let mut jacobian = vec![0.0; n * n];
        m.jacobian(x, &u, payload, &mut jacobian);
        let joints = m.layout().joints();
        for column in 0..2 * joints {
            let h = 1e-6 * m.layout().scales[column];
            let at = |shift: f64| {
                let mut shifted = x.to_vec();
                shifted[column] += shift;
                m.reference_derivative(&shifted, &u, payload).expect("a corrected machine")
            };
            let (ahead, behind) = (at(h), at(-h));
            for row in joints..2 * joints {
                let difference = (ahead[row] - behind[row]) / (2.0 * h);
                let exact = jacobian[row * n + column];
                let scale: f64 =
                    (0..n).map(|k| (jacobian[row * n + k] * m.layout().scales[k]).abs()).fold(1e-9, f64::max);
                let error = (exact - difference).abs() * m.layout().scales[column];
                assert!(error < 2e-5 * scale, "{} {row} {column}: {exact} {difference}", m.machine().name);
            }
        }
    });
}

#[test]
fn far_above_the_ground_every_bit_is_that_of_the_machine_without() {
    let far = model("rottne-f9-lab", &[("ground.height".to_string(), OverrideValue::Number(-30.0))]);
    let free = model("rottne-f9-lab", &[]);
    let (x, u) = (some_state(free.as_ref(), &mut Noise(9)), [0.003; 3]);
    let derivatives = |m: &dyn Model| {
        let mut jacobian = vec![0.0; x.len() * x.len()];
        m.jacobian(&x, &u, 40.0, &mut jacobian);
        jacobian
    };
    let rates = |m: &dyn Model| {
        let mut dx = vec![0.0; x.len()];
        m.derivative(&x, &u, 40.0, &mut dx);
        dx
    };
    assert_eq!(rates(far.as_ref()), rates(free.as_ref()));
    assert_eq!(derivatives(far.as_ref()), derivatives(free.as_ref()));
    let names = |m: &dyn Model| m.output_info().iter().map(|o| o.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(far.as_ref()).len(), names(free.as_ref()).len() + 3);
}

fn options(method: &str, payload: f64, changes: &[(f64, f64)]) -> RunOptions {
    let step = if method == "hc-rosenbrock-3" { 1e-3 } else { 0.01 };
    RunOptions {
        method: method.into(),
        tolerances: Tolerances { relative: 1e-7, absolute: 1e-7, max_step: step },
        control: crate::control(method),
        payload,
        payload_changes: changes.iter().map(|&(time, mass)| PayloadChange { time, mass }).collect(),
        supply: None,
        ledger: true,
        max_steps: 1_000_000,
    }
}

/// Lowers the boom at a constant spool command (m), then closes the valve.
fn lowering(until: f64, spool: f64) -> Commands {
    Commands { times: vec![0.0, until], values: vec![spool, 0.0, 0.0, 0.0, 0.0, 0.0], linear: false }
}

const POSE: [f64; 3] = [1.9, 1.7, 0.0];

fn run(m: &dyn Model, end: f64, commands: &Commands, options: &RunOptions) -> Run {
    let start = m.equilibrium(&POSE, EquilibriumMode::Hold, options.payload).expect("a pose above the ground");
    let record: Vec<f64> = (0..=(end * 200.0) as usize).map(|i| i as f64 / 200.0).collect();
    let run = simulate(m, &start, end, commands, &record, options, &mut |_| true);
    assert_eq!(run.outcome.kind, OutcomeKind::Completed, "{}", run.outcome.message);
    run
}

/// Row `i` of the outputs.
fn row<'a>(m: &dyn Model, run: &'a Run, i: usize) -> &'a [f64] {
    &run.states[i * m.layout().len()..(i + 1) * m.layout().len()]
}

fn output(m: &dyn Model, run: &Run, name: &str, i: usize) -> f64 {
    ledger::outputs(m, run, i)[m.output_info().iter().position(|o| o.name == name).expect("an output")]
}

/// The largest gap of the ledger and what the contact took, J.
fn gap(m: &dyn Model, run: &Run) -> (f64, f64) {
    (ledger::gap(m, run), ledger::at_end(m, run, "ground.contact"))
}

#[test]
fn the_ledger_closes_over_a_drop_onto_the_ground() {
    let m = lab();
    let m = m.as_ref();
    let done = run(m, 18.0, &lowering(17.0, -0.02), &options("rodas5p", 100.0, &[]));
    let (worst, heat) = gap(m, &done);
    let deepest = (0..done.times.len()).map(|i| output(m, &done, "tip.contact.z", i)).fold(0.0, f64::max);
    println!("{worst} J open, {heat} J into the ground, {deepest} N at most");
    assert!(deepest > 1000.0 && heat > 1.0, "{deepest} N, {heat} J");
    assert!(worst < 1e-3 * heat, "{worst} J of {heat} J");
    assert!(done.warnings.iter().all(|w| w.kind != "energy-ledger-open"), "{:?}", done.warnings);
}

#[test]
fn steps_of_a_millisecond_follow_the_contact() {
    let m = lab();
    let m = m.as_ref();
    for payload in [0.0, 300.0] {
        let exact = run(m, 26.0, &lowering(24.0, -0.02), &options("rodas5p", payload, &[]));
        let even = run(m, 26.0, &lowering(24.0, -0.02), &options("hc-rosenbrock-3", payload, &[]));
        let apart = |i: usize| {
            let [a, b] = [&exact, &even].map(|run| m.tip_in_plane(&row(m, run, i)[..3]));
            (a[0] - b[0]).hypot(a[1] - b[1])
        };
        let worst = (0..exact.times.len()).map(apart).fold(0.0, f64::max);
        let pressed = (0..exact.times.len()).map(|i| output(m, &exact, "tip.contact.z", i)).fold(0.0, f64::max);
        let ends = [0, exact.times.len() - 1].map(|i| m.tip_in_plane(&row(m, &exact, i)[..3]));
        println!("{ends:?} {payload} kg: {worst} m apart, {pressed} N");
        assert!(pressed > 1000.0 && worst < 1e-3, "{payload} kg: {worst} m apart, {pressed} N");
        assert!(gap(m, &even).0 < 0.01 * gap(m, &even).1.max(100.0), "{:?}", gap(m, &even));
    }
}

#[test]
fn what_is_lowered_comes_to_rest_as_deep_as_the_spring_needs() {
    let m = lab();
    let m = m.as_ref();
    let done = run(m, 14.0, &lowering(7.0, -0.015), &options("rodas5p", 300.0, &[]));
    let last = done.times.len() - 1;
    let (tip, force) = (m.tip_in_plane(&row(m, &done, last)[..3]), output(m, &done, "tip.contact.z", last));
    let depth = FLOOR + 0.32 + 0.044 * 300f64.sqrt() - tip[1];
    println!("{depth} m deep under {force} N at {} m", tip[0]);
    assert!(tip[0] > 2.1, "beside the bunk: {}", tip[0]);
    assert!(force > 1000.0 && (depth - force / STIFFNESS - SOFT).abs() < 1e-4, "{depth} m under {force} N");
    assert!(m.tip_velocity(&row(m, &done, last)[..3], &row(m, &done, last)[3..6])[2].abs() < 1e-3);
}

#[test]
fn a_load_is_set_down_and_picked_up_again() {
    let m = lab();
    let m = m.as_ref();
    // Down onto the ground, let go there, taken again, lifted.
    let commands = Commands {
        times: vec![0.0, 7.0, 10.0],
        values: vec![-0.015, 0.0, 0.0, 0.0, 0.0, 0.0, 0.015, 0.0, 0.0],
        linear: false,
    };
    let done = run(m, 14.0, &commands, &options("rodas5p", 300.0, &[(8.0, 0.0), (9.0, 300.0)]));
    let at = |name: &str, t: f64| output(m, &done, name, (t * 200.0) as usize);
    assert!(at("tip.contact.z", 7.9) > 1000.0, "the ground carries {} N", at("tip.contact.z", 7.9));
    assert_eq!(at("tip.contact.z", 8.5), 0.0, "nothing hangs, the tip itself is high above");
    assert_eq!(at("tip.contact.z", 14.0), 0.0, "lifted off");
    assert!(at("tip.z", 14.0) > at("tip.z", 10.0) + 0.1);
    let (worst, heat) = gap(m, &done);
    println!("{worst} J open, {heat} J into the ground, {:?}", done.payload_events);
    assert!(worst < 1e-3 * heat, "{worst} J of {heat} J");
}

#[test]
fn the_bunk_carries_higher_than_the_ground() {
    let m = lab();
    let [x, z] = m.tip_in_plane(&POSE);
    let under = |height: f64| {
        let mut changed = overrides();
        changed.extend([
            ("ground.support.bunk.height".to_string(), OverrideValue::Number(height)),
            ("ground.support.bunk.from".to_string(), OverrideValue::Number(x - 0.3)),
            ("ground.support.bunk.to".to_string(), OverrideValue::Number(x + 0.3)),
        ]);
        model("rottne-f9-lab", &changed)
    };
    // A load of 100 kg that just stands on the bunk, and one that the bunk would have to lift.
    let hang = 0.32 + 0.44;
    let standing = under(z - hang + 0.004);
    let rest = standing.equilibrium(&POSE, EquilibriumMode::Hold, 100.0).expect("it rests on the bunk");
    let mut rates = vec![0.0; rest.len()];
    standing.derivative(&rest, &[0.0; 3], 100.0, &mut rates);
    assert!(rates[3..6].iter().all(|a| a.abs() < 1e-9), "at rest: {:?}", &rates[3..6]);
    let (mut carried, mut hanging) = ([0.0; 3], [0.0; 3]);
    standing.static_force(&POSE, 100.0, &mut carried);
    model("rottne-f9-lab", &[]).static_force(&POSE, 100.0, &mut hanging);
    assert!(carried[0] < hanging[0], "the bunk takes from the boom's cylinder");
    let error = under(z - hang + 0.3).equilibrium(&POSE, EquilibriumMode::Hold, 100.0).unwrap_err().to_string();
    assert!(error.contains("is inside the ground") && error.contains("raise the tip"), "{error}");
    assert!(
        under(z - hang + 0.3).equilibrium(&POSE, EquilibriumMode::Hold, 0.0).is_ok(),
        "without the load it is free"
    );
}
