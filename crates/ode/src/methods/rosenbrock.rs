//! The step of a Rosenbrock method, given by its [`Tableau`].   theory: docs/theory/integration.md
//!
//! Rows hold the states of one system in blocks, or those of several systems side by side, one state per [`Cell`].

use crate::linear::rows::{add_sum, set_sum, split, Cell};
use crate::methods::tableau::{Argument, Tableau};

/// Equations x' = f(t, x), linearised at the start of a step.
pub trait Linearised<E> {
    /// Writes f for the `argument` of a stage.
    fn rate(&mut self, stage: usize, argument: &[E], rate: &mut [E]);
    /// Adds h d_i df/dt to the right-hand side of a stage, where f depends on time.
    #[inline(always)]
    fn drift(&self, _stage: usize, _k: &mut [E]) {}
    /// Replaces `r` by the solution of `(I/(h gamma) - J) k = r`.
    fn solve(&self, r: &mut [E]);
}

/// Writes the increments of a step from `x` into the rows of `k`; on entry its first row is f at the start. `inverse`: 1/h.
/// `argument` is work space for a state; in the end it is the argument of the last stage.
#[inline(always)]
pub fn stages<E: Cell, const S: usize>(
    tableau: &Tableau<S>,
    equations: &mut impl Linearised<E>,
    inverse: E::Factor,
    x: &[E],
    k: &mut [E],
    argument: &mut [E],
) {
    // Each stage knows the number of its terms, so that sums are taken in one pass.
    macro_rules! in_turn {
        ($($i:literal)*) => {
            $(if $i < S {
                stage::<E, S, $i>(tableau, equations, inverse, x, k, argument);
            })*
        };
    }
    const { assert!(S <= 8) };
    in_turn!(0 1 2 3 4 5 6 7);
}

#[inline(always)]
fn stage<E: Cell, const S: usize, const I: usize>(
    tableau: &Tableau<S>,
    equations: &mut impl Linearised<E>,
    inverse: E::Factor,
    x: &[E],
    k: &mut [E],
    argument: &mut [E],
) {
    let (done, rest) = split::<E, I>(k, x.len());
    let (own, rest) = rest.split_at_mut(x.len());
    match tableau.arguments[I] {
        Argument::Start | Argument::Same => {}
        Argument::Sum => {
            set_sum(argument, x, tableau.a[I], done);
            equations.rate(I, argument, own);
        }
        Argument::Continued => {
            argument.iter_mut().zip(done[I - 1]).for_each(|(argument, k)| *argument = argument.plus(*k));
            equations.rate(I, argument, own);
        }
    }
    if I + 1 < S && matches!(tableau.arguments[I + 1], Argument::Same) {
        rest[..x.len()].copy_from_slice(own);
    }
    add_sum(own, inverse, tableau.c[I], done);
    equations.drift(I, own);
    equations.solve(own);
}
