//! ROS3P: linearly implicit method of order three in three stages, A-stable, for fixed steps.
//!                                                              theory: docs/theory/integration.md
//!
//! Coefficients: J. Lang, J. Verwer, ROS3P - an accurate third-order Rosenbrock solver designed for parabolic problems,
//! BIT 41 (2001) 731-738, doi 10.1023/A:1021900219772.
//!
//! With W = I/(h gamma) - J:
//!     W k_1 = f(t, x) + h d_1 f_t
//!     W k_2 = f(t + h, x + a k_1) + C_21/h k_1 + h d_2 f_t
//!     W k_3 = f(t + h, x + a k_1) + (C_31 k_1 + C_32 k_2)/h + h d_3 f_t
//! and x_new = x + sum_j m_j k_j. The last two stages share their right-hand side: a step costs two of them, a Jacobian and
//! a factorisation.

use super::{Effort, Linearisation, Method, Point, Target};
use crate::system::System;
use hydrocrane_num::Real;

pub const STAGES: usize = 3;
/// 1/2 + sqrt(3)/6
pub const GAMMA: f64 = 0.788_675_134_594_812_9;
const A: f64 = 1.267_949_192_431_122_8;
const C21: f64 = -1.607_695_154_586_736;
const C31: f64 = -3.464_101_615_137_754_4;
const C32: f64 = -1.732_050_807_568_877_2;
const D: [f64; STAGES] = [GAMMA, -0.211_324_865_405_187_1, -1.077_350_269_189_625_8];
const WEIGHTS: [f64; STAGES] = [2.0, 0.577_350_269_189_625_8, 0.422_649_730_810_374_2];

/// Equations x' = f(t, x), linearised where a step starts.
pub trait Linearised<T> {
    /// Writes f at the end of the step for the state `x`.
    fn rate_at_end(&mut self, x: &[T], rate: &mut [T]);
    /// Replaces `r` by the solution of `(I/(h gamma) - J) k = r`.
    fn solve(&self, r: &mut [T]);
}

/// The increments of a step of size `h` from `x` into `k`, whose first comes as f at the start. Quadratures may follow
/// behind the state in `k`. `argument` is room for a state.
#[inline(always)]
pub fn stages<T: Real>(
    equations: &mut impl Linearised<T>,
    h: T,
    x: &[T],
    time_derivative: Option<&[T]>,
    k: &mut [Vec<T>; STAGES],
    argument: &mut [T],
) {
    let [first, second, third] = k;
    let inverse = T::c(1.0) / h;
    let drift = |k: &mut [T], weight: f64| {
        for (k, slope) in k.iter_mut().zip(time_derivative.unwrap_or(&[])) {
            *k += h * *slope * weight;
        }
    };
    drift(first, D[0]);
    equations.solve(first);
    for (argument, (x, k)) in argument.iter_mut().zip(x.iter().zip(&*first)) {
        *argument = *x + *k * A;
    }
    equations.rate_at_end(argument, second);
    third.copy_from_slice(second);
    for (second, first) in second.iter_mut().zip(&*first) {
        *second += inverse * *first * C21;
    }
    drift(second, D[1]);
    equations.solve(second);
    for (third, (first, second)) in third.iter_mut().zip(first.iter().zip(&*second)) {
        *third += inverse * (*first * C31 + *second * C32);
    }
    drift(third, D[2]);
    equations.solve(third);
}

/// Where the increments lead from `x`, number `i` of them.
#[inline(always)]
pub fn end<T: Real>(x: T, k: &[Vec<T>; STAGES], i: usize) -> T {
    x + k[0][i] * WEIGHTS[0] + k[1][i] * WEIGHTS[1] + k[2][i] * WEIGHTS[2]
}

/// The method for a [`System`]; quadratures lie behind the states.
pub struct Ros3p {
    /// Number of states.
    n: usize,
    linearisation: Linearisation,
    time_derivative: Vec<f64>,
    k: [Vec<f64>; STAGES],
    argument: Vec<f64>,
    /// Start of the last accepted step, whose increments are kept until the next attempt.
    start: Vec<f64>,
    effort: Effort,
}

impl Ros3p {
    pub fn new(n: usize, m: usize) -> Self {
        Ros3p {
            n,
            linearisation: Linearisation::new(n, m).with_secants(),
            time_derivative: vec![0.0; n],
            k: std::array::from_fn(|_| vec![0.0; n + m]),
            argument: vec![0.0; n],
            start: vec![0.0; n + m],
            effort: Effort::default(),
        }
    }
}

/// A system where a step of size `h` starts.
struct Start<'a> {
    system: &'a dyn System,
    linearisation: &'a Linearisation,
    n: usize,
    t: f64,
    h: f64,
}

impl Linearised<f64> for Start<'_> {
    fn rate_at_end(&mut self, x: &[f64], rate: &mut [f64]) {
        let (dx, dw) = rate.split_at_mut(self.n);
        self.system.derivative(self.t + self.h, x, dx, dw);
    }

    /// A quadrature's row needs no solve: nothing depends on it.
    fn solve(&self, r: &mut [f64]) {
        let (k, kappa) = r.split_at_mut(self.n);
        self.linearisation.solve(k);
        self.linearisation.add_quadrature_slopes(k, kappa);
        kappa.iter_mut().for_each(|value| *value *= self.h * GAMMA);
    }
}

impl Method for Ros3p {
    fn order(&self) -> u32 {
        3
    }

    fn fixed_steps(&self) -> bool {
        true
    }

    fn begin(&mut self, system: &dyn System, t: f64, x: &[f64]) {
        system.linearise(t, x, &mut self.linearisation);
        system.time_derivative(t, x, &mut self.time_derivative);
        self.effort.jacobians += 1;
    }

    fn attempt(&mut self, system: &dyn System, t: f64, h: f64, from: Point, to: &mut Target) -> bool {
        self.effort.factorisations += 1;
        if !self.linearisation.factor(1.0 / (h * GAMMA)) {
            return false;
        }
        let Ros3p { n, linearisation, time_derivative, k, argument, .. } = self;
        let (k_of_states, k_of_quadratures) = k[0].split_at_mut(*n);
        k_of_states.copy_from_slice(&linearisation.rate);
        k_of_quadratures.copy_from_slice(&linearisation.quadrature_rate);
        let mut start = Start { system, linearisation, n: *n, t, h };
        stages(&mut start, h, from.x, Some(time_derivative), k, argument);
        self.effort.derivatives += 1;
        to.x.iter_mut().zip(from.x).enumerate().for_each(|(i, (to, from))| *to = end(*from, k, i));
        to.w.iter_mut().zip(from.w).enumerate().for_each(|(i, (to, from))| *to = end(*from, k, *n + i));
        true
    }

    fn accept(&mut self, from: Point, _to: Point) {
        self.start[..self.n].copy_from_slice(from.x);
        self.start[self.n..].copy_from_slice(from.w);
    }

    fn interpolate(&self, theta: f64, x: &mut [f64], w: &mut [f64]) {
        let weights = interpolant(theta);
        for (i, out) in x.iter_mut().chain(w).enumerate() {
            *out = self.start[i] + (0..STAGES).map(|j| weights[j] * self.k[j][i]).sum::<f64>();
        }
    }

    fn effort(&self) -> Effort {
        self.effort
    }
}

/// Weights of the increments at the fraction `theta` of a step: three of the four conditions of order three, the method
/// itself at the end. No slope at the end of the step enters, so that stiff states stay as damped as in the stages.
fn interpolant(theta: f64) -> [f64; STAGES] {
    // sum b = theta,   sum b_i (alpha_i + gamma_i) = theta^2/2,   sum b_i alpha_i^2 = theta^3/3
    let third = (GAMMA * theta - 0.5 * theta * theta) / (GAMMA - 1.0 - D[2]);
    let outer = theta.powi(3) / 3.0;
    let b = [theta - outer, outer - third, third];
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
        assert!((0..3).all(|i| (a[i] - [0.0, 1.0, 1.0][i]).abs() < 1e-14));
        assert!((0..3).all(|i| (sums(gamma)[i] - D[i]).abs() < 1e-14), "{:?}", sums(gamma));
    }
}
