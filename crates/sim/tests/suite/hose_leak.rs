//! Hoses that leak and hoses that burst: speeds and flows by hand, loads that valves hold, oil and energy accounted for.

use crate::load_holding::{hanging, moved, oil_that_is_lost, VISCOUS};
use crate::port_valves::areas;
use crate::supply::{output, rows};
use crate::{extended, ledger};
use hydrocrane_machine::parse;
use hydrocrane_machine::scenario::{parse_scenario_with, Scenario};
use hydrocrane_sim::assembly::{assemble, Machines, RunSettings};
use hydrocrane_sim::{Model, OutcomeKind, PhasedRun};

/// Of the hole, m^2; it passes 5.3 l/min at 50 bar.
const AREA: f64 = 1.2e-6;
/// Of the single cylinder's edges, at 8 bar, m^3/s.
const EDGE_FLOW: f64 = 6e-3 / 60.0;
const STROKE: f64 = 0.05;

fn leak(cylinder: &str, side: &str, opening: &str) -> String {
    format!("[hose-leak.{cylinder}-{side}]\ncylinder = \"{cylinder}\"\nside = \"{side}\"\nopening = \"{opening}\"\n")
}

/// On the side that carries the load.
fn leaking() -> String {
    leak("test", "rod-side", "1.2 mm^2")
}

/// Passes 1.5 l/min at 10 bar, and does not open by the load alone.
const COUNTERBALANCE: &str =
    "[counterbalance.load]\ncylinder = \"test\"\nside = \"rod-side\"\nsetting = \"90 bar\"\npilot-ratio = 3\n\
    opening-pressure = \"30 bar\"\nnominal-flow = \"1.5 l/min\"\nnominal-pressure-drop = \"10 bar\"\n";

fn hose_burst(flow: &str) -> String {
    format!(
        "[hose-burst.load]\ncylinder = \"test\"\nside = \"rod-side\"\nclosing-flow = \"{flow}\"\n\
         nominal-flow = \"10 l/min\"\nnominal-pressure-drop = \"2 bar\"\n"
    )
}

/// Flow through the hole, m^3/s.
fn through_hole(m: &dyn Model, p: f64) -> f64 {
    0.7 * AREA * (2.0 * p / m.machine().fluid.density).sqrt()
}

fn of(m: &dyn Model, x: &[f64], name: &str) -> f64 {
    output(m, x, &format!("cylinder.test.{name}"))
}

#[test]
fn without_a_valve_the_load_sinks_as_fast_as_its_oil_leaves() {
    let m = hanging(&leaking());
    let m = m.as_ref();
    let run = moved(m, -0.2, 0.0, 2.0);
    let x = rows(m, &run).pop().expect("a row");
    let ([a1, a2], v, [p1, p2]) = (areas(m), of(m, x, "v"), [m.layout().p1(0), m.layout().p2(0)].map(|i| x[i]));
    let weight = (300.0 + m.machine().links[1].mass) * m.machine().environment.gravity.abs();
    println!("sinks at {v:.4} m/s, {:.1} and {:.1} bar", p1 / 1e5, p2 / 1e5);
    assert!((v * a2 / through_hole(m, p2) - 1.0).abs() < 1e-3, "{v} {p2}");
    assert!(((weight + p1 * a1 - VISCOUS * v) / (p2 * a2) - 1.0).abs() < 1e-3);
    // What the warning tells is what the piston pushed out, and some per cent of oil that expands.
    let told = run.warnings.iter().find(|warning| warning.kind == "oil-lost").expect("a warning");
    let litres: f64 = told.text.split(' ').next().expect("a number").parse().expect("a number");
    let moved = of(m, x, "x") - of(m, rows(m, &run)[0], "x");
    let pushed = 1e3 * moved * a2;
    assert!(pushed < litres && litres < 1.05 * pushed, "{litres} l of {pushed} l");
    assert!(told.text.contains("rod side of cylinder `test`") && told.time < 0.01, "{told:?}");
}

#[test]
fn a_hose_burst_valve_holds_where_more_flows_than_it_is_set_to() {
    let sunk = |more: &str| {
        let m = hanging(&(leaking() + more));
        let run = moved(m.as_ref(), -0.2, 0.0, 2.0);
        let x = rows(m.as_ref(), &run);
        (of(m.as_ref(), x[200], "x") - of(m.as_ref(), x[0], "x"), of(m.as_ref(), x[200], "lost2"))
    };
    let ((free, _), (wide, _), (held, lost)) = (sunk(""), sunk(&hose_burst("20 l/min")), sunk(&hose_burst("1 l/min")));
    println!("{free} m free, {wide} m below its flow, {held} m held");
    assert!(free > 0.02 && (wide / free - 1.0).abs() < 0.1, "{free} {wide}");
    assert!(held.abs() < 1e-3 * free && lost == 0.0, "{held} {lost}");
}

#[test]
fn a_counterbalance_valve_holds_and_lowers_through_the_hole() {
    let m = hanging(&(leaking() + COUNTERBALANCE));
    let m = m.as_ref();
    let held = moved(m, -0.2, 0.0, 2.0);
    let x = rows(m, &held);
    assert!((of(m, x[200], "x") - of(m, x[0], "x")).abs() < 1e-4 && of(m, x[200], "lost2") == 0.0);
    // Lowered by the pressure of the other side, the valve opens: its oil goes to the tank and to the outside.
    let lowered = moved(m, -0.2, 0.01, 4.0);
    let x = rows(m, &lowered).pop().expect("a row");
    let ([_, a2], p) = (areas(m), x[m.layout().p2(0)]);
    let (v, lost) = (of(m, x, "v"), of(m, x, "lost2"));
    let open = ((p + 3.0 * x[m.layout().p1(0)] - 90e5) / 30e5).clamp(0.0, 1.0);
    let (own, edge) = (1.5e-3 / 60.0 / 10e5f64.sqrt() * open, EDGE_FLOW / 8e5f64.sqrt() * 0.01 / STROKE);
    let hole = through_hole(m, 1.0);
    // The hose has the pressure at which both take what the valve passes.
    let hose = p * own * own / (own * own + (edge + hole).powi(2));
    println!("{:.1} bar in the chamber, {:.1} bar in the hose, valve {open:.2} open", p / 1e5, hose / 1e5);
    assert!(open > 0.05 && open < 0.95, "{open}");
    assert!((lost / (hole * hose.sqrt()) - 1.0).abs() < 1e-3, "{lost}");
    assert!((v * a2 / ((edge + hole) * hose.sqrt()) - 1.0).abs() < 2e-2, "{v}");
}

#[test]
fn what_is_fed_into_a_burst_hose_behind_a_check_valve_leaves_it() {
    let m = hanging(&(leak("test", "rod-side", "20 mm^2") + COUNTERBALANCE));
    let m = m.as_ref();
    let run = moved(m, 0.1, -0.01, 2.0);
    let x = rows(m, &run);
    let (first, last) = (x[0], x[200]);
    // The compensator sets the flow.
    let fed = EDGE_FLOW * 0.01 / STROKE;
    println!("{:.3} l/min fed, {:.3} l/min lost", fed * 6e4, of(m, last, "lost2") * 6e4);
    assert!((of(m, last, "lost2") / fed - 1.0).abs() < 0.02);
    let crept = of(m, last, "x") - of(m, first, "x");
    assert!(crept.abs() < 1e-3, "{crept} m");
    // Through a small hole the load is lifted all the same.
    let m = hanging(&(leak("test", "rod-side", "0.05 mm^2") + COUNTERBALANCE));
    let m = m.as_ref();
    let run = moved(m, 0.1, -0.01, 2.0);
    let x = rows(m, &run);
    let ([_, a2], last) = (areas(m), x[200]);
    let hole = through_hole(m, x[200][m.layout().p2(0)]) * 0.05e-6 / AREA;
    // The hole is laminar below 0.1 bar, which a few parts in a million are left of.
    assert!((of(m, last, "lost2") / hole - 1.0).abs() < 1e-5, "{} {hole}", of(m, last, "lost2"));
    assert!((-of(m, last, "v") * a2 / (fed - hole) - 1.0).abs() < 0.02, "{}", of(m, last, "v"));
}

#[test]
fn oil_and_energy_are_accounted_for() {
    let pump = "[pump.main]\ntype = \"load-sensing\"\ndisplacement = \"28 ml\"\nspeed = \"1500 rpm\"\nvolumetric-efficiency = 0.92\n\
         hydromechanical-efficiency = 0.9\nls-margin = \"20 bar\"\n[mains]\nvolume = \"0.6 l\"\n";
    for more in ["".to_string(), COUNTERBALANCE.into(), hose_burst("1 l/min"), hose_burst("20 l/min")] {
        for (place, spool) in [(-0.2, 0.01), (0.1, -0.01)] {
            for supply in ["", pump] {
                let m = hanging(&(more.clone() + &leaking() + &leak("test", "piston-side", "0.4 mm^2") + supply));
                let m = m.as_ref();
                let run = moved(m, place, spool, 2.0);
                let (mut lost, mut most) = (0.0f64, 0.0f64);
                for (x, u) in rows(m, &run).iter().zip(run.commands.chunks_exact(1)) {
                    let (gap, flow) = oil_that_is_lost(m, 0, x, u, 300.0);
                    (lost, most) = (lost.max(gap.abs()), most.max(flow));
                }
                assert!(lost < 1e-9 * most, "{lost} of {most} m^3/s");
                let [gap, leaks] = [ledger::gap(m, &run), ledger::at_end(m, &run, "lines.leaks")];
                let given = ledger::at_end(m, &run, "supply");
                println!("supply {given:.1} J, {leaks:.2} J with the oil that left, open {gap:.1e} J");
                assert!(leaks > 0.1 && gap < 1e-4 * given.max(leaks), "{gap} of {given} J");
            }
        }
    }
}

const HANGING: &str = "extends = \"single-cylinder\"\n[machine]\nclass = \"assumed\"\n[friction.test]\nmodel = \"static\"\ncoulomb = \"0 N\"\n\
    breakaway = \"0 N\"\nviscous-exponent = 1\nviscous = \"40000 N s/m\"\n";

fn plan(machine: &str, more: &str) -> Result<Scenario, String> {
    let text = format!(
        "[scenario]\nname = \"burst\"\nmachine = \"./hanging.toml\"\nduration = \"2 s\"\npayload = \"300 kg\"\n\
         [initial]\njoint.slide = \"-0.2 m\"\n[solver]\nmethod = \"rodas5p\"\nrtol = 1e-8\n{more}"
    );
    parse_scenario_with(&text, "burst.toml", &[("hanging.toml".into(), machine.into())])
        .map_err(|error| error.to_string())
}

fn done(machine: &str, more: &str) -> (Vec<f64>, PhasedRun) {
    let plan = plan(machine, more).unwrap_or_else(|error| panic!("{error}"));
    let mut machines = Machines { machine: "./hanging.toml", text: Some(machine) };
    let settings = RunSettings { ledger: true, max_steps: 1_000_000 };
    let mut assembly = assemble(&plan, settings, &mut machines).unwrap_or_else(|error| panic!("{error}"));
    let record: Vec<f64> = (0..=200).map(|i| f64::from(i) / 100.0).collect();
    let run = assembly.run(&record, &mut |_| true);
    assert_eq!(run.run.outcome.kind, OutcomeKind::Completed, "{}", run.run.outcome.message);
    let n = assembly.stages[0].model.layout().len();
    (run.run.states.iter().step_by(n).copied().collect(), run)
}

const BURST: &str =
    "[burst.load]\ncylinder = \"test\"\nside = \"rod-side\"\ntime = \"0.5 s\"\nopening = \"1.2 mm^2\"\n";

#[test]
fn a_hose_that_bursts_in_a_scenario_is_tight_before_and_leaks_from_then_on() {
    let (burst, run) = done(HANGING, BURST);
    let (leaking, _) = done(&(HANGING.to_string() + &leaking()), "");
    let (tight, _) = done(HANGING, "");
    for i in 0..=50 {
        assert!((burst[i] - tight[i]).abs() < 1e-7, "{i}: {} {}", burst[i], tight[i]);
    }
    assert!((leaking[150] - leaking[0]).abs() > 0.02);
    for i in 0..=150 {
        // Until then the load has crept by 0.01 mm.
        assert!((burst[50 + i] - leaking[i]).abs() < 1e-4, "{i}: {} {}", burst[50 + i], leaking[i]);
    }
    let told = run.run.warnings.iter().find(|warning| warning.kind == "oil-lost").expect("a warning");
    assert!((told.time - 0.5).abs() < 0.01, "{told:?}");
    assert!(!run.run.warnings.iter().any(|warning| warning.kind == "energy-ledger-open"));
    // A controller goes on, and so do its samples, through a burst and through a phase after it.
    let levers = "[controller]\nname = \"lever\"\n[phase.later]\ntime = \"1 s\"\njoystick = { mode = \"lever\", time = [\"1 s\"], test = [0] }\n";
    let (driven, run) = done(HANGING, &(BURST.to_string() + levers));
    assert_eq!(run.samples.len(), 2);
    for (a, b) in driven.iter().zip(&burst) {
        assert!((a - b).abs() < 1e-5, "{a} {b}");
    }
    // At the start it has burst already.
    let (at_once, _) = done(HANGING, &BURST.replace("0.5 s", "0 s"));
    for (a, b) in at_once.iter().zip(&leaking) {
        assert_eq!(a, b);
    }
}

#[test]
fn a_burst_is_written_as_it_was_read() {
    let plan = plan(HANGING, BURST).expect("a scenario");
    let machine = parse(HANGING, "hanging.toml", &[]).expect("a machine");
    let text = plan.to_toml(&[&machine]).expect("a file");
    let again =
        parse_scenario_with(&text, "again.toml", &[("hanging.toml".into(), HANGING.into())]).expect("a scenario");
    assert_eq!(again.faults.bursts, plan.faults.bursts);
}

#[test]
fn what_cannot_leak_or_burst_is_said() {
    let refused = |machine: &str, more: &str| plan(machine, more).unwrap_err();
    let twice = BURST.to_string() + &BURST.replace("burst.load", "burst.again");
    assert!(refused(HANGING, &twice).contains("bursts twice"));
    let both = HANGING.to_string() + &leaking();
    assert!(refused(&both, BURST).contains("a leak in this hose"));
    let unknown = refused(HANGING, &BURST.replace("\"test\"", "\"tset\""));
    assert!(unknown.contains("no cylinder `tset`") && unknown.contains("`test`"), "{unknown}");
    assert!(refused(HANGING, &BURST.replace("1.2 mm^2", "-1 mm^2")).contains("burst.load.opening"));
    assert!(refused(HANGING, &BURST.replace("1.2 mm^2", "1.2 mm")).contains("area"));
    let wide = leaking() + "discharge-coefficient = 1.2\n";
    let text = format!("{HANGING}{wide}");
    assert!(parse(&text, "leak.toml", &[]).unwrap_err().to_string().contains("exceeds 1"));
    let again = leaking() + &leaking().replace("test-rod-side", "other");
    let text = format!("{HANGING}{again}");
    assert!(parse(&text, "leak.toml", &[]).unwrap_err().to_string().contains("already"));
    // A tight hose changes nothing.
    let (with, without) = (extended("hiab-xs031", &leak("lift", "piston-side", "0 mm^2")), extended("hiab-xs031", ""));
    let mut x = without.equilibrium(&[1.0, -0.6, 0.5], hydrocrane_sim::EquilibriumMode::Hold, 100.0).expect("a pose");
    x[without.layout().xs(0)] = 0.004;
    let rates = |m: &dyn Model| {
        let mut dx = vec![0.0; x.len()];
        m.derivative(&x, &[0.0; 3], 100.0, &mut dx);
        dx
    };
    assert_eq!(rates(with.as_ref()), rates(without.as_ref()));
}
