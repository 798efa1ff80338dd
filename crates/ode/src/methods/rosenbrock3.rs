//! hc-rosenbrock-3: linearly implicit method of order three, L-stable, for fixed steps.   theory: docs/theory/integration.md
//!
//! With G = (I - h gamma J)^-1, F_1 = f(t, x) and F_2 = f(t + alpha h, x + alpha h G F_1)
//!     x_new = x + h (p_1 G + p_2 G^2 + p_3 G^3 + p_4 G^4) F_1 + h (q_2 G^2 + q_3 G^3) F_2.
//! A step costs two right-hand sides, a Jacobian, a factorisation and four solves, which are cheap here: with four
//! solves the error of an oscillation is a fifteenth of that with three. Powers of G are collected from the highest down; as
//! p_1 = gamma, the first increment h gamma G F_1 is used unchanged. The increments also give a solution of order two that damps
//! stiff components: its distance is the error estimate.

use crate::linear::rows::with_avx2;
use crate::linear::system::System;
use crate::linear::{Factored, Linearisation};
use crate::methods::method::{Effort, Method, Restart, Target};

const STAGES: usize = 4;
/// gamma: L-stable from 0.22365 on; the error of an oscillation is smallest near this bound.
const GAMMA: f64 = 0.23;
/// alpha: position of the second right-hand side as a share of the step.
const NODE: f64 = 0.75;
/// p_2 to p_4: weights of the right-hand side at the start.
const P: [f64; 3] = [3_325_073.0 / 1_428_300.0, -175_299.0 / 52_900.0, 61_533.0 / 52_900.0];
/// q_2 and q_3: weights of the second right-hand side.
const Q: [f64; 2] = [704.0 / 621.0, -112.0 / 207.0];
/// Weights of the increments in the error estimate.
const ESTIMATE: [f64; STAGES] = [-1.324_937_582_050_629_2, 0.601_068_593_537_668_2, 0.167_977_798_974_853_5, 0.25];
/// Weights of the increments inside a step: see [`interpolant`].
const INTERPOLANT: [[f64; 4]; STAGES] = [
    [15.973_052_048_890_666, -46.210_066_164_753_51, -18.845_193_649_165_13, 33.818_539_925_040_84],
    [-3.570_527_704_895_972_7, 25.706_649_546_843_63, -44.272_243_683_895_31, -5.712_269_363_629_87],
    [-0.883_925_801_586_136_3, 10.067_684_796_926_917, -27.063_170_164_594_604, 1.081_835_291_665_336],
    [-2.376_121_233_318_882_3, 13.403_603_919_756_397, -13.359_313_198_961_987, -3.297_385_580_196_955_8],
];

/// Applies `of` to each component of a start and its increments.
#[inline(always)]
fn combine(out: &mut [f64], from: &[f64], k: &[Vec<f64>; STAGES], of: impl Fn(f64, [f64; STAGES]) -> f64) {
    let [one, two, three, four] = k;
    let increments = one.iter().zip(two).zip(three).zip(four);
    for ((out, from), (((one, two), three), four)) in out.iter_mut().zip(from).zip(increments) {
        *out = of(*from, [*one, *two, *three, *four]);
    }
}

/// The method for a [`System`].
pub struct Rosenbrock3 {
    linearisation: Linearisation,
    factored: Factored<f64>,
    /// df/dt, and whether it is nonzero.
    time_derivative: Vec<f64>,
    driven: bool,
    k: [Vec<f64>; STAGES],
    /// The second right-hand side and where it is taken.
    ahead: Vec<f64>,
    argument: Vec<f64>,
    /// Start of the last attempt.
    start: Vec<f64>,
    effort: Effort,
}

impl Rosenbrock3 {
    pub fn new(n: usize) -> Self {
        Rosenbrock3 {
            linearisation: Linearisation::new(n).with_secants(),
            factored: Factored::default(),
            time_derivative: vec![0.0; n],
            driven: false,
            k: hydrocrane_num::array::from_fn(|_| vec![0.0; n]),
            ahead: vec![0.0; n],
            argument: vec![0.0; n],
            start: vec![0.0; n],
            effort: Effort::default(),
        }
    }

    /// Writes the increments of a step of size `h` from `x` into `k`; on entry `k[0]` is f at the start. They are h gamma G F_1,
    /// then the partial sums of p and q over the powers of G.
    #[inline(always)]
    fn stages(&mut self, system: &dyn System, t: f64, h: f64, x: &[f64]) {
        let Rosenbrock3 { linearisation, factored, time_derivative, driven, ahead, argument, .. } = self;
        let [first, second, third, fourth] = &mut self.k;
        let inverse = 1.0 / h;
        // A solve takes df/dt as often as time has gone on in what it is applied to.
        let drift = |k: &mut [f64], passed: f64| {
            for (k, dfdt) in k.iter_mut().zip(if *driven { &time_derivative[..] } else { &[] }) {
                *k += h * *dfdt * passed;
            }
        };
        drift(first, GAMMA);
        factored.solve_outlined(linearisation, first);
        for (argument, (x, k)) in argument.iter_mut().zip(x.iter().zip(&*first)) {
            *argument = *x + *k * (NODE / GAMMA);
        }
        system.derivative(t + NODE * h, argument, ahead);
        let [p2, p3, p4] = P.map(|p| p / (GAMMA * GAMMA));
        let [q2, q3] = Q.map(|q| q / GAMMA);
        for (second, (first, ahead)) in second.iter_mut().zip(first.iter().zip(&*ahead)) {
            *second = inverse * *first * p4 + *ahead * q3;
        }
        drift(second, P[2] + Q[1]);
        factored.solve_outlined(linearisation, second);
        for (third, ((first, second), ahead)) in third.iter_mut().zip(first.iter().zip(&*second).zip(&*ahead)) {
            *third = inverse * (*first * p3 + *second * (1.0 / GAMMA)) + *ahead * q2;
        }
        drift(third, P[1] + P[2] + Q[0] + Q[1]);
        factored.solve_outlined(linearisation, third);
        for (fourth, (first, third)) in fourth.iter_mut().zip(first.iter().zip(&*third)) {
            *fourth = inverse * (*first * p2 + *third * (1.0 / GAMMA));
        }
        drift(fourth, 1.0 - GAMMA);
        factored.solve_outlined(linearisation, fourth);
    }
}

impl Method for Rosenbrock3 {
    fn order(&self) -> u32 {
        3
    }

    fn estimate_order(&self) -> u32 {
        3
    }

    fn begin(&mut self, system: &dyn System, t: f64, x: &[f64], _restart: Restart) {
        system.linearise(t, x, &mut self.linearisation);
        self.driven = system.time_derivative(t, x, &mut self.time_derivative);
        self.effort.jacobians += 1;
    }

    fn attempt(&mut self, system: &dyn System, t: f64, h: f64, x: &[f64], to: &mut Target) -> bool {
        self.effort.factorisations += 1;
        if !self.factored.factor_outlined(&self.linearisation, 1.0 / (h * GAMMA)) {
            return false;
        }
        self.start.copy_from_slice(x);
        self.k[0].copy_from_slice(&self.linearisation.rate);
        with_avx2(
            #[inline(always)]
            || self.stages(system, t, h, x),
        );
        self.effort.derivatives += 1;
        combine(&mut to.x, x, &self.k, |x, k| x + k[0] + k[3]);
        combine(&mut to.error, x, &self.k, |_, k| k.iter().zip(ESTIMATE).map(|(k, weight)| weight * k).sum());
        true
    }

    fn interpolate(&self, theta: f64, x: &mut [f64]) {
        let [one, two, three, four] = interpolant(theta);
        combine(x, &self.start, &self.k, |start, k| start + (one * k[0] + two * k[1] + three * k[2] + four * k[3]));
    }

    fn effort(&self) -> Effort {
        self.effort
    }
}

/// Weights of the increments at the fraction `theta` of a step: all four conditions of order three, the method itself at
/// the end. The derivative at the end of the step is not used, so stiff states stay as damped as in the stages.
fn interpolant(theta: f64) -> [f64; STAGES] {
    // Weights of f, J f, J J f and f'' f f.
    let (square, cube) = (theta * theta, theta * theta * theta);
    let moments = [theta, square / 2.0, cube / 6.0, cube / 3.0];
    INTERPOLANT.map(|row| row.iter().zip(moments).map(|(weight, moment)| weight * moment).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Weights of F_1 and of F_2 by the powers of G, first power first.
    type Weights = ([f64; 4], [f64; 4]);

    const WHOLE: Weights = ([GAMMA, P[0], P[1], P[2]], [0.0, Q[0], Q[1], 0.0]);

    /// The increments themselves.
    const INCREMENTS: [Weights; STAGES] = [
        ([GAMMA, 0.0, 0.0, 0.0], [0.0; 4]),
        ([0.0, P[2], 0.0, 0.0], [Q[1], 0.0, 0.0, 0.0]),
        ([0.0, P[1], P[2], 0.0], [Q[0], Q[1], 0.0, 0.0]),
        ([0.0, P[0], P[1], P[2]], [0.0, Q[0], Q[1], 0.0]),
    ];

    /// Coefficients in the series of an increment of h f, h^2 J f, h^3 J J f, h^3 f''(f, f) / 2, h^4 J f''(f, f) / 2 and
    /// h^4 f'''(f, f, f) / 6, with G^k = 1 + k h gamma J + k (k + 1) / 2 (h gamma J)^2 + ...
    fn series((p, q): Weights) -> [f64; 6] {
        let (g, a) = (GAMMA, NODE);
        let power = |k: usize| k as f64 + 1.0;
        let second = |k: usize| 0.5 * power(k) * (power(k) + 1.0) * g * g;
        let sum = |of: &dyn Fn(usize) -> f64| (0..4).map(of).sum::<f64>();
        [
            sum(&|k| p[k] + q[k]),
            sum(&|k| p[k] * power(k) * g + q[k] * (power(k) * g + a)),
            sum(&|k| p[k] * second(k) + q[k] * (second(k) + power(k) * g * a + a * g)),
            sum(&|k| q[k] * a * a),
            sum(&|k| q[k] * power(k) * g * a * a),
            sum(&|k| q[k] * a.powi(3)),
        ]
    }

    #[test]
    fn the_coefficients_satisfy_every_condition_of_order_three_and_two_of_order_four() {
        let wanted = [1.0, 1.0 / 2.0, 1.0 / 6.0, 1.0 / 3.0, 1.0 / 12.0, 1.0 / 4.0];
        for (found, wanted) in series(WHOLE).into_iter().zip(wanted) {
            assert!((found - wanted).abs() < 1e-14, "{found} for {wanted}");
        }
    }

    #[test]
    fn the_estimate_vanishes_to_order_two_and_for_what_is_infinitely_stiff() {
        let sum = |of: &dyn Fn(Weights) -> f64| INCREMENTS.iter().zip(ESTIMATE).map(|(k, e)| e * of(*k)).sum::<f64>();
        let [first, second, third, bend] = [0, 1, 2, 3].map(|row: usize| sum(&|k| series(k)[row]));
        let stiff = sum(&|(p, q)| -(p[0] + q[0] * (1.0 - NODE / GAMMA)) / GAMMA);
        assert!([first, second, stiff].iter().all(|left: &f64| left.abs() < 1e-14), "{first} {second} {stiff}");
        assert!(third.abs() > 1e-3 && bend.abs() > 1e-2, "{third} {bend}");
    }

    #[test]
    fn the_interpolant_is_of_order_three_everywhere_and_ends_with_the_step() {
        let found = INCREMENTS.map(series);
        for theta in [0.0, 0.1, 0.5, 0.9, 1.0f64] {
            let weights = interpolant(theta);
            let wanted = [theta, theta.powi(2) / 2.0, theta.powi(3) / 6.0, theta.powi(3) / 3.0];
            for (row, wanted) in wanted.into_iter().enumerate() {
                let sum = weights.iter().zip(&found).map(|(weight, series)| weight * series[row]).sum::<f64>();
                assert!((sum - wanted).abs() < 1e-13, "{sum} for {wanted}");
            }
        }
        let end = interpolant(1.0);
        assert!((0..STAGES).all(|i| (end[i] - [1.0, 0.0, 0.0, 1.0][i]).abs() < 1e-13), "{end:?}");
    }

    /// |R(i y)|^2 for an oscillation of `y` rad per step, and the distance of R from the exact exp(i y).
    fn swing(y: f64) -> (f64, f64) {
        type Complex = (f64, f64);
        let times = |a: Complex, b: Complex| (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0);
        let plus = |a: Complex, b: Complex| (a.0 + b.0, a.1 + b.1);
        let (z, size) = ((0.0, y), 1.0 + (GAMMA * y).powi(2));
        let g = (1.0 / size, GAMMA * y / size);
        let ahead = plus((1.0, 0.0), times((NODE, 0.0), times(z, g)));
        let (mut sum, mut power) = ((0.0, 0.0), (1.0, 0.0));
        for (p, q) in WHOLE.0.into_iter().zip(WHOLE.1) {
            power = times(power, g);
            sum = plus(sum, times(power, plus((p, 0.0), times((q, 0.0), ahead))));
        }
        let end = plus((1.0, 0.0), times(z, sum));
        (end.0 * end.0 + end.1 * end.1, (end.0 - y.cos()).hypot(end.1 - y.sin()))
    }

    /// x' = |j| f(x), linearised with the derivative `j`.
    struct Scalar {
        j: f64,
        f: fn(f64) -> f64,
    }

    impl System for Scalar {
        fn dimension(&self) -> usize {
            1
        }
        fn derivative(&self, _t: f64, x: &[f64], dx: &mut [f64]) {
            dx[0] = self.j.abs() * (self.f)(x[0]);
        }
        fn linearise(&self, _t: f64, x: &[f64], at: &mut Linearisation) {
            at.rate[0] = self.j.abs() * (self.f)(x[0]);
            at.dense(0)[0] = self.j;
        }
        fn time_derivative(&self, _t: f64, _x: &[f64], _dfdt: &mut [f64]) -> bool {
            false
        }
        fn admissible(&self, _x: &[f64]) -> bool {
            true
        }
        fn scales(&self) -> &[f64] {
            &[1.0]
        }
    }

    /// One step of size 1 from 1.
    fn step(j: f64, f: fn(f64) -> f64) -> f64 {
        let (scalar, mut method, mut target) = (Scalar { j, f }, Rosenbrock3::new(1), Target::new(1));
        method.begin(&scalar, 0.0, &[1.0], Restart::State);
        assert!(method.attempt(&scalar, 0.0, 1.0, &[1.0], &mut target));
        target.x[0]
    }

    #[test]
    fn it_is_l_stable() {
        for i in 1..100_000 {
            let (size, _) = swing(0.002 * f64::from(i));
            assert!(size <= 1.0 + 1e-14, "{i}: {size}");
        }
        for (fast, left) in [(1e1, 0.2), (1e2, 0.08), (1e4, 1e-3), (1e8, 1e-7)] {
            let end = step(-fast, |x| -x);
            assert!(end.abs() < left, "{fast}: {end}");
        }
    }

    #[test]
    fn a_swing_of_14_hz_is_followed_in_steps_of_10_ms() {
        let (_, off) = swing(14.0 * std::f64::consts::TAU * 0.01);
        assert!(off < 9e-4, "{off}");
    }

    #[test]
    fn friction_by_its_secant_brings_a_mass_to_a_stand() {
        for strong in [1e2, 1e4, 1e6] {
            let end = step(-strong, |x| -x.signum());
            assert!(end.abs() < 20.0 / strong, "{strong}: {end}");
        }
        for strong in [0.1, 0.5, 1.0, 2.0, 3.0, 10.0] {
            assert!(step(-strong, |x| -x.signum()).abs() < 1.0);
        }
    }
}
