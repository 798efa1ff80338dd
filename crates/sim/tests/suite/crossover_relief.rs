//! Cross-over relief valves in a whole machine: the speed of a sinking load by hand, oil and energy accounted for.

use crate::ledger;
use crate::load_holding::{hanging, moved, oil_that_is_lost, VISCOUS};
use crate::port_valves::{areas, feeding, lowering};
use crate::supply::{output, rows};
use hydrocrane_machine::parse;

/// A cross-over relief valve of 10 l/min at 20 bar beyond its setting.
fn crossing(cylinder: &str, side: &str, setting: &str) -> String {
    format!("[crossover-relief.{cylinder}-{side}]\ncylinder = \"{cylinder}\"\nside = \"{side}\"\nsetting = \"{setting}\"\nnominal-flow = \"10 l/min\"\n")
}

const GRADIENT: f64 = 10e-3 / 60.0 / 20e5;

#[test]
fn a_load_beyond_the_setting_sinks_and_the_tank_fills_what_the_rod_side_does_not() {
    let m = hanging(&(crossing("test", "rod-side", "15 bar") + &feeding("test", "piston-side")));
    let m = m.as_ref();
    let run = moved(m, -0.1, 0.0, 3.0);
    let x = rows(m, &run).pop().expect("a row");
    let ([a1, a2], tank) = (areas(m), m.machine().supply.tank_pressure);
    let weight = (300.0 + m.machine().links[1].mass) * m.machine().environment.gravity.abs();
    let (p1, p2) = (x[m.layout().p1(0)], x[m.layout().p2(0)]);
    let of = |name: &str| output(m, x, &format!("cylinder.test.{name}"));
    let v = of("v");
    println!("sinks at {v} m/s with {p1} and {p2} Pa");
    // The weight hangs on both pressures, the valve passes the oil of the rod side, and the anti-cavitation valve the rest of the piston side.
    assert!(v > 1e-3 && p1 < tank, "{v} {p1}");
    assert!(((p2 * a2 - p1 * a1) / (weight - VISCOUS * v) - 1.0).abs() < 2e-3, "{p1} {p2}");
    let by_hand = GRADIENT * (p2 - p1 - 15e5);
    // The connectors take a little of both pressures.
    assert!((of("crossed") / -by_hand - 1.0).abs() < 1e-3, "{} {by_hand}", of("crossed"));
    assert!((by_hand / (a2 * v) - 1.0).abs() < 5e-3, "{by_hand} {}", a2 * v);
    assert!((of("relieved1") / (-(a1 - a2) * v) - 1.0).abs() < 5e-3, "{}", of("relieved1"));
    assert!(of("q1") > 0.0 && of("q2") > 0.0 && of("relieved2") == 0.0);
}

#[test]
fn oil_and_energy_are_accounted_for() {
    let parts = crossing("lift", "piston-side", "40 bar") + &crossing("lift", "rod-side", "30 bar");
    let (m, run) = lowering(&(parts + &feeding("lift", "rod-side")));
    let m = m.as_ref();
    let (mut lost, mut most, mut crossed) = (0.0f64, 0.0f64, 0.0f64);
    for (x, u) in rows(m, &run).iter().zip(run.commands.chunks_exact(3)) {
        let (gap, flow) = oil_that_is_lost(m, 0, x, u, 300.0);
        (lost, most) = (lost.max(gap.abs()), most.max(flow));
        crossed = crossed.max(output(m, x, "cylinder.lift.crossed"));
    }
    assert!(lost < 1e-9 * most && crossed > 0.01 * most, "{lost} {crossed} of {most} m^3/s");
    let (gap, heat) = (ledger::gap(m, &run), ledger::at_end(m, &run, "valves.crossover_relief"));
    println!("{crossed:.1e} of {most:.1e} m^3/s cross; lost {heat:.2} J, open {gap:.2e} J");
    assert!(heat > 1.0 && gap < 1e-5 * heat, "{gap} of {heat} J");
}

#[test]
fn a_second_valve_of_a_side_is_refused() {
    let twice = crossing("test", "rod-side", "90 bar")
        + &crossing("test", "rod-side", "80 bar").replace("crossover-relief.test", "crossover-relief.other");
    let text = format!("extends = \"single-cylinder\"\n[machine]\nclass = \"assumed\"\n{twice}");
    let shown = parse(&text, "crossing.toml", &[]).unwrap_err().to_string();
    assert!(shown.contains("already") && shown.contains("crossover-relief.other"), "{shown}");
}
