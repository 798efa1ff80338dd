//! The bundled machines say what their sources say.

use std::f64::consts::{FRAC_PI_2, PI};

use hydrocrane_machine::model::Form;
use hydrocrane_machine::model::*;
use hydrocrane_machine::{bundled_machines, bundled_scenarios, load, load_scenario, Machine, OverrideValue, Template};

fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance
}

fn rotated(angle: f64, [x, z]: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [cos * x - sin * z, sin * x + cos * z]
}

fn sum([ax, az]: [f64; 2], [bx, bz]: [f64; 2]) -> [f64; 2] {
    [ax + bx, az + bz]
}

/// Origin and angle of every link frame, by the definitions of `model.rs`.
fn frames(machine: &Machine, q: &[f64]) -> Vec<([f64; 2], f64)> {
    let mut frames = vec![([0.0; 2], 0.0)];
    for (i, joint) in machine.joints.iter().enumerate() {
        let (origin, angle) = frames[i];
        let moved = joint.sense * (q[i] - joint.zero);
        let at = sum(origin, rotated(angle, joint.at));
        frames.push(match joint.kind {
            JointKind::Revolute(convention) => {
                let half_turn = if convention == AngleConvention::Included { PI } else { 0.0 };
                let child_axis = angle + machine.links[i].axis + moved - joint.sense * half_turn;
                (at, child_axis - machine.links[i + 1].axis)
            }
            JointKind::Prismatic { direction } => (sum(at, rotated(angle + direction, [moved, 0.0])), angle),
        });
    }
    frames
}

fn position(machine: &Machine, q: &[f64], point: &Point) -> [f64; 2] {
    let (origin, angle) = frames(machine, q)[point.link];
    sum(origin, rotated(angle, point.position))
}

fn pin_distance(machine: &Machine, q: &[f64], cylinder: &Cylinder) -> f64 {
    let RodPin::Point(rod) = &cylinder.rod_pin else { panic!("a linkage") };
    let [a, b] = [position(machine, q, &cylinder.barrel_pin), position(machine, q, rod)];
    (a[0] - b[0]).hypot(a[1] - b[1])
}

#[test]
fn every_bundled_file_loads() {
    for (name, _) in bundled_machines() {
        assert_eq!(load(name, &[]).unwrap_or_else(|error| panic!("{error}")).name, *name);
    }
    for (name, _) in bundled_scenarios() {
        assert_eq!(load_scenario(name, &[]).unwrap_or_else(|error| panic!("{error}")).name, *name);
    }
}

/// The printed program's start, alpha = beta = 100 deg, x3 = 0, has its tip at (2.8251, -0.1990) m.
#[test]
fn the_lab_crane_has_the_printed_tip() {
    let crane = load("rottne-f9-lab", &[]).unwrap();
    let q = [100f64.to_radians(), 100f64.to_radians(), 0.0];
    let tip = position(&crane, &q, &crane.tip);
    assert!(close(tip[0], 2.8251, 5e-5) && close(tip[1], -0.1990, 5e-5), "{tip:?}");
}

/// Thesis (40) evaluated with DIMENSION: x1(100 deg) = 0.0427, x1(172 deg) = 0.2510 m.
#[test]
fn the_lift_cylinder_has_the_printed_strokes() {
    let crane = load("rottne-f9-lab", &[]).unwrap();
    let lift = &crane.cylinders[0];
    for (alpha, stroke) in [(45f64, -0.1216), (100.0, 0.0427), (172.0, 0.2510)] {
        let length = pin_distance(&crane, &[alpha.to_radians(), FRAC_PI_2, 0.0], lift);
        assert!(close(length - lift.mid_length, stroke, 6e-5), "{}", length - lift.mid_length);
    }
}

#[test]
fn the_extension_s_coordinate_is_its_piston_position() {
    let crane = load("rottne-f9-lab", &[]).unwrap();
    let extension = &crane.cylinders[2];
    for x3 in [-0.3, 0.0, 0.2] {
        let length = pin_distance(&crane, &[1.7, 1.8, x3], extension);
        assert!(close(length - extension.mid_length, x3, 1e-12));
    }
}

/// The side of the four-bar against thesis (17)-(26): epsilon_1 as the printed program computes it.
#[test]
fn the_torque_linkage_lies_on_the_printed_side() {
    let crane = load("rottne-f9-lab", &[]).unwrap();
    let RodPin::FourBar(linkage) = &crane.cylinders[1].rod_pin else { panic!("no linkage") };
    let [p4, t3] = [linkage.rocker_pivot.position, linkage.coupler_pivot.position];
    let [r1, r2] = [linkage.rocker_length, linkage.coupler_length];
    let joint = crane.joints[1].at;
    let arm = [joint[0] - p4[0], joint[1] - p4[1]];
    let phi = (arm[1] / arm[0]).atan();
    let [n4, n3] = [arm[0].hypot(arm[1]), t3[0].hypot(t3[1])];
    for degrees in [5, 40, 75, 110, 145, 175] {
        let beta = f64::from(degrees).to_radians();
        let theta1 = 2.0 * PI - beta - FRAC_PI_2 + (t3[0] / t3[1]).atan() + phi;
        let diagonal = (n4 * n4 + n3 * n3 - 2.0 * n4 * n3 * theta1.cos()).sqrt();
        let theta2 = ((r1 * r1 + r2 * r2 - diagonal * diagonal) / (2.0 * r1 * r2)).acos();
        let epsilon = (n3 / diagonal * theta1.sin()).asin() + (r2 / diagonal * theta2.sin()).asin() + phi;
        let pin = rotated(epsilon, [r1, 0.0]);
        let coupler = sum(joint, rotated(beta - PI, t3));
        let line = [coupler[0] - p4[0], coupler[1] - p4[1]];
        assert!(close((pin[0] - line[0]).hypot(pin[1] - line[1]), r2, 1e-12));
        let cross = line[0] * pin[1] - line[1] * pin[0];
        assert_eq!(cross.signum(), linkage.side, "beta {degrees} deg");
    }
}

/// Closed form of the tip given by the source, whose extension axis is not a unit vector: 0.5 um at full extension.
#[test]
fn the_loader_crane_has_the_source_s_tip() {
    let crane = load("hiab-xs031", &[]).unwrap();
    for (t1, t2, x) in [(0.0f64, 0.0f64, 0.0f64), (0.4, -1.2, 0.3), (1.3, -0.5, 1.1), (-0.1, -2.4, 0.7)] {
        let source = [
            -0.189261 + 1.59687 * t1.cos() - 0.100002 * t1.sin() + (1.99949 + x) * (t1 + t2).cos()
                - (0.154167 + 0.000928646 * x) * (t1 + t2).sin(),
            0.85 + 0.100002 * t1.cos()
                + 1.59687 * t1.sin()
                + (1.99949 + x) * (t1 + t2).sin()
                + (0.154167 + 0.000928646 * x) * (t1 + t2).cos(),
        ];
        let tip = position(&crane, &[t1, t2, x], &crane.tip);
        assert!(close(tip[0], source[0], 1e-6) && close(tip[1], source[1], 1e-6), "{tip:?} {source:?}");
    }
}

/// Triangle formulas of the source for lift and tilt; the extension's pins are 1.241 m + x apart. The source prints the
/// place of the lift joint to a micrometre, 0.13 um off its own triangle.
#[test]
fn the_loader_crane_has_the_source_s_pin_lengths() {
    let crane = load("hiab-xs031", &[]).unwrap();
    let triangle = |a: f64, b: f64, angle: f64| (a * a + b * b + 2.0 * a * b * angle.cos()).sqrt();
    for (t1, t2, x) in [(0.0, -0.3, 0.0), (0.4, -1.2, 0.3), (1.3, -0.5, 1.1), (-0.1, -2.4, 0.7)] {
        let q1 = -FRAC_PI_2 - 0.380746995657807 - 0.121961735475489 + t1;
        let q2 = t2 - 0.122594643555178 - 0.288982033065996;
        let expected = [
            triangle(1.0071227324212, 0.37610632101293, q1),
            triangle(1.132185817991, 0.30901132665325, q2),
            1.241 + x,
        ];
        for (cylinder, expected) in crane.cylinders.iter().zip(expected) {
            let length = pin_distance(&crane, &[t1, t2, x], cylinder);
            assert!(close(length, expected, 2e-7), "{}: {length} {expected}", cylinder.name);
        }
    }
}

#[test]
fn bodies_of_a_link_are_combined_about_their_common_centre() {
    let crane = load("hiab-xs031", &[]).unwrap();
    let tilt = &crane.links[2];
    // Mass, centre (x, z) and inertia of the three bodies in the file.
    let bodies = [
        (33.92850233, [0.657387, 0.088902], 7.40915161),
        (10.34519231, [0.223006, -0.259984], 0.55785997),
        (9.26136143, [0.975299, 0.277471], 1.48398069),
    ];
    // About the frame's origin both ways.
    let about_origin: f64 = bodies.iter().map(|(m, c, i)| i + m * (c[0] * c[0] + c[1] * c[1])).sum();
    let [x, z] = tilt.centre_of_gravity;
    assert!(close(tilt.mass, 53.53505607, 1e-9));
    assert!(close(tilt.inertia + tilt.mass * (x * x + z * z), about_origin, 1e-9));
    assert_eq!(tilt.inertia_about, InertiaAbout::CentreOfGravity);
}

#[test]
fn the_printed_machine_differs_where_the_thesis_errs() {
    let [printed, corrected] = ["heinze-2007", "rottne-f9-lab"].map(|name| load(name, &[]).unwrap());
    assert_eq!(printed.links, corrected.links);
    assert!(!printed.errata.gravity_sign && corrected.errata.gravity_sign);
    assert_eq!(printed.fluid.cavitation, Cavitation::None);
    assert_eq!(printed.fluid.printed_leakage_viscosity, Some(0.6));
    for (cylinder, blended) in printed.cylinders.iter().zip([[true, false], [false; 2], [false; 2]]) {
        assert_eq!(cylinder.friction.model, FrictionModel::Static);
        assert_eq!((cylinder.friction.coulomb, cylinder.friction.breakaway), ([100.0; 2], [750.0; 2]));
        assert_eq!(cylinder.valve.printed_blend.as_ref().unwrap().ports, blended);
        assert!(matches!(cylinder.leakage, Leakage::Gap { gap: 1e-4, .. }));
    }
    let extension = &printed.cylinders[2];
    assert!(matches!(extension.leakage, Leakage::Gap { printed_external_from_piston_side: true, .. }));
    assert!(close(extension.printed_dead_volume.unwrap()[0] / extension.dead_volume[0], PI / 4.0, 1e-15));
}

/// sigma_1 = 2 sqrt(sigma_0 m), m the steel of piston and rod; lift and jib scaled by bore + rod diameter.
#[test]
fn the_lab_crane_s_friction_follows_its_stated_rules() {
    let crane = load("rottne-f9-lab", &[]).unwrap();
    let reference = &crane.cylinders[2];
    for (cylinder, [piston, rod]) in crane.cylinders.iter().zip([[0.1, 0.31], [0.1, 0.31], [0.08, 0.71]]) {
        let area = |diameter: f64| 0.25 * PI * diameter * diameter;
        let mass = 7850.0 * (area(cylinder.bore) * piston + area(cylinder.rod_diameter) * rod);
        let friction = &cylinder.friction;
        let damping = 2.0 * (friction.bristle_stiffness * mass).sqrt();
        assert!(close(friction.bristle_damping, damping, 0.6), "{damping}");
        let scale = (cylinder.bore + cylinder.rod_diameter) / (reference.bore + reference.rod_diameter);
        for side in 0..2 {
            assert!(close(friction.coulomb[side], scale * reference.friction.coulomb[side], 1e-9));
            assert!(close(friction.breakaway[side], scale * reference.friction.breakaway[side], 1e-9));
            assert!(close(friction.viscous[side], scale * reference.friction.viscous[side], 1e-9));
        }
        assert!(close(friction.bristle_stiffness, scale * reference.friction.bristle_stiffness, 1e-6));
    }
}

#[test]
fn numbers_are_listed_in_si_with_their_units() {
    let template = Template::open("single-cylinder", &[]).expect("bundled");
    let machine = template.build(&[("supply.pressure".into(), OverrideValue::Number(1e7))]).expect("a pressure");
    let value =
        |key: &str| machine.provenance.iter().find(|p| p.key == key).unwrap_or_else(|| panic!("{key}")).value.clone();
    assert_eq!(value("supply.pressure").si, [1e7]);
    let pair = value("friction.test.coulomb");
    assert_eq!((pair.si, pair.units, pair.form), (vec![170.0, 350.0], vec!["N".into(), "N".into()], Form::Two));
    let shared = value("friction.test.viscous-exponent");
    assert_eq!((shared.si, shared.form), (vec![1.5, 1.5], Form::Shared));
    assert_eq!(value("link.mass.point.hook").si, [0.0, -0.3]);
    assert!(machine.provenance.iter().all(|p| p.key != "friction.test.model"));
    assert_eq!(template.build(&[]).expect("bundled").supply.pressure, 140e5);
}
