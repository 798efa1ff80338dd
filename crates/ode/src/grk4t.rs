//! GRK4T: linearly implicit method of order 4(3) in four stages for equations that do not depend on time.
//!                                                              theory: docs/theory/integration.md
//!
//! Coefficients: P. Kaps, P. Rentrop, Generalized Runge-Kutta methods of order four with stepsize control for stiff ordinary
//! differential equations, Numer. Math. 33 (1979) 55-68, doi 10.1007/BF01396495; here for increments, gamma = 0.231.
//!
//! With W = I/(h gamma) - J:
//!     W k_1 = f(x)
//!     W k_2 = f(x + a_21 k_1) + C_21/h k_1
//!     W k_3 = f(x + a_31 k_1 + a_32 k_2) + (C_31 k_1 + C_32 k_2)/h
//!     W k_4 = f(x + a_31 k_1 + a_32 k_2) + (C_41 k_1 + C_42 k_2 + C_43 k_3)/h
//! and x_new = x + sum_j m_j k_j, error sum_j e_j k_j. The last two stages share their right-hand side: a step costs three
//! of them, one with the Jacobian, and a factorisation.

use crate::tableau::Tableau;
use hydrocrane_num::Real;

pub const STAGES: usize = 4;
pub const GAMMA: f64 = TABLEAU.gamma;

/// The last two stages share their argument.
pub(crate) const TABLEAU: Tableau<STAGES> = Tableau {
    gamma: 0.231,
    a: [&[], &[2.0], &ROW, &ROW],
    c: [
        &[],
        &[-5.071_675_338_77],
        &[6.020_152_728_65, 0.159_750_684_673],
        &[-1.856_343_618_686, -8.505_380_858_19, -2.084_075_136_02],
    ],
    weights: [3.957_503_746_63, 4.624_892_388_36, 0.617_477_263_873, 1.282_612_945_268],
    error: [-2.302_155_402_92, -3.073_634_485_39, 0.873_280_801_802, 1.282_612_945_268],
};
const ROW: [f64; 2] = [4.524_708_207_36, 4.163_528_788_6];

/// Equations x' = f(x), linearised at the start of a step.
pub trait Linearised<T> {
    /// Writes f for the state `x`.
    fn rate(&mut self, x: &[T], rate: &mut [T]);
    /// Replaces `r` by the solution of `(I/(h gamma) - J) k = r`.
    fn solve(&self, r: &mut [T]);
}

/// Writes the increments of a step of size `h` from `x` into `k`; on entry `k[0]` is f at the start. `argument` is work space
/// for a state.
#[inline(always)]
pub fn stages<T: Real>(
    equations: &mut impl Linearised<T>,
    h: T,
    x: &[T],
    k: &mut [Vec<T>; STAGES],
    argument: &mut [T],
) {
    let [first, second, third, fourth] = k;
    let Tableau { a, c, .. } = TABLEAU;
    let inverse = T::c(1.0) / h;
    equations.solve(first);
    for (i, argument) in argument.iter_mut().enumerate() {
        *argument = x[i] + first[i] * a[1][0];
    }
    equations.rate(argument, second);
    for (second, first) in second.iter_mut().zip(&*first) {
        *second += inverse * *first * c[1][0];
    }
    equations.solve(second);
    for (i, argument) in argument.iter_mut().enumerate() {
        *argument = x[i] + first[i] * a[2][0] + second[i] * a[2][1];
    }
    equations.rate(argument, third);
    fourth.copy_from_slice(third);
    for (i, third) in third.iter_mut().enumerate() {
        *third += inverse * (first[i] * c[2][0] + second[i] * c[2][1]);
    }
    equations.solve(third);
    for (i, fourth) in fourth.iter_mut().enumerate() {
        *fourth += inverse * (first[i] * c[3][0] + second[i] * c[3][1] + third[i] * c[3][2]);
    }
    equations.solve(fourth);
}

/// Component `i` of the new state, from `x` and the increments.
#[inline(always)]
pub fn end<T: Real>(x: T, k: &[Vec<T>; STAGES], i: usize) -> T {
    x + weighted(k, i, TABLEAU.weights)
}

/// Estimate of the error of component `i`.
#[inline(always)]
pub fn error<T: Real>(k: &[Vec<T>; STAGES], i: usize) -> T {
    weighted(k, i, TABLEAU.error)
}

#[inline(always)]
fn weighted<T: Real>(k: &[Vec<T>; STAGES], i: usize, weights: [f64; STAGES]) -> T {
    k[0][i] * weights[0] + k[1][i] * weights[1] + k[2][i] * weights[2] + k[3][i] * weights[3]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Published to twelve digits.
    const PUBLISHED: f64 = 5e-12;

    #[test]
    fn the_coefficients_satisfy_every_condition_of_order_four_and_the_embedded_ones_of_order_three() {
        let (three, four) = TABLEAU.missed(TABLEAU.weights);
        assert!(three.iter().chain(&four).all(|miss| miss.abs() < PUBLISHED), "{three:?} {four:?}");
        let (three, four) = TABLEAU.missed(std::array::from_fn(|i| TABLEAU.weights[i] - TABLEAU.error[i]));
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
