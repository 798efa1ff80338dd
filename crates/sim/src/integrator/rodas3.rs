//! Rodas3: stiffly accurate Rosenbrock method of order 3(2), 4 stages, L-stable.    theory: docs/theory/integration.md
//!
//! Coefficients: A. Sandu, J. G. Verwer, J. G. Blom, E. J. Spee, G. R. Carmichael, F. A. Potra, Benchmarking stiff ODE solvers
//! for atmospheric chemistry problems II: Rosenbrock solvers, Atmos. Environ. 31 (1997) 3459-3472,
//! doi 10.1016/S1352-2310(97)83212-8.
//!
//! For x' = f(x), with W = I/(h gamma) - J:
//!     W k_1 = f(x)
//!     W k_2 = f(x) + 4/h k_1
//!     W k_3 = f(x + 2 k_1) + (k_1 - k_2)/h
//!     W k_4 = f(x + 2 k_1 + k_3) + (k_1 - k_2 - 8/3 k_3)/h
//! and x_new = x + 2 k_1 + k_3 + k_4, error k_4. A step costs a Jacobian with its right-hand side, two more right-hand
//! sides and a factorisation.

use super::ros3p::Linearised;
use hydrocrane_num::Real;

pub const STAGES: usize = 4;
pub const GAMMA: f64 = 0.5;

/// The new state from `x` after a step of size `h` into `reached`, and the increments into `k`, whose first comes as f at
/// the start and whose last is the estimate of the error.
#[inline(always)]
pub fn step<T: Real>(
    equations: &mut impl Linearised<T>,
    h: T,
    x: &[T],
    k: &mut [Vec<T>; STAGES],
    reached: &mut [T],
) {
    let [first, second, third, fourth] = k;
    let inverse = T::c(1.0) / h;
    second.copy_from_slice(first);
    equations.solve(first);
    for (second, first) in second.iter_mut().zip(&*first) {
        *second += inverse * *first * 4.0;
    }
    equations.solve(second);
    for (reached, (x, first)) in reached.iter_mut().zip(x.iter().zip(&*first)) {
        *reached = *x + *first * 2.0;
    }
    equations.rate_at_end(reached, third);
    for (third, (first, second)) in third.iter_mut().zip(first.iter().zip(&*second)) {
        *third += inverse * (*first - *second);
    }
    equations.solve(third);
    for (reached, third) in reached.iter_mut().zip(&*third) {
        *reached += *third;
    }
    equations.rate_at_end(reached, fourth);
    for (fourth, ((first, second), third)) in fourth.iter_mut().zip(first.iter().zip(&*second).zip(&*third)) {
        *fourth += inverse * (*first - *second - *third * (8.0 / 3.0));
    }
    equations.solve(fourth);
    for (reached, fourth) in reached.iter_mut().zip(&*fourth) {
        *reached += *fourth;
    }
}
