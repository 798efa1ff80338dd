//! Convergence order of each method, its interpolant and its quadratures, against closed solutions.

use hydrocrane_ode::System;
use hydrocrane_ode::{method, Linearisation, StepControl, Stepper, Tolerances, METHODS};

/// A driven, a nonlinear and two oscillating states, with the integral of one squared:
///     y' = y cos t,   z' = -z^2,   u' = v,   v' = -u,   w' = u^2
struct Analytic;

const SCALES: [f64; 4] = [1.0; 4];

fn exact(t: f64) -> ([f64; 4], f64) {
    ([t.sin().exp(), 1.0 / (1.0 + t), t.cos(), -t.sin()], 0.5 * t + 0.25 * (2.0 * t).sin())
}

impl System for Analytic {
    fn dimension(&self) -> usize {
        4
    }
    fn quadrature_rates(&self, x: &[f64], dw: &mut [f64]) {
        dw[0] = x[2] * x[2];
    }
    fn derivative(&self, t: f64, x: &[f64], dx: &mut [f64]) {
        dx.copy_from_slice(&[x[0] * t.cos(), -x[1] * x[1], x[3], -x[2]]);
    }
    fn linearise(&self, t: f64, x: &[f64], at: &mut Linearisation) {
        self.derivative(t, x, &mut at.rate);
        let dfdx = at.dense(0);
        dfdx.fill(0.0);
        dfdx[0] = t.cos();
        dfdx[5] = -2.0 * x[1];
        dfdx[11] = 1.0;
        dfdx[14] = -1.0;
    }
    fn time_derivative(&self, t: f64, x: &[f64], dfdt: &mut [f64]) -> bool {
        dfdt.copy_from_slice(&[-x[0] * t.sin(), 0.0, 0.0, 0.0]);
        true
    }
    fn admissible(&self, _x: &[f64]) -> bool {
        true
    }
    fn scales(&self) -> &[f64] {
        &SCALES
    }
}

/// Errors at t = 2 with steps of fixed size: states, quadrature, and the interpolant inside all steps.
fn errors(name: &str, h: f64) -> [f64; 3] {
    let fixed = Tolerances { relative: 1e9, absolute: 1e9, max_step: h };
    let method = method(name, 4).expect("a listed method");
    let mut stepper = Stepper::new(method, fixed, 0.0, &exact(0.0).0, 1).with_control(crate::control(name));
    let (mut inside, mut x, mut w) = (0.0f64, [0.0; 4], [0.0; 1]);
    while stepper.t < 2.0 {
        // Limits on the grid keep the step size exact.
        let limit = (stepper.t / h).round() * h + h;
        stepper.step(&Analytic, limit).expect("a smooth problem");
        for theta in [0.2, 0.5, 0.8] {
            let t = stepper.previous_time() + theta * (stepper.t - stepper.previous_time());
            stepper.interpolate(t, &mut x);
            stepper.interpolate_integrals(t, &mut w);
            let (exact_x, exact_w) = exact(t);
            inside = x.iter().zip(&exact_x).map(|(a, b)| (a - b).abs()).fold(inside, f64::max);
            inside = inside.max((w[0] - exact_w).abs());
        }
    }
    let (exact_x, exact_w) = exact(stepper.t);
    let states = stepper.x.iter().zip(&exact_x).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    [states, (stepper.integrals()[0] - exact_w).abs(), inside]
}

/// Order of a method.
fn order_of(name: &str) -> f64 {
    f64::from(method(name, 4).expect("a listed method").order())
}

/// Errors below this are rounding.
const ROUNDING: f64 = 1e-13;

/// How errors fall with the step; those of rounding do not.
fn orders(name: &str) -> [f64; 3] {
    let (coarse, fine) = (errors(name, 0.05), errors(name, 0.025));
    std::array::from_fn(|i| if fine[i] < ROUNDING { f64::INFINITY } else { (coarse[i] / fine[i]).log2() })
}

#[test]
fn states_converge_with_the_order_of_the_method() {
    for name in METHODS {
        let order = orders(name)[0];
        assert!((order - order_of(name)).abs() < 0.2, "{name}: {order}");
    }
}

#[test]
fn quadratures_converge_with_the_order_of_the_states_and_interpolants_with_one_less() {
    for name in METHODS {
        let [_, quadrature, interpolant] = orders(name);
        assert!(quadrature > order_of(name) - 0.3, "{name}: quadrature {quadrature}");
        assert!(interpolant > order_of(name) - 1.2, "{name}: interpolant {interpolant}");
    }
}

#[test]
fn tolerances_are_met_by_any_method() {
    for name in METHODS {
        for tolerance in [1e-4, 1e-7, 1e-10] {
            let tolerances = Tolerances { relative: tolerance, absolute: tolerance, max_step: 1.0 };
            let mut stepper = Stepper::new(method(name, 4).expect("listed"), tolerances, 0.0, &exact(0.0).0, 1);
            while stepper.t < 10.0 {
                stepper.step(&Analytic, 10.0).expect("a smooth problem");
            }
            let error = stepper.x.iter().zip(&exact(10.0).0).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(error < 30.0 * tolerance, "{name} at {tolerance}: {error}");
        }
    }
}

#[test]
fn a_restart_within_rounding_of_a_limit_does_not_shorten_later_ones() {
    for name in ["rodas5p", "hc-exponential-4", "tsit5"] {
        let tolerances = Tolerances { relative: 1e-6, absolute: 1e-6, max_step: 0.5 };
        let mut stepper = Stepper::new(method(name, 4).expect("listed"), tolerances, 0.0, &exact(0.0).0, 1);
        for limit in [1.0 - 1e-15, 1.0, 2.0] {
            while stepper.t < limit {
                stepper.step(&Analytic, limit).expect("a smooth problem");
            }
            stepper.restart();
        }
    }
}

#[test]
fn even_steps_are_equal_and_end_at_the_limit_by_any_method() {
    for name in METHODS {
        let largest = Tolerances { relative: 1e-4, absolute: 1e-4, max_step: 0.03 };
        let stepper = Stepper::new(method(name, 4).expect("listed"), largest, 0.0, &exact(0.0).0, 1);
        let mut stepper = stepper.with_control(StepControl::Even);
        for (limit, steps) in [(0.1, 4), (0.19, 3), (0.2, 1)] {
            let (begin, before) = (stepper.t, stepper.accepted);
            while stepper.t < limit {
                let from = stepper.t;
                stepper.step(&Analytic, limit).expect("a smooth problem");
                assert!((stepper.t - from - (limit - begin) / steps as f64).abs() < 1e-15, "{name}");
            }
            assert_eq!((stepper.t, stepper.accepted - before), (limit, steps), "{name}");
        }
        assert_eq!(stepper.rejected, 0, "{name}");
    }
}

/// y' = -p y^2 with its derivative by p behind it:   s' = -2 p y s - y^2,   y(0) = 1, s(0) = 0
struct WithTangent {
    p: f64,
}

impl System for WithTangent {
    fn dimension(&self) -> usize {
        2
    }
    fn tangents(&self) -> usize {
        1
    }
    fn derivative(&self, _t: f64, x: &[f64], dx: &mut [f64]) {
        dx.copy_from_slice(&[-self.p * x[0] * x[0], -2.0 * self.p * x[0] * x[1] - x[0] * x[0]]);
    }
    fn linearise(&self, t: f64, x: &[f64], at: &mut Linearisation) {
        self.derivative(t, x, &mut at.rate);
        let dfdx = at.dense(1);
        dfdx.copy_from_slice(&[-2.0 * self.p * x[0], -2.0 * self.p * x[1] - 2.0 * x[0]]);
    }
    fn time_derivative(&self, _t: f64, _x: &[f64], _dfdt: &mut [f64]) -> bool {
        false
    }
    fn admissible(&self, _x: &[f64]) -> bool {
        true
    }
    fn scales(&self) -> &[f64] {
        &SCALES[..1]
    }
}

/// State and tangent at t = 2 with steps of fixed size.
fn at_two(name: &str, p: f64, h: f64) -> [f64; 2] {
    let fixed = Tolerances { relative: 1e9, absolute: 1e9, max_step: h };
    let stepper = Stepper::new(method(name, 2).expect("listed"), fixed, 0.0, &[1.0, 0.0], 0);
    let mut stepper = stepper.with_control(crate::control(name));
    while stepper.t < 2.0 {
        let limit = (stepper.t / h).round() * h + h;
        stepper.step(&WithTangent { p }, limit).expect("a smooth problem");
    }
    [stepper.x[0], stepper.x[1]]
}

#[test]
fn a_tangent_is_the_derivative_of_the_very_steps() {
    for name in METHODS {
        // Steps so large that the discrete solution is far from the exact one.
        let difference = (at_two(name, 1.5 + 1e-4, 0.5)[0] - at_two(name, 1.5 - 1e-4, 0.5)[0]) / 2e-4;
        let tangent = at_two(name, 1.5, 0.5)[1];
        let exact = -2.0 / (1.0 + 1.5 * 2.0f64).powi(2);
        assert!((tangent / difference - 1.0).abs() < 1e-7, "{name}: {tangent}, {difference}");
        assert!((tangent / exact - 1.0).abs() > 1e-6, "{name}: the steps are too small to tell");
    }
}

#[test]
fn tangents_converge_with_the_order_of_the_states() {
    for name in METHODS {
        let exact = [1.0 / (1.0 + 2.0 * 1.5), -2.0 / (1.0 + 2.0 * 1.5f64).powi(2)];
        let errors = |h: f64| -> [f64; 2] {
            let found = at_two(name, 1.5, h);
            std::array::from_fn(|i| (found[i] - exact[i]).abs())
        };
        let (coarse, fine) = (errors(0.1), errors(0.0125));
        let [states, tangents] = std::array::from_fn(|i| (coarse[i] / fine[i]).log2() / 3.0);
        let order = order_of(name);
        assert!(tangents > order - 0.5 && (tangents - states).abs() < 0.15, "{name}: {states}, {tangents}");
    }
}
