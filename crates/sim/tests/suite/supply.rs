//! Pump, mains and relief valve in a whole machine: steady states by hand, oil and energy accounted for, one pump for all.

use crate::{extended, ledger};
use hydrocrane_machine::{load, parse};
use hydrocrane_ode::Tolerances;
use hydrocrane_sim::{build, simulate, Commands, EquilibriumMode, Model, OutcomeKind, Run, RunOptions};
use std::sync::Arc;

const POSE: [f64; 3] = [1.745, 1.745, 0.0];
const SET: f64 = 140e5;

fn lab_with(more: &str) -> Arc<dyn Model> {
    extended("rottne-f9-pump", more)
}

fn pump() -> Arc<dyn Model> {
    lab_with("")
}

fn fixed() -> Arc<dyn Model> {
    extended(
        "rottne-f9-lab",
        r#"
        [pump.main]
        type = "fixed"
        displacement = "10 ml"
        speed = "1450 rpm"
        volumetric-efficiency = 0.94
        hydromechanical-efficiency = 0.9
        [mains]
        volume = "0.4 l"
        relief-gradient = "4 l/(min bar)"
        "#,
    )
}

/// Flow of the fixed pump without losses, m^3/s; the one of `rottne-f9-pump` gives 63 % of it.
const FULL: f64 = 10e-6 * 1450.0 / 60.0;

pub fn options(method: &str) -> RunOptions {
    RunOptions {
        method: method.to_string(),
        tolerances: Tolerances { relative: 1e-7, absolute: 1e-7, max_step: 0.02 },
        control: crate::control(method),
        payload: 0.0,
        payload_changes: Vec::new(),
        supply: None,
        ledger: true,
        max_steps: 1_000_000,
    }
}

/// Even steps of 1 ms where a method has them: return edges and curves are too steep for longer ones.
pub fn fine(method: &str) -> RunOptions {
    let mut options = options(method);
    if method == "hc-rosenbrock-3" {
        options.tolerances.max_step = 1e-3;
    }
    options
}

pub fn run(m: &dyn Model, end: f64, spools: [f64; 3], options: &RunOptions) -> Run {
    let start = m.equilibrium(&POSE, EquilibriumMode::Hold, options.payload).expect("a pose");
    let values = [[0.0; 3], [0.0; 3], spools].concat();
    let commands = Commands { times: vec![0.0, 0.1, 0.3], values, linear: true };
    let record: Vec<f64> = (0..=(end * 100.0) as usize).map(|i| i as f64 / 100.0).collect();
    let run = simulate(m, &start, end, &commands, &record, options, &mut |_| true);
    assert_eq!(run.outcome.kind, OutcomeKind::Completed, "{}", run.outcome.message);
    run
}

pub fn output(m: &dyn Model, x: &[f64], name: &str) -> f64 {
    let mut out = vec![0.0; m.output_info().len()];
    m.outputs(x, 0.0, &mut out);
    out[m.output_info().iter().position(|o| o.name == name).unwrap_or_else(|| panic!("no output {name}"))]
}

pub fn rows<'a>(m: &dyn Model, run: &'a Run) -> Vec<&'a [f64]> {
    run.states.chunks_exact(m.layout().len()).collect()
}

#[test]
fn a_crane_at_rest_leaves_its_supply_at_rest() {
    for (m, modes) in
        [(pump(), &[EquilibriumMode::Hold, EquilibriumMode::Steady][..]), (fixed(), &[EquilibriumMode::Hold])]
    {
        for mode in modes {
            let x = m.equilibrium(&POSE, *mode, 50.0).expect("a pose");
            let p = m.layout().mains().expect("mains");
            let u: Vec<f64> = (0..3).map(|c| x[m.layout().xs(c)]).collect();
            let mut dx = vec![0.0; x.len()];
            m.derivative(&x, &u, 50.0, &mut dx);
            // 1 Pa/s of mains of 0.4 l is 4e-13 m^3/s, of a pump of 2e-4 m^3/s.
            assert!(dx[p..].iter().all(|rate| rate.abs() < 1.0), "{mode:?} {:?}", &dx[p..]);
        }
    }
}

#[test]
fn at_rest_the_pressures_are_those_found_by_hand() {
    // The swivel gives what the pump leaks: 6 % of the full flow at 140 bar, so e = 0.06 p/140 bar and p = 140 bar - 6 bar e.
    let m = pump();
    let x = m.equilibrium(&POSE, EquilibriumMode::Hold, 0.0).expect("a pose");
    let p = m.layout().mains().expect("mains");
    let e = 0.06 / (1.0 + 0.06 * 6.0 / 140.0);
    assert!((x[p + 1] - e).abs() < 1e-12, "{} {e}", x[p + 1]);
    assert!((x[p] - (SET - 6e5 * e)).abs() < 1e-3, "{} Pa", x[p]);
    // All that a fixed pump gives at p, less its leakage, passes the relief valve, which opens at 140 bar.
    let m = fixed();
    let x = m.equilibrium(&POSE, EquilibriumMode::Hold, 0.0).expect("a pose");
    let (gradient, leakage) = (4e-3 / 60.0 / 1e5, 0.06 * FULL / SET);
    let by_hand = (FULL + gradient * SET) / (gradient + leakage);
    assert!((x[p] - by_hand).abs() < 1e-3, "{} {by_hand}", x[p]);
    assert!((output(m.as_ref(), &x, "mains.relief_flow") - gradient * (by_hand - SET)).abs() < 1e-12);
    let power = FULL * by_hand / 0.9;
    assert!((output(m.as_ref(), &x, "mains.shaft_power") - power).abs() < 1e-6 * power);
}

#[test]
fn the_mains_keep_all_oil_that_does_not_leave_them() {
    let m = pump();
    let m = m.as_ref();
    let done = run(m, 2.0, [0.045, 0.03, 0.02], &options("rodas5p"));
    let p = m.layout().mains().expect("mains");
    let (mut dx, mains) = (vec![0.0; m.layout().len()], m.machine().supply.mains.as_ref().expect("mains"));
    for (x, u) in rows(m, &done).iter().zip(done.commands.chunks_exact(3)) {
        m.derivative(x, u, 0.0, &mut dx);
        // d(rho V)/dt / rho
        let stored = dx[p] * ((mains.volume + mains.compliance * x[p]) / m.bulk_modulus(x[p]) + mains.compliance);
        let flows = ["mains.pump_flow", "mains.relief_flow", "supply.flow"].map(|name| output(m, x, name));
        let gap = stored - (flows[0] - flows[1] - flows[2]);
        assert!(gap.abs() < 1e-9 * FULL, "{gap} m^3/s");
    }
}

#[test]
fn every_joule_of_the_shaft_is_accounted_for() {
    for (m, method) in [(pump(), "rodas5p"), (fixed(), "rodas5p"), (pump(), "hc-exponential-4")] {
        let m = m.as_ref();
        let done = run(m, 2.5, [0.045, -0.02, 0.0], &options(method));
        assert!(done.warnings.iter().all(|w| w.kind != "energy-ledger-open"), "{:?}", done.warnings);
        let (gap, shaft) = (ledger::gap(m, &done), ledger::at_end(m, &done, "mains.shaft"));
        println!("{method}: shaft {shaft:.1} J, open {gap:.2e} J");
        assert!(shaft > 1000.0);
        assert!(gap < 1e-5 * shaft, "{gap} J of {shaft} J");
        let at_valves = ledger::at_end(m, &done, "supply");
        assert!((ledger::at_end(m, &done, "mains.delivered") - at_valves).abs() < 1e-9 * shaft);
    }
}

#[test]
fn functions_that_ask_for_more_than_the_pump_gives_share_it() {
    let m = pump();
    let m = m.as_ref();
    let travel = |spools: [f64; 3]| {
        let done = run(m, 1.5, spools, &options("rodas5p"));
        let rows = rows(m, &done);
        let moved = |c: usize| {
            let name = format!("cylinder.{}.x", m.machine().cylinders[c].name);
            output(m, rows[rows.len() - 1], &name) - output(m, rows[0], &name)
        };
        let p = m.layout().mains().expect("mains");
        let least = rows.iter().map(|x| x[p]).fold(f64::INFINITY, f64::min);
        let starved = done.warnings.iter().any(|w| w.kind == "pump-saturated");
        ([moved(0), moved(1)], least, starved)
    };
    let (lift, alone, starved) = travel([0.03, 0.0, 0.0]);
    assert!(alone > 0.9 * SET && !starved, "{alone}");
    let (both, together, starved) = travel([0.03, -0.05, 0.05]);
    assert!(together < 0.8 * SET && starved, "{together}");
    assert!(both[0] < 0.9 * lift[0] && both[0] > 0.1 * lift[0], "{both:?} {lift:?}");
    // No more flows out of the pump than it can give.
    let done = run(m, 1.5, [0.03, -0.05, 0.05], &options("rodas5p"));
    assert!(rows(m, &done).iter().all(|x| output(m, x, "mains.pump_flow") < 0.63 * FULL));
}

#[test]
fn a_check_valve_holds_the_load_where_the_mains_cannot_lift_it() {
    // 20 bar lift nothing here: without a check valve the boom sinks and presses oil back into the mains.
    let weak = |check: &str| {
        lab_with(&format!("[supply]\npressure = \"20 bar\"\n[mains]\nrelief-pressure = \"30 bar\"\n[valve.lift]\nload-check = \"{check}\""))
    };
    let sunk = |m: Arc<dyn Model>| {
        let done = run(m.as_ref(), 2.0, [0.03, 0.0, 0.0], &RunOptions { payload: 250.0, ..options("rodas5p") });
        let rows = rows(m.as_ref(), &done);
        output(m.as_ref(), rows[0], "cylinder.lift.x") - output(m.as_ref(), rows[rows.len() - 1], "cylinder.lift.x")
    };
    let (checked, free) = (sunk(weak("yes")), sunk(weak("no")));
    println!("sunk {checked} m with a check valve, {free} m without");
    assert!(checked.abs() < 5e-4, "{checked} m");
    assert!(free > 2e-3, "{free} m");
}

#[test]
fn all_methods_agree_on_a_crane_with_a_pump() {
    let m = pump();
    let m = m.as_ref();
    let end = |method: &str| {
        let done = run(m, 1.5, [0.04, -0.03, 0.02], &options(method));
        rows(m, &done).pop().expect("a row").to_vec()
    };
    let exact = end("rodas5p");
    for method in ["hc-exponential-4", "hc-rosenbrock-3"] {
        for ((a, b), scale) in end(method).iter().zip(&exact).zip(&m.layout().scales) {
            // Even steps of 20 ms at most resolve less.
            let share = if method == "hc-rosenbrock-3" { 2e-2 } else { 1e-4 };
            assert!((a - b).abs() < share * scale, "{method}: {a} {b}");
        }
    }
}

#[test]
fn a_pump_that_never_wants_for_oil_is_the_ideal_supply() {
    // A huge, quick pump with stiff control: the crane moves as on a constant pressure.
    let ideal = build(&load("rottne-f9-lab", &[]).expect("a machine")).expect("it can be built");
    let huge = {
        let text = r#"
            extends = "rottne-f9-lab"
            [machine]
            class = "assumed"
            [pump.main]
            type = "pressure-compensated"
            displacement = "900 ml"
            speed = "3000 rpm"
            volumetric-efficiency = 1
            hydromechanical-efficiency = 1
            control-range = "0.2 bar"
            time-constant = "1 ms"
            [mains]
            volume = "20 l"
        "#;
        build(&parse(text, "huge.toml", &[]).unwrap_or_else(|error| panic!("{error}"))).expect("it can be built")
    };
    let spools = [0.03, -0.02, 0.01];
    let (a, b) =
        (run(ideal.as_ref(), 1.5, spools, &options("rodas5p")), run(huge.as_ref(), 1.5, spools, &options("rodas5p")));
    let (a, b) = (
        rows(ideal.as_ref(), &a).pop().expect("a row").to_vec(),
        rows(huge.as_ref(), &b).pop().expect("a row").to_vec(),
    );
    let tips = [ideal.tip_in_plane(&a[..3]), huge.tip_in_plane(&b[..3])];
    let apart = (tips[0][0] - tips[1][0]).hypot(tips[0][1] - tips[1][1]);
    assert!(apart < 1e-4, "{apart} m");
}
