//! One hydraulic axis among the states: where its own states stand, and the derivatives of its outputs.

use hydrocrane_num::{Field, Pack};
use std::ops::{Add, Mul, Sub};

/// Numbers that can be multiplied with derivatives of type `S`.
pub trait ScalarOver<S>: Field + Add<S, Output = Self> + Sub<S, Output = Self> + Mul<S, Output = Self> {}

impl<S, T: Field + Add<S, Output = T> + Sub<S, Output = T> + Mul<S, Output = T>> ScalarOver<S> for T {}

/// Largest number of coordinates of a border.
pub const MAX_BORDER: usize = if cfg!(feature = "chains") { 6 } else { 3 };
/// Largest number of states that all axes share.
pub const MAX_SHARED: usize = 6;
/// Largest number of those that act on axes.
pub const MAX_ACTING: usize = 3;

/// Indices of an axis's own states in the state vector.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct AxisStates {
    pub p1: usize,
    pub p2: usize,
    pub xs: usize,
    pub vs: usize,
    /// `None` without bristles.
    pub z: Option<usize>,
    /// `None` where nothing that moves throttles the supply: see [`crate::AxisOpening`].
    pub opening: Option<usize>,
}

/// Derivatives of one output of an axis by its local state: its coordinate and rate, and its own states.
#[derive(Debug, Clone, Copy, Default)]
pub struct Row<T> {
    pub q: T,
    pub qd: T,
    pub p1: T,
    pub p2: T,
    pub xs: T,
    pub z: T,
}

/// Derivatives of the outputs of one axis.
#[derive(Debug, Clone, Copy, Default)]
pub struct AxisDerivatives<T> {
    pub at: AxisStates,
    /// Of the rates of pressures and bristles.
    pub p1: Row<T>,
    pub p2: Row<T>,
    pub z: Row<T>,
    /// d(xs', vs')/d(xs, vs)
    pub spool: [[T; 2]; 2],
    /// Of the net force; its derivatives by q and q' are contained in `by_q` and `by_qd`.
    pub force: Row<T>,
    /// Derivatives of all accelerations by the net force.
    pub response: [T; MAX_BORDER],
}

impl<T: Field> Row<T> {
    /// The local state of axis `c` in the state `k`.
    #[inline(always)]
    pub(crate) fn local(joints: usize, c: usize, at: &AxisStates, k: &[T]) -> Self {
        let z = at.z.map_or(T::c(0.0), |z| k[z]);
        Row { q: k[c], qd: k[joints + c], p1: k[at.p1], p2: k[at.p2], xs: k[at.xs], z }
    }
}

impl<T: Copy> Row<T> {
    /// Directional derivative of the output along a change of the local state.
    #[inline(always)]
    pub(crate) fn directional<K: ScalarOver<T>>(&self, local: &Row<K>) -> K {
        let known = local.q * self.q + local.qd * self.qd + local.p1 * self.p1 + local.p2 * self.p2;
        known + local.xs * self.xs + local.z * self.z
    }

    pub(crate) fn write(&self, joints: usize, c: usize, at: &AxisStates, row: &mut [T]) {
        let known = [(c, self.q), (joints + c, self.qd), (at.p1, self.p1), (at.p2, self.p2), (at.xs, self.xs)];
        for (column, derivative) in known.into_iter().chain(at.z.map(|z| (z, self.z))) {
            row[column] = derivative;
        }
    }

    #[inline(always)]
    pub fn map<U>(&self, f: impl Fn(T) -> U) -> Row<U> {
        Row { q: f(self.q), qd: f(self.qd), p1: f(self.p1), p2: f(self.p2), xs: f(self.xs), z: f(self.z) }
    }

    /// Sum of two outputs.
    #[inline(always)]
    pub fn plus(&self, other: &Self) -> Self
    where
        T: Field,
    {
        Row {
            q: self.q + other.q,
            qd: self.qd + other.qd,
            p1: self.p1 + other.p1,
            p2: self.p2 + other.p2,
            xs: self.xs + other.xs,
            z: self.z + other.z,
        }
    }

    /// The row of one lane of `T`.
    #[inline(always)]
    pub fn lane<U>(&self, i: usize) -> Row<U>
    where
        T: Pack<U>,
    {
        self.map(|number| number.lane(i))
    }
}
