//! GRK4T: linearly implicit method of order 4(3) in four stages for equations that do not depend on time.
//!                                                              theory: docs/theory/integration.md
//!
//! Coefficients: P. Kaps, P. Rentrop, Generalized Runge-Kutta methods of order four with stepsize control for stiff ordinary
//! differential equations, Numer. Math. 33 (1979) 55-68, doi 10.1007/BF01396495; here of the increments, gamma = 0.231.
//!
//! With W = I/(h gamma) - J:
//!     W k_1 = f(x)
//!     W k_2 = f(x + a_21 k_1) + C_21/h k_1
//!     W k_3 = f(x + a_31 k_1 + a_32 k_2) + (C_31 k_1 + C_32 k_2)/h
//!     W k_4 = f(x + a_31 k_1 + a_32 k_2) + (C_41 k_1 + C_42 k_2 + C_43 k_3)/h
//! and x_new = x + sum_j m_j k_j, error sum_j e_j k_j. The last two stages share their right-hand side: a step costs three
//! of them, one with the Jacobian, and a factorisation.

use hydrocrane_num::Real;

pub const STAGES: usize = 4;
pub const GAMMA: f64 = 0.231;
const A: [[f64; 2]; 2] = [[2.0, 0.0], [4.524_708_207_36, 4.163_528_788_6]];
const C: [[f64; 3]; 3] = [
    [-5.071_675_338_77, 0.0, 0.0],
    [6.020_152_728_65, 0.159_750_684_673, 0.0],
    [-1.856_343_618_686, -8.505_380_858_19, -2.084_075_136_02],
];
const WEIGHTS: [f64; STAGES] = [3.957_503_746_63, 4.624_892_388_36, 0.617_477_263_873, 1.282_612_945_268];
const ERROR: [f64; STAGES] = [-2.302_155_402_92, -3.073_634_485_39, 0.873_280_801_802, 1.282_612_945_268];

/// Equations x' = f(x), linearised where a step starts.
pub trait Linearised<T> {
    /// Writes f for the state `x`.
    fn rate(&mut self, x: &[T], rate: &mut [T]);
    /// Replaces `r` by the solution of `(I/(h gamma) - J) k = r`.
    fn solve(&self, r: &mut [T]);
}

/// The increments of a step of size `h` from `x` into `k`, whose first comes as f at the start. `argument` is room for a
/// state.
#[inline(always)]
pub fn stages<T: Real>(
    equations: &mut impl Linearised<T>,
    h: T,
    x: &[T],
    k: &mut [Vec<T>; STAGES],
    argument: &mut [T],
) {
    let [first, second, third, fourth] = k;
    let inverse = T::c(1.0) / h;
    equations.solve(first);
    for (i, argument) in argument.iter_mut().enumerate() {
        *argument = x[i] + first[i] * A[0][0];
    }
    equations.rate(argument, second);
    for (second, first) in second.iter_mut().zip(&*first) {
        *second += inverse * *first * C[0][0];
    }
    equations.solve(second);
    for (i, argument) in argument.iter_mut().enumerate() {
        *argument = x[i] + first[i] * A[1][0] + second[i] * A[1][1];
    }
    equations.rate(argument, third);
    fourth.copy_from_slice(third);
    for (i, third) in third.iter_mut().enumerate() {
        *third += inverse * (first[i] * C[1][0] + second[i] * C[1][1]);
    }
    equations.solve(third);
    for (i, fourth) in fourth.iter_mut().enumerate() {
        *fourth += inverse * (first[i] * C[2][0] + second[i] * C[2][1] + third[i] * C[2][2]);
    }
    equations.solve(fourth);
}

/// Where the increments lead from `x`, number `i` of them.
#[inline(always)]
pub fn end<T: Real>(x: T, k: &[Vec<T>; STAGES], i: usize) -> T {
    x + weighted(k, i, WEIGHTS)
}

/// Estimate of the error there.
#[inline(always)]
pub fn error<T: Real>(k: &[Vec<T>; STAGES], i: usize) -> T {
    weighted(k, i, ERROR)
}

#[inline(always)]
fn weighted<T: Real>(k: &[Vec<T>; STAGES], i: usize, weights: [f64; STAGES]) -> T {
    k[0][i] * weights[0] + k[1][i] * weights[1] + k[2][i] * weights[2] + k[3][i] * weights[3]
}

#[cfg(test)]
mod tests {
    use super::*;

    type Square = [[f64; STAGES]; STAGES];

    /// The method in the form of its order conditions, k_i = h f(x + sum alpha_ij k_j) + h J sum gamma_ij k_j: the
    /// matrix alpha, the sum of alpha and gamma, and weights b from those of the increments u = gamma k.
    fn untransformed(weights: [f64; STAGES]) -> (Square, Square, [f64; STAGES]) {
        // I/gamma - C is the inverse of the matrix gamma, both lower triangular.
        let (g, mut gamma) = (GAMMA, [[0.0; STAGES]; STAGES]);
        let c = |row: usize, j: usize| if row == 0 { 0.0 } else { C[row - 1][j] };
        for column in 0..STAGES {
            for row in column..STAGES {
                let unit = f64::from(u8::from(row == column));
                gamma[row][column] = g * (unit + (column..row).map(|j| c(row, j) * gamma[j][column]).sum::<f64>());
            }
        }
        let times = |left: [f64; STAGES]| std::array::from_fn(|j| (0..STAGES).map(|i| left[i] * gamma[i][j]).sum());
        let row = |a: [f64; 2]| times([a[0], a[1], 0.0, 0.0]);
        let alpha: Square = [[0.0; STAGES], row(A[0]), row(A[1]), row(A[1])];
        let both = std::array::from_fn(|i| std::array::from_fn(|j| alpha[i][j] + gamma[i][j]));
        (alpha, both, times(weights))
    }

    fn applied(m: &Square, v: [f64; STAGES]) -> [f64; STAGES] {
        std::array::from_fn(|i| (0..STAGES).map(|j| m[i][j] * v[j]).sum())
    }

    /// By how much the weights `m` of the increments miss the conditions of order three, and the others of order four.
    fn missed(m: [f64; STAGES]) -> ([f64; 4], [f64; 4]) {
        let (alpha, both, b) = untransformed(m);
        let ones = [1.0; STAGES];
        let (a, beta) = (applied(&alpha, ones), applied(&both, ones));
        let sum = |v: [f64; STAGES]| (0..STAGES).map(|i| b[i] * v[i]).sum::<f64>();
        let each = |f: &dyn Fn(usize) -> f64| -> [f64; STAGES] { std::array::from_fn(f) };
        let (squares, derivatives) = (each(&|i| a[i] * a[i]), applied(&alpha, beta));
        (
            [sum(ones) - 1.0, sum(beta) - 1.0 / 2.0, sum(squares) - 1.0 / 3.0, sum(applied(&both, beta)) - 1.0 / 6.0],
            [
                sum(each(&|i| a[i].powi(3))) - 1.0 / 4.0,
                sum(each(&|i| a[i] * derivatives[i])) - 1.0 / 8.0,
                sum(applied(&both, squares)) - 1.0 / 12.0,
                sum(applied(&both, applied(&both, beta))) - 1.0 / 24.0,
            ],
        )
    }

    /// Published to twelve digits.
    const PUBLISHED: f64 = 5e-12;

    #[test]
    fn the_coefficients_satisfy_every_condition_of_order_four_and_the_embedded_ones_of_order_three() {
        let (three, four) = missed(WEIGHTS);
        assert!(three.iter().chain(&four).all(|miss| miss.abs() < PUBLISHED), "{three:?} {four:?}");
        let (three, four) = missed(std::array::from_fn(|i| WEIGHTS[i] - ERROR[i]));
        assert!(three.iter().all(|miss| miss.abs() < PUBLISHED), "{three:?}");
        // It sees errors of linear equations too.
        assert!(four.iter().all(|miss| miss.abs() > 1e-3), "{four:?}");
    }

    /// x' = rate (x - 1).
    struct Decay {
        rate: f64,
        h: f64,
    }

    impl Linearised<f64> for Decay {
        fn rate(&mut self, x: &[f64], rate: &mut [f64]) {
            rate[0] = self.rate * (x[0] - 1.0);
        }
        fn solve(&self, r: &mut [f64]) {
            r[0] /= 1.0 / (self.h * GAMMA) - self.rate;
        }
    }

    #[test]
    fn a_state_far_too_fast_is_more_than_halved_in_a_step() {
        let mut fast = Decay { rate: -1e9, h: 0.01 };
        let mut k: [Vec<f64>; STAGES] = std::array::from_fn(|_| vec![0.0]);
        fast.rate(&[3.0], &mut k[0]);
        stages(&mut fast, 0.01, &[3.0], &mut k, &mut [0.0]);
        assert!(((end(3.0, &k, 0) - 1.0) / 2.0 - 0.4536).abs() < 1e-4);
    }
}
