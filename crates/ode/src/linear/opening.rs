//! A state of an axis beside spool and pressures: the opening of what throttles its supply, such as a pressure compensator that moves.
//!
//! With o the opening of axis c and y the acting shared states:
//! ```text
//! p1', p2'   also by o
//! o'         by q_c, q_c', p1, p2, xs, o, y
//! ```
//! and every shared state may depend on o. It is eliminated before the pressures: o = (r_o + what else changes o')/(s - do'/do).

use crate::linear::axis::{AxisDerivatives, AxisStates, Row, ScalarOver, MAX_ACTING, MAX_SHARED};
use hydrocrane_num::{Field, Real};

/// Derivatives of and by the opening of one axis.
#[derive(Debug, Clone, Copy, Default)]
pub struct AxisOpening<T> {
    /// Of p1' and p2' by it.
    pub on_pressures: [T; 2],
    /// Of the rates of the shared states by it.
    pub on_shared: [T; MAX_SHARED],
    /// Of its rate by the local state of its axis; bristles do not count.
    pub by_axis: Row<T>,
    /// Of its rate by the acting shared states.
    pub by_acting: [T; MAX_ACTING],
    /// Of its rate by itself.
    pub own: T,
}

/// The opening of axis `c`: its index among the states and its derivatives, if it has one.
#[inline(always)]
pub(crate) fn opening<'a, T>(
    openings: Option<&'a [AxisOpening<T>]>,
    c: usize,
    at: &AxisStates,
) -> Option<(usize, &'a AxisOpening<T>)> {
    Some((at.opening?, &openings?[c]))
}

/// What an axis without its opening lacks, by which it counts as if it had none.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Eliminated<T> {
    /// 1/(s - do'/do), times the derivatives of p1' and p2' by o.
    pub inverse: T,
    pub on_pressures: [T; 2],
}

impl<T: Field> Eliminated<T> {
    #[inline(always)]
    pub fn new<S: Copy>(own: &AxisOpening<S>, shift: T) -> Self
    where
        T: ScalarOver<S>,
    {
        let inverse = T::c(1.0) / (shift - own.own);
        Eliminated { inverse, on_pressures: [inverse * own.on_pressures[0], inverse * own.on_pressures[1]] }
    }
}

impl<T: Copy> AxisOpening<T> {
    pub fn map<U: Real>(&self, f: impl Fn(T) -> U) -> AxisOpening<U> {
        AxisOpening {
            on_pressures: self.on_pressures.map(&f),
            on_shared: self.on_shared.map(&f),
            by_axis: self.by_axis.map(&f),
            by_acting: self.by_acting.map(&f),
            own: f(self.own),
        }
    }

    /// y += J k: what the opening at index `o` of an axis adds to the rates of its pressures and of the shared states, and its own rate,
    /// along a change `k` of the states, of which `local` belongs to the axis. `shared`: index of the first shared state and their number,
    /// and that of the acting ones.
    #[inline(always)]
    pub(crate) fn add_product<K: ScalarOver<T>>(
        &self,
        (o, at): (usize, &AxisStates),
        local: &Row<K>,
        [first, count, acting]: [usize; 3],
        k: &[K],
        y: &mut [K],
    ) {
        y[at.p1] += k[o] * self.on_pressures[0];
        y[at.p2] += k[o] * self.on_pressures[1];
        y[o] += self.by_axis.directional(local) + k[o] * self.own;
        for j in 0..acting {
            y[o] += k[first + j] * self.by_acting[j];
        }
        for i in 0..count {
            y[first + i] += k[o] * self.on_shared[i];
        }
    }

    /// Its row and column of the dense matrix, `n x n`, of axis `c` of all `axes`; `shared` as above.
    pub(crate) fn write_dense(
        &self,
        o: usize,
        c: usize,
        axes: &[AxisDerivatives<T>],
        [first, count, acting]: [usize; 3],
        n: usize,
        dense: &mut [T],
    ) {
        let at = &axes[c].at;
        self.by_axis.write(axes.len(), c, at, &mut dense[o * n..][..n]);
        dense[o * n + o] = self.own;
        dense[o * n + first..][..acting].copy_from_slice(&self.by_acting[..acting]);
        dense[at.p1 * n + o] = self.on_pressures[0];
        dense[at.p2 * n + o] = self.on_pressures[1];
        for i in 0..count {
            dense[(first + i) * n + o] = self.on_shared[i];
        }
    }
}
