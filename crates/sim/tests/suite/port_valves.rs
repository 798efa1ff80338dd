//! Relief and anti-cavitation valves at the ports of cylinders: pressures and flows by hand, no cavitation, oil and energy accounted for.

use crate::load_holding::{hanging, moved, VISCOUS};
use crate::supply::{options, output, rows};
use crate::{extended, ledger};
use hydrocrane_machine::parse;
use hydrocrane_sim::{simulate, Commands, EquilibriumMode, Model, OutcomeKind, Run, RunOptions};
use std::f64::consts::FRAC_PI_4;
use std::sync::Arc;

/// A relief valve of 10 l/min at 20 bar beyond its setting.
fn relief(cylinder: &str, side: &str, setting: &str) -> String {
    format!("[port-relief.{cylinder}-{side}]\ncylinder = \"{cylinder}\"\nside = \"{side}\"\nsetting = \"{setting}\"\nnominal-flow = \"10 l/min\"\n")
}

/// An anti-cavitation valve of 80 l/min at 2 bar.
pub fn feeding(cylinder: &str, side: &str) -> String {
    format!("[anti-cavitation.{cylinder}-{side}]\ncylinder = \"{cylinder}\"\nside = \"{side}\"\nnominal-flow = \"80 l/min\"\nnominal-pressure-drop = \"2 bar\"\n")
}

const GRADIENT: f64 = 10e-3 / 60.0 / 20e5;

pub fn areas(m: &dyn Model) -> [f64; 2] {
    let cylinder = &m.machine().cylinders[0];
    let area = FRAC_PI_4 * cylinder.bore.powi(2);
    [area, area - FRAC_PI_4 * cylinder.rod_diameter.powi(2)]
}

/// The loader crane lowers 300 kg with its valve wide open, and stops.
pub fn lowering(more: &str) -> (Arc<dyn Model>, Run) {
    let m = extended("hiab-xs031", more);
    let options = RunOptions { payload: 300.0, ..options("rodas5p") };
    let start = m.equilibrium(&[1.0, -0.6, 0.5], EquilibriumMode::Hold, options.payload).expect("a pose");
    let values = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -0.008, 0.0, 0.0, -0.008, 0.0, 0.0, 0.0, 0.0, 0.0].to_vec();
    let commands = Commands { times: vec![0.0, 0.1, 0.3, 1.0, 1.2], values, linear: true };
    let record: Vec<f64> = (0..=150).map(|i| i as f64 / 100.0).collect();
    let run = simulate(m.as_ref(), &start, 1.5, &commands, &record, &options, &mut |_| true);
    assert_eq!(run.outcome.kind, OutcomeKind::Completed, "{}", run.outcome.message);
    (m, run)
}

#[test]
fn a_chamber_that_a_load_empties_is_fed_from_the_tank() {
    let least = |more: &str| {
        let (m, run) = lowering(more);
        rows(m.as_ref(), &run).iter().map(|x| x[m.layout().p2(0)]).fold(f64::INFINITY, f64::min)
    };
    let (without, with) = (least(""), least(&feeding("lift", "rod-side")));
    println!("rod side: {:.2} bar without, {:.2} bar with an anti-cavitation valve", without / 1e5, with / 1e5);
    // The tank of this crane has 10 bar.
    assert!(without < -0.5e5, "{without}");
    assert!(with > 10e5 - 2e5, "{with}");
}

#[test]
fn a_load_beyond_the_setting_sinks_at_the_speed_found_by_hand() {
    let m = hanging(&(relief("test", "rod-side", "15 bar") + &feeding("test", "piston-side")));
    let m = m.as_ref();
    let run = moved(m, -0.1, 0.0, 3.0);
    let x = rows(m, &run).pop().expect("a row");
    let [a1, a2] = areas(m);
    let weight = (300.0 + m.machine().links[1].mass) * m.machine().environment.gravity.abs();
    // The anti-cavitation valve fills the piston side, so that the weight hangs on the rod side and on the vacuum that fills it.
    let fed = |v: f64| {
        let root = a1 * v * (1.9e5f64).sqrt() / (80e-3 / 60.0);
        // Below 0.1 bar the flow is laminar.
        let (mut low, mut high) = (0.0, 1e5);
        for _ in 0..100 {
            let left: f64 = 0.5 * (low + high);
            let g = if left < 0.1e5 { left * (3.0 - left / 0.1e5) / (2.0 * 0.1e5f64.sqrt()) } else { left.sqrt() };
            if g < root {
                low = left
            } else {
                high = left
            }
        }
        -0.1e5 - low
    };
    let (mut slow, mut fast) = (0.0, 2.0);
    for _ in 0..100 {
        let v = 0.5 * (slow + fast);
        let p2 = (weight - VISCOUS * v + fed(v) * a1) / a2;
        if GRADIENT * (p2 - 15e5) > a2 * v {
            slow = v
        } else {
            fast = v
        }
    }
    let v = output(m, x, "cylinder.test.v");
    println!("sinks at {v} m/s, by hand {slow} m/s");
    assert!((v / slow - 1.0).abs() < 5e-3, "{v} {slow}");
    assert!((output(m, x, "cylinder.test.relieved2") / (a2 * slow) - 1.0).abs() < 5e-3);
    assert!((output(m, x, "cylinder.test.relieved1") / (-a1 * slow) - 1.0).abs() < 5e-3);
}

#[test]
fn a_section_at_its_relief_valve_keeps_the_pressure() {
    // The piston is at its end and the valve open: what passes its edge passes the relief valve.
    let m = extended("single-cylinder", &relief("test", "piston-side", "90 bar"));
    let m = m.as_ref();
    let run = moved(m, 0.3, 0.02, 8.0);
    let x = rows(m, &run).pop().expect("a row");
    let edge = 1e-4 * 0.02 / 0.05 / 75e5f64.sqrt();
    let (mut low, mut high) = (90e5, 140e5);
    for _ in 0..100 {
        let p: f64 = 0.5 * (low + high);
        if edge * (140e5 - p).sqrt() > GRADIENT * (p - 90e5) {
            low = p
        } else {
            high = p
        }
    }
    let p1 = x[m.layout().p1(0)];
    println!("{:.3} bar, by hand {:.3} bar", p1 / 1e5, low / 1e5);
    assert!(output(m, x, "cylinder.test.v").abs() < 1e-6);
    assert!((p1 - low).abs() < 0.05e5, "{p1} {low}");
    assert!(ledger::at_end(m, &run, "valves.port_relief") > 100.0);
}

#[test]
fn oil_and_energy_are_accounted_for() {
    let (m, run) = lowering(&(feeding("lift", "rod-side") + &relief("lift", "piston-side", "60 bar")));
    let m = m.as_ref();
    let [a1, a2] = areas(m);
    let cylinder = &m.machine().cylinders[0];
    let mut dx = vec![0.0; m.layout().len()];
    let (mut most, mut relieved, mut fed) = (0.0, 0.0, 0.0);
    for (x, u) in rows(m, &run).iter().zip(run.commands.chunks_exact(3)) {
        m.derivative(x, u, 300.0, &mut dx);
        let of = |name: &str| output(m, x, &format!("cylinder.lift.{name}"));
        let half = cylinder.stroke / 2.0;
        let volumes =
            [cylinder.dead_volume[0] + a1 * (half + of("x")), cylinder.dead_volume[1] + a2 * (half - of("x"))];
        let at = [m.layout().p1(0), m.layout().p2(0)];
        let stored: f64 = (0..2).map(|side| dx[at[side]] * volumes[side] / m.bulk_modulus(x[at[side]])).sum();
        // No leakage crosses the piston's rod here: what flows in through both ports is stored or makes room.
        let gap = stored + (a1 - a2) * of("v") - (of("q1") - of("q2")) + leaked(m, x);
        most = f64::max(most, of("q2").abs());
        relieved = f64::max(relieved, of("relieved1"));
        fed = f64::min(fed, of("relieved2"));
        assert!(gap.abs() < 1e-9 * most.max(1e-4), "{gap} m^3/s");
    }
    assert!(relieved > 0.05 * most && fed < -0.1 * most, "{relieved} {fed} of {most}");
    let (gap, lost) = (ledger::gap(m, &run), ledger::at_end(m, &run, "valves.port_relief"));
    let fed = ledger::at_end(m, &run, "valves.anti_cavitation");
    println!("lost in relief valves {lost:.2} J, in anti-cavitation valves {fed:.2} J, open {gap:.2e} J");
    assert!(lost > 10.0 && fed > 0.1, "{lost} {fed}");
    assert!(gap < 1e-5 * lost, "{gap} of {lost} J");
}

/// What leaves the rod side to the outside, m^3/s.
fn leaked(m: &dyn Model, x: &[f64]) -> f64 {
    match m.machine().cylinders[0].leakage {
        hydrocrane_machine::model::Leakage::Conductance { external, .. } => {
            external * (x[m.layout().p2(0)] - m.machine().supply.tank_pressure)
        }
        hydrocrane_machine::model::Leakage::Gap { .. } => panic!("the loader crane states conductances"),
    }
}

#[test]
fn a_port_valve_that_cannot_be_is_said() {
    let refused = |more: &str| {
        let text = format!("extends = \"single-cylinder\"\n[machine]\nclass = \"assumed\"\n{more}");
        parse(&text, "ports.toml", &[]).unwrap_err().to_string()
    };
    let twice = relief("test", "rod-side", "90 bar")
        + &relief("test", "rod-side", "80 bar").replace("port-relief.test", "port-relief.other");
    assert!(refused(&twice).contains("already"));
    let shut = feeding("test", "rod-side") + "opening-pressure = \"2 bar\"\n";
    let shown = refused(&shut);
    assert!(shown.contains("still closed") && shown.contains("opening-pressure"), "{shown}");
    let unknown = relief("test", "rod-side", "90 bar").replace("\"test\"", "\"tset\"");
    assert!(refused(&unknown).contains("no cylinder `tset`"));
}
