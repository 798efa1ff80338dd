//! Compensators that follow late: at rest and step by hand, as without the lag once all is steady, also beyond what the pump gives.

use crate::supply::{options, output, rows, run};
use crate::{extended, ledger};
use hydrocrane_machine::parse;
use hydrocrane_sim::{EquilibriumMode, Model, Run};
use std::sync::Arc;

const POSE: [f64; 3] = [1.745, 1.745, 0.0];

/// Lift and jib of the crane with compensators before the spool follow with the time constant `lag`; "" for at once.
fn before(lag: &str, more: &str) -> Arc<dyn Model> {
    let late = match lag {
        "" => String::new(),
        lag => ["lift", "jib"].map(|name| format!("[valve.{name}]\ncompensator-time-constant = \"{lag}\"\n")).concat(),
    };
    extended("rottne-f9-mobile", &(late + more))
}

/// Sections that share the flow of a pump; lift and jib follow late.
fn sharing(lag: &str, displacement: &str) -> Arc<dyn Model> {
    let late = if lag.is_empty() { String::new() } else { format!("compensator-time-constant = \"{lag}\"\n") };
    let section = |name: &str| {
        format!(
            "[valve.{name}]\nnominal-flow = \"12 l/min\"\nnominal-pressure-drop = \"16 bar\"\noverlap = \"0 mm\"\n\
             compensator = \"behind-spool\"\nreturn-area-ratio = [0.4, 1.0]\n{late}"
        )
    };
    let pump = format!(
        "[supply]\npressure = \"180 bar\"\n[pump.main]\ntype = \"load-sensing\"\ndisplacement = \"{displacement}\"\n\
         speed = \"1450 rpm\"\nvolumetric-efficiency = 0.94\nhydromechanical-efficiency = 0.9\ncontrol-range = \"4 bar\"\n\
         ls-margin = \"20 bar\"\n[mains]\nvolume = \"0.4 l\"\nhose-compliance = \"0.04 ml/bar\"\nrelief-pressure = \"210 bar\"\n"
    );
    extended("rottne-f9-lab", &(["lift", "jib"].map(section).concat() + &pump))
}

fn last<'a>(m: &dyn Model, run: &'a Run) -> &'a [f64] {
    rows(m, run).pop().expect("a row")
}

fn at(m: &dyn Model, state: &str) -> usize {
    m.layout().names.iter().position(|name| name == state).unwrap_or_else(|| panic!("{state}"))
}

#[test]
fn at_rest_it_keeps_its_setting_over_the_tank() {
    let m = before("30 ms", "");
    let x = m.equilibrium(&POSE, EquilibriumMode::Hold, 0.0).expect("a pose");
    let (p, tank) = (x[m.layout().mains().expect("mains")], m.machine().supply.tank_pressure);
    let by_hand = (8e5 / (p - tank)).sqrt();
    for name in ["lift", "jib"] {
        let opening = x[at(m.as_ref(), &format!("cylinder.{name}.compensator"))];
        assert!((opening - by_hand).abs() < 1e-9, "{name}: {opening} {by_hand}");
    }
    // The extension's follows at once: it has no state.
    assert!(m.layout().names.iter().all(|name| name != "cylinder.extension.compensator"));
    // The same where the supply is ideal, with the spools open for the leakage.
    let ideal = "[valve.lift]\ncompensator = \"before-spool\"\ncompensator-setting = \"9 bar\"\nleakage = \"2e-14 m^3/(s Pa)\"\n\
        compensator-time-constant = \"30 ms\"\n";
    let m = extended("rottne-f9-lab", ideal);
    let x = m.equilibrium(&POSE, EquilibriumMode::Steady, 0.0).expect("a steady pose");
    let mut dx = vec![0.0; x.len()];
    m.derivative(&x, &[x[m.layout().xs(0)], x[m.layout().xs(1)], x[m.layout().xs(2)]], 0.0, &mut dx);
    let rate = dx[at(m.as_ref(), "cylinder.lift.compensator")];
    assert!(rate.abs() < 1e-9, "{rate}");
}

#[test]
fn after_a_disturbance_its_opening_returns_exponentially() {
    let m = before("40 ms", "");
    let m = m.as_ref();
    let mut x = m.equilibrium(&POSE, EquilibriumMode::Hold, 0.0).expect("a pose");
    let o = at(m, "cylinder.jib.compensator");
    let (settled, mut dx) = (x[o], vec![0.0; x.len()]);
    x[o] = 0.9;
    m.derivative(&x, &[0.0; 3], 0.0, &mut dx);
    assert!((dx[o] - (settled - 0.9) / 0.04).abs() < 1e-9, "{}", dx[o]);
    // Spool open by hand: the flow over the edge is the root of what the opening leaves of the drop.
    let (spool, share) = (m.layout().xs(1), 0.5);
    x[spool] = 0.005 + share * 0.045;
    let p = x[m.layout().mains().expect("mains")];
    x[m.layout().p1(1)] = p - 10e5;
    let by_hand = 12e-3 / 60.0 * share * (0.81 * 10e5 / 8e5f64).sqrt();
    let q = output(m, &x, "cylinder.jib.q1");
    assert!((q / by_hand - 1.0).abs() < 1e-4, "{q} {by_hand}");
    let taken = output(m, &x, "cylinder.jib.compensator_drop");
    assert!((taken - 0.19 * 10e5).abs() < 1.0, "{taken}");
}

/// Largest difference of two states of which the second has openings too, by their scales and sizes.
fn apart(m: &dyn Model, x: &[f64], late: &dyn Model, y: &[f64]) -> f64 {
    let of = |(i, name): (usize, &String)| {
        let other = y[at(late, name)];
        (x[i] - other).abs() / (m.layout().scales[i] + x[i].abs())
    };
    m.layout().names.iter().enumerate().map(of).fold(0.0, f64::max)
}

#[test]
fn steady_motion_is_that_without_the_lag() {
    let spools = [0.02, -0.015, 0.02];
    let end = |m: &dyn Model| last(m, &run(m, 3.0, spools, &options("rodas5p"))).to_vec();
    for (at_once, late) in [(before("", ""), before("50 ms", "")), (sharing("", "18 ml"), sharing("50 ms", "18 ml"))] {
        let (m, late) = (at_once.as_ref(), late.as_ref());
        let (x, y) = (end(m), end(late));
        for name in ["lift", "jib", "extension"] {
            let flow = |m: &dyn Model, x: &[f64]| output(m, x, &format!("cylinder.{name}.q1"));
            let (at_once, late) = (flow(m, &x), flow(late, &y));
            assert!((at_once - late).abs() < 3e-3 * at_once.abs(), "{name}: {at_once} {late}");
        }
    }
}

#[test]
fn a_short_lag_changes_the_run_in_proportion() {
    let spools = [0.03, -0.02, 0.02];
    let end = |m: &dyn Model| last(m, &run(m, 0.6, spools, &options("rodas5p"))).to_vec();
    let m = before("", "");
    let m = m.as_ref();
    let x = end(m);
    let [long, short] = ["4 ms", "1 ms"].map(|lag| {
        let late = before(lag, "");
        apart(m, &x, late.as_ref(), &end(late.as_ref()))
    });
    println!("4 ms: {long:.2e}, 1 ms: {short:.2e}");
    assert!(short < 0.4 * long && short > 0.1 * long && long < 0.1, "{long} {short}");
}

#[test]
fn beyond_what_the_pump_gives_the_highest_load_has_its_compensator_open() {
    let m = before("50 ms", "[pump.main]\ndisplacement = \"12 ml\"\n");
    let m = m.as_ref();
    let done = run(m, 1.5, [0.045, 0.04, 0.0], &options("rodas5p"));
    let x = last(m, &done);
    let p = x[m.layout().mains().expect("mains")];
    for (c, name) in ["lift", "jib"].into_iter().enumerate() {
        let (opening, drop) = (x[at(m, &format!("cylinder.{name}.compensator"))], p - x[m.layout().p1(c)]);
        let by_hand = (drop.min(8e5) / drop).sqrt();
        assert!((opening - by_hand).abs() < 2e-3, "{name}: {opening} {by_hand}");
        // The lift has the higher load: its section starves.
        assert_eq!(by_hand < 0.95, name == "jib", "{name}: {by_hand}");
    }
    assert!(done.warnings.iter().any(|w| w.kind == "pump-saturated"), "{:?}", done.warnings);
    // Flow sharing: the proportions hold.
    let m = sharing("50 ms", "7 ml");
    let m = m.as_ref();
    let done = run(m, 2.0, [0.045, 0.03, 0.0], &options("rodas5p"));
    let x = last(m, &done);
    let [lift, jib] = ["lift", "jib"].map(|name| output(m, x, &format!("cylinder.{name}.q1")));
    assert!((lift / jib / 1.5 - 1.0).abs() < 0.02, "{lift} {jib}");
}

#[test]
fn every_joule_is_accounted_for_by_all_methods() {
    for (m, method) in [
        (before("40 ms", ""), "rodas5p"),
        (before("40 ms", "[pump.main]\ndisplacement = \"7 ml\"\n"), "hc-exponential-4"),
        (sharing("20 ms", "7 ml"), "rodas5p"),
    ] {
        let m = m.as_ref();
        let done = run(m, 2.5, [0.045, -0.03, 0.02], &options(method));
        let (gap, shaft) = (ledger::gap(m, &done), ledger::at_end(m, &done, "mains.shaft"));
        let lost = ledger::at_end(m, &done, "valves.compensators");
        println!("{method}: shaft {shaft:.1} J, compensators {lost:.1} J, open {gap:.2e} J");
        assert!(lost > 0.02 * shaft && gap < 2e-5 * shaft, "{lost} {gap} of {shaft} J");
    }
    let m = before("40 ms", "");
    let m = m.as_ref();
    let end = |method: &str| last(m, &run(m, 1.5, [0.04, -0.03, 0.02], &options(method))).to_vec();
    let exact = end("rodas5p");
    for method in ["hc-exponential-4", "hc-rosenbrock-3"] {
        assert!(apart(m, &exact, m, &end(method)) < 1e-3, "{method}");
    }
}

#[test]
fn a_lag_without_a_compensator_is_refused() {
    let text = "extends = \"rottne-f9-lab\"\n[machine]\nclass = \"assumed\"\n[valve.lift]\ncompensator-time-constant = \"20 ms\"\n";
    let shown = parse(text, "circuit.toml", &[]).unwrap_err().to_string();
    assert!(shown.contains("valve.lift.compensator-time-constant") && shown.contains("no compensator"), "{shown}");
    let text = text.replace("rottne-f9-lab", "rottne-f9-mobile").replace("20 ms", "0 ms");
    let shown = parse(&text, "circuit.toml", &[]).unwrap_err().to_string();
    assert!(shown.contains("greater than zero"), "{shown}");
}
