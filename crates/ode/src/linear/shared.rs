//! States that all axes share, such as the pressure of the supply: a second border around the block arrow.
//!
//! The states at the end of the state vector are shared. The first of them, the acting ones, act on the pressures of every axis;
//! the others act on shared states only. Every shared state may depend on the local states of all axes:
//! ```text
//! p1', p2'   of axis c also by the acting shared states
//! y'         by y and, axis by axis, by q_c, q_c', p1, p2, xs, z
//! ```
//! With A the arrow, B and C the couplings and D the block of the shared states, [A, -B; -C, sI - D] (k, y) = (r, s) is solved
//! by the Schur complement of A: W = A^-1 B once, a column for each acting state, then y = (sI - D - C W)^-1 (s + C A^-1 r) and
//! k = A^-1 r + W y.

use crate::linear::axis::{AxisDerivatives, Row, ScalarOver, MAX_ACTING, MAX_BORDER, MAX_SHARED};
use crate::linear::opening::{opening, AxisOpening};
use hydrocrane_num::{linear::small, Field, Real};

/// Number of shared states that most systems have at most.
const FEW: usize = 4;

/// Which states are shared: the last `count` from `first` on, of which the first `acting` act on axes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SharedStates {
    pub first: usize,
    pub count: usize,
    pub acting: usize,
}

/// Derivatives that belong to shared states.
#[derive(Debug, Clone, Copy)]
pub struct SharedDerivatives<T> {
    pub at: SharedStates,
    /// Of p1' and p2' of each axis by each acting state.
    pub on_axes: [[[T; 2]; MAX_BORDER]; MAX_ACTING],
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
            on_axes: [[[zero; 2]; MAX_BORDER]; MAX_ACTING],
            by_axes: [[Row::default(); MAX_BORDER]; MAX_SHARED],
            own: [[zero; MAX_SHARED]; MAX_SHARED],
        }
    }

    pub fn map<U: Real>(&self, f: impl Fn(T) -> U) -> SharedDerivatives<U> {
        SharedDerivatives {
            at: self.at,
            on_axes: self.on_axes.map(|axes| axes.map(|pair| pair.map(&f))),
            by_axes: self.by_axes.map(|rows| rows.map(|row| row.map(&f))),
            own: self.own.map(|row| row.map(&f)),
        }
    }
}

impl<T: Copy> SharedDerivatives<T> {
    /// y += J k: what the shared states add to the rates of axes, and their own rates.
    #[inline(always)]
    pub fn add_product<K: ScalarOver<T>>(&self, axes: &[AxisDerivatives<T>], k: &[K], y: &mut [K]) {
        let SharedStates { first, count, acting } = self.at;
        for j in 0..acting {
            for (axis, on_axis) in axes.iter().zip(&self.on_axes[j]) {
                y[axis.at.p1] += k[first + j] * on_axis[0];
                y[axis.at.p2] += k[first + j] * on_axis[1];
            }
        }
        for i in 0..count {
            y[first + i] += self.by_axes_of(axes, None, i, k);
            for j in 0..count {
                y[first + i] += k[first + j] * self.own[i][j];
            }
        }
    }

    /// The rate of shared state `i` along a change `k` of the axes' states and of their `openings`, if these count.
    #[inline(always)]
    fn by_axes_of<K: ScalarOver<T>>(
        &self,
        axes: &[AxisDerivatives<T>],
        openings: Option<&[AxisOpening<T>]>,
        i: usize,
        k: &[K],
    ) -> K {
        let n = axes.len();
        let mut sum = K::c(0.0);
        for c in 0..n {
            let at = &axes[c].at;
            sum += self.by_axes[i][c].directional(&Row::local(n, c, at, k));
            if let Some((o, own)) = opening(openings, c, at) {
                sum += k[o] * own.on_shared[i];
            }
        }
        sum
    }

    /// Their rows and columns of the dense matrix, `n x n`.
    pub fn write_dense(&self, axes: &[AxisDerivatives<T>], n: usize, dense: &mut [T]) {
        let SharedStates { first, count, acting } = self.at;
        for j in 0..acting {
            for (axis, on_axis) in axes.iter().zip(&self.on_axes[j]) {
                dense[axis.at.p1 * n + first + j] = on_axis[0];
                dense[axis.at.p2 * n + first + j] = on_axis[1];
            }
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
    /// A^-1 B: the answers of all other states to the acting ones.
    answers: [Vec<T>; MAX_ACTING],
    /// (sI - D - C W)^-1
    inverse: [[T; MAX_SHARED]; MAX_SHARED],
}

impl<T: Field> SharedFactors<T> {
    /// Factors what is left for `shared`; `solve` replaces a right-hand side by A^-1 of it.
    #[inline(always)]
    pub fn factor<S: Copy>(
        &mut self,
        axes: &[AxisDerivatives<S>],
        openings: Option<&[AxisOpening<S>]>,
        shared: &SharedDerivatives<S>,
        shift: T,
        solve: impl Fn(&mut [T]),
    ) -> T::Mask
    where
        T: ScalarOver<S>,
    {
        let SharedStates { first, count, acting } = shared.at;
        for j in 0..acting {
            let answer = &mut self.answers[j];
            answer.clear();
            answer.resize(first, T::c(0.0));
            for (axis, on_axis) in axes.iter().zip(&shared.on_axes[j]) {
                // A number of S becomes one of T by its product with one.
                answer[axis.at.p1] = T::c(1.0) * on_axis[0];
                answer[axis.at.p2] = T::c(1.0) * on_axis[1];
            }
            for (c, axis) in axes.iter().enumerate() {
                if let Some((o, own)) = opening(openings, c, &axis.at) {
                    answer[o] = T::c(1.0) * own.by_acting[j];
                }
            }
            solve(answer);
        }
        if count <= FEW {
            self.invert::<S, FEW>(axes, openings, shared, shift)
        } else {
            self.invert::<S, MAX_SHARED>(axes, openings, shared, shift)
        }
    }

    /// The inverse of the Schur complement, with ones on the diagonal beyond the shared states up to `M`.
    #[inline(always)]
    fn invert<S: Copy, const M: usize>(
        &mut self,
        axes: &[AxisDerivatives<S>],
        openings: Option<&[AxisOpening<S>]>,
        shared: &SharedDerivatives<S>,
        shift: T,
    ) -> T::Mask
    where
        T: ScalarOver<S>,
    {
        let SharedStates { count, acting, .. } = shared.at;
        let mut matrix = [[T::c(0.0); M]; M];
        for i in 0..M {
            matrix[i][i] = if i < count { shift } else { T::c(1.0) };
            for j in 0..M {
                matrix[i][j] = matrix[i][j] - shared.own[i][j];
            }
            for j in 0..acting {
                matrix[i][j] -= shared.by_axes_of(axes, openings, i, &self.answers[j]);
            }
        }
        let inverse = small::inverse(matrix);
        let mut sound = T::c(0.0).finite();
        for (own, row) in self.inverse.iter_mut().zip(inverse) {
            for (own, number) in own.iter_mut().zip(row) {
                sound = sound & number.finite();
                *own = number;
            }
        }
        sound
    }

    /// Completes a right-hand side `r` of which the part of the arrow has been solved.
    #[inline(always)]
    pub fn solve<S: Copy>(
        &self,
        axes: &[AxisDerivatives<S>],
        openings: Option<&[AxisOpening<S>]>,
        shared: &SharedDerivatives<S>,
        r: &mut [T],
    ) where
        T: ScalarOver<S>,
    {
        let SharedStates { first, count, acting } = shared.at;
        let mut right = [T::c(0.0); MAX_SHARED];
        for i in 0..count {
            right[i] = r[first + i] + shared.by_axes_of(axes, openings, i, r);
        }
        for i in 0..count {
            let mut sum = T::c(0.0);
            for j in 0..count {
                sum += self.inverse[i][j] * right[j];
            }
            r[first + i] = sum;
        }
        let (others, own) = r.split_at_mut(first);
        for (answer, acting) in self.answers.iter().zip(&own[..acting]) {
            for (r, answer) in others.iter_mut().zip(answer) {
                *r += *answer * *acting;
            }
        }
    }
}
