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

use crate::linear::rows::{sum, Cell};
use crate::methods::tableau::{arguments, Tableau};

pub const STAGES: usize = 4;
pub const GAMMA: f64 = TABLEAU.gamma;

pub const TABLEAU: Tableau<STAGES> = Tableau {
    gamma: 0.231,
    a: A,
    arguments: arguments(A),
    c: [
        &[],
        &[-5.071_675_338_77],
        &[6.020_152_728_65, 0.159_750_684_673],
        &[-1.856_343_618_686, -8.505_380_858_19, -2.084_075_136_02],
    ],
    weights: [3.957_503_746_63, 4.624_892_388_36, 0.617_477_263_873, 1.282_612_945_268],
    error: [-2.302_155_402_92, -3.073_634_485_39, 0.873_280_801_802, 1.282_612_945_268],
};
/// The last two stages share their argument.
const A: [&[f64]; STAGES] = [&[], &[2.0], &ROW, &ROW];
const ROW: [f64; 2] = [4.524_708_207_36, 4.163_528_788_6];

/// Cell `i` of the new state, from `x` and the rows of increments.
#[inline(always)]
pub fn end<E: Cell>(x: E, k: &[&[E]; STAGES], i: usize) -> E {
    x.plus(sum(&TABLEAU.weights, k, i))
}

/// Estimate of the error of cell `i`.
#[inline(always)]
pub fn error<E: Cell>(k: &[&[E]; STAGES], i: usize) -> E {
    sum(&TABLEAU.error, k, i)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::rows::all;
    use crate::methods::rosenbrock::{stages, Linearised};
    use crate::methods::tableau::Argument;

    /// Published to twelve digits.
    const PUBLISHED: f64 = 5e-12;

    #[test]
    fn the_last_stage_shares_the_argument_of_the_one_before() {
        assert_eq!(TABLEAU.arguments, [Argument::Start, Argument::Sum, Argument::Sum, Argument::Same]);
    }

    #[test]
    fn the_coefficients_satisfy_every_condition_of_order_four_and_the_embedded_ones_of_order_three() {
        let (three, four) = TABLEAU.missed(TABLEAU.weights);
        assert!(three.iter().chain(&four).all(|miss| miss.abs() < PUBLISHED), "{three:?} {four:?}");
        let (three, four) = TABLEAU.missed(hydrocrane_num::array::from_fn(|i| TABLEAU.weights[i] - TABLEAU.error[i]));
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
        fn rate(&mut self, _stage: usize, x: &[f64], rate: &mut [f64]) {
            rate[0] = self.rate * (x[0] - 1.0);
        }
        fn solve(&self, r: &mut [f64]) {
            r[0] /= 1.0 / (self.h * GAMMA) - self.rate;
        }
    }

    #[test]
    fn a_state_far_too_fast_is_more_than_halved_in_a_step() {
        let mut fast = Decay { rate: -1e9, h: 0.01 };
        let mut k = [0.0; STAGES];
        fast.rate(0, &[3.0], &mut k[..1]);
        stages(&TABLEAU, &mut fast, 1.0 / 0.01, &[3.0], &mut k, &mut [0.0]);
        assert!(((end(3.0, &all(&k, 1), 0) - 1.0) / 2.0 - 0.4536).abs() < 1e-4);
    }
}
