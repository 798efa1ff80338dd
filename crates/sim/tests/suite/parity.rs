//! The fast right-hand side equals the readable reference; the exact Jacobian equals finite differences.

use crate::extended;
use hydrocrane_machine::load;
use hydrocrane_ode::BlockArrow;
use hydrocrane_sim::{build, Model};
use std::sync::Arc;

const MACHINES: [&str; 10] = [
    "rottne-f9-lab",
    "rottne-f9-pump",
    "rottne-f9-mobile",
    "rottne-f9-ls",
    "rottne-f9-forwarder",
    "hiab-xs031",
    "single-cylinder",
    "rig-rottne",
    "rig-kalmar",
    "sany-sy19e",
];

fn model(name: &str) -> Arc<dyn Model> {
    build(&load(name, &[]).expect("a bundled machine")).expect("a machine that can be built")
}

/// A bundled machine without friction in its seals.
fn frictionless(name: &str) -> Arc<dyn Model> {
    let mut machine = load(name, &[]).expect("a bundled machine");
    for cylinder in &mut machine.cylinders {
        let friction = &mut cylinder.friction;
        (friction.coulomb, friction.breakaway, friction.viscous) = ([0.0; 2], [0.0; 2], [0.0; 2]);
    }
    build(&machine).expect("a frictionless machine can be built")
}

/// Every machine as it is, and without friction.
pub fn models() -> impl Iterator<Item = (&'static str, Arc<dyn Model>)> {
    MACHINES.into_iter().flat_map(|name| [(name, model(name)), (name, frictionless(name))])
}

/// Fixed pumps, several pumps, compensators that follow late, torque limits, engines, soft hoses, tank lines, unloading, flow sharing, curves, separate meter-out, load-holding, port and cross-over valves, priority, lines, hoses that leak, accumulators and
/// measured pressures on chains of one and
/// three joints.
pub fn models_with_pumps() -> impl Iterator<Item = (&'static str, Arc<dyn Model>)> {
    let fixed = r#"
        [pump.main]
        type = "fixed"
        displacement = "20 ml"
        speed = "1500 rpm"
        volumetric-efficiency = 0.9
        hydromechanical-efficiency = 0.85
        [mains]
        volume = "1 l"
        hose-compliance = "0.3 ml/bar"
    "#;
    let limited = r#"
        [pump.main]
        type = "pressure-compensated"
        displacement = "40 ml"
        speed = "1500 rpm"
        volumetric-efficiency = 0.9
        hydromechanical-efficiency = 0.85
        torque-limit = "30 N m"
        droop = "12 %"
        rated-torque = "25 N m"
        [mains]
        volume = "1 l"
    "#;
    let unloaded = fixed.replace("[mains]", "ls-margin = \"15 bar\"\n[mains]");
    let sharing = limited.replace("pressure-compensated", "load-sensing").replace("[mains]", "ls-margin = \"25 bar\"\n[mains]")
        + "[valve.lift]\ncompensator = \"behind-spool\"\n[valve.tilt]\ncompensator = \"before-spool\"\ncompensator-setting = \"9 bar\"\n";
    let beside = |name: &str, of: &str, size: &str| {
        let pump = of.split("[mains]").next().expect("a pump").replace("main", name);
        pump.replace("40 ml", size).replace("20 ml", size)
    };
    let two = beside("aside", limited, "25 ml")
        .replace("droop = \"12 %\"", "control-range = \"3 bar\"\ndroop = \"5 %\"")
        + limited;
    let three = beside("third", fixed, "13 ml") + &beside("aside", fixed, "8 ml") + fixed;
    let sensing =
        limited.replace("pressure-compensated", "load-sensing").replace("[mains]", "ls-margin = \"25 bar\"\n[mains]");
    let keeping = |margin: &str| sensing.replace("25 bar", margin);
    let all = beside("third", &keeping("18 bar"), "15 ml") + &beside("aside", &keeping("31 bar"), "8 ml") + &sensing;
    let holding = |cylinder: &str, side: &str| {
        format!(
            "[counterbalance.{cylinder}-{side}]\ncylinder = \"{cylinder}\"\nside = \"{side}\"\nsetting = \"120 bar\"\npilot-ratio = 3.5\n\
             nominal-flow = \"40 l/min\"\nnominal-pressure-drop = \"8 bar\"\n"
        )
    };
    let on_both_sides = ["piston-side", "rod-side"].map(|side| holding("test", side)).concat();
    let at_ports = ["lift", "tilt"].map(|cylinder| {
        let at = |side: &str| format!("cylinder = \"{cylinder}\"\nside = \"{side}\"\nnominal-flow = \"60 l/min\"\n");
        format!(
            "[port-relief.{cylinder}]\n{}setting = \"110 bar\"\n[anti-cavitation.{cylinder}]\n{}nominal-pressure-drop = \"2 bar\"\n\
             [anti-cavitation.{cylinder}-2]\n{}nominal-pressure-drop = \"5 bar\"\nopening-pressure = \"0.5 bar\"\n",
            at("piston-side"),
            at("piston-side"),
            at("rod-side")
        )
    });
    let at = |cylinder: &str, side: &str| format!("cylinder = \"{cylinder}\"\nside = \"{side}\"\n");
    let crossing = |cylinder: &str| {
        format!(
            "[crossover-relief.{cylinder}]\n{}setting = \"30 bar\"\nnominal-flow = \"60 l/min\"\n\
             [crossover-relief.{cylinder}-2]\n{}setting = \"45 bar\"\nnominal-flow = \"40 l/min\"\noverpressure = \"10 bar\"\n",
            at(cylinder, "piston-side"),
            at(cylinder, "rod-side")
        )
    };
    let passing = "nominal-flow = \"40 l/min\"\nnominal-pressure-drop = \"5 bar\"\n";
    let checked = |cylinder: &str| {
        format!(
            "[pilot-check.{cylinder}]\n{}pilot-ratio = 3.5\n{passing}[hose-burst.{cylinder}]\n{}closing-flow = \"4 l/min\"\nbleed = 0.02\n{passing}",
            at(cylinder, "rod-side"),
            at(cylinder, "piston-side")
        )
    };
    let lines = |cylinder: &str| {
        format!(
            "[line.{cylinder}]\n{}length = \"4 m\"\ninner-diameter = \"12 mm\"\ncompliance = \"0.05 ml/bar\"\n\
             [line.{cylinder}-2]\n{}volume = \"0.3 l\"\n",
            at(cylinder, "piston-side"),
            at(cylinder, "rod-side")
        )
    };
    let resisting = |cylinder: &str| {
        lines(cylinder).replace("\n[line", "\nnominal-flow = \"90 l/min\"\n[line")
            + "nominal-flow = \"30 l/min\"\nnominal-pressure-drop = \"6 bar\"\nlaminar-share = 0.3\n"
    };
    let alone = |cylinder: &str, side: &str| {
        format!(
            "[line.{cylinder}]\n{}nominal-flow = \"20 l/min\"\nnominal-pressure-drop = \"9 bar\"\n",
            at(cylinder, side)
        )
    };
    let leaking = |cylinder: &str, openings: [&str; 2]| {
        ["piston-side", "rod-side"]
            .iter()
            .zip(openings)
            .map(|(side, opening)| {
                format!("[hose-leak.{cylinder}-{side}]\n{}opening = \"{opening}\"\n", at(cylinder, side))
            })
            .collect::<String>()
    };
    let gas = "[accumulator.main]\nvolume = \"0.7 l\"\nprecharge = \"80 bar\"\n";
    let returning = "[tank-line]\nvolume = \"3 l\"\nhose-compliance = \"0.2 ml/bar\"\nnominal-flow = \"60 l/min\"\nnominal-pressure-drop = \"4 bar\"\n\
        [tank-line.filter]\nnominal-flow = \"60 l/min\"\nnominal-pressure-drop = \"1 bar\"\n";
    let bypassed = format!("{returning}bypass-pressure = \"2 bar\"\n");
    let held = unloaded.clone() + &on_both_sides;
    let first =
        |cylinder: &str| format!("[priority]\ncylinder = \"{cylinder}\"\nmargin = \"3 bar\"\nrange = \"20 bar\"\n");
    let lifting = sharing.clone() + &holding("lift", "piston-side") + &holding("tilt", "rod-side");
    let curve = |valve: &str, edge: &str, points: &str| format!("[valve.{valve}.metering.{edge}]\n{points}\n");
    let notch = "travel = [0, 0.1, 0.2, 0.6, 1]\narea = [0, 0, 0.05, 0.3, 0.9]";
    let wide = "travel = [0, 0.3, 0.8, 1]\nflow = [\"0 l/min\", \"1 l/min\", \"9 l/min\", \"9 l/min\"]";
    let notched = sharing.clone()
        + "overlap = \"2 mm\"\n"
        + &[("supply-to-a", notch), ("a-to-tank", wide), ("supply-to-b", wide), ("b-to-tank", notch)]
            .map(|(edge, points)| curve("lift", edge, points))
            .concat()
        + &curve("tilt", "b-to-tank", notch);
    let separate = sharing.clone()
        + "return-pressure = [\"40 bar\", \"3 bar\"]\nreturn-area-ratio = [0.6, 1.3]\n\
           [valve.extension]\noverlap = \"0.1 mm\"\nreturn-pressure = \"70 bar\"\nreturn-pressure-range = \"60 bar\"\n";
    let behind_late = "compensator = \"behind-spool\"\ncompensator-time-constant = \"20 ms\"\n";
    let before_late =
        "compensator = \"before-spool\"\ncompensator-setting = \"9 bar\"\ncompensator-time-constant = \"70 ms\"\n";
    let late = sensing + &format!("[valve.lift]\n{behind_late}[valve.tilt]\n{before_late}");
    let regenerative = curve("extension", "supply-to-b", notch) + &curve("extension", "a-to-tank", wide);
    [
        ("hiab-xs031", late.clone()),
        ("rottne-f9-lab", format!("[valve.lift]\n{before_late}[valve.jib]\n{before_late}")),
        ("single-cylinder", format!("{unloaded}[valve.test]\n{behind_late}{}{returning}", resisting("test"))),
        (
            "hiab-xs031",
            late.clone() + &first("tilt") + &resisting("lift") + &resisting("tilt") + &at_ports.concat() + &bypassed,
        ),
        (
            "hiab-xs031",
            late + &holding("lift", "piston-side")
                + &holding("tilt", "rod-side")
                + &alone("lift", "piston-side")
                + &leaking("lift", ["9 mm^2", "1 mm^2"])
                + &leaking("tilt", ["1 mm^2", "30 mm^2"]),
        ),
        ("hiab-xs031", notched),
        ("hiab-xs031", separate),
        ("rottne-f9-lab", regenerative),
        ("hiab-xs031", "[supply]\nmeasured = \"yes\"\n".to_string()),
        ("hiab-xs031", resisting("lift")),
        ("rottne-f9-lab", resisting("extension")),
        ("hiab-xs031", sharing.clone() + &resisting("lift") + &resisting("tilt") + &at_ports.concat()),
        ("hiab-xs031", lifting.clone() + &alone("lift", "piston-side") + &resisting("extension")),
        ("single-cylinder", unloaded.clone() + &checked("test") + &alone("test", "piston-side")),
        ("hiab-xs031", sharing.clone() + &first("tilt")),
        ("rottne-f9-lab", unloaded.clone() + &first("jib")),
        ("hiab-xs031", lifting.clone() + &first("lift") + &resisting("extension") + &bypassed),
        ("hiab-xs031", two.clone()),
        ("single-cylinder", two + returning),
        ("single-cylinder", three),
        ("hiab-xs031", all.clone()),
        ("hiab-xs031", all + &bypassed),
        ("single-cylinder", crossing("test")),
        ("hiab-xs031", crossing("lift")),
        (
            "hiab-xs031",
            lifting.clone()
                + &crossing("tilt")
                + &crossing("lift")
                + &at_ports.concat()
                + &resisting("extension")
                + &bypassed,
        ),
        ("single-cylinder", leaking("test", ["20 mm^2", "0.3 mm^2"])),
        ("single-cylinder", unloaded.clone() + &on_both_sides + &leaking("test", ["2 mm^2", "0 mm^2"])),
        (
            "single-cylinder",
            unloaded.clone()
                + &checked("test")
                + &alone("test", "piston-side")
                + &leaking("test", ["3 mm^2", "8 mm^2"]),
        ),
        ("rottne-f9-lab", leaking("extension", ["5 mm^2", "1 mm^2"])),
        (
            "hiab-xs031",
            lifting.clone()
                + &first("tilt")
                + &resisting("extension")
                + &leaking("lift", ["9 mm^2", "1 mm^2"])
                + &leaking("tilt", ["1 mm^2", "30 mm^2"])
                + &bypassed,
        ),
        ("single-cylinder", on_both_sides),
        ("hiab-xs031", at_ports[0].clone()),
        ("hiab-xs031", checked("lift") + &lines("tilt")),
        ("single-cylinder", unloaded.clone() + &checked("test")),
        ("single-cylinder", fixed.to_string() + &lines("test") + gas),
        ("hiab-xs031", sharing.clone() + &lines("lift") + gas),
        ("hiab-xs031", lifting.clone() + &at_ports.concat()),
        ("single-cylinder", held.clone() + returning),
        ("hiab-xs031", limited.to_string() + returning),
        ("single-cylinder", fixed.to_string() + returning),
        ("hiab-xs031", lifting.clone() + &at_ports.concat() + &bypassed),
        ("single-cylinder", unloaded.clone() + &checked("test") + &alone("test", "piston-side") + &bypassed),
        ("single-cylinder", held),
        ("hiab-xs031", lifting),
        ("hiab-xs031", fixed.to_string()),
        ("single-cylinder", fixed.to_string()),
        ("hiab-xs031", limited.to_string()),
        ("single-cylinder", unloaded),
        ("hiab-xs031", sharing),
    ]
    .into_iter()
    .map(|(name, pump)| (name, extended(name, &pump)))
}

/// A repeatable stream of numbers in (-1, 1).
pub struct Noise(pub u64);

impl Noise {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// A state anywhere inside the joint limits, pressures from vacuum to beyond supply.
pub fn random_state(m: &dyn Model, noise: &mut Noise) -> Vec<f64> {
    let limits = m.joint_limits();
    let q: Vec<f64> =
        limits.iter().map(|l| 0.5 * (l.lower + l.upper + 0.96 * noise.next() * (l.upper - l.lower))).collect();
    let mut x = vec![0.0; m.layout().len()];
    x[..q.len()].copy_from_slice(&q);
    for (i, name) in m.layout().names.iter().enumerate() {
        match name.rsplit('.').next() {
            Some("qd") => x[i] = 0.3 * noise.next(),
            Some("p1" | "p2") => x[i] = 75e5 + 75.8e5 * noise.next(),
            Some("xs") => x[i] = 0.02 * noise.next(),
            Some("vs") => x[i] = noise.next(),
            Some("z") => x[i] = 1e-3 * noise.next(),
            // From empty mains to beyond the relief pressure.
            Some("p" | "load") => x[i] = 90e5 + 90e5 * noise.next(),
            Some("displacement" | "compensator") => x[i] = 0.5 + 0.5 * noise.next(),
            _ => {}
        }
    }
    x
}

/// That the fast right-hand side and the readable one agree.
pub fn assert_the_same(name: &str, m: &dyn Model, x: &[f64], u: &[f64], payload: f64) {
    let mut fast = vec![0.0; x.len()];
    m.derivative(x, u, payload, &mut fast);
    let slow = m.reference_derivative(x, u, payload).expect("a corrected machine");
    for (i, (a, b)) in fast.iter().zip(&slow).enumerate() {
        let state = &m.layout().names[i];
        assert!((a - b).abs() <= 1e-10 * a.abs() + 1e-12, "{name} {state}: {a} {b}");
    }
}

#[test]
fn fast_right_hand_side_equals_the_reference() {
    for (name, m) in models().chain(models_with_pumps()) {
        let mut noise = Noise(7);
        for _ in 0..500 {
            let x = random_state(m.as_ref(), &mut noise);
            let u: Vec<f64> = (0..m.layout().joints()).map(|_| 0.02 * noise.next()).collect();
            assert_the_same(name, m.as_ref(), &x, &u, 100.0 * noise.next().abs());
        }
    }
}

#[test]
fn steering_a_linearisation_gives_the_one_at_the_other_commands() {
    let mut limited = load("rottne-f9-lab", &[]).expect("a bundled machine");
    limited.cylinders[0].valve.spool.acceleration_limit = Some(2000.0);
    let machines = MACHINES.map(model).into_iter().chain([build(&limited).expect("a machine that can be built")]);
    for m in machines {
        let (n, mut noise) = (m.layout().len(), Noise(5));
        for _ in 0..20 {
            let x = random_state(m.as_ref(), &mut noise);
            let mut commands = || -> Vec<f64> { (0..m.layout().joints()).map(|_| 0.02 * noise.next()).collect() };
            let (before, after) = (commands(), commands());
            let at = |u: &[f64]| {
                let (mut rate, mut derivatives) = (vec![0.0; n], BlockArrow::new(m.layout().blocks()));
                m.linearise(&x, u, 0.0, &mut rate, &mut derivatives);
                (rate, derivatives)
            };
            let dense = |derivatives: &BlockArrow<f64>| {
                let mut jacobian = vec![0.0; n * n];
                derivatives.write_dense(n, &mut jacobian);
                jacobian
            };
            let ((mut rate, mut derivatives), (wanted_rate, wanted_derivatives)) = (at(&before), at(&after));
            assert_ne!(rate, wanted_rate);
            m.update_input(&x, &after, &mut rate, &mut derivatives);
            assert_eq!((rate, dense(&derivatives)), (wanted_rate, dense(&wanted_derivatives)));
        }
    }
}

#[test]
fn exact_jacobian_equals_central_differences() {
    for (name, m) in models().chain(models_with_pumps()) {
        let n = m.layout().len();
        let mut noise = Noise(11);
        for _ in 0..50 {
            let x = random_state(m.as_ref(), &mut noise);
            let u = vec![0.005; m.layout().joints()];
            let mut jacobian = vec![0.0; n * n];
            m.jacobian(&x, &u, 20.0, &mut jacobian);
            for column in 0..n {
                let h = 1e-6 * m.layout().scales[column];
                let at = |shift: f64| {
                    let mut shifted = x.clone();
                    shifted[column] += shift;
                    let mut dx = vec![0.0; n];
                    m.derivative(&shifted, &u, 20.0, &mut dx);
                    dx
                };
                // Of fourth order: where a valve begins to open, curves are narrow.
                let [near, far] = [h, 2.0 * h].map(|h| (at(h), at(-h)));
                for row in 0..n {
                    let difference = (8.0 * (near.0[row] - near.1[row]) - (far.0[row] - far.1[row])) / (12.0 * h);
                    let exact = jacobian[row * n + column];
                    let row_scale =
                        (0..n).map(|k| (jacobian[row * n + k] * m.layout().scales[k]).abs()).fold(1e-12, f64::max);
                    let error = (exact - difference).abs() * m.layout().scales[column];
                    assert!(error < 1e-6 * row_scale, "{name} {row} {column}: {exact} {difference}");
                }
            }
        }
    }
}
