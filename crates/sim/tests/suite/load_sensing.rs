//! Load sensing and pressure compensators in a whole machine: flows and pressures by hand, below and above what the pump gives.

use crate::supply::{options, output, rows, run};
use crate::{extended, ledger};
use hydrocrane_machine::{load, parse};
use hydrocrane_sim::{EquilibriumMode, Model, Run};
use std::sync::Arc;

/// The crane with compensators before the spool.
fn mobile(more: &str) -> Arc<dyn Model> {
    extended("rottne-f9-mobile", more)
}

/// A pump that two functions exceed.
const SMALL: &str = "[pump.main]\ndisplacement = \"7 ml\"\n";

/// The lab's crane with sections that share the flow of a load-sensing pump.
fn sharing(displacement: &str) -> Arc<dyn Model> {
    let section = |name: &str| {
        format!(
            "[valve.{name}]\ntype = \"4/3\"\nnominal-flow = \"12 l/min\"\nnominal-pressure-drop = \"16 bar\"\n\
             compensator = \"behind-spool\"\nreturn-area-ratio = [0.4, 1.0]\n"
        )
    };
    let sections = ["lift", "jib", "extension"].map(section).concat();
    let pump = format!(
        "[supply]\npressure = \"180 bar\"\n[pump.main]\ntype = \"load-sensing\"\ndisplacement = \"{displacement}\"\n\
         speed = \"1450 rpm\"\nvolumetric-efficiency = 0.94\nhydromechanical-efficiency = 0.9\ncontrol-range = \"4 bar\"\n\
         ls-margin = \"20 bar\"\n[mains]\nvolume = \"0.4 l\"\nhose-compliance = \"0.04 ml/bar\"\nrelief-pressure = \"210 bar\"\n"
    );
    extended("rottne-f9-lab", &(sections + &pump))
}

const RANGE: f64 = 4e5;
const MARGIN: f64 = 20e5;
const SETTING: f64 = 8e5;
/// Of lift and jib at full opening, m^3/s.
const NOMINAL: f64 = 12e-3 / 60.0;

/// Share of the opening at the spool position `spool` (m), with and without the 5 mm of overlap.
fn opening(spool: f64, overlap: f64) -> f64 {
    (spool.abs() - overlap) / (0.05 - overlap)
}

fn last<'a>(m: &dyn Model, run: &'a Run) -> &'a [f64] {
    rows(m, run).pop().expect("a row")
}

#[test]
fn the_pump_stands_by_at_its_margin() {
    let m = mobile("");
    let x = m.equilibrium(&[1.745, 1.745, 0.0], EquilibriumMode::Hold, 50.0).expect("a pose");
    let layout = m.layout();
    let [p, load, e] = [layout.mains(), layout.load(), layout.swivel()].map(|at| x[at.expect("a state")]);
    let tank = m.machine().supply.tank_pressure;
    assert_eq!(load, tank);
    assert!((p - (tank + MARGIN - RANGE * e)).abs() < 1.0, "{p} Pa at {e}");
    // Little displacement makes up for the leakage of pump and valves.
    assert!(e > 0.0 && e < 0.02, "{e}");
    let mut dx = vec![0.0; x.len()];
    m.derivative(&x, &[0.0; 3], 50.0, &mut dx);
    assert!(dx[layout.blocks().shared.first..].iter().all(|rate| rate.abs() < 1.0), "{dx:?}");
}

#[test]
fn a_fixed_pump_idles_at_its_margin_and_gives_the_rest_to_the_tank() {
    let m = extended(
        "rottne-f9-lab",
        "[pump.main]\ntype = \"fixed\"\ndisplacement = \"10 ml\"\nspeed = \"1450 rpm\"\nvolumetric-efficiency = 0.94\n\
         hydromechanical-efficiency = 0.9\nls-margin = \"12 bar\"\n[mains]\nvolume = \"0.4 l\"\nrelief-gradient = \"4 l/(min bar)\"\n",
    );
    let x = m.equilibrium(&[1.745, 1.745, 0.0], EquilibriumMode::Hold, 0.0).expect("a pose");
    let machine = m.machine();
    let (full, gradient, tank) = (10e-6 * 1450.0 / 60.0, 4e-3 / 60.0 / 1e5, machine.supply.tank_pressure);
    let leakage = 0.06 * full / (machine.supply.pressure - tank);
    let by_hand = (full + gradient * (tank + 12e5) + leakage * tank) / (gradient + leakage);
    let p = x[m.layout().mains().expect("mains")];
    assert!((p - by_hand).abs() < 10.0, "{p} {by_hand}");
    // Under load the relief valve keeps the margin over it.
    let done = run(m.as_ref(), 1.5, [0.03, 0.0, 0.0], &options("rodas5p"));
    let x = last(m.as_ref(), &done);
    let [p, load] = [m.layout().mains(), m.layout().load()].map(|at| x[at.expect("a state")]);
    let relieved = output(m.as_ref(), x, "mains.relief_flow");
    assert!(load > 10e5 && (p - (load + 12e5 + relieved / gradient)).abs() < 1.0, "{p} {load} {relieved}");
}

#[test]
fn while_the_pump_suffices_no_flow_depends_on_the_load() {
    let m = mobile("");
    let m = m.as_ref();
    for payload in [0.0, 250.0] {
        let spools = [0.02, 0.015, 0.02];
        let done = run(m, 1.5, spools, &hydrocrane_sim::RunOptions { payload, ..options("rodas5p") });
        let x = last(m, &done);
        for (name, spool, nominal) in
            [("lift", 0.02, NOMINAL), ("jib", 0.015, NOMINAL), ("extension", 0.02, 0.5 * NOMINAL)]
        {
            let (q, wanted) = (output(m, x, &format!("cylinder.{name}.q1")), nominal * opening(spool, 0.005));
            assert!((q / wanted - 1.0).abs() < 1e-6, "{name} with {payload} kg: {q} {wanted}");
        }
        let [p, load, e] =
            [m.layout().mains(), m.layout().load(), m.layout().swivel()].map(|at| x[at.expect("a state")]);
        assert!((p - (load + MARGIN - RANGE * e)).abs() < 0.5e5, "{p} {load} {e}");
        assert!(done.warnings.iter().all(|w| w.kind != "pump-saturated"), "{:?}", done.warnings);
    }
}

#[test]
fn when_the_pump_is_exceeded_the_highest_load_starves() {
    let m = mobile(SMALL);
    let m = m.as_ref();
    let (spools, overlap) = ([0.045, 0.04, 0.0], 0.005);
    let done = run(m, 1.5, spools, &options("rodas5p"));
    let x = last(m, &done);
    let share =
        |c: usize, name: &str| output(m, x, &format!("cylinder.{name}.q1")) / (NOMINAL * opening(spools[c], overlap));
    let pressures = [x[m.layout().p1(0)], x[m.layout().p1(1)]];
    let mut shares = [share(0, "lift"), share(1, "jib")];
    if pressures[0] < pressures[1] {
        shares.swap(0, 1);
    }
    let [heavy, light] = shares;
    assert!(heavy < 0.5 && light > 0.95, "{heavy} {light}");
    assert!(done.warnings.iter().any(|w| w.kind == "pump-saturated"), "{:?}", done.warnings);
}

#[test]
fn sections_that_share_the_flow_keep_their_proportions() {
    for displacement in ["18 ml", "7 ml"] {
        let m = sharing(displacement);
        let m = m.as_ref();
        let spools = [0.045, 0.03, 0.0];
        let done = run(m, 1.5, spools, &options("rodas5p"));
        let x = last(m, &done);
        let [lift, jib] = ["lift", "jib"].map(|name| output(m, x, &format!("cylinder.{name}.q1")));
        assert!((lift / jib / (0.045 / 0.03) - 1.0).abs() < 0.02, "{displacement}: {lift} {jib}");
        let [p, load] = [m.layout().mains(), m.layout().load()].map(|at| x[at.expect("a state")]);
        let by_hand = NOMINAL * opening(0.045, 0.0) * ((p - load) / SETTING).sqrt();
        assert!((lift / by_hand - 1.0).abs() < 0.02, "{displacement}: {lift} {by_hand}");
        let saturated = done.warnings.iter().any(|w| w.kind == "pump-saturated");
        assert_eq!(saturated, displacement == "7 ml", "{:?}", done.warnings);
    }
}

#[test]
fn a_cylinder_at_its_end_brings_the_pump_to_its_highest_pressure() {
    let m = mobile("");
    let m = m.as_ref();
    let done = run(m, 20.0, [0.0, 0.0, 0.05], &options("rodas5p"));
    let x = last(m, &done);
    let [p, e] = [m.layout().mains(), m.layout().swivel()].map(|at| x[at.expect("a state")]);
    assert!((p - (180e5 - RANGE * e)).abs() < 0.1e5, "{p} {e}");
    assert!(e < 0.1, "{e}");
}

#[test]
fn every_joule_is_accounted_for_with_the_compensators_named() {
    for (m, method) in [(mobile(""), "rodas5p"), (sharing("7 ml"), "rodas5p"), (mobile(SMALL), "hc-exponential-4")] {
        let m = m.as_ref();
        let done = run(m, 2.5, [0.045, -0.03, 0.02], &options(method));
        let (gap, shaft) = (ledger::gap(m, &done), ledger::at_end(m, &done, "mains.shaft"));
        let lost = ledger::at_end(m, &done, "valves.compensators");
        println!("{method}: shaft {shaft:.1} J, compensators {lost:.1} J, open {gap:.2e} J");
        assert!(lost > 0.02 * shaft, "{lost} of {shaft} J");
        assert!(gap < 2e-5 * shaft, "{gap} J of {shaft} J");
    }
}

#[test]
fn all_methods_agree_on_a_load_sensing_crane() {
    for m in [mobile(SMALL), sharing("18 ml")] {
        let m = m.as_ref();
        let end = |method: &str| last(m, &run(m, 1.5, [0.04, -0.03, 0.02], &options(method))).to_vec();
        let exact = end("rodas5p");
        for method in ["hc-exponential-4", "hc-rosenbrock-3"] {
            let found = end(method);
            for (i, (a, b)) in found.iter().zip(&exact).enumerate() {
                let tolerance = 1e-3 * m.layout().scales[i].max(b.abs());
                assert!((a - b).abs() < tolerance, "{method}, {}: {a} {b}", m.layout().names[i]);
            }
        }
    }
}

#[test]
fn a_file_says_at_once_what_cannot_work() {
    let refused = |base: &str, more: &str| {
        let text = format!("extends = \"{base}\"\n[machine]\nclass = \"assumed\"\n{more}");
        parse(&text, "circuit.toml", &[]).unwrap_err().to_string()
    };
    let shown = refused("rottne-f9-lab", "[valve.lift]\ncompensator = \"behind-spool\"");
    assert!(shown.contains("no pump senses the load") && shown.contains("ls-margin"), "{shown}");
    let shown = refused("rottne-f9-lab", "[valve.lift]\ncompensator = \"before-spool\"");
    assert!(shown.contains("compensator-setting"), "{shown}");
    let shown =
        refused("rottne-f9-lab", "[valve.extension]\ncompensator = \"before-spool\"\ncompensator-setting = \"8 bar\"");
    assert!(shown.contains("regenerative"), "{shown}");
    let shown = refused("rottne-f9-pump", "[pump.main]\nls-margin = \"20 bar\"");
    assert!(shown.contains("pressure-compensated") && shown.contains("load-sensing"), "{shown}");
    let warned = |more: &str| {
        let text = format!("extends = \"rottne-f9-mobile\"\n[machine]\nclass = \"assumed\"\n{more}");
        let machine = parse(&text, "circuit.toml", &[]).unwrap_or_else(|error| panic!("{error}"));
        machine.warnings.iter().map(|warning| warning.text.clone()).collect::<Vec<_>>().join("\n")
    };
    assert!(warned("").is_empty() && load("rottne-f9-mobile", &[]).is_ok(), "{}", warned(""));
    let shown = warned("[pump.main]\nls-margin = \"11 bar\"");
    assert!(shown.contains("7.0 bar") && shown.contains("8.0 bar"), "{shown}");
    let shown = warned("[pump.main]\ndisplacement = \"6 ml\"");
    assert!(shown.contains("12.0 l/min"), "{shown}");
}
