//! Forward-mode derivatives: a value with `N` directional derivatives, over any [`Real`].

use crate::{Field, Real};
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// `value + sum_i derivative[i] eps_i` with `eps_i eps_j = 0`.
///
/// Masks come from the value, so a computation takes the same path with and without derivatives.
#[derive(Debug, Clone, Copy)]
pub struct Dual<S, const N: usize> {
    pub value: S,
    pub derivative: [S; N],
}

impl<S: Real, const N: usize> Dual<S, N> {
    #[inline(always)]
    pub fn constant(value: S) -> Self {
        Dual { value, derivative: [S::c(0.0); N] }
    }

    /// The `i`-th independent variable.
    #[inline(always)]
    pub fn variable(value: S, i: usize) -> Self {
        let mut x = Self::constant(value);
        x.derivative[i] = S::c(1.0);
        x
    }

    /// The same number among `M` independent variables, of which `at` tells this one's.
    #[inline(always)]
    pub fn among<const M: usize>(self, at: [usize; N]) -> Dual<S, M> {
        let mut wide = Dual::constant(self.value);
        for i in 0..N {
            wide.derivative[at[i]] = self.derivative[i];
        }
        wide
    }

    /// `f(self)` given its value and slope.
    #[inline(always)]
    fn chain(self, value: S, slope: S) -> Self {
        self.each(value, |d| d * slope)
    }

    /// With `f` of every derivative, in a plain loop: the array functions of the standard library and its iterators are not
    /// always inlined.
    #[inline(always)]
    fn each(self, value: S, f: impl Fn(S) -> S) -> Self {
        let mut derivative = self.derivative;
        for i in 0..N {
            derivative[i] = f(derivative[i]);
        }
        Dual { value, derivative }
    }

    #[inline(always)]
    fn zip(self, other: Self, value: S, f: impl Fn(S, S) -> S) -> Self {
        let mut derivative = self.derivative;
        for i in 0..N {
            derivative[i] = f(derivative[i], other.derivative[i]);
        }
        Dual { value, derivative }
    }
}

impl<S: Real, const N: usize> Default for Dual<S, N> {
    #[inline(always)]
    fn default() -> Self {
        Self::constant(S::c(0.0))
    }
}

impl<S: Real, const N: usize> Neg for Dual<S, N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.each(-self.value, |d| -d)
    }
}

impl<S: Real, const N: usize> Add for Dual<S, N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        self.zip(o, self.value + o.value, |a, b| a + b)
    }
}

impl<S: Real, const N: usize> Sub for Dual<S, N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        self.zip(o, self.value - o.value, |a, b| a - b)
    }
}

// The product rule adds.
#[allow(clippy::suspicious_arithmetic_impl)]
impl<S: Real, const N: usize> Mul for Dual<S, N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        self.zip(o, self.value * o.value, |a, b| a * o.value + b * self.value)
    }
}

impl<S: Real, const N: usize> Div for Dual<S, N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        let inverse = S::c(1.0) / o.value;
        let value = self.value / o.value;
        self.zip(o, value, |a, b| (a - b * value) * inverse)
    }
}

impl<S: Real, const N: usize> Add<f64> for Dual<S, N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: f64) -> Self {
        Dual { value: self.value + o, derivative: self.derivative }
    }
}

impl<S: Real, const N: usize> Sub<f64> for Dual<S, N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: f64) -> Self {
        Dual { value: self.value - o, derivative: self.derivative }
    }
}

impl<S: Real, const N: usize> Mul<f64> for Dual<S, N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: f64) -> Self {
        self.each(self.value * o, |d| d * o)
    }
}

impl<S: Real, const N: usize> Div<f64> for Dual<S, N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, o: f64) -> Self {
        self.each(self.value / o, |d| d / o)
    }
}

impl<S: Real, const N: usize> AddAssign for Dual<S, N> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl<S: Real, const N: usize> SubAssign for Dual<S, N> {
    #[inline(always)]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}

/// By the value.
impl<S: Real, const N: usize> Field for Dual<S, N> {
    type Mask = S::Mask;

    #[inline(always)]
    fn c(x: f64) -> Self {
        Self::constant(S::c(x))
    }
    #[inline(always)]
    fn select(mask: S::Mask, a: Self, b: Self) -> Self {
        a.zip(b, S::select(mask, a.value, b.value), |x, y| S::select(mask, x, y))
    }
    #[inline(always)]
    fn nearer_zero(self, other: Self) -> S::Mask {
        self.value.nearer_zero(other.value)
    }
    #[inline(always)]
    fn finite(self) -> S::Mask {
        self.value.finite()
    }
}

impl<S: Real, const N: usize> Real for Dual<S, N> {
    #[inline(always)]
    fn look_up_row<const K: usize>(
        self,
        starts: impl Fn(usize) -> Option<f64>,
        f: impl Fn(f64) -> [f64; K],
    ) -> [Self; K] {
        self.value.look_up_row(starts, f).map(Self::constant)
    }
    #[inline(always)]
    fn outlined<O>(f: impl FnMut() -> O) -> O {
        S::outlined(f)
    }
    #[inline(always)]
    fn outlined_if_dual<O>(f: impl FnMut() -> O) -> O {
        S::outlined(f)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, S::c(0.5) / root)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        let e = self.value.exp();
        self.chain(e, e)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        self.chain(self.value.ln(), S::c(1.0) / self.value)
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (s, c) = self.value.sin_cos();
        (self.chain(s, c), self.chain(c, -s))
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        // The slope from the value: finite for every argument, where sinh/cosh would overflow.
        let t = self.value.tanh();
        self.chain(t, S::c(1.0) - t * t)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        let slope = S::select(self.value.lt(S::c(0.0)), S::c(-1.0), S::c(1.0));
        self.chain(self.value.abs(), slope)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> S::Mask {
        self.value.lt(other.value)
    }
    #[inline(always)]
    fn le(self, other: Self) -> S::Mask {
        self.value.le(other.value)
    }
}
