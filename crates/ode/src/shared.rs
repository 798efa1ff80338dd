//! States that all axes share, such as the pressure of the supply: a second border around the block arrow.
//!
//! The states at the end of the state vector are shared. The first of them acts on the pressures of every axis; the others act
//! on shared states only. Every shared state may depend on the local states of all axes:
//! ```text
//! p1', p2'   of axis c also by the first shared state
//! y'         by y and, axis by axis, by q_c, q_c', p1, p2, xs, z
//! ```
//! With A the arrow, B and C the couplings and D the block of the shared states, [A, -B; -C, sI - D] (k, y) = (r, s) is solved
//! by the Schur complement of A: W = A^-1 B once, then y = (sI - D - C W)^-1 (s + C A^-1 r) and k = A^-1 r + W y.

use crate::axis::{AxisDerivatives, Row, ScalarOver, MAX_BORDER};
use hydrocrane_num::{small, Field, Real};

/// Largest number of shared states.
pub const MAX_SHARED: usize = 2;

/// Which states are shared: the last `count` from `first` on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SharedStates {
    pub first: usize,
    pub count: usize,
}

/// Derivatives that belong to shared states.
#[derive(Debug, Clone, Copy)]
pub struct SharedDerivatives<T> {
    pub at: SharedStates,
    /// Of p1' and p2' of each axis by the first shared state.
    pub on_axes: [[T; 2]; MAX_BORDER],
    /// Of the rates of the shared states by the local states of each axis.
    pub by_axes: [[Row<T>; MAX_BORDER]; MAX_SHARED],
    /// Of the rates of the shared states by each other.
    pub own: [[T; MAX_SHARED]; MAX_SHARED],
}

impl<T: Real> SharedDerivatives<T> {
    /// All zero.
    pub fn new(at: SharedStates) -> Self {
        let zero = T::c(0.0);
        SharedDerivatives {
            at,
            on_axes: [[zero; 2]; MAX_BORDER],
            by_axes: [[Row::default(); MAX_BORDER]; MAX_SHARED],
            own: [[zero; MAX_SHARED]; MAX_SHARED],
        }
    }

    pub fn map<U: Real>(&self, f: impl Fn(T) -> U) -> SharedDerivatives<U> {
        SharedDerivatives {
            at: self.at,
            on_axes: self.on_axes.map(|pair| pair.map(&f)),
            by_axes: self.by_axes.map(|rows| rows.map(|row| row.map(&f))),
            own: self.own.map(|row| row.map(&f)),
        }
    }
}

impl<T: Copy> SharedDerivatives<T> {
    /// y += J k: what the shared states add to the rates of axes, and their own rates.
    #[inline(always)]
    pub fn add_product<K: ScalarOver<T>>(&self, axes: &[AxisDerivatives<T>], k: &[K], y: &mut [K]) {
        let SharedStates { first, count } = self.at;
        for (c, on_axis) in self.on_axes[..axes.len()].iter().enumerate() {
            let at = &axes[c].at;
            y[at.p1] += k[first] * on_axis[0];
            y[at.p2] += k[first] * on_axis[1];
        }
        for i in 0..count {
            y[first + i] += self.by_axes_of(axes, i, k);
            for j in 0..count {
                y[first + i] += k[first + j] * self.own[i][j];
            }
        }
    }

    /// The rate of shared state `i` along a change `k` of the axes' states.
    #[inline(always)]
    fn by_axes_of<K: ScalarOver<T>>(&self, axes: &[AxisDerivatives<T>], i: usize, k: &[K]) -> K {
        let n = axes.len();
        let mut sum = K::c(0.0);
        for c in 0..n {
            sum += self.by_axes[i][c].directional(&Row::local(n, c, &axes[c].at, k));
        }
        sum
    }

    /// Their rows and columns of the dense matrix, `n x n`.
    pub fn write_dense(&self, axes: &[AxisDerivatives<T>], n: usize, dense: &mut [T]) {
        let SharedStates { first, count } = self.at;
        for c in 0..axes.len() {
            let at = &axes[c].at;
            dense[at.p1 * n + first] = self.on_axes[c][0];
            dense[at.p2 * n + first] = self.on_axes[c][1];
        }
        for i in 0..count {
            let row = &mut dense[(first + i) * n..][..n];
            for c in 0..axes.len() {
                self.by_axes[i][c].write(axes.len(), c, &axes[c].at, row);
            }
            row[first..first + count].copy_from_slice(&self.own[i][..count]);
        }
    }
}

/// What is known of the shared states once the arrow is factored.
#[derive(Debug, Clone, Default)]
pub struct SharedFactors<T> {
    /// A^-1 B: the answer of all other states to the first shared one.
    answer: Vec<T>,
    /// (sI - D - C W)^-1
    inverse: [[T; MAX_SHARED]; MAX_SHARED],
}

impl<T: Field> SharedFactors<T> {
    /// Factors what is left for `shared`; `solve` replaces a right-hand side by A^-1 of it.
    #[inline(always)]
    pub fn factor<S: Copy>(
        &mut self,
        axes: &[AxisDerivatives<S>],
        shared: &SharedDerivatives<S>,
        shift: T,
        solve: impl FnOnce(&mut [T]),
    ) -> T::Mask
    where
        T: ScalarOver<S>,
    {
        let SharedStates { first, count } = shared.at;
        self.answer.clear();
        self.answer.resize(first, T::c(0.0));
        for (c, on_axis) in shared.on_axes[..axes.len()].iter().enumerate() {
            let at = &axes[c].at;
            // A number of S becomes one of T by its product with one.
            self.answer[at.p1] = T::c(1.0) * on_axis[0];
            self.answer[at.p2] = T::c(1.0) * on_axis[1];
        }
        solve(&mut self.answer);
        let mut matrix = [[T::c(0.0); MAX_SHARED]; MAX_SHARED];
        for i in 0..MAX_SHARED {
            matrix[i][i] = if i < count { shift } else { T::c(1.0) };
            for j in 0..MAX_SHARED {
                matrix[i][j] = matrix[i][j] - shared.own[i][j];
            }
            matrix[i][0] -= shared.by_axes_of(axes, i, &self.answer);
        }
        self.inverse = small::inverse(matrix);
        let mut sound = T::c(0.0).finite();
        for row in &self.inverse {
            for number in row {
                sound = sound & number.finite();
            }
        }
        sound
    }

    /// Completes a right-hand side `r` of which the part of the arrow has been solved.
    #[inline(always)]
    pub fn solve<S: Copy>(&self, axes: &[AxisDerivatives<S>], shared: &SharedDerivatives<S>, r: &mut [T])
    where
        T: ScalarOver<S>,
    {
        let SharedStates { first, count } = shared.at;
        let mut right = [T::c(0.0); MAX_SHARED];
        for i in 0..count {
            right[i] = r[first + i] + shared.by_axes_of(axes, i, r);
        }
        for i in 0..count {
            let mut sum = T::c(0.0);
            for j in 0..count {
                sum += self.inverse[i][j] * right[j];
            }
            r[first + i] = sum;
        }
        let acting = r[first];
        for (r, answer) in r[..first].iter_mut().zip(&self.answer) {
            *r += *answer * acting;
        }
    }
}
