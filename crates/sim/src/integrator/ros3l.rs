//! ROS3L: linearly implicit method of order three in three stages, L-stable, for fixed steps.
//!                                                              theory: docs/theory/integration.md
//!
//! With W = I/(h gamma) - J:
//!     W k_1 = f(t, x) + h d_1 f_t
//!     W k_2 = f(t + alpha h, x + 2 k_1) + C_21/h k_1 + h d_2 f_t
//!     W k_3 = f(t + alpha h, x + 2 k_1) + (C_31 k_1 + C_32 k_2)/h + h d_3 f_t
//! and x_new = x + sum_j m_j k_j. The last two stages share their right-hand side: a step costs two of them, a Jacobian and
//! a factorisation. Of this family (A. Sandu et al., Benchmarking stiff ODE solvers for atmospheric chemistry problems II:
//! Rosenbrock solvers, Atmos. Environ. 31 (1997) 3459-3472, doi 10.1016/S1352-2310(97)83212-8, whose ROS3 has
//! alpha = gamma) the conditions of order three and L-stability leave alpha free, which is twice gamma: then a mass that
//! constant friction would turn round within the step comes to a stand.

use super::rows::wide;
use super::{Effort, Linearisation, Method, Point, Target};
use crate::system::System;

const STAGES: usize = 3;
/// The root of gamma^3 - 3 gamma^2 + 3/2 gamma - 1/6 between 1/3 and 1/2.
const GAMMA: f64 = 0.435_866_521_508_459;
/// Where the last two stages are, as a share of the step.
const NODE: f64 = 2.0 * GAMMA;
const A: f64 = 2.0;
const C21: f64 = 0.675_161_651_004_046;
const C31: f64 = -5.852_283_092_120_213;
const C32: f64 = -1.901_285_526_477_801;
const D: [f64; STAGES] = [GAMMA, 0.564_133_478_491_541, -1.143_449_221_516_972];
const WEIGHTS: [f64; STAGES] = [2.423_364_536_605_055, 0.920_178_917_478_537_4, 0.503_185_619_126_517_3];

/// Number by number what `of` says of a start and its increments, of which `out` takes those from `first` on.
#[inline(always)]
fn join(out: &mut [f64], from: &[f64], k: &[Vec<f64>; STAGES], first: usize, of: impl Fn(f64, [f64; STAGES]) -> f64) {
    let [one, two, three] = k;
    let increments = one[first..].iter().zip(&two[first..]).zip(&three[first..]);
    for ((out, from), ((one, two), three)) in out.iter_mut().zip(from).zip(increments) {
        *out = of(*from, [*one, *two, *three]);
    }
}

/// The method for a [`System`]; quadratures lie behind the states.
pub struct Ros3l {
    /// Number of states.
    n: usize,
    linearisation: Linearisation,
    /// df/dt, and whether any of it is not zero.
    time_derivative: Vec<f64>,
    driven: bool,
    k: [Vec<f64>; STAGES],
    argument: Vec<f64>,
    /// Start of the last attempt.
    start: Vec<f64>,
    effort: Effort,
}

impl Ros3l {
    pub fn new(n: usize, m: usize) -> Self {
        Ros3l {
            n,
            linearisation: Linearisation::new(n, m).with_secants(),
            time_derivative: vec![0.0; n],
            driven: false,
            k: std::array::from_fn(|_| vec![0.0; n + m]),
            argument: vec![0.0; n],
            start: vec![0.0; n + m],
            effort: Effort::default(),
        }
    }

    /// The increments of a step of size `h` from `x` into `k`, whose first comes as f at the start.
    #[inline(always)]
    fn stages(&mut self, system: &dyn System, t: f64, h: f64, x: &[f64]) {
        let Ros3l { n, linearisation, time_derivative, driven, k: [first, second, third], argument, .. } = self;
        let inverse = 1.0 / h;
        let drift = |k: &mut [f64], weight: f64| {
            for (k, slope) in k.iter_mut().zip(if *driven { &time_derivative[..] } else { &[] }) {
                *k += h * *slope * weight;
            }
        };
        drift(first, D[0]);
        solve(linearisation, h, *n, first);
        for (argument, (x, k)) in argument.iter_mut().zip(x.iter().zip(&*first)) {
            *argument = *x + *k * A;
        }
        let (dx, dw) = second.split_at_mut(*n);
        system.derivative(t + NODE * h, argument, dx, dw);
        third.copy_from_slice(second);
        for (second, first) in second.iter_mut().zip(&*first) {
            *second += inverse * *first * C21;
        }
        drift(second, D[1]);
        solve(linearisation, h, *n, second);
        for (third, (first, second)) in third.iter_mut().zip(first.iter().zip(&*second)) {
            *third += inverse * (*first * C31 + *second * C32);
        }
        drift(third, D[2]);
        solve(linearisation, h, *n, third);
    }
}

/// Replaces `r` by the solution of `(I/(h gamma) - J) k = r` with the quadratures behind the `n` states, whose rows need no
/// solve: nothing depends on them.
#[inline(always)]
fn solve(linearisation: &Linearisation, h: f64, n: usize, r: &mut [f64]) {
    let (k, kappa) = r.split_at_mut(n);
    linearisation.solve(k);
    linearisation.add_quadrature_slopes(k, kappa);
    kappa.iter_mut().for_each(|value| *value *= h * GAMMA);
}

impl Method for Ros3l {
    fn order(&self) -> u32 {
        3
    }

    fn fixed_steps(&self) -> bool {
        true
    }

    fn begin(&mut self, system: &dyn System, t: f64, x: &[f64]) {
        system.linearise(t, x, &mut self.linearisation);
        self.driven = system.time_derivative(t, x, &mut self.time_derivative);
        self.effort.jacobians += 1;
    }

    fn attempt(&mut self, system: &dyn System, t: f64, h: f64, from: Point, to: &mut Target) -> bool {
        self.effort.factorisations += 1;
        if !self.linearisation.factor(1.0 / (h * GAMMA)) {
            return false;
        }
        self.start[..self.n].copy_from_slice(from.x);
        self.start[self.n..].copy_from_slice(from.w);
        let (k_of_states, k_of_quadratures) = self.k[0].split_at_mut(self.n);
        k_of_states.copy_from_slice(&self.linearisation.rate);
        k_of_quadratures.copy_from_slice(&self.linearisation.quadrature_rate);
        wide(
            #[inline(always)]
            || self.stages(system, t, h, from.x),
        );
        self.effort.derivatives += 1;
        let end = |x: f64, k: [f64; STAGES]| x + k[0] * WEIGHTS[0] + k[1] * WEIGHTS[1] + k[2] * WEIGHTS[2];
        join(&mut to.x, from.x, &self.k, 0, end);
        join(&mut to.w, from.w, &self.k, self.n, end);
        true
    }

    fn interpolate(&self, theta: f64, x: &mut [f64], w: &mut [f64]) {
        let [one, two, three] = interpolant(theta);
        let there = |start: f64, k: [f64; STAGES]| start + (one * k[0] + two * k[1] + three * k[2]);
        join(x, &self.start[..self.n], &self.k, 0, there);
        join(w, &self.start[self.n..], &self.k, self.n, there);
    }

    fn effort(&self) -> Effort {
        self.effort
    }
}

/// Weights of the increments at the fraction `theta` of a step: three of the four conditions of order three, the method
/// itself at the end. No slope at the end of the step enters, so that stiff states stay as damped as in the stages.
fn interpolant(theta: f64) -> [f64; STAGES] {
    // sum b = theta,   sum b_i (alpha_i + gamma_i) = theta^2/2,   sum b_i alpha_i^2 = theta^3/3
    let ahead = theta.powi(3) / (3.0 * NODE * NODE);
    let first = theta - ahead;
    let third = (0.5 * theta * theta - GAMMA * first - (NODE + D[1]) * ahead) / (D[2] - D[1]);
    let b = [first, ahead - third, third];
    // b times the inverse of the matrix gamma, which is I/gamma - C.
    [b[0] / GAMMA - C21 * b[1] - C31 * b[2], b[1] / GAMMA - C32 * b[2], b[2] / GAMMA]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The method in the form of its order conditions, k_i = h f(x + sum alpha_ij k_j) + h J sum gamma_ij k_j: the
    /// matrices alpha and gamma and the weights b, from those of the increments u = gamma k.
    fn untransformed() -> ([[f64; 3]; 3], [[f64; 3]; 3], [f64; 3]) {
        // I/gamma - C is the inverse of the matrix gamma, both lower triangular.
        let (g, mut gamma) = (GAMMA, [[0.0; 3]; 3]);
        let c = [[0.0; 3], [C21, 0.0, 0.0], [C31, C32, 0.0]];
        for column in 0..3 {
            for row in column..3 {
                let unit = f64::from(u8::from(row == column));
                gamma[row][column] = g * (unit + (column..row).map(|j| c[row][j] * gamma[j][column]).sum::<f64>());
            }
        }
        let times = |left: [f64; 3]| std::array::from_fn(|j| (0..3).map(|i| left[i] * gamma[i][j]).sum::<f64>());
        let alpha = [[0.0; 3], times([A, 0.0, 0.0]), times([A, 0.0, 0.0])];
        (alpha, gamma, times(WEIGHTS))
    }

    #[test]
    fn the_coefficients_satisfy_every_condition_of_order_three() {
        let (alpha, gamma, b) = untransformed();
        let sums = |m: [[f64; 3]; 3]| m.map(|row| row.iter().sum::<f64>());
        let both = std::array::from_fn(|i| std::array::from_fn(|j| alpha[i][j] + gamma[i][j]));
        let (a, beta): ([f64; 3], [f64; 3]) = (sums(alpha), sums(both));
        let inner: [f64; 3] = std::array::from_fn(|i| (0..3).map(|j| both[i][j] * beta[j]).sum());
        let sum = |f: &dyn Fn(usize) -> f64| (0..3).map(|i| b[i] * f(i)).sum::<f64>();
        for (found, wanted) in [
            (sum(&|_| 1.0), 1.0),
            (sum(&|i| beta[i]), 1.0 / 2.0),
            (sum(&|i| a[i] * a[i]), 1.0 / 3.0),
            (sum(&|i| inner[i]), 1.0 / 6.0),
        ] {
            assert!((found - wanted).abs() < 1e-14, "{found} for {wanted}");
        }
        let whole = interpolant(1.0);
        assert!((0..3).all(|i| (whole[i] - WEIGHTS[i]).abs() < 1e-14), "{whole:?}");
        // Nodes and time weights are the row sums.
        assert!((0..3).all(|i| (a[i] - [0.0, NODE, NODE][i]).abs() < 1e-14));
        assert!((0..3).all(|i| (sums(gamma)[i] - D[i]).abs() < 1e-14), "{:?}", sums(gamma));
    }

    /// x' = |j| f(x), linearised with the slope `j`.
    struct Scalar {
        j: f64,
        f: fn(f64) -> f64,
    }

    impl System for Scalar {
        fn dimension(&self) -> usize {
            1
        }
        fn quadratures(&self) -> usize {
            0
        }
        fn derivative(&self, _t: f64, x: &[f64], dx: &mut [f64], _dw: &mut [f64]) {
            dx[0] = self.j.abs() * (self.f)(x[0]);
        }
        fn linearise(&self, _t: f64, x: &[f64], at: &mut Linearisation) {
            at.rate[0] = self.j.abs() * (self.f)(x[0]);
            at.dense(0).0[0] = self.j;
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
        let (scalar, mut method, mut target) = (Scalar { j, f }, Ros3l::new(1, 0), Target::new(1, 0));
        method.begin(&scalar, 0.0, &[1.0]);
        assert!(method.attempt(&scalar, 0.0, 1.0, Point { x: &[1.0], w: &[] }, &mut target));
        target.x[0]
    }

    #[test]
    fn it_is_l_stable() {
        // On the imaginary axis |R| <= 1 where gamma^3 - 3 gamma^2 + 3/2 gamma - 1/6 = 0 lies between these bounds
        // (Hairer, Wanner: Solving Ordinary Differential Equations II, table IV.6.4).
        assert!(GAMMA.powi(3) - 3.0 * GAMMA * GAMMA + 1.5 * GAMMA - 1.0 / 6.0 < 1e-15);
        assert!((0.223_647_8..0.572_816_06).contains(&GAMMA));
        for (fast, left) in [(1e1, 0.2), (1e2, 0.05), (1e4, 1e-3), (1e8, 1e-7)] {
            let end = step(-fast, |x| -x);
            assert!(end.abs() < left, "{fast}: {end}");
        }
    }

    #[test]
    fn friction_by_its_secant_brings_a_mass_to_a_stand() {
        for strong in [1e2, 1e4, 1e6] {
            let end = step(-strong, |x| -x.signum());
            assert!(end.abs() < 4.0 / strong, "{strong}: {end}");
        }
        for strong in [0.1, 0.5, 1.0, 2.0, 3.0, 10.0] {
            assert!(step(-strong, |x| -x.signum()).abs() < 1.0);
        }
    }
}
