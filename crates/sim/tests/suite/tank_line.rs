//! The tank line in a whole machine: its pressure by hand, what the sections see of it, oil and energy accounted for.

use crate::supply::{options, output, rows, run};
use crate::{extended, ledger};
use hydrocrane_machine::parse;
use hydrocrane_sim::{EquilibriumMode, Model};
use std::sync::Arc;

const POSE: [f64; 3] = [1.745, 1.745, 0.0];
const TANK: f64 = 0.5e5;
/// Flow at which the drops are stated, m^3/s.
const NOMINAL: f64 = 20.0 / 60e3;

/// At 20 l/min the line takes 3 bar, half of it laminar, and the filter 2 bar; its bypass opens at 1.5 bar.
const LINE: &str = "[tank-line]\nvolume = \"2 l\"\nhose-compliance = \"0.2 ml/bar\"\nnominal-flow = \"20 l/min\"\n\
    nominal-pressure-drop = \"3 bar\"\n[tank-line.filter]\nnominal-flow = \"20 l/min\"\nnominal-pressure-drop = \"2 bar\"\n";
const BYPASS: &str = "bypass-pressure = \"1.5 bar\"\nbypass-overpressure = \"0.5 bar\"\n";

fn with(base: &str, more: &str) -> Arc<dyn Model> {
    extended(base, &format!("[supply]\ntank-pressure = \"0.5 bar\"\n{more}"))
}

/// Drops over line and filter at the flow `q`, Pa.
fn by_hand(q: f64, bypass: bool) -> [f64; 2] {
    let share = q / NOMINAL;
    let alone = 2e5 * share;
    // Beyond 1.5 bar the filter passes 10 and the bypass 40 l/min per bar.
    let filter = if bypass && alone > 1.5e5 { (share * 20.0 + 40.0 * 1.5) / 50.0 * 1e5 } else { alone };
    [1.5e5 * share + 1.5e5 * share * share, filter]
}

fn pressure(m: &dyn Model, x: &[f64]) -> f64 {
    x[m.layout().tank().expect("a tank line")]
}

#[test]
fn steady_pressures_of_the_line_are_those_by_hand() {
    for (more, bypass) in [("", false), (BYPASS, true)] {
        let m = with("rottne-f9-pump", &format!("{LINE}{more}"));
        let m = m.as_ref();
        let done = run(m, 2.0, [0.045, 0.0, 0.0], &options("rodas5p"));
        let x = rows(m, &done).pop().expect("a row").to_vec();
        let of = |name: &str| output(m, &x, &format!("tank_line.{name}"));
        let [line, filter] = by_hand(of("flow"), bypass);
        assert!(of("flow") > 0.1 * NOMINAL, "{}", of("flow"));
        assert!((pressure(m, &x) - TANK - line - filter).abs() < 1.0, "{} {line} {filter}", pressure(m, &x));
        assert!((of("filter_drop") - filter).abs() < 1.0);
        // The section returns through its edge against that pressure, not against the tank's.
        let p2 = x[m.layout().p2(0)];
        let (spool, q2) = (x[m.layout().xs(0)], output(m, &x, "cylinder.lift.q2"));
        let against = |back: f64| m.orifice_flow(0, spool, p2 - back);
        let leaks = m.machine().cylinders[0].valve.leakage * 150e5;
        assert!((against(pressure(m, &x)) - q2).abs() < 1e-3 * q2 + leaks, "{} {q2}", against(pressure(m, &x)));
        assert!((against(TANK) - q2).abs() > 1e-3 * q2 + leaks);
    }
}

#[test]
fn a_fixed_pump_at_rest_returns_all_it_gives_and_the_line_stands_at_its_drop() {
    let pump = "[pump.main]\ntype = \"fixed\"\ndisplacement = \"10 ml\"\nspeed = \"1450 rpm\"\nvolumetric-efficiency = 0.94\n\
        hydromechanical-efficiency = 0.9\nls-margin = \"12 bar\"\n[mains]\nvolume = \"0.4 l\"\nrelief-gradient = \"4 l/(min bar)\"\n";
    let m = with("rottne-f9-lab", &format!("{pump}{LINE}{BYPASS}"));
    let m = m.as_ref();
    let x = m.equilibrium(&POSE, EquilibriumMode::Hold, 0.0).expect("a pose");
    let relieved = output(m, &x, "mains.relief_flow");
    let [line, filter] = by_hand(output(m, &x, "tank_line.returned"), true);
    assert!(relieved > 13.0 / 60e3 && filter > 1e5, "{relieved} {filter}");
    assert!((pressure(m, &x) - TANK - line - filter).abs() < 1e-3, "{} {line} {filter}", pressure(m, &x));
    let mut dx = vec![0.0; x.len()];
    m.derivative(&x, &[0.0; 3], 0.0, &mut dx);
    assert!(dx[m.layout().blocks().shared.first..].iter().all(|rate| rate.abs() < 1.0), "{dx:?}");
}

#[test]
fn sections_feel_each_other_through_the_line() {
    // The jib returns oil; the boom's closed section sees the pressure of the line through its leakage alone.
    let rate = |line: &str, jib: f64| {
        let m = with("rottne-f9-ls", line);
        let done = run(m.as_ref(), 1.5, [0.02, jib, 0.0], &options("rodas5p"));
        let x = rows(m.as_ref(), &done).pop().expect("a row").to_vec();
        (output(m.as_ref(), &x, "cylinder.lift.v"), m, x)
    };
    let narrow = LINE.replace("20 l/min", "3 l/min");
    let (alone, ..) = rate(&narrow, 0.0);
    let (beside, m, x) = rate(&narrow, 0.04);
    let (free, ..) = rate("", 0.0);
    let back = pressure(m.as_ref(), &x);
    println!(
        "return pressure {:.1} bar; lift {:.4} m/s alone, {:.4} beside the jib, {:.4} without a line",
        back / 1e5,
        alone,
        beside,
        free
    );
    assert!(back > 5e5, "{back}");
    // A compensated section keeps its speed as long as the pump does.
    assert!((alone / free - 1.0).abs() < 0.02 && (beside / free - 1.0).abs() < 0.05, "{alone} {beside} {free}");
    // Its load pressure rises by what the return takes, over the areas.
    let m = m.as_ref();
    assert!(x[m.layout().p2(0)] > back, "{} {back}", x[m.layout().p2(0)]);
}

#[test]
fn oil_and_energy_are_accounted_for() {
    for (base, method, spools) in
        [("rottne-f9-pump", "rodas5p", [0.045, -0.03, 0.0]), ("rottne-f9-ls", "hc-exponential-4", [0.04, -0.03, 0.0])]
    {
        let m = with(base, &format!("{}{BYPASS}", LINE.replace("20 l/min", "4 l/min")));
        let m = m.as_ref();
        let done = run(m, 2.0, spools, &options(method));
        let line = m.machine().supply.mains.as_ref().and_then(|mains| mains.tank_line.as_ref()).expect("a tank line");
        let (mut dx, mut most) = (vec![0.0; m.layout().len()], 0.0);
        for (x, u) in rows(m, &done).iter().zip(done.commands.chunks_exact(3)) {
            m.derivative(x, u, 0.0, &mut dx);
            let p = pressure(m, x);
            let capacity = (line.volume + line.compliance * p) / m.bulk_modulus(p) + line.compliance;
            let flows = ["returned", "flow"].map(|name| output(m, x, &format!("tank_line.{name}")));
            let gap = dx[m.layout().tank().expect("a tank line")] * capacity - (flows[0] - flows[1]);
            most = f64::max(most, flows[0]);
            assert!(gap.abs() < 1e-9 * most.max(1e-5), "{gap} m^3/s of {most}");
        }
        let lost =
            ["resistance", "filter", "bypass"].map(|name| ledger::at_end(m, &done, &format!("tank_line.{name}")));
        let gap = ledger::gap(m, &done);
        println!("{base} {method}: lost in line, filter and bypass {lost:.1?} J, open {gap:.2e} J");
        assert!(lost.iter().all(|lost| *lost > 1.0), "{lost:?}");
        assert!(gap < 1e-5 * lost.iter().sum::<f64>(), "{gap} of {lost:?} J");
    }
}

#[test]
fn an_anti_cavitation_valve_feeds_more_from_a_pre_loaded_line() {
    let valve = "[anti-cavitation.lift]\ncylinder = \"lift\"\nside = \"rod-side\"\nnominal-flow = \"20 l/min\"\nnominal-pressure-drop = \"1 bar\"\n\
        opening-pressure = \"0.2 bar\"\n";
    let m = with("rottne-f9-pump", &format!("{LINE}{valve}"));
    let m = m.as_ref();
    let mut x = m.equilibrium(&POSE, EquilibriumMode::Hold, 0.0).expect("a pose");
    let (tank, p2) = (m.layout().tank().expect("a tank line"), m.layout().p2(0));
    x[p2] = 1e5;
    let fed = [1e5, 4e5].map(|back| {
        x[tank] = back;
        -output(m, &x, "cylinder.lift.relieved2")
    });
    assert_eq!(fed[0], 0.0);
    // 3 bar less the 0.2 bar that open it.
    assert!((fed[1] / (NOMINAL * (2.8f64 / 0.8).sqrt()) - 1.0).abs() < 1e-9, "{fed:?}");
    // That oil leaves the line.
    assert!(output(m, &x, "tank_line.returned") < -0.9 * fed[1]);
}

#[test]
fn a_tank_line_that_cannot_be_is_said() {
    let refused = |base: &str, more: &str| {
        let text = format!("extends = \"{base}\"\n[machine]\nclass = \"assumed\"\n{more}");
        parse(&text, "tank-line.toml", &[]).unwrap_err().to_string()
    };
    let shown = refused("rottne-f9-lab", LINE);
    assert!(shown.contains("tank-line") && shown.contains("return pressure"), "{shown}");
    assert!(refused("rottne-f9-pump", "[tank-line]\nvolume = \"2 l\"\n").contains("nominal-flow"));
    let lonely = format!("{LINE}bypass-overpressure = \"1 bar\"\n");
    assert!(refused("rottne-f9-pump", &lonely).contains("bypass-pressure"));
    let half = LINE.replace("nominal-pressure-drop = \"3 bar\"\n", "");
    assert!(refused("rottne-f9-pump", &half).contains("nominal-pressure-drop"));
}

#[test]
fn a_high_return_pressure_is_said() {
    let warned = |base: &str, more: &str| {
        let text = format!(
            "extends = \"{base}\"\n[machine]\nclass = \"assumed\"\n[supply]\ntank-pressure = \"0.5 bar\"\n{more}"
        );
        parse(&text, "tank-line.toml", &[]).unwrap_or_else(|error| panic!("{error}")).warnings
    };
    assert!(warned("rottne-f9-mobile", LINE).is_empty());
    // The pump gives 24.53 l/min, less than the sections take. The jib takes 12 of them, and returns 4/3 of that as it retracts.
    let given = 18e-6 * 1450.0 / 60.0 * 0.94;
    let [line, filter] = by_hand(given + 4.0 / 60e3, false);
    assert!((given * 60e3 - 24.534).abs() < 1e-9 && line > filter);
    let narrow = LINE.replace("\"3 bar\"", "\"12 bar\"");
    let found = warned("rottne-f9-mobile", &narrow);
    let [warning] = &found[..] else { panic!("{found:?}") };
    assert_eq!(warning.key, "tank-line.nominal-pressure-drop");
    let text = format!(
        "{:.1} bar while 29 l/min return, which happens when `jib` retracts",
        (0.5e5 + 4.0 * line + filter) / 1e5
    );
    assert!(warning.text.contains(&text), "{text}: {}", warning.text);
    // Of the filter; with a bypass valve there is nothing to say.
    let fine = LINE.replace("\"2 bar\"", "\"9 bar\"");
    let found = warned("rottne-f9-mobile", &fine);
    assert_eq!(found.iter().map(|of| of.key.as_str()).collect::<Vec<_>>(), ["tank-line.filter.nominal-pressure-drop"]);
    assert!(warned("rottne-f9-mobile", &format!("{fine}{BYPASS}")).is_empty());
}
