//! An engine that slows down under the pump: speed, pressure and energy of whole machines by hand.

use crate::supply::{options, output, rows, run};
use crate::{extended, ledger};
use hydrocrane_machine::parse;
use hydrocrane_sim::{EquilibriumMode, Model};
use std::f64::consts::TAU;
use std::sync::Arc;

const IDLE: f64 = 1450.0 / 60.0 * TAU;
const DROOP: f64 = 0.1;
const RATED: f64 = 25.0;
const ENGINE: &str = "droop = \"10 %\"\nrated-torque = \"25 N m\"\n";

fn fixed(engine: &str) -> Arc<dyn Model> {
    let pump = format!(
        "[pump.main]\ntype = \"fixed\"\ndisplacement = \"10 ml\"\nspeed = \"1450 rpm\"\n{engine}volumetric-efficiency = 0.94\n\
         hydromechanical-efficiency = 0.9\n[mains]\nvolume = \"0.4 l\"\nrelief-gradient = \"4 l/(min bar)\"\n"
    );
    extended("rottne-f9-lab", &pump)
}

fn swivelling() -> Arc<dyn Model> {
    extended("rottne-f9-pump", &format!("[pump.main]\n{ENGINE}"))
}

#[test]
fn at_rest_pump_engine_and_relief_valve_balance() {
    for m in [fixed(ENGINE), swivelling()] {
        let m = m.as_ref();
        let x = m.equilibrium(&[1.745, 1.745, 0.0], EquilibriumMode::Hold, 50.0).expect("a pose");
        let mut dx = vec![0.0; x.len()];
        m.derivative(&x, &[0.0; 3], 50.0, &mut dx);
        let first = m.layout().blocks().shared.first;
        assert!(dx[first].abs() < 1e3 && dx[first + 1..].iter().all(|rate| rate.abs() < 1e-6), "{:?}", &dx[first..]);
        // The torque by hand: D dp (e + 1/eta - 1).
        let (p, e) = (x[first], m.layout().swivel().map_or(1.0, |e| x[e]));
        let mains = m.machine().supply.mains.as_ref().expect("mains");
        let torque = mains.pump.displacement / TAU * (p - m.machine().supply.tank_pressure) * (e + 1.0 / 0.9 - 1.0);
        let speed = IDLE * (1.0 - DROOP * torque / RATED);
        assert!((output(m, &x, "mains.shaft_speed") / speed - 1.0).abs() < 1e-12);
        assert!((output(m, &x, "mains.shaft_power") / (torque * speed) - 1.0).abs() < 1e-12);
    }
    // 10 ml at some 140 bar and 90 %: 24.8 N m, which is nearly the rated torque.
    let x = fixed(ENGINE).equilibrium(&[1.745, 1.745, 0.0], EquilibriumMode::Hold, 0.0).expect("a pose");
    let speed = output(fixed(ENGINE).as_ref(), &x, "mains.shaft_speed");
    assert!((speed / (0.9 * IDLE) - 1.0).abs() < 0.01, "{speed}");
}

#[test]
fn a_constant_speed_is_an_engine_without_droop() {
    let x = fixed("").equilibrium(&[1.745, 1.745, 0.0], EquilibriumMode::Hold, 0.0).expect("a pose");
    assert_eq!(output(fixed("").as_ref(), &x, "mains.shaft_speed"), IDLE);
}

#[test]
fn every_joule_of_the_engine_is_accounted_for_by_all_methods() {
    let m = swivelling();
    let m = m.as_ref();
    let ends = ["rodas5p", "hc-exponential-4"].map(|method| {
        let done = run(m, 2.0, [0.045, -0.03, 0.02], &options(method));
        let (gap, shaft) = (ledger::gap(m, &done), ledger::at_end(m, &done, "mains.shaft"));
        assert!(gap < 2e-5 * shaft, "{method}: {gap} J of {shaft} J");
        let slowest = rows(m, &done).iter().map(|x| output(m, x, "mains.shaft_speed")).fold(f64::INFINITY, f64::min);
        assert!(slowest < 0.97 * IDLE, "{slowest}");
        rows(m, &done).pop().expect("a row").to_vec()
    });
    for (i, (a, b)) in ends[0].iter().zip(&ends[1]).enumerate() {
        assert!((a - b).abs() < 1e-3 * m.layout().scales[i].max(b.abs()), "{}: {a} {b}", m.layout().names[i]);
    }
}

#[test]
fn a_file_says_what_an_engine_cannot_be() {
    let refused = |more: &str| {
        let text = format!("extends = \"rottne-f9-pump\"\n[machine]\nclass = \"assumed\"\n[pump.main]\n{more}");
        parse(&text, "engine.toml", &[]).unwrap_err().to_string()
    };
    assert!(refused("droop = 1.2\nrated-torque = \"25 N m\"").contains("stand still"));
    assert!(refused("droop = 0.05").contains("rated-torque"));
    assert!(refused("rated-torque = \"25 N m\"").contains("without `droop`"));
    assert!(refused("droop = 0\nrated-torque = \"25 N m\"").contains("greater than zero"));
    // What it loses under load counts when the pump is compared with its valves.
    let text = "extends = \"rottne-f9-pump\"\n[machine]\nclass = \"assumed\"\n[pump.main]\ndroop = \"29 %\"\nrated-torque = \"10 N m\"";
    let warnings = parse(text, "engine.toml", &[]).expect("accepted").warnings;
    assert!(warnings.iter().any(|w| w.text.contains("takes 5.8 l/min")), "{warnings:?}");
}
