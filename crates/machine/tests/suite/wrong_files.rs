//! Files as newcomers write them: one value wrong, usual alone, impossible beside the others. Each is named by its key.

use hydrocrane_machine::{bundled_machines, load, parse, Machine, MachineError, OverrideValue};

const MINI: &str = include_str!("mini.toml");

fn changed(base: &str, key: &str, value: &str) -> Result<Machine, MachineError> {
    let change = [(key.to_string(), OverrideValue::Text(value.into()))];
    match base {
        "mini" => parse(MINI, "mini.toml", &change),
        name => load(name, &change),
    }
}

/// Base, key, wrong value, what is said of it.
const WRONG: &[(&str, &str, &str, &str)] = &[
    // Masses in g or t, moments of inertia in kg mm^2 or g mm^2.
    ("mini", "link.boom.mass", "227 g", "radius of gyration"),
    ("mini", "link.arm.mass", "13 t", "lead"),
    ("mini", "link.bucket.mass", "53 t", "53 kg"),
    ("mini", "link.boom.inertia", "67.8 kg mm^2", "usual is"),
    ("mini", "link.arm.inertia", "30.3 kg cm^2", "lead"),
    ("mini", "link.bucket.inertia", "3020 kg m^2", "radius of gyration"),
    ("rottne-f9-lab", "link.boom.inertia", "118644 kg m^2", "radius of gyration"),
    ("rottne-f9-lab", "link.jib.mass", "27540 kg", "less than mass times distance squared"),
    ("rottne-f9-lab", "link.extension.mass", "100 g", "radius of gyration"),
    ("hiab-xs031", "link.lift.body.beam.mass", "54.6 t", "54.6 kg"),
    ("hiab-xs031", "link.tilt.body.beam.inertia", "7.5 kg mm^2", "lead"),
    // Masses ten times too large or too small, beside the moment of inertia.
    ("mini", "link.boom.mass", "2273 kg", "the radius of gyration would be"),
    ("mini", "link.arm.mass", "13 kg", "the radius of gyration would be"),
    ("rottne-f9-lab", "link.boom.mass", "7.59 kg", "radius of gyration"),
    // Centres of gravity and points in cm or mm, or in the frame of the link before.
    ("mini", "link.arm.centre-of-gravity", "(2.275, 0.227) m", "beyond the link"),
    ("mini", "link.boom.centre-of-gravity", "(10.25, 3.84) m", "beyond the link"),
    ("mini", "link.bucket.centre-of-gravity", "(2.89, 1.66) m", "beyond the link"),
    ("rottne-f9-lab", "link.jib.centre-of-gravity", "(4.03, 0.97) m", "less than mass times"),
    ("hiab-xs031", "link.lift.body.beam.centre-of-gravity", "(10, 0) m", "beyond the link"),
    ("mini", "link.bucket.point.tip", "(567, 0) m", "567 mm"),
    ("mini", "link.boom.point.rod", "(1.025, 0.278) mm", "apart"),
    ("mini", "link.arm.point.rod", "(-0.251, 0.158) mm", "no lever"),
    ("mini", "link.boom.point.arm-barrel", "(97.7, 73.7) m", "measures"),
    // Diameters, lengths and strokes.
    ("mini", "cylinder.boom.rod-diameter", "85 mm", "exchange the two diameters"),
    ("mini", "cylinder.boom.bore", "45 mm", "exchange the two diameters"),
    ("mini", "cylinder.arm.rod-diameter", "4.5 mm", "thin in a bore"),
    ("mini", "cylinder.arm.rod-diameter", "74 mm", "thick in a bore"),
    ("mini", "cylinder.bucket.bore", "650 mm", "usual is"),
    ("mini", "cylinder.bucket.bore", "6.5 mm", "exchange the two diameters"),
    ("mini", "cylinder.boom.stroke", "4 m", "shorter than the stroke"),
    ("mini", "cylinder.boom.closed-length", "90.5 mm", "measures"),
    ("mini", "cylinder.bucket.closed-length", "84 mm", "shorter than the stroke"),
    ("mini", "cylinder.boom.stroke", "40 mm", "long for a stroke of 40.0 mm"),
    ("mini", "cylinder.boom.stroke", "200 mm", "long for a stroke of 200 mm"),
    ("hiab-xs031", "cylinder.extension.stroke", "110 mm", "long for a stroke of 110 mm"),
    ("mini", "cylinder.boom.end-stop.zone", "250 mm", "half the stroke"),
    ("mini", "cylinder.boom.end-stop.stiffness", "1e7 N/mm", "the rod itself"),
    ("rottne-f9-lab", "cylinder.jib.end-stop.stiffness", "5e9 N/m", "the rod itself"),
    ("mini", "cylinder.boom.end-stop.stiffness", "100 kN/m", "soft"),
    ("mini", "cylinder.boom.end-stop.zone", "130 mm", "both stops together take 260 of the"),
    // cc for l, and back.
    ("mini", "cylinder.boom.dead-volume", "0.6 cc", "passage"),
    ("mini", "cylinder.boom.dead-volume", "60 l", "usual is"),
    ("mini", "cylinder.arm.dead-volume", "40 l", "compresses"),
    ("rottne-f9-lab", "cylinder.lift.port-diameter", "1 mm", "m/s"),
    ("rottne-f9-lab", "cylinder.extension.port-diameter", "10 cm", "wider than half the bore"),
    ("rottne-f9-ls", "pump.main.displacement", "28 l", "28 ml"),
    ("rottne-f9-lab", "cylinder.lift.leakage-gap", "0.1 mm", "leak"),
    ("mini", "cylinder.boom.internal-leakage", "1e-10 m^3/(s Pa)", "leak"),
    ("mini", "valve.boom.leakage", "1e-10 m^3/(s Pa)", "pass a closed edge"),
    // Valves.
    ("single-cylinder", "valve.test.nominal-flow", "2e-2 m^3/s", "piston would move"),
    ("mini", "valve.arm.nominal-flow", "40 ml/min", "usual is"),
    ("single-cylinder", "valve.test.nominal-flow", "0.1 l/min", "piston would move"),
    ("mini", "valve.bucket.nominal-edge-pressure-drop", "35 Pa", "35 bar"),
    ("mini", "valve.bucket.transition-pressure", "40 bar", "laminar"),
    ("mini", "valve.boom.nominal-flow", "4.5 l/min", "takes 18.0 s for its stroke, and the others 1.66 to 2.01 s"),
    ("mini", "valve.bucket.nominal-flow", "300 l/min", "takes 0.166 s for its stroke, and the others"),
    ("hiab-xs031", "valve.extension.nominal-flow", "4 l/min", "for its stroke, and the others"),
    ("mini", "valve.boom.overlap", "12 mm", "never open"),
    ("mini", "valve.boom.overlap", "6 mm", "move no piston"),
    ("mini", "valve.boom.command.dead-band", "6 mm", "move no piston"),
    ("mini", "valve.boom.return-pressure", "12 MPa", "more than half of the supply pressure"),
    ("mini", "valve.boom.velocity-limit", "1 mm/s", "slow"),
    // Friction.
    ("mini", "friction.boom.breakaway", "340 kN", "usual is"),
    ("mini", "friction.boom.breakaway", "90 kN", "presses the piston"),
    ("mini", "friction.arm.coulomb", "1.7 N", "circumference"),
    ("mini", "friction.boom.viscous", "2e7 N s/m", "usual is"),
    ("mini", "friction.boom.viscous", "1.7e4 N s/mm", "1.7e4 N s/m"),
    ("mini", "friction.boom.viscous", "3e5 N s/m", "where the supply has"),
    ("mini", "friction.arm.viscous", "13.25 N s/m", "of Coulomb friction"),
    ("mini", "friction.bucket.bristle-stiffness", "1.3 kN/m", "bristles would yield"),
    // Oil and supply.
    ("rottne-f9-ls", "pump.main.torque-limit", "5 N m", "small: at"),
    ("mini", "fluid.bulk-modulus", "1.2 MPa", "1.2 GPa"),
    ("mini", "fluid.density", "0.87 kg/m^3", "kg/l"),
    ("mini", "fluid.viscosity", "46 Pa s", "46 mPa s"),
    ("mini", "supply.pressure", "200 kPa", "usual is"),
    ("mini", "supply.pressure", "2000 bar", "usual is"),
    ("mini", "supply.tank-pressure", "300 bar", "below the tank pressure"),
    ("mini", "payload.hang", "1.2 m", "without effect"),
    ("mini", "environment.gravity", "9.81 mm/s^2", "usual is"),
    ("mini", "environment.slope", "40 deg", "usual is"),
    ("mini", "environment.slope", "60 deg", "60 deg or more: no machine stands on such ground"),
    ("mini", "environment.slope", "-75 deg", "for example \"10 deg\""),
    ("mini", "environment.slope", "3 m", "angle"),
    // Beside all others of its kind, which are alike: MPa for bar, rad/s for Hz, rpm for Hz.
    ("hiab-xs031", "valve.tilt.nominal-edge-pressure-drop", "7 bar", "10.0 times as small as in valve.lift"),
    ("mini", "valve.boom.transition-pressure", "10 bar", "10.0 times as large as in valve.arm"),
    ("rottne-f9-ls", "valve.jib.natural-frequency", "10 rad/s", "6.28 times as small as in valve.lift"),
    ("sany-sy19e", "valve.boom.natural-frequency", "95.5 Hz", "9.55 times as large as in valve.slew"),
    ("rottne-f9-lab", "cylinder.extension.leakage-gap", "0.001 mm", "as small as in cylinder.lift"),
    // Drops against what the margin and the compensators leave an edge.
    ("rottne-f9-ls", "valve.jib.nominal-pressure-drop", "16 MPa", "over an edge there are 8.0 bar"),
    ("rottne-f9-mobile", "valve.lift.compensator-setting", "1.5 bar", "at full stroke it takes 43 %"),
    ("rottne-f9-ls", "pump.main.ls-margin", "2 bar", "small: it leaves"),
    // Points and centres of gravity in mm that are m.
    ("rottne-f9-lab", "link.extension.point.tip", "(1.136, -0.051) mm", "from the origin of its link's frame"),
    ("mini", "link.boom.centre-of-gravity", "(1.025, 0.384) mm", "from the origin of its link's frame"),
    // Lengths of gaps in m.
    ("rottne-f9-lab", "cylinder.lift.gland-length", "0.9 m", "longer than the stroke"),
    ("rottne-f9-lab", "cylinder.jib.piston-length", "10 m", "not shorter than the barrel"),
    // Per mm for per m, per minute for per second.
    ("mini", "cylinder.boom.end-stop.damping", "100 kN s/mm", "lets go of the piston"),
    ("mini", "friction.boom.bristle-damping", "9528 N s/mm", "of the Stribeck rise"),
    ("mini", "friction.boom.stribeck-velocity", "1 m/s", "friction still falls"),
    ("rottne-f9-ls", "valve.jib.delay", "0.6 s", "the spool swings in 0.100 s"),
    // Oil, relief valve and payload against the whole machine.
    ("rottne-f9-lab", "fluid.bulk-modulus-max", "14.5 GPa", "with the other values of the oil"),
    ("rottne-f9-pump", "mains.relief-pressure", "450 bar", "the supply is set to 140 bar"),
    ("mini", "payload.mass", "0.3 kg", "at the tip of links of"),
];

#[test]
fn every_wrong_value_is_named() {
    let mut missed = Vec::new();
    for (base, key, value, said) in WRONG {
        let found = match changed(base, key, value) {
            Ok(machine) => {
                let of = machine.warnings.iter().map(|w| format!("{}: {}; {}", w.key, w.text, w.cure));
                of.collect::<Vec<_>>().join("\n")
            }
            Err(error) => error.to_string(),
        };
        if !found.contains(said) || found.is_empty() {
            missed.push(format!("{base} {key} = {value}, wanted `{said}`: {found}"));
        }
    }
    assert!(missed.is_empty(), "{} of {}:\n{}", missed.len(), WRONG.len(), missed.join("\n"));
}

#[test]
fn right_files_are_not_blamed() {
    assert_eq!(parse(MINI, "mini.toml", &[]).unwrap().warnings, []);
    for (name, _) in bundled_machines() {
        assert_eq!(load(name, &[]).unwrap().warnings, [], "{name}");
    }
    // Other values of the same size are as good.
    for (key, value) in [
        ("link.boom.mass", "500 lb"),
        ("link.boom.inertia", "0 kg m^2"),
        ("cylinder.boom.bore", "3.5 in"),
        ("cylinder.arm.rod-diameter", "25 mm"),
        ("cylinder.boom.dead-volume", "3 l"),
        ("valve.boom.nominal-flow", "10 gpm"),
        ("friction.boom.breakaway", "6 kN"),
        ("supply.pressure", "350 bar"),
    ] {
        let machine = changed("mini", key, value).unwrap();
        assert_eq!(machine.warnings, [], "{key} = {value}");
    }
}

/// Of several valves and lines of one cylinder the one is named that lies outside of all others.
#[test]
fn one_of_several_flows_is_named() {
    let beside = "\n[counterbalance.boom]\ncylinder = \"boom\"\nside = \"piston-side\"\nsetting = \"260 bar\"\npilot-ratio = 4\n\
                  nominal-flow = \"60 l/min\"\nnominal-pressure-drop = \"8 bar\"\n[anti-cavitation.boom]\ncylinder = \"boom\"\nside = \"rod-side\"\n\
                  nominal-flow = \"50 l/min\"\nnominal-pressure-drop = \"3 bar\"\n";
    let named = |key: &str, flow: &str| {
        let change = [(format!("{key}.nominal-flow"), OverrideValue::Text(flow.into()))];
        let machine = parse(&format!("{MINI}{beside}"), "mini.toml", &change).unwrap();
        machine.warnings.into_iter().map(|w| format!("{} {}", w.key, w.text)).collect::<Vec<_>>()
    };
    assert_eq!(named("anti-cavitation.boom", "70 l/min"), [""; 0]);
    for (key, flow, word) in [
        ("anti-cavitation.boom", "5 l/min", "small"),
        ("anti-cavitation.boom", "500 l/min", "large"),
        ("counterbalance.boom", "6 l/min", "small"),
        ("valve.boom", "4.5 l/min", "small"),
        ("valve.boom", "450 l/min", "large"),
    ] {
        let found = named(key, flow);
        let wanted = format!("{key}.nominal-flow {word} beside the ");
        assert!(found.len() == 1 && found[0].starts_with(&wanted), "{key} = {flow}: {found:?}");
    }
}

#[test]
fn friction_of_nothing_is_named() {
    let none = [("coulomb", "0 N"), ("breakaway", "0 N"), ("viscous", "0 N s/m")];
    let change = none.map(|(key, value)| (format!("friction.arm.{key}"), OverrideValue::Text(value.into())));
    let machine = parse(MINI, "mini.toml", &change).unwrap();
    assert!(machine.warnings.iter().any(|w| w.key == "friction.arm.breakaway" && w.text.starts_with("zero")));
}

#[test]
fn cylinders_in_parallel_are_counted_in_whole_numbers() {
    for (value, said) in [
        ("0", "greater than zero"),
        ("1.5", "whole number of cylinders up to 8, found 1.5"),
        ("-1", "greater than zero"),
        ("9", "whole number of cylinders up to 8, found 9"),
        ("\"two\"", "plain number"),
    ] {
        let text = MINI.replace("[cylinder.boom]", &format!("[cylinder.boom]\ncount = {value}"));
        let error = parse(&text, "mini.toml", &[]).expect_err(value).to_string();
        let line = 1 + text.lines().position(|line| line.starts_with("count")).expect("the key");
        for part in [&format!("mini.toml:{line}:"), "cylinder.boom.count", said, "; "] {
            assert!(error.contains(part), "{value}, wanted `{part}`: {error}");
        }
    }
    // Two share the flow of the valve, and each has its own seals, stop and dead volume.
    assert_eq!(changed("mini", "cylinder.boom.count", "2").unwrap().warnings, []);
}

#[test]
fn a_slope_needs_its_unit() {
    let text = MINI.replace("[environment]", "[environment]\nslope = 10");
    let error = parse(&text, "mini.toml", &[]).expect_err("a bare number").to_string();
    assert!(error.contains("environment.slope") && error.contains("deg"), "{error}");
}

#[test]
fn motors_are_read_with_their_gears() {
    const FILE: &str = include_str!("../../../../machines/sany-sy19e.toml");
    const MOTOR: &str = "motor = { displacement = \"23.6 cm3/rev\", gear-ratio = 134 }";
    let rack = FILE.lines().find(|line| line.starts_with("rack-radius")).expect("the ring");
    for (from, to, key, said) in [
        (MOTOR, "motor = { displacement = \"0 ml\", gear-ratio = 134 }", "motor.displacement", "greater than zero"),
        (MOTOR, "motor = { displacement = \"-5 cm3/rev\", gear-ratio = 9 }", "motor.displacement", "greater than zero"),
        (MOTOR, "motor = { displacement = \"23.6 mm\", gear-ratio = 134 }", "motor.displacement", "volume"),
        (MOTOR, "motor = { displacement = 23.6, gear-ratio = 134 }", "motor.displacement", "unit"),
        (MOTOR, "motor = { displacement = \"23.6 ml\", gear-ratio = 0 }", "motor.gear-ratio", "greater than zero"),
        (MOTOR, "motor = { displacement = \"23.6 ml\", gear-ratio = -134 }", "motor.gear-ratio", "greater than zero"),
        (MOTOR, "motor = { displacement = \"23.6 ml\", gear-ratio = nan }", "motor.gear-ratio", "not finite"),
        (MOTOR, "motor = { displacement = \"23.6 ml\" }", "motor", "gear-ratio"),
        (MOTOR, "motor = { gear-ratio = 134 }", "motor", "displacement"),
        (
            MOTOR,
            "motor = { displacement = \"1 ml\", gear_ratio = 1 }",
            "motor.gear_ratio",
            "did you mean `gear-ratio`?",
        ),
        (MOTOR, "motor = \"23.6 ml\"", "motor", "table"),
        (rack, "", "cylinder.slew", "rack-radius"),
        (
            rack,
            "barrel = \"cabin.boom-barrel\"\nrod = \"boom.boom-rod\"\nclosed-length = \"1 m\"",
            "cylinder.slew",
            "rack-radius",
        ),
        (MOTOR, &format!("{MOTOR}\nbore = \"50 mm\""), "cylinder.slew.bore", "has no bore"),
        (MOTOR, &format!("{MOTOR}\nrod-diameter = \"0 mm\""), "cylinder.slew.rod-diameter", "has no rod-diameter"),
        (MOTOR, &format!("{MOTOR}\npiston-length = \"50 mm\""), "cylinder.slew.piston-length", "has no piston-length"),
        (MOTOR, "", "cylinder.slew", "bore"),
        (
            "stroke = { value = \"1.3 m\"",
            "closed-length = { value = \"1.3 m\"",
            "cylinder.slew.closed-length",
            "rack-radius",
        ),
    ] {
        let text = FILE.replacen(from, to, 1);
        assert_ne!(text, FILE, "{from}");
        let error = parse(&text, "mine.toml", &[]).expect_err(to);
        let told = error.to_string();
        for part in ["mine.toml:", key, said] {
            assert!(told.contains(part), "{to}, wanted `{part}`: {told}");
        }
        assert!(error.cure().is_some(), "no cure: {told}");
    }
    // The unit may state the turn.
    let other = parse(&FILE.replacen("23.6 cm3/rev", "23.6 ml", 1), "mine.toml", &[]).unwrap();
    let bore = |machine: &Machine| machine.cylinders[0].bore;
    assert!((bore(&other) / bore(&parse(FILE, "mine.toml", &[]).unwrap()) - 1.0).abs() < 1e-14);
    assert!(other.cylinders[0].motor && !other.cylinders[1].motor && other.warnings.is_empty());
}
