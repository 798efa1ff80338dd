//! Curves of metering edges in a whole machine: flows by hand, energy, sections side by side, controllers.

use crate::supply::{fine, options, output, rows, run};
use crate::{extended, ledger};
use hydrocrane_machine::parse;
use hydrocrane_sim::Model;
use std::sync::Arc;

/// A closed zone of a tenth, a notch up to the middle, then the full area; the edge to the tank begins earlier.
const FEED: &str = "travel = [0, 0.1, 0.5, 1]\narea = [0, 0, 0.2, 1]";

fn notched(valve: &str) -> String {
    format!(
        "[valve.{valve}]\nreturn-area-ratio = 1\n[valve.{valve}.metering.supply-to-a]\n{FEED}\n[valve.{valve}.metering.supply-to-b]\n{FEED}\n\
         [valve.{valve}.metering.a-to-tank]\ntravel = [0, 0.08, 0.6, 1]\nflow = [\"0 l/min\", \"0 l/min\", \"2 l/min\", \"4.8 l/min\"]\n"
    )
}

fn crane() -> Arc<dyn Model> {
    extended("rottne-f9-mobile", &["lift", "jib", "extension"].map(notched).concat())
}

/// Of lift and jib at the nominal drop, m^3/s: a compensator keeps it.
const NOMINAL: f64 = 12e-3 / 60.0;

#[test]
fn a_compensated_section_has_the_flow_of_its_curve() {
    let m = crane();
    // At its points, and between two of them where the curve was looked up in SciPy's PchipInterpolator.
    for (spool, share) in [(0.005, 0.0), (0.025, 0.2), (0.0375, SCIPY_AT_THREE_QUARTERS)] {
        let done = run(m.as_ref(), 1.5, [spool, 0.0, 0.0], &options("rodas5p"));
        let x = rows(m.as_ref(), &done).pop().expect("a row");
        let q = output(m.as_ref(), x, "cylinder.lift.q1");
        assert!((q - share * NOMINAL).abs() < 1e-6 * NOMINAL, "{spool}: {q} {}", share * NOMINAL);
    }
}

const SCIPY_AT_THREE_QUARTERS: f64 = 0.508_518_358_323_721_6;

#[test]
fn a_curve_along_the_straight_line_is_the_valve_without_one() {
    let line = "travel = [0, 1]\narea = [0, 1]";
    let edges = ["supply-to-a", "a-to-tank", "supply-to-b", "b-to-tank"];
    let straight =
        ["lift", "jib"].map(|v| edges.map(|e| format!("[valve.{v}.metering.{e}]\n{line}\n")).concat()).concat();
    let ends = ["", &straight].map(|more| {
        let m = extended("rottne-f9-lab", more);
        rows(m.as_ref(), &run(m.as_ref(), 1.0, [0.02, -0.03, 0.01], &options("rodas5p"))).pop().expect("a row").to_vec()
    });
    for (plain, curved) in ends[0].iter().zip(&ends[1]) {
        assert!((plain - curved).abs() <= 1e-9 * plain.abs().max(1e-3), "{plain} {curved}");
    }
}

#[test]
fn every_joule_is_accounted_for_by_all_methods() {
    let m = crane();
    let ends = ["rodas5p", "hc-exponential-4", "hc-rosenbrock-3"].map(|method| {
        let done = run(m.as_ref(), 1.5, [0.035, -0.03, 0.03], &fine(method));
        let (gap, shaft) = (ledger::gap(m.as_ref(), &done), ledger::at_end(m.as_ref(), &done, "mains.shaft"));
        // Its even steps are chosen for the states, not for the integrals of powers.
        let allowed = if method == "hc-rosenbrock-3" { 2e-4 } else { 2e-5 };
        assert!(gap < allowed * shaft, "{method}: {gap} J of {shaft} J");
        rows(m.as_ref(), &done).pop().expect("a row").to_vec()
    });
    for other in &ends[1..] {
        for (i, (a, b)) in other.iter().zip(&ends[0]).enumerate() {
            let tolerance = 1e-3 * m.layout().scales[i].max(b.abs());
            assert!((a - b).abs() < tolerance, "{}: {a} {b}", m.layout().names[i]);
        }
    }
}

#[test]
fn the_load_sensing_line_hears_of_a_section_before_its_edge_opens() {
    let m = crane();
    let load = |spool: f64| {
        let done = run(m.as_ref(), 1.5, [spool, 0.0, 0.0], &options("rodas5p"));
        rows(m.as_ref(), &done).pop().expect("a row")[m.layout().load().expect("a line")]
    };
    // Its edge opens at 5 mm, a tenth of the stroke.
    assert!(load(4.4e-3) < 2e5 && load(5e-3) > 10e5, "{} {}", load(4.4e-3), load(5e-3));
}

#[test]
fn a_file_says_what_a_curve_cannot_be() {
    let refused = |more: &str| {
        let text = format!("extends = \"rottne-f9-lab\"\n[machine]\nclass = \"assumed\"\n{more}");
        parse(&text, "valve.toml", &[]).map(|m| m.warnings).map_err(|error| error.to_string())
    };
    let of = |edge: &str, travel: &str, values: &str| {
        refused(&format!("[valve.lift.metering.{edge}]\ntravel = {travel}\n{values}\n")).expect_err("refused")
    };
    for (travel, values, words) in [
        ("[0, 0.5, 0.4, 1]", "area = [0, 0.1, 0.2, 1]", "does not rise"),
        ("[0.1, 1]", "area = [0, 1]", "from 0 to 1"),
        ("[0, 0.5]", "area = [0, 1]", "from 0 to 1"),
        ("[0, 0.5, 0.5001, 1]", "area = [0, 0.1, 0.2, 1]", "0.001"),
        ("[1]", "area = [1]", "2 to 16"),
        ("[0, 0.5, 1]", "area = [0, 1]", "2 values for 3 points"),
        ("[0, 1]", "area = [0.1, 1]", "open in the middle"),
        ("[0, 0.5, 1]", "area = [0, 0.5, 0.4]", "falls from 0.5 to 0.4"),
        ("[0, 1]", "area = [0, 0]", "never opens"),
        ("[0, 1]", "area = [0, 1]\nflow = [\"0 l/min\", \"1 l/min\"]", "excludes"),
        ("[0, 1]", "", "as `flow`"),
        ("[0, 1]", "flow = [\"0 bar\", \"1 bar\"]", "volume flow"),
    ] {
        let shown = of("supply-to-a", travel, values);
        assert!(shown.contains(words), "{words}: {shown}");
    }
    let shown = refused("[valve.extension.metering.b-to-tank]\ntravel = [0, 1]\narea = [0, 1]").expect_err("refused");
    assert!(shown.contains("regenerative") && shown.contains("supply-to-b"), "{shown}");
    let shown =
        refused("[valve.lift]\nreturn-area-ratio = [0.4, 1]\nmetering.a-to-tank = { travel = [0, 1], area = [0, 1] }")
            .expect_err("refused");
    assert!(shown.contains("return-area-ratio"), "{shown}");
    let edges = ["supply-to-a", "a-to-tank", "supply-to-b", "b-to-tank"];
    let all = edges.map(|e| format!("[valve.lift.metering.{e}]\ntravel = [0, 1]\narea = [0, 1]\n")).concat();
    let warned = refused(&format!("[valve.lift]\noverlap = \"1 mm\"\n{all}")).expect("accepted");
    assert!(warned.iter().any(|w| w.text.contains("counts for nothing")), "{warned:?}");
}
