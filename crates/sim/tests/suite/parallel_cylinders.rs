//! Equal cylinders in parallel: the same as one of twice the size, and the same laws in both right-hand sides.

use crate::extended;
use crate::parity::{assert_the_same, random_state, Noise};
use crate::supply::{options, rows};
use hydrocrane_machine::model::{Leakage, Machine};
use hydrocrane_machine::{load, OverrideValue};
use hydrocrane_sim::{build, simulate, Commands, EquilibriumMode, Model, OutcomeKind};
use std::f64::consts::SQRT_2;
use std::sync::Arc;

/// Its ports throttle nothing, and what leaks is stated as conductances.
const MACHINE: &str = "hiab-xs031";
const PAYLOAD: f64 = 200.0;

/// Two of each cylinder, by the key.
fn two_of_each() -> Arc<dyn Model> {
    let names = ["lift", "tilt", "extension"];
    let changes = names.map(|name| (format!("cylinder.{name}.count"), OverrideValue::Number(2.0)));
    build(&load(MACHINE, &changes).expect("two of each")).expect("it can be built")
}

/// One of each with twice the area, volume, leak, force and stiffness.
fn one_of_twice_the_size() -> Arc<dyn Model> {
    let mut machine: Machine = load(MACHINE, &[]).expect("a bundled machine");
    for of in &mut machine.cylinders {
        (of.bore, of.rod_diameter) = (SQRT_2 * of.bore, SQRT_2 * of.rod_diameter);
        of.port_diameter = of.port_diameter.map(|diameter| SQRT_2 * diameter);
        of.dead_volume = of.dead_volume.map(|volume| 2.0 * volume);
        let Leakage::Conductance { internal, external } = of.leakage else { panic!("stated as conductances") };
        of.leakage = Leakage::Conductance { internal: 2.0 * internal, external: 2.0 * external };
        (of.end_stop.stiffness, of.end_stop.damping) = (2.0 * of.end_stop.stiffness, 2.0 * of.end_stop.damping);
        let seals = &mut of.friction;
        for pair in [&mut seals.coulomb, &mut seals.breakaway, &mut seals.viscous] {
            *pair = pair.map(|of_one| 2.0 * of_one);
        }
        (seals.bristle_stiffness, seals.bristle_damping) = (2.0 * seals.bristle_stiffness, 2.0 * seals.bristle_damping);
    }
    build(&machine).expect("it can be built")
}

fn assert_close(what: &str, ours: &[f64], theirs: &[f64], relative: f64) {
    let scale = ours.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    for (a, b) in ours.iter().zip(theirs) {
        assert!((a - b).abs() <= relative * (a.abs() + 1e-3 * scale), "{what}: {a} and {b}");
    }
}

#[test]
fn two_are_one_of_twice_the_size() {
    let (two, one) = (two_of_each(), one_of_twice_the_size());
    let pose: Vec<f64> = two.joint_limits().iter().map(|l| 0.5 * (l.lower + l.upper)).collect();
    let [a, b] = [&two, &one].map(|m| m.equilibrium(&pose, EquilibriumMode::Hold, PAYLOAD).expect("a pose"));
    assert_close("equilibrium", &a, &b, 1e-12);
    let [a, b] = [&two, &one].map(|m| {
        let mut speeds = vec![0.0; 6];
        m.piston_speeds(&pose, PAYLOAD, &mut speeds);
        speeds
    });
    assert_close("piston speeds", &a, &b, 1e-9);
    let [(a, by_a), (b, by_b)] = [&two, &one].map(|m| m.capacity(&pose, 1e6));
    assert_close("load that is held", &[a], &[b], 1e-11);
    assert!(by_a == by_b && a > 2.0 * load_that_one_holds(&pose), "{a} kg by {by_a:?}, {by_b:?}");
    let commands = Commands {
        times: vec![0.0, 0.1, 0.4, 1.0, 1.2],
        values: vec![0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 5e-3, -4e-3, 4e-3, 5e-3, -4e-3, 4e-3, 0.0, 0.0, 0.0],
        linear: true,
    };
    let record: Vec<f64> = (0..=40).map(|i| f64::from(i) / 20.0).collect();
    let [(a, out_a), (b, out_b)] = [&two, &one].map(|m| {
        let start = m.equilibrium(&pose, EquilibriumMode::Hold, PAYLOAD).expect("a pose");
        let mut options = options("rodas5p");
        options.payload = PAYLOAD;
        let run = simulate(m.as_ref(), &start, 2.0, &commands, &record, &options, &mut |_| true);
        assert_eq!(run.outcome.kind, OutcomeKind::Completed, "{}", run.outcome.message);
        let states: Vec<Vec<f64>> = rows(m.as_ref(), &run).into_iter().map(<[f64]>::to_vec).collect();
        let outputs = states.iter().map(|x| {
            let mut out = vec![0.0; m.output_info().len()];
            m.outputs(x, PAYLOAD, &mut out);
            out
        });
        let outputs: Vec<Vec<f64>> = outputs.collect();
        (states, outputs)
    });
    let moved = (a[40][0] - a[0][0]).abs();
    assert!(moved > 0.01, "{moved}");
    for (what, a, b) in [("states", &a, &b), ("outputs", &out_a, &out_b)] {
        for column in 0..a[0].len() {
            let [a, b] = [a, b].map(|rows| rows.iter().map(|row| row[column]).collect::<Vec<f64>>());
            // What the choice of steps makes of rounding.
            assert_close(&format!("{what} {column}"), &a, &b, 2e-4);
        }
    }
}

fn load_that_one_holds(pose: &[f64]) -> f64 {
    let one = build(&load(MACHINE, &[]).expect("a bundled machine")).expect("it can be built");
    one.capacity(pose, 1e6).0
}

#[test]
fn both_right_hand_sides_count_them_in_any_number() {
    let lines =
        "[line.hose]\ncylinder = \"lift\"\nside = \"rod-side\"\nvolume = \"0.5 l\"\ncompliance = \"0.05 ml/bar\"\n";
    for (base, more) in [
        (MACHINE, format!("[cylinder.lift]\ncount = 2\n[cylinder.extension]\ncount = 8\n{lines}")),
        // Gaps, and the dynamic pressure of ports.
        ("rottne-f9-lab", format!("[cylinder.lift]\ncount = 3\n[cylinder.jib]\ncount = 2\n{lines}")),
    ] {
        let m = extended(base, &more);
        let mut noise = Noise(11);
        for _ in 0..200 {
            let x = random_state(m.as_ref(), &mut noise);
            let u: Vec<f64> = (0..3).map(|_| 0.02 * noise.next()).collect();
            assert_the_same(base, m.as_ref(), &x, &u, PAYLOAD);
        }
    }
}
