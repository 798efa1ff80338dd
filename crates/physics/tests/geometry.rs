//! The lab crane's geometry against the thesis's trigonometric forms, evaluated here on their own.

use hydrocrane_num::{Dual, Field, Vec2};
use hydrocrane_physics::geometry::cylinder_triangle::included_angle;
use hydrocrane_physics::geometry::four_bar::FourBar;
use hydrocrane_physics::geometry::frames::Joint;
use hydrocrane_physics::geometry::stroke::{Actuation, Mounting};
use std::f64::consts::PI;

const T1: [f64; 2] = [2.231, 0.109];
const J3: [f64; 2] = [2.309, 0.081];
const T3: [f64; 2] = [-0.035, 0.094];
const C2S: [f64; 2] = [1.519, 0.214];
const MID_2: f64 = 0.035 + 0.445 / 2.0 + 0.05 + 0.31 + 0.095;

fn joint(at: [f64; 2], offset: f64) -> Joint<f64> {
    Joint { at: Vec2::c(at), direction: Vec2::default(), offset, zero: 0.0, sense: 1.0, revolute: true }
}

fn jib() -> (Joint<f64>, Actuation<f64>) {
    let linkage = FourBar {
        rocker_pivot: Vec2::c(T1),
        coupler_pivot: Vec2::c(T3),
        rocker_length: 0.182,
        coupler_length: 0.194,
        side: 1.0,
    };
    (joint(J3, -PI), Actuation { mounting: Mounting::FourBar { barrel: Vec2::c(C2S), linkage }, mid_length: MID_2 })
}

fn boom() -> (Joint<f64>, Actuation<f64>) {
    let mounting = Mounting::Pins {
        on_parent: Vec2::c([0.115, 0.033]),
        on_child: Vec2::c([0.199, -0.061]),
        barrel_on_child: true,
        aside: 0.0,
    };
    (joint([0.0, 0.73], -PI / 2.0), Actuation { mounting, mid_length: 0.05 + 0.215 + 0.05 + 0.31 + 0.01 })
}

/// Thesis (17)-(26) and (41), (42), with the slips of the text mended (E27, E29): x2 from beta.
fn thesis_x2(beta: f64) -> f64 {
    let (dx, dz) = (J3[0] - T1[0], J3[1] - T1[1]);
    let (near, far) = (dx.hypot(dz), f64::hypot(T3[0], T3[1]));
    let theta_1 = 2.0 * PI - beta - PI / 2.0 + (T3[0] / T3[1]).atan() + (dz / dx).atan();
    let diagonal = (near * near + far * far - 2.0 * near * far * theta_1.cos()).sqrt();
    let theta_2 = ((0.182f64.powi(2) + 0.194f64.powi(2) - diagonal * diagonal) / (2.0 * 0.182 * 0.194)).acos();
    let theta_31 = (far / diagonal * theta_1.sin()).asin();
    let theta_32 = (0.194 / diagonal * theta_2.sin()).asin();
    let epsilon_1 = theta_31 + theta_32 + (dz / dx).atan();
    let pin = [T1[0] + 0.182 * epsilon_1.cos(), T1[1] + 0.182 * epsilon_1.sin()];
    f64::hypot(pin[0] - C2S[0], pin[1] - C2S[1]) - MID_2
}

#[test]
fn closed_form_four_bar_equals_the_thesis_angles() {
    let (joint, actuation) = jib();
    for degrees in 6..=178 {
        let beta = f64::from(degrees).to_radians();
        let (x, _) = actuation.stroke(&joint.pose(beta));
        assert!((x - thesis_x2(beta)).abs() < 1e-12, "beta = {degrees} deg: {x} {}", thesis_x2(beta));
    }
}

#[test]
fn strokes_of_erratum_13() {
    let degrees =
        |(joint, actuation): (Joint<f64>, Actuation<f64>), d: f64| actuation.stroke(&joint.pose(d.to_radians())).0;
    for (crane, angle, x) in
        [(boom(), 45.0, -0.1216), (boom(), 172.0, 0.2510), (jib(), 178.0, -0.1424), (jib(), 5.0, 0.1684)]
    {
        assert!((degrees(crane, angle) - x).abs() < 1e-4);
    }
}

#[test]
fn stroke_derivative_is_exact_at_every_angle() {
    for (joint, actuation) in [boom(), jib()] {
        let (wide_joint, wide) = (joint.lift::<Dual<f64, 1>>(), actuation.lift::<Dual<f64, 1>>());
        for degrees in 28..=176 {
            let q = f64::from(degrees).to_radians();
            let (x, _) = wide.stroke(&wide_joint.pose(Dual::variable(q, 0)));
            let (_, slope) = actuation.stroke(&joint.pose(q));
            assert!((x.derivative[0] - slope).abs() < 1e-12 * slope.abs().max(1e-3));
        }
    }
}

#[test]
fn boom_angle_from_the_law_of_cosines() {
    let (joint, actuation) = boom();
    let (arm_1, arm_2) = (f64::hypot(0.115, 0.73 - 0.033), f64::hypot(0.199, 0.061));
    let psi_1 = (-0.115f64 / (0.73 - 0.033)).atan();
    let psi_2 = (-0.061f64 / 0.199).atan();
    for degrees in [30.0f64, 60.0, 100.0, 135.0] {
        let (x, _) = actuation.stroke(&joint.pose(degrees.to_radians()));
        let psi_0 = included_angle(arm_1, arm_2, x + actuation.mid_length).expect("a triangle");
        // Thesis (12): alpha = psi_0 - psi_1 - psi_2, both fixed angles negative.
        assert!((psi_0 - psi_1 - psi_2 - degrees.to_radians()).abs() < 1e-12, "{degrees}");
    }
    assert_eq!(included_angle(1.0, 1.0, 2.1), None);
}

#[test]
fn boom_has_its_dead_centre_at_26_4_degrees() {
    let (joint, actuation) = boom();
    let slope = |d: f64| actuation.stroke(&joint.pose(d.to_radians())).1;
    assert!(slope(26.3) < 0.0 && slope(26.5) > 0.0);
}

#[test]
fn torn_linkage_keeps_finite_value_and_slope() {
    let (_, actuation) = jib();
    let Mounting::FourBar { linkage, .. } = actuation.mounting else { panic!("the jib has a four-bar") };
    let far = linkage.lift::<Dual<f64, 1>>();
    let away = hydrocrane_physics::geometry::MovingPoint {
        position: Vec2::new(Dual::variable(9.0, 0), Dual::c(9.0)),
        rate: Vec2::new(Dual::c(1.0), Dual::c(0.5)),
    };
    let pin = far.common_pin(away);
    assert!(far.closure(away.position).value < 0.0);
    assert!(pin.position.x.derivative[0].is_finite() && pin.rate.z.value.is_finite());
}

#[test]
fn slope_angles_swing_as_erratum_41_says() {
    // Over the ranges of Table 1: 9.7 deg for the lift cylinder, 8.6 deg for the jib cylinder.
    let swing = |(joint, actuation): (Joint<f64>, Actuation<f64>), from: i32, to: i32| {
        let slopes: Vec<f64> =
            (from..=to).map(|d| actuation.slope(&joint.pose(f64::from(d).to_radians())).to_degrees()).collect();
        slopes.iter().fold(f64::MIN, |a, b| a.max(*b)) - slopes.iter().fold(f64::MAX, |a, b| a.min(*b))
    };
    assert!((swing(boom(), 45, 172) - 9.7).abs() < 0.05);
    assert!((swing(jib(), 5, 178) - 8.6).abs() < 0.05);
}
