//! Several pumps on one mains: at rest by hand, two halves as one whole, oil and energy accounted for, what is refused.

use crate::supply::{options, output, rows, run};
use crate::{extended, ledger};
use hydrocrane_machine::parse;
use hydrocrane_sim::{EquilibriumMode, Model};
use std::f64::consts::TAU;
use std::sync::Arc;

const POSE: [f64; 3] = [1.745, 1.745, 0.0];
const SET: f64 = 140e5;

/// A pump beside that of `rottne-f9-pump`, whose displacement is `main`.
fn beside(main: &str, displacement: &str, more: &str) -> String {
    format!(
        "[pump.main]\ndisplacement = \"{main}\"\n[pump.aside]\ntype = \"pressure-compensated\"\ndisplacement = \"{displacement}\"\n\
         speed = \"1450 rpm\"\nvolumetric-efficiency = 0.94\nhydromechanical-efficiency = 0.9\ncontrol-range = \"6 bar\"\n\
         time-constant = \"50 ms\"\n{more}"
    )
}

fn with(more: &str) -> Arc<dyn Model> {
    extended("rottne-f9-pump", more)
}

#[test]
fn at_rest_each_pump_swivels_as_its_range_asks() {
    let m = with(&beside("4 ml", "9 ml", "").replace("control-range = \"6 bar\"", "control-range = \"12 bar\""));
    let m = m.as_ref();
    let x = m.equilibrium(&POSE, EquilibriumMode::Hold, 0.0).expect("a pose");
    let layout = m.layout();
    let p = layout.mains().expect("mains");
    let names: Vec<&str> = layout.swivels().map(|at| layout.names[at].as_str()).collect();
    assert_eq!(names, ["pump.main.displacement", "pump.aside.displacement"]);
    // Leakage of 6 % of each at 140 bar: sum D (set - p)/range = 0.06 sum D p/140 bar; the tank is at 0 bar.
    let (small, large) = (4.0 / 6e5, 9.0 / 12e5);
    let by_hand = (small + large) * SET / (small + large + 0.06 * 13.0 / SET);
    assert!((x[p] - by_hand).abs() < 1.0, "{} {by_hand}", x[p]);
    for (at, range) in layout.swivels().zip([6e5, 12e5]) {
        assert!((x[at] - (SET - by_hand) / range).abs() < 1e-6, "{}", x[at]);
    }
    let mut dx = vec![0.0; x.len()];
    m.derivative(&x, &[0.0; 3], 0.0, &mut dx);
    assert!(dx[p..].iter().all(|rate| rate.abs() < 1.0), "{dx:?}");
}

#[test]
fn two_halves_move_the_crane_as_the_whole_does() {
    let spools = [0.045, -0.03, 0.0];
    let end = |more: &str| {
        let m = with(more);
        let done = run(m.as_ref(), 1.5, spools, &options("rodas5p"));
        let x = rows(m.as_ref(), &done).pop().expect("a row").to_vec();
        let spent = ["mains.shaft", "mains.mechanical_loss", "mains.pump_leakage"]
            .map(|name| ledger::at_end(m.as_ref(), &done, name));
        (m, x, spent)
    };
    let ((one, x, spent), (two, y, halves)) = (end(""), end(&beside("3.15 ml", "3.15 ml", "")));
    let (one, two) = (one.as_ref(), two.as_ref());
    for (i, (a, b)) in x.iter().zip(&y).enumerate() {
        let scale = one.layout().scales[i];
        assert!((a - b).abs() < 1e-4 * (scale + a.abs()), "{}: {a} {b}", one.layout().names[i]);
    }
    assert_eq!(y[two.layout().swivels().start], y[two.layout().swivels().end - 1]);
    for (a, b) in spent.iter().zip(halves) {
        assert!((a / b - 1.0).abs() < 1e-5, "{spent:?} {halves:?}");
    }
    let of = |name: &str| output(two, &y, name);
    assert!((2.0 * of("pump.aside.flow") / of("mains.pump_flow") - 1.0).abs() < 1e-12);
    assert!((2.0 * of("pump.main.shaft_power") / of("mains.shaft_power") - 1.0).abs() < 1e-12);
    assert!((of("pump.aside.shaft_speed") - 1450.0 / 60.0 * TAU).abs() < 1e-9);
}

#[test]
fn oil_and_energy_of_unlike_pumps_are_accounted_for() {
    let engine = "droop = \"8 %\"\nrated-torque = \"12 N m\"\ntorque-limit = \"9 N m\"\n";
    for method in ["rodas5p", "hc-exponential-4"] {
        let m =
            with(&beside("3 ml", "5 ml", engine).replace("control-range = \"6 bar\"", "control-range = \"10 bar\""));
        let m = m.as_ref();
        let done = run(m, 2.0, [0.045, 0.03, 0.02], &options(method));
        let p = m.layout().mains().expect("mains");
        let (mut dx, mains) = (vec![0.0; m.layout().len()], m.machine().supply.mains.as_ref().expect("mains"));
        for (x, u) in rows(m, &done).iter().zip(done.commands.chunks_exact(3)) {
            m.derivative(x, u, 0.0, &mut dx);
            let stored = dx[p] * ((mains.volume + mains.compliance * x[p]) / m.bulk_modulus(x[p]) + mains.compliance);
            let [main, aside, relief, drawn] =
                ["pump.main.flow", "pump.aside.flow", "mains.relief_flow", "supply.flow"]
                    .map(|name| output(m, x, name));
            assert!((stored - (main + aside - relief - drawn)).abs() < 1e-9 * (main + aside).abs().max(1e-5));
        }
        let (gap, shaft) = (ledger::gap(m, &done), ledger::at_end(m, &done, "mains.shaft"));
        println!("{method}: {shaft:.1} J at the shafts, open {gap:.2e} J");
        assert!(shaft > 100.0 && gap < 1e-6 * shaft, "{gap} of {shaft} J");
    }
}

#[test]
fn pumps_that_do_not_fit_together_are_refused() {
    let refused = |more: &str| {
        let text = format!("extends = \"rottne-f9-pump\"\n[machine]\nclass = \"assumed\"\n{more}");
        parse(&text, "pumps.toml", &[]).unwrap_err().to_string()
    };
    let second = beside("3 ml", "3 ml", "");
    let fixed = second
        .replace("pressure-compensated", "fixed")
        .replace("control-range = \"6 bar\"\ntime-constant = \"50 ms\"\n", "");
    let shown = refused(&fixed);
    assert!(shown.contains("one type") && shown.contains("pump.aside.type"), "{shown}");
    let ideal = "[pump.aside]\ntype = \"constant-pressure\"\n";
    assert!(refused(ideal).contains("one type"));
    let many = ["aside", "b", "c"]
        .map(|name| second.replace("[pump.main]\ndisplacement = \"3 ml\"\n", "").replace("aside", name));
    let shown = refused(&many.concat());
    assert!(shown.contains("4 pumps") && shown.contains("3 at most"), "{shown}");
    let unlike = |more: &str| {
        let text =
            format!("extends = \"rottne-f9-mobile\"\n[machine]\nclass = \"assumed\"\n{}{more}", sensing("17 bar"));
        parse(&text, "pumps.toml", &[]).unwrap_err().to_string()
    };
    let shown = unlike("ls-time-constant = \"7 ms\"\n");
    assert!(shown.contains("one load-sensing line") && shown.contains("pump.aside.ls-time-constant"), "{shown}");
    let fixed = |name: &str, margin: &str| {
        format!(
            "[pump.{name}]\ntype = \"fixed\"\ndisplacement = \"9 ml\"\nspeed = \"1450 rpm\"\nvolumetric-efficiency = 0.94\n\
             hydromechanical-efficiency = 0.9\n{margin}\n"
        )
    };
    let on_valve = |margins: [&str; 2]| {
        let pumps = fixed("main", margins[0]) + &fixed("aside", margins[1]);
        let text =
            format!("extends = \"hiab-xs031\"\n[machine]\nclass = \"assumed\"\n{pumps}[mains]\nvolume = \"1 l\"\n");
        parse(&text, "pumps.toml", &[]).map(|_| ()).map_err(|error| error.to_string())
    };
    let [fifteen, twelve] = ["15 bar", "12 bar"].map(|margin| format!("ls-margin = \"{margin}\""));
    for (second, words) in [("", "or none"), (twelve.as_str(), "one valve unloads all fixed pumps")] {
        let shown = on_valve([&fifteen, second]).unwrap_err();
        assert!(shown.contains(words) && shown.contains("pump.aside.ls-margin"), "{shown}");
    }
    assert_eq!(on_valve([&fifteen, &fifteen]), Ok(()));
}

/// A second pump of `rottne-f9-mobile` with this margin.
fn sensing(margin: &str) -> String {
    format!(
        "[pump.aside]\ntype = \"load-sensing\"\ndisplacement = \"9 ml\"\nspeed = \"1450 rpm\"\nvolumetric-efficiency = 0.94\n\
         hydromechanical-efficiency = 0.9\ncontrol-range = \"5 bar\"\nls-margin = \"{margin}\"\n"
    )
}

#[test]
fn at_standby_the_pump_with_the_larger_margin_keeps_the_mains_alone() {
    let m = extended("rottne-f9-mobile", &sensing("34 bar"));
    let m = m.as_ref();
    let x = m.equilibrium(&POSE, EquilibriumMode::Hold, 0.0).expect("a pose");
    let (layout, supply) = (m.layout(), &m.machine().supply);
    let main = &supply.mains.as_ref().expect("mains").pump;
    let [p, at_main, at_aside] =
        [layout.mains().expect("mains"), layout.swivels().start, layout.swivels().start + 1].map(|at| x[at]);
    // Leakage of both at 34 bar less what the swivel takes: D w (set - p)/range = sum of k (p - p_0).
    let full = |pump: &hydrocrane_machine::model::Pump| pump.displacement / TAU * pump.speed;
    let leaking = |pump: &hydrocrane_machine::model::Pump| {
        (1.0 - pump.volumetric_efficiency) * full(pump) / (supply.pressure - supply.tank_pressure)
    };
    let aside = &supply.mains.as_ref().expect("mains").further[0];
    let (tank, k) = (supply.tank_pressure, leaking(main) + leaking(aside));
    let set = tank + 34e5;
    // The valves leak less than a thousandth of that.
    let by_hand = (full(aside) / 5e5 * set + k * tank) / (full(aside) / 5e5 + k);
    assert!((p - by_hand).abs() < 1e-3 * 34e5, "{p} {by_hand}");
    assert!(at_main == 0.0 && (at_aside - (set - p) / 5e5).abs() < 1e-9, "{at_main} {at_aside}");
    let mut dx = vec![0.0; x.len()];
    m.derivative(&x, &[0.0; 3], 0.0, &mut dx);
    assert!(dx[layout.swivels()].iter().all(|rate| rate.abs() < 1e-6), "{dx:?}");
}
