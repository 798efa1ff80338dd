//! What holds loads in a whole machine: counterbalance and pilot-operated check valves hold, and lower at the speed of the oil that is
//! fed; hose-burst valves close.

use crate::extended;
use crate::supply::{options, output, rows};
use hydrocrane_machine::parse;
use hydrocrane_physics::hydraulics::leakage::annular_gap_conductance;
use hydrocrane_sim::{simulate, Commands, EquilibriumMode, Model, OutcomeKind, Run, RunOptions};
use std::sync::Arc;

const SETTING: f64 = 60e5;
const OPENING: f64 = 30e5;
const FLOW: f64 = 1.5e-3 / 60.0;
const DROP: f64 = 10e5;
/// Of the valve's edges, at 8 bar.
const EDGE_FLOW: f64 = 6e-3 / 60.0;
const COMPENSATED: f64 = 8e5;
const STROKE: f64 = 0.05;

pub const VISCOUS: f64 = 40e3;

/// A mass that hangs on a cylinder with viscous friction alone: its rod side carries it.
pub fn hanging(more: &str) -> Arc<dyn Model> {
    let text = format!(
        "[friction.test]\nmodel = \"static\"\ncoulomb = \"0 N\"\nbreakaway = \"0 N\"\nviscous-exponent = 1\nviscous = \"40000 N s/m\"\n\
         [valve.test]\nnominal-flow = \"6 l/min\"\nnominal-pressure-drop = \"16 bar\"\ncompensator = \"before-spool\"\n\
         compensator-setting = \"8 bar\"\n{more}"
    );
    extended("single-cylinder", &text)
}

fn counterbalance(ratio: f64) -> String {
    format!(
        "[counterbalance.load]\ncylinder = \"test\"\nside = \"rod-side\"\nsetting = \"60 bar\"\npilot-ratio = {ratio}\n\
         opening-pressure = \"30 bar\"\nnominal-flow = \"1.5 l/min\"\nnominal-pressure-drop = \"10 bar\"\n"
    )
}

/// From rest at `q` (m) with the spool at `spool` (m).
pub fn moved(m: &dyn Model, q: f64, spool: f64, end: f64) -> Run {
    let options = RunOptions { payload: 300.0, ..options("rodas5p") };
    let start = m.equilibrium(&[q], EquilibriumMode::Hold, options.payload).expect("a pose");
    let commands = Commands { times: vec![0.0, 0.1, 0.6], values: vec![0.0, 0.0, spool], linear: true };
    let record: Vec<f64> = (0..=(end * 100.0) as usize).map(|i| i as f64 / 100.0).collect();
    let run = simulate(m, &start, end, &commands, &record, &options, &mut |_| true);
    assert_eq!(run.outcome.kind, OutcomeKind::Completed, "{}", run.outcome.message);
    run
}

#[test]
fn the_load_sinks_at_the_speed_of_the_oil_that_is_fed_at_every_pilot_ratio() {
    let spool = 0.01;
    for ratio in [1.0, 2.0, 3.0] {
        let m = hanging(&counterbalance(ratio));
        let run = moved(m.as_ref(), -0.1, spool, 6.0);
        let x = rows(m.as_ref(), &run).pop().expect("a row");
        let cylinder = &m.machine().cylinders[0];
        let a1 = std::f64::consts::FRAC_PI_4 * cylinder.bore.powi(2);
        let a2 = a1 - std::f64::consts::FRAC_PI_4 * cylinder.rod_diameter.powi(2);
        let tank = m.machine().supply.tank_pressure;
        // The compensator sets the flow into the piston side, that the speed, that the flow out of the rod side.
        let v = EDGE_FLOW * spool / STROKE / a1;
        assert!((output(m.as_ref(), x, "cylinder.test.v") / v - 1.0).abs() < 2e-3, "{ratio}: {v}");
        // Weight and flow give both pressures.
        let pull = (300.0 + m.machine().links[1].mass) * m.machine().environment.gravity.abs() - VISCOUS * v;
        let flow = |p2: f64| {
            let p1 = (p2 * a2 - pull) / a1;
            let open = ((p2 + ratio * p1 - SETTING) / OPENING).clamp(0.0, 1.0);
            let (own, edge) = (FLOW / DROP.sqrt() * open, EDGE_FLOW / COMPENSATED.sqrt() * spool / STROKE);
            if open == 0.0 {
                0.0
            } else {
                (p2 - tank).sqrt() / (own.powi(-2) + edge.powi(-2)).sqrt()
            }
        };
        let (mut low, mut high) = (pull / a2, 300e5);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if flow(middle) < v * a2 {
                low = middle
            } else {
                high = middle
            }
        }
        let p2 = x[m.layout().p2(0)];
        println!("ratio {ratio}: {:.2} bar, by hand {:.2} bar", p2 / 1e5, low / 1e5);
        assert!((p2 / low - 1.0).abs() < 0.01, "{ratio}: {p2} {low}");
    }
}

#[test]
fn behind_a_closed_spool_nothing_creeps_through_its_leakage() {
    let leaking = "leakage = \"1e-12 m^3/(s Pa)\"\n";
    let sunk = |m: Arc<dyn Model>| {
        let run = moved(m.as_ref(), 0.1, 0.0, 20.0);
        let rows = rows(m.as_ref(), &run);
        output(m.as_ref(), rows[rows.len() - 1], "cylinder.test.x") - output(m.as_ref(), rows[0], "cylinder.test.x")
    };
    let (held, free) = (sunk(hanging(&format!("{leaking}{}", counterbalance(3.0)))), sunk(hanging(leaking)));
    println!("{held} m with a counterbalance valve, {free} m without");
    assert!(free > 5e-3 && held.abs() < 0.2 * free, "{held} {free}");
}

#[test]
fn a_counterbalance_valve_that_cannot_be_is_said() {
    let refused = |base: &str, more: &str| {
        let text = format!("extends = \"{base}\"\n[machine]\nclass = \"assumed\"\n{more}");
        parse(&text, "held.toml", &[]).unwrap_err().to_string()
    };
    let twice = counterbalance(3.0) + &counterbalance(3.0).replace("counterbalance.load", "counterbalance.other");
    assert!(refused("single-cylinder", &twice).contains("already"));
    let regenerative = counterbalance(3.0).replace("\"test\"", "\"extension\"");
    assert!(refused("rottne-f9-lab", &regenerative).contains("regenerative"));
    let unknown = counterbalance(3.0).replace("\"test\"", "\"tset\"");
    let shown = refused("single-cylinder", &unknown);
    assert!(shown.contains("no cylinder `tset`") && shown.contains("test"), "{shown}");
    let both = counterbalance(3.0) + PILOT_CHECK;
    assert!(refused("single-cylinder", &both).contains("already"));
    let weak = PILOT_CHECK.replace("pilot-ratio = 4", "pilot-ratio = 1");
    assert!(refused("single-cylinder", &weak).contains("pilot-ratio"));
    let never = "[hose-burst.load]\ncylinder = \"test\"\nside = \"rod-side\"\nclosing-flow = \"2 l/min\"\nbleed = 1\n\
         nominal-flow = \"10 l/min\"\nnominal-pressure-drop = \"2 bar\"\n";
    assert!(refused("single-cylinder", never).contains("never closes"));
    let line = "[line.load]\ncylinder = \"test\"\nside = \"rod-side\"\nvolume = \"0.2 l\"\n";
    let shown = refused("single-cylinder", &(counterbalance(3.0) + line));
    assert!(shown.contains("pressure of its own"), "{shown}");
    let empty = line.replace("volume = \"0.2 l\"\n", "");
    assert!(refused("single-cylinder", &(counterbalance(3.0) + &empty)).contains("nominal-flow"));
    let sideless = counterbalance(3.0).replace("rod-side", "rod");
    assert!(refused("single-cylinder", &sideless).contains("rod-side"));
}

#[test]
fn a_counterbalance_valve_set_too_low_is_said_with_pose_pressure_and_cure() {
    let said = |payload: f64| {
        let m = hanging(&format!("{}[payload]\nmass = \"{payload} kg\"\n", counterbalance(3.0)));
        let warnings = m.machine().warnings.clone();
        warnings.into_iter().find(|warning| warning.key == "counterbalance.load.setting")
    };
    // The rod side carries all of the weight while the tank's pressure, none here, is on the piston.
    let m = hanging("");
    let cylinder = &m.machine().cylinders[0];
    let a2 = std::f64::consts::FRAC_PI_4 * (cylinder.bore.powi(2) - cylinder.rod_diameter.powi(2));
    let pressure = |payload: f64| (payload + m.machine().links[1].mass) * m.machine().environment.gravity.abs() / a2;
    assert!(1.3 * pressure(400.0) < SETTING && said(400.0).is_none());
    assert!(1.3 * pressure(550.0) > SETTING);
    let warning = said(550.0).expect("a warning");
    let bar = format!("{:.0} bar with 550 kg", pressure(550.0) / 1e5);
    assert!(warning.text.contains(&bar) && warning.text.contains("slide"), "{warning:?}");
    assert!(warning.cure.contains(&format!("{:.0} bar", (1.3 * pressure(550.0) / 1e5).ceil())), "{warning:?}");
    assert!(warning.place.contains("extended.toml:"), "{warning:?}");
    // Built once more, it is said once.
    let again = hydrocrane_sim::build(m.machine()).expect("it can be built");
    assert_eq!(again.machine().warnings, m.machine().warnings);
}

const PILOT_CHECK: &str =
    "[pilot-check.load]\ncylinder = \"test\"\nside = \"rod-side\"\npilot-ratio = 4\nspring-pressure = \"2 bar\"\n\
     nominal-flow = \"6 l/min\"\nnominal-pressure-drop = \"10 bar\"\n";

#[test]
fn a_pilot_operated_check_valve_holds_and_lowers_as_fast_as_oil_is_fed() {
    let m = hanging(&format!("leakage = \"1e-12 m^3/(s Pa)\"\n{PILOT_CHECK}"));
    let m = m.as_ref();
    let position = |x: &[f64]| output(m, x, "cylinder.test.x");
    let held = moved(m, 0.1, 0.0, 20.0);
    let rows_held = rows(m, &held);
    let crept = position(rows_held[rows_held.len() - 1]) - position(rows_held[0]);
    // What leaks past the piston evens its pressures out: as behind a counterbalance valve.
    assert!(crept.abs() < 3e-3, "{crept} m");
    let spool = 0.01;
    let run = moved(m, -0.1, spool, 6.0);
    let all = rows(m, &run);
    let a1 = std::f64::consts::FRAC_PI_4 * m.machine().cylinders[0].bore.powi(2);
    let (v, mean) = (EDGE_FLOW * spool / STROKE / a1, (position(all[600]) - position(all[400])) / 2.0);
    println!("sinks at {mean} m/s, fed for {v} m/s");
    assert!((mean / v - 1.0).abs() < 0.05, "{mean} {v}");
}

#[test]
fn a_hose_burst_valve_closes_above_its_flow_and_leaves_its_bleed() {
    let burst = |flow: &str| {
        format!(
            "[hose-burst.load]\ncylinder = \"test\"\nside = \"rod-side\"\nclosing-flow = \"{flow}\"\nbleed = 0.02\n\
             nominal-flow = \"10 l/min\"\nnominal-pressure-drop = \"2 bar\"\n"
        )
    };
    let speed = |more: &str| {
        let m = hanging(more);
        let run = moved(m.as_ref(), -0.2, 0.04, 2.5);
        let x = rows(m.as_ref(), &run).pop().expect("a row").to_vec();
        (output(m.as_ref(), &x, "cylinder.test.v"), x[m.layout().p2(0)], m)
    };
    let (free, ..) = speed("");
    let (wide, ..) = speed(&burst("20 l/min"));
    let (closed, p2, m) = speed(&burst("2 l/min"));
    let cylinder = &m.machine().cylinders[0];
    let a2 = std::f64::consts::FRAC_PI_4 * (cylinder.bore.powi(2) - cylinder.rod_diameter.powi(2));
    // Its bleed and the open edge in series.
    let (bleed, edge) = (0.02 * 10e-3 / 60.0 / 2e5f64.sqrt(), EDGE_FLOW / COMPENSATED.sqrt() * 0.04 / STROKE);
    let by_hand = (p2 - m.machine().supply.tank_pressure).sqrt() / (bleed.powi(-2) + edge.powi(-2)).sqrt() / a2;
    println!("{free} m/s free, {wide} m/s below its flow, {closed} m/s closed, by hand {by_hand} m/s");
    assert!(free > 0.02 && wide > 0.9 * free, "{free} {wide}");
    assert!(closed < 0.5 * free && (closed / by_hand - 1.0).abs() < 0.02, "{closed} {by_hand}");
}

/// Net oil that a cylinder takes, stores and passes on, m^3/s, by what its pressures do: flows into both chambers less what is
/// stored and what makes room; and the largest flow.
pub fn oil_that_is_lost(m: &dyn Model, c: usize, x: &[f64], u: &[f64], payload: f64) -> (f64, f64) {
    let cylinder = &m.machine().cylinders[c];
    let mut dx = vec![0.0; x.len()];
    m.derivative(x, u, payload, &mut dx);
    let of = |name: &str| output(m, x, &format!("cylinder.{}.{name}", cylinder.name));
    let a1 = std::f64::consts::FRAC_PI_4 * cylinder.bore.powi(2);
    let a2 = a1 - std::f64::consts::FRAC_PI_4 * cylinder.rod_diameter.powi(2);
    let half = cylinder.stroke / 2.0;
    let dead =
        |side: usize| cylinder.dead_volume[side] + cylinder.ports.lines[side].as_ref().map_or(0.0, |line| line.volume);
    let volumes = [dead(0) + a1 * (half + of("x")), dead(1) + a2 * (half - of("x"))];
    let stored: f64 = [m.layout().p1(c), m.layout().p2(c)]
        .iter()
        .zip(volumes)
        .map(|(&p, volume)| dx[p] * volume / m.bulk_modulus(x[p]))
        .sum();
    let outside = match cylinder.leakage {
        hydrocrane_machine::model::Leakage::Conductance { external, .. } => {
            external * (x[m.layout().p2(c)] - m.machine().supply.tank_pressure)
        }
        hydrocrane_machine::model::Leakage::Gap { gap, gland_length, .. } => {
            let conductance =
                annular_gap_conductance(cylinder.rod_diameter, gap, gland_length, m.machine().fluid.viscosity);
            conductance * (x[m.layout().p2(c)] - m.machine().supply.tank_pressure)
        }
    };
    (stored + (a1 - a2) * of("v") + outside - (of("q1") - of("q2")), of("q1").abs().max(of("q2").abs()))
}

/// What the mains of a supply with a pump store, less what flows into them, m^3/s.
fn oil_lost_in_the_mains(m: &dyn Model, x: &[f64], u: &[f64], payload: f64) -> f64 {
    let mains = m.machine().supply.mains.as_ref().expect("mains");
    let at = m.layout().mains().expect("mains");
    let mut dx = vec![0.0; x.len()];
    m.derivative(x, u, payload, &mut dx);
    let volume = mains.volume + mains.compliance * x[at];
    let stored = dx[at] * (volume / m.bulk_modulus(x[at]) + mains.compliance);
    let [pump, relief, drawn] = ["mains.pump_flow", "mains.relief_flow", "supply.flow"].map(|name| output(m, x, name));
    stored - (pump - relief - drawn)
}

#[test]
fn no_oil_is_lost_through_what_holds_loads_and_valves_at_the_ports() {
    let on = |kind: &str, cylinder: &str, side: &str, more: &str| {
        format!("[{kind}.{cylinder}-{side}]\ncylinder = \"{cylinder}\"\nside = \"{side}\"\nnominal-flow = \"40 l/min\"\n{more}")
    };
    let pump = "[pump.main]\ntype = \"load-sensing\"\ndisplacement = \"28 ml\"\nspeed = \"1500 rpm\"\nvolumetric-efficiency = 0.92\n\
         hydromechanical-efficiency = 0.9\nls-margin = \"20 bar\"\n[mains]\nvolume = \"0.6 l\"\nhose-compliance = \"0.2 ml/bar\"\n";
    let parts = [
        on(
            "counterbalance",
            "lift",
            "piston-side",
            "setting = \"150 bar\"\npilot-ratio = 3\nnominal-pressure-drop = \"8 bar\"\n",
        ),
        on("pilot-check", "tilt", "rod-side", "pilot-ratio = 4\nnominal-pressure-drop = \"5 bar\"\n"),
        on(
            "hose-burst",
            "extension",
            "piston-side",
            "closing-flow = \"8 l/min\"\nbleed = 0.02\nnominal-pressure-drop = \"2 bar\"\n",
        ),
        on("port-relief", "lift", "piston-side", "setting = \"90 bar\"\n"),
        on("port-relief", "tilt", "piston-side", "setting = \"60 bar\"\n"),
        on("anti-cavitation", "lift", "rod-side", "nominal-pressure-drop = \"2 bar\"\n"),
        on("anti-cavitation", "tilt", "piston-side", "nominal-pressure-drop = \"2 bar\"\n"),
        on("line", "lift", "piston-side", "nominal-pressure-drop = \"9 bar\"\n"),
        on(
            "line",
            "tilt",
            "piston-side",
            "nominal-pressure-drop = \"6 bar\"\nlength = \"4 m\"\ninner-diameter = \"12 mm\"\n",
        ),
    ];
    let m = extended("hiab-xs031", &(pump.to_string() + &parts.concat()));
    let m = m.as_ref();
    let options = RunOptions { payload: 300.0, ..options("rodas5p") };
    let start = m.equilibrium(&[1.0, -0.6, 0.5], EquilibriumMode::Hold, options.payload).expect("a pose");
    // Down and out, a sudden stop, up and in.
    let rows_of_commands =
        [[0.0; 3], [-0.008, -0.006, 0.007], [-0.008, -0.006, 0.007], [0.0; 3], [0.006, 0.007, -0.007]];
    let commands = Commands { times: vec![0.1, 0.3, 1.2, 1.25, 1.6], values: rows_of_commands.concat(), linear: true };
    let record: Vec<f64> = (0..=240).map(|i| f64::from(i) / 100.0).collect();
    let run = simulate(m, &start, 2.4, &commands, &record, &options, &mut |_| true);
    assert_eq!(run.outcome.kind, OutcomeKind::Completed, "{}", run.outcome.message);
    let (mut lost, mut most, mut relieved, mut fed) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
    for (x, u) in rows(m, &run).iter().zip(run.commands.chunks_exact(3)) {
        for c in 0..3 {
            let (gap, flow) = oil_that_is_lost(m, c, x, u, options.payload);
            (lost, most) = (lost.max(gap.abs()), most.max(flow));
            for side in ["relieved1", "relieved2"] {
                let through = output(m, x, &format!("cylinder.{}.{side}", m.machine().cylinders[c].name));
                (relieved, fed) = (relieved.max(through), fed.min(through));
            }
        }
        lost = lost.max(oil_lost_in_the_mains(m, x, u, options.payload).abs());
    }
    println!("{lost:.1e} m^3/s lost of {most:.1e}; port valves pass {relieved:.1e} and {fed:.1e}");
    assert!(lost < 1e-9 * most, "{lost} of {most} m^3/s");
    assert!(relieved > 1e-3 * most && fed < -1e-3 * most, "the port valves stayed closed: {relieved} {fed} of {most}");
}

#[test]
fn what_holds_a_load_keeps_oil_and_energy() {
    for more in [PILOT_CHECK.to_string(), counterbalance(3.0)] {
        let m = hanging(&more);
        let run = moved(m.as_ref(), -0.1, 0.01, 3.0);
        let (gap, supply) = (crate::ledger::gap(m.as_ref(), &run), crate::ledger::at_end(m.as_ref(), &run, "supply"));
        println!("supply {supply:.1} J, open {gap:.2e} J");
        assert!(supply > 10.0 && gap < 1e-4 * supply, "{gap} of {supply} J");
    }
}
