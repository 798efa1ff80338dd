//! The section that is served first: flows of a small pump by hand, what the others get, energy accounted for.

use crate::supply::{options, output, rows, run};
use crate::{extended, ledger};
use hydrocrane_machine::parse;
use hydrocrane_sim::{Model, RunOptions};
use std::sync::Arc;

/// Of lift and jib at full opening, m^3/s.
const NOMINAL: f64 = 12e-3 / 60.0;
/// Shut 9 bar above the load, free 11.2 bar above it; the exhausted pump leaves 16 bar.
const KEPT: f64 = 9e5;
const RANGE: f64 = 2e5;

fn first(cylinder: &str) -> String {
    format!("[priority]\ncylinder = \"{cylinder}\"\nmargin = \"9 bar\"\n")
}

fn mobile(more: &str) -> Arc<dyn Model> {
    extended("rottne-f9-mobile", more)
}

/// A pump that two functions exceed.
const SMALL: &str = "[pump.main]\ndisplacement = \"7 ml\"\n";

/// Flow at the spool position `spool` (m) behind 5 mm of overlap and a compensator that has its pressure.
fn wanted(spool: f64, nominal: f64) -> f64 {
    nominal * (spool - 0.005) / 0.045
}

#[test]
fn the_section_served_first_has_its_flow_and_the_other_one_the_rest() {
    let spools = [0.03, 0.03, 0.0];
    let each = wanted(0.03, NOMINAL);
    let flows = |more: &str| {
        let m = mobile(&format!("{SMALL}{more}"));
        let done = run(m.as_ref(), 1.5, spools, &options("rodas5p"));
        let x = rows(m.as_ref(), &done).pop().expect("a row").to_vec();
        let shares = ["lift", "jib"].map(|name| output(m.as_ref(), &x, &format!("cylinder.{name}.q1")) / each);
        (shares, m, x)
    };
    let (without, ..) = flows("");
    println!("without priority: lift {:.3}, jib {:.3}", without[0], without[1]);
    assert!(without[0].min(without[1]) < 0.9);
    for (own, name) in ["lift", "jib"].into_iter().enumerate() {
        let (shares, m, x) = flows(&first(name));
        let m = m.as_ref();
        let [p, load] = [m.layout().mains(), m.layout().load()].map(|at| x[at.expect("a state")]);
        let [pump, drawn, given] = ["mains.pump_flow", "supply.flow", "mains.priority"].map(|of| output(m, &x, of));
        println!("{name} first: {shares:.3?}, the other may take {given:.3}; margin {:.2} bar", (p - load) / 1e5);
        assert!((shares[own] - 1.0).abs() < 1e-3, "{name}: {shares:?}");
        // The rest of the pump's flow, by hand.
        let rest = (pump - each) / each;
        assert!(rest < 0.6 && (shares[1 - own] / rest - 1.0).abs() < 0.02, "{name}: {shares:?} {rest}");
        assert!((given / shares[1 - own] - 1.0).abs() < 1e-3, "{given} {shares:?}");
        assert!((drawn / pump - 1.0).abs() < 0.01, "{drawn} {pump}");
        assert!(p - load > KEPT - 0.1 * RANGE && p - load < KEPT + 1.1 * RANGE, "{p} {load}");
    }
}

#[test]
fn those_that_give_way_keep_their_proportions() {
    let m = mobile(&format!("{SMALL}{}", first("jib")));
    let m = m.as_ref();
    let spools = [0.03, 0.025, 0.04];
    let done = run(m, 1.0, spools, &options("rodas5p"));
    let x = rows(m, &done).pop().expect("a row");
    let share =
        |name: &str, spool: f64, nominal: f64| output(m, x, &format!("cylinder.{name}.q1")) / wanted(spool, nominal);
    let [lift, jib, extension] = [
        share("lift", spools[0], NOMINAL),
        share("jib", spools[1], NOMINAL),
        share("extension", spools[2], 0.5 * NOMINAL),
    ];
    println!("lift {lift:.4}, jib {jib:.4}, extension {extension:.4}");
    assert!((jib - 1.0).abs() < 1e-3, "{jib}");
    assert!(lift < 0.7 && (lift / extension - 1.0).abs() < 1e-3, "{lift} {extension}");
}

#[test]
fn while_the_pump_suffices_nothing_changes() {
    let m = mobile(&first("jib"));
    let m = m.as_ref();
    let spools = [0.02, 0.015, 0.02];
    let done = run(m, 1.5, spools, &options("rodas5p"));
    let x = rows(m, &done).pop().expect("a row");
    assert!((output(m, x, "mains.priority") - 1.0).abs() < 1e-12);
    for (name, spool, nominal) in [("lift", 0.02, NOMINAL), ("jib", 0.015, NOMINAL), ("extension", 0.02, 0.5 * NOMINAL)]
    {
        let share = output(m, x, &format!("cylinder.{name}.q1")) / wanted(spool, nominal);
        assert!((share - 1.0).abs() < 1e-6, "{name}: {share}");
    }
    assert!(done.warnings.iter().all(|w| w.kind != "pump-saturated"), "{:?}", done.warnings);
}

#[test]
fn energy_is_accounted_for() {
    for method in ["rodas5p", "hc-exponential-4"] {
        let m = mobile(&format!("{SMALL}{}", first("jib")));
        let m = m.as_ref();
        let run = run(m, 1.5, [0.03, 0.03, 0.0], &RunOptions { payload: 50.0, ..options(method) });
        let (gap, lost) = (ledger::gap(m, &run), ledger::at_end(m, &run, "valves.priority"));
        println!("{method}: lost in the priority element {lost:.2} J, open {gap:.2e} J");
        assert!(lost > 10.0 && gap < 1e-5 * lost, "{gap} of {lost} J");
    }
}

#[test]
fn a_priority_that_cannot_be_is_said() {
    let text = |base: &str, more: &str| format!("extends = \"{base}\"\n[machine]\nclass = \"assumed\"\n{more}");
    let refused = |base: &str, more: &str| parse(&text(base, more), "priority.toml", &[]).unwrap_err().to_string();
    assert!(refused("rottne-f9-pump", &first("jib")).contains("no pump senses the load"));
    assert!(refused("rottne-f9-mobile", &first("gib")).contains("no cylinder `gib`"));
    let shown = refused("rottne-f9-mobile", &first("jib").replace("9 bar", "20 bar"));
    assert!(shown.contains("never move") && shown.contains("priority.margin"), "{shown}");
    assert!(refused("single-cylinder", &first("test")).contains("no other section"));
    let warned = |more: &str| {
        let machine =
            parse(&text("rottne-f9-mobile", more), "priority.toml", &[]).unwrap_or_else(|error| panic!("{error}"));
        machine.warnings.iter().map(|warning| warning.text.clone()).collect::<Vec<_>>().join("\n")
    };
    assert_eq!(warned(&first("jib")), "");
    let shown = warned(&first("jib").replace("9 bar", "15 bar"));
    assert!(shown.contains("17.2 bar") && shown.contains("16.0 bar"), "{shown}");
    let shown = warned(&first("jib").replace("9 bar", "6 bar"));
    assert!(shown.contains("valve `jib` takes 8.0 bar"), "{shown}");
}
