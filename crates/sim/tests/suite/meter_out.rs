//! Spools of their own for the return in a whole machine: pressures by hand, lowering, energy.

use crate::supply::{fine, options, output, rows, run};
use crate::{extended, ledger};
use hydrocrane_machine::parse;
use hydrocrane_sim::{Model, Run};
use std::sync::Arc;

const RANGE: f64 = 5e5;

fn separate(a: &str, b: &str) -> Arc<dyn Model> {
    let of = |valve| format!("[valve.{valve}]\nreturn-area-ratio = 1\nreturn-pressure = [\"{a}\", \"{b}\"]\n");
    extended("rottne-f9-ls", &["lift", "jib", "extension"].map(of).concat())
}

fn last<'a>(m: &dyn Model, run: &'a Run) -> &'a [f64] {
    rows(m, run).pop().expect("a row")
}

/// Opening of the edge to the tank as a share of its full one, from its flow and the drop over it.
fn opened(q: f64, drop: f64) -> f64 {
    q / (1e-4 * (drop / 8e5).sqrt())
}

#[test]
fn the_side_that_drains_keeps_its_pressure_whatever_the_load() {
    let m = separate("40 bar", "6 bar");
    let m = m.as_ref();
    let tank = m.machine().supply.tank_pressure;
    for payload in [0.0, 150.0] {
        let done = run(m, 2.0, [0.03, 0.0, 0.0], &hydrocrane_sim::RunOptions { payload, ..options("rodas5p") });
        let x = last(m, &done);
        let (p2, q2) = (x[m.layout().p2(0)], output(m, x, "cylinder.lift.q2"));
        let by_hand = 6e5 + RANGE * opened(q2, p2 - tank);
        assert!((p2 - by_hand).abs() < 0.1e5 && p2 > 6e5 && p2 < 9e5, "{payload} kg: {p2} {by_hand}");
    }
}

#[test]
fn a_load_that_pushes_is_braked_by_the_return_pressure() {
    // It carries 30 to 40 bar: 60 bar hold it up, and it sinks as fast as its rod side is fed.
    let m = separate("60 bar", "6 bar");
    let m = m.as_ref();
    let done = run(m, 2.0, [-0.025, 0.0, 0.0], &options("rodas5p"));
    let x = last(m, &done);
    let fed = 1e-4 * (0.025 - 0.004) / (0.05 - 0.004);
    assert!((output(m, x, "cylinder.lift.q2") / -fed - 1.0).abs() < 1e-3, "{}", output(m, x, "cylinder.lift.q2"));
    let [p1, p2] = [x[m.layout().p1(0)], x[m.layout().p2(0)]];
    assert!(p1 > 60e5 && p1 < 60e5 + RANGE && p2 > 5e5, "{p1} {p2}");
}

#[test]
fn every_joule_is_accounted_for_by_all_methods() {
    let m = separate("60 bar", "6 bar");
    let m = m.as_ref();
    let ends = ["rodas5p", "hc-exponential-4", "hc-rosenbrock-3"].map(|method| {
        let done = run(m, 1.5, [0.03, -0.03, 0.02], &fine(method));
        let (gap, shaft) = (ledger::gap(m, &done), ledger::at_end(m, &done, "mains.shaft"));
        // Its even steps are chosen for the states, not for the integrals of powers.
        let allowed = if method == "hc-rosenbrock-3" { 2e-4 } else { 2e-5 };
        assert!(gap < allowed * shaft, "{method}: {gap} J of {shaft} J");
        last(m, &done).to_vec()
    });
    for other in &ends[1..] {
        for (i, (a, b)) in other.iter().zip(&ends[0]).enumerate() {
            assert!((a - b).abs() < 2e-3 * m.layout().scales[i].max(b.abs()), "{}: {a} {b}", m.layout().names[i]);
        }
    }
}

#[test]
fn a_file_says_what_a_return_pressure_excludes() {
    let refused = |base: &str, more: &str| {
        let text = format!("extends = \"{base}\"\n[machine]\nclass = \"assumed\"\n{more}");
        parse(&text, "valve.toml", &[]).unwrap_err().to_string()
    };
    assert!(refused("rottne-f9-lab", "[valve.extension]\nreturn-pressure = \"5 bar\"").contains("regenerative"));
    assert!(refused("rottne-f9-lab", "[valve.lift]\nreturn-pressure-range = \"5 bar\"")
        .contains("without `return-pressure`"));
    assert!(refused("rottne-f9-mobile", "[valve.lift]\nreturn-pressure = \"5 bar\"").contains("keep one of the two"));
    assert!(
        refused("rottne-f9-lab", "[valve.lift]\nreturn-pressure = [\"5 bar\", \"-1 bar\"]").contains("zero or greater")
    );
    let curve = "[valve.lift.metering.a-to-tank]\ntravel = [0, 1]\narea = [0, 1]";
    assert!(
        refused("rottne-f9-lab", &format!("[valve.lift]\nreturn-pressure = \"5 bar\"\n{curve}")).contains("a-to-tank")
    );
}
