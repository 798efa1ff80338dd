//! Lines between valves and cylinders and an accumulator on the mains: compliance by hand, oil and energy accounted for.

use crate::supply::{options, output, rows, run};
use crate::{extended, ledger};
use hydrocrane_machine::parse;
use hydrocrane_sim::{EquilibriumMode, Model};
use std::f64::consts::FRAC_PI_4;
use std::sync::Arc;

const LENGTH: f64 = 6.0;
const COMPLIANCE: f64 = 0.08e-6 / 1e5;

/// A hose of 12 mm to one side of the boom's cylinder.
fn hose(side: &str, elastic: bool) -> String {
    let compliance = if elastic { "compliance = \"0.08 ml/bar\"\n" } else { "" };
    format!("[line.{side}]\ncylinder = \"lift\"\nside = \"{side}\"\nlength = \"6 m\"\ninner-diameter = \"12 mm\"\n{compliance}")
}

const GAS: &str = "[accumulator.main]\nvolume = \"0.5 l\"\nprecharge = \"60 bar\"\n";

fn lab(more: &str) -> Arc<dyn Model> {
    extended("rottne-f9-pump", more)
}

#[test]
fn a_line_takes_up_what_its_oil_and_its_walls_do() {
    let rate = |more: &str| {
        let m = extended("rottne-f9-lab", more);
        let mut x = m.equilibrium(&[1.745, 1.745, 0.0], EquilibriumMode::Hold, 0.0).expect("a pose");
        x[m.layout().xs(0)] = 0.02;
        let mut dx = vec![0.0; x.len()];
        m.derivative(&x, &[0.0; 3], 0.0, &mut dx);
        let p1 = m.layout().p1(0);
        (dx[p1], x[p1], output(m.as_ref(), &x, "cylinder.lift.x"), m)
    };
    let (bare, p, x, m) = rate("");
    let cylinder = &m.machine().cylinders[0];
    let chamber = cylinder.dead_volume[0] + FRAC_PI_4 * cylinder.bore.powi(2) * (cylinder.stroke / 2.0 + x);
    let (line, bulk) = (FRAC_PI_4 * 0.012f64.powi(2) * LENGTH, m.bulk_modulus(p));
    let (stiff, ..) = rate(&hose("piston-side", false));
    assert!((stiff / bare / (chamber / (chamber + line)) - 1.0).abs() < 1e-9, "{stiff} {bare}");
    let (soft, ..) = rate(&hose("piston-side", true));
    let capacity = (chamber + line + COMPLIANCE * p) / bulk + COMPLIANCE;
    assert!((soft / bare / (chamber / bulk / capacity) - 1.0).abs() < 1e-9, "{soft} {bare}");
}

const RESISTING: &str = "nominal-flow = \"30 l/min\"\nnominal-pressure-drop = \"8 bar\"\nlaminar-share = 0.4\n";

#[test]
fn a_resistance_takes_its_drop_before_the_edge() {
    let hoses = ["piston-side", "rod-side"].map(|side| hose(side, false) + RESISTING).concat();
    let m = extended("rottne-f9-lab", &hoses);
    let m = m.as_ref();
    let done = run(m, 1.5, [0.03, 0.0, 0.0], &options("rodas5p"));
    let x = rows(m, &done).pop().expect("a row").to_vec();
    let [q1, q2] = ["q1", "q2"].map(|q| output(m, &x, &format!("cylinder.lift.{q}")));
    let [drop1, drop2] = ["line_drop1", "line_drop2"].map(|drop| output(m, &x, &format!("cylinder.lift.{drop}")));
    let nominal = 30.0 / 60e3;
    let by_hand = |q: f64| 8e5 * (0.4 * q / nominal + 0.6 * (q / nominal).powi(2));
    assert!((drop1 / by_hand(q1) - 1.0).abs() < 1e-9 && (drop2 / -by_hand(q2) - 1.0).abs() < 1e-9, "{drop1} {drop2}");
    assert!(drop1 > 0.1e5, "{drop1}");
    // What is left falls over the edges, whose leakage the lines do not see.
    let (p1, p2) = (x[m.layout().p1(0)], x[m.layout().p2(0)]);
    let supply = &m.machine().supply;
    let leaks = m.machine().cylinders[0].valve.leakage * supply.pressure;
    let fed = m.orifice_flow(0, x[m.layout().xs(0)], supply.pressure - p1 - drop1);
    let drained = m.orifice_flow(0, x[m.layout().xs(0)], p2 + drop2 - supply.tank_pressure);
    assert!(
        (fed - q1).abs() < 1e-4 * q1 + leaks && (drained - q2).abs() < 1e-4 * q2 + leaks,
        "{fed} {q1} {drained} {q2}"
    );
    // In the same state the machine without lines has the whole drop at its edge.
    let bare = extended("rottne-f9-lab", "");
    let (free, whole) = (output(bare.as_ref(), &x, "cylinder.lift.q1"), supply.pressure - p1);
    println!("lines of {:.2} and {:.2} bar leave {:.4} of the flow", drop1 / 1e5, -drop2 / 1e5, q1 / free);
    assert!((q1 / free - ((whole - drop1) / whole).sqrt()).abs() < 1e-4 && q1 < 0.999 * free, "{q1} {free}");
}

#[test]
fn a_pump_that_senses_the_load_sees_what_the_line_takes() {
    let m = extended("rottne-f9-ls", &(hose("piston-side", false) + RESISTING));
    let m = m.as_ref();
    let done = run(m, 2.5, [0.03, 0.0, 0.0], &options("rodas5p"));
    let x = rows(m, &done).pop().expect("a row").to_vec();
    let (load, p1) = (x[m.layout().load().expect("load sensing")], x[m.layout().p1(0)]);
    let drop = output(m, &x, "cylinder.lift.line_drop1");
    assert!(drop > 0.1e5 && (load - p1 - drop).abs() < 0.02e5, "{load} {p1} {drop}");
}

#[test]
fn an_accumulator_gives_what_its_gas_pressed_out() {
    // A weak pump and a fast start: the mains fall, and the accumulator gives what the pump does not.
    let least = |more: &str| {
        let m = lab(more);
        let done = run(m.as_ref(), 1.0, [0.03, 0.03, 0.0], &options("rodas5p"));
        let p = m.layout().mains().expect("mains");
        rows(m.as_ref(), &done).iter().take(60).map(|x| x[p]).fold(f64::INFINITY, f64::min)
    };
    let (with, without) = (least(GAS), least(""));
    println!("the mains fall to {:.1} bar with an accumulator, to {:.1} bar without", with / 1e5, without / 1e5);
    assert!(with > without + 5e5, "{with} {without}");
    // Without consumers the pump fills it: the oil in the mains grows by what flows in.
    let m = lab(GAS);
    let m = m.as_ref();
    let done = run(m, 1.0, [0.03, 0.03, 0.0], &options("rodas5p"));
    let (p, mains) = (m.layout().mains().expect("mains"), m.machine().supply.mains.as_ref().expect("mains"));
    let mut dx = vec![0.0; m.layout().len()];
    for (x, u) in rows(m, &done).iter().zip(done.commands.chunks_exact(3)) {
        m.derivative(x, u, 0.0, &mut dx);
        let (empty, absolute) = (60e5 + 1.013_25e5, x[p] + 1.013_25e5);
        // Well above the precharge the gas follows its law alone.
        assert!(x[p] > 61e5, "{}", x[p]);
        let gas = 0.5e-3 * (empty / absolute).powf(1.0 / 1.4);
        let volume = mains.volume + mains.compliance * x[p] + 0.5e-3 - gas;
        let stored = dx[p] * (volume / m.bulk_modulus(x[p]) + mains.compliance + gas / (1.4 * absolute));
        let flows = ["mains.pump_flow", "mains.relief_flow", "supply.flow"].map(|name| output(m, x, name));
        let gap = stored - (flows[0] - flows[1] - flows[2]);
        assert!(gap.abs() < 1e-9 * 2.4e-4, "{gap} m^3/s");
    }
}

#[test]
fn energy_in_hoses_and_gas_is_accounted_for() {
    let hoses = hose("piston-side", true) + &hose("rod-side", true);
    let resisting = hoses.replace("compliance", &format!("{RESISTING}compliance"));
    for (more, method) in [
        (hoses.clone() + GAS, "rodas5p"),
        (hoses + GAS, "hc-exponential-4"),
        (resisting.clone(), "rodas5p"),
        (resisting, "hc-exponential-4"),
    ] {
        let m = lab(&more);
        let m = m.as_ref();
        let done = run(m, 2.0, [0.045, -0.02, 0.0], &options(method));
        let (gap, shaft) = (ledger::gap(m, &done), ledger::at_end(m, &done, "mains.shaft"));
        println!("{method}: shaft {shaft:.1} J, open {gap:.2e} J");
        assert!(shaft > 500.0 && gap < 1e-5 * shaft, "{gap} of {shaft} J");
    }
}

#[test]
fn a_line_or_an_accumulator_that_cannot_be_is_said() {
    let refused = |base: &str, more: &str| {
        let text = format!("extends = \"{base}\"\n[machine]\nclass = \"assumed\"\n{more}");
        parse(&text, "lines.toml", &[]).unwrap_err().to_string()
    };
    assert!(refused("rottne-f9-lab", GAS).contains("constant pressure"));
    assert!(refused("rottne-f9-pump", &(GAS.to_string() + &GAS.replace("main", "other"))).contains("second"));
    assert!(refused("rottne-f9-pump", &format!("{GAS}polytropic-exponent = 0.9\n")).contains("below 1"));
    let half = hose("rod-side", false).replace("inner-diameter = \"12 mm\"\n", "");
    assert!(refused("rottne-f9-lab", &half).contains("inner-diameter"));
    let with = |more: &str| refused("rottne-f9-lab", &(hose("rod-side", false) + more));
    assert!(with("nominal-pressure-drop = \"2 bar\"\n").contains("nominal-flow"));
    assert!(with("nominal-flow = \"20 l/min\"\nlaminar-share = 0.5\n").contains("computed"));
    assert!(with(&RESISTING.replace("0.4", "1.4")).contains("exceeds 1"));
    assert!(with(&format!("{RESISTING}[errata]\norifice-law = \"as-printed\"\n")).contains("orifice-law"));
    let volume =
        "[line.a]\ncylinder = \"lift\"\nside = \"rod-side\"\nvolume = \"0.1 l\"\nnominal-flow = \"20 l/min\"\n";
    assert!(refused("rottne-f9-lab", volume).contains("nominal-pressure-drop"));
    let twice = hose("rod-side", false) + &hose("rod-side", false).replace("line.rod-side", "line.other");
    assert!(refused("rottne-f9-lab", &twice).contains("already"));
}
