//! Forward-mode derivatives: a value with `N` directional derivatives, over any [`Real`].

use crate::Real;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// `value + sum_i derivative[i] eps_i` with `eps_i eps_j = 0`.
///
/// Masks come from the value, so a computation takes the same path with and without derivatives.
#[derive(Debug, Clone, Copy)]
pub struct Dual<S, const N: usize> {
    pub value: S,
    pub derivative: [S; N],
}

impl<S: Real, const N: usize> Dual<S, N> {
    pub fn constant(value: S) -> Self {
        Dual { value, derivative: [S::c(0.0); N] }
    }

    /// The `i`-th independent variable.
    pub fn variable(value: S, i: usize) -> Self {
        let mut x = Self::constant(value);
        x.derivative[i] = S::c(1.0);
        x
    }

    /// `f(self)` given its value and slope.
    #[inline]
    fn chain(self, value: S, slope: S) -> Self {
        Dual { value, derivative: self.derivative.map(|d| d * slope) }
    }

    #[inline]
    fn zip(self, other: Self, value: S, f: impl Fn(S, S) -> S) -> Self {
        let mut derivative = self.derivative;
        for (d, &e) in derivative.iter_mut().zip(&other.derivative) {
            *d = f(*d, e);
        }
        Dual { value, derivative }
    }
}

impl<S: Real, const N: usize> Default for Dual<S, N> {
    fn default() -> Self {
        Self::constant(S::c(0.0))
    }
}

impl<S: Real, const N: usize> Neg for Dual<S, N> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Dual { value: -self.value, derivative: self.derivative.map(|d| -d) }
    }
}

impl<S: Real, const N: usize> Add for Dual<S, N> {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        self.zip(o, self.value + o.value, |a, b| a + b)
    }
}

impl<S: Real, const N: usize> Sub for Dual<S, N> {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        self.zip(o, self.value - o.value, |a, b| a - b)
    }
}

// The product rule adds.
#[allow(clippy::suspicious_arithmetic_impl)]
impl<S: Real, const N: usize> Mul for Dual<S, N> {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        self.zip(o, self.value * o.value, |a, b| a * o.value + b * self.value)
    }
}

impl<S: Real, const N: usize> Div for Dual<S, N> {
    type Output = Self;
    #[inline]
    fn div(self, o: Self) -> Self {
        let inverse = S::c(1.0) / o.value;
        let value = self.value / o.value;
        self.zip(o, value, |a, b| (a - b * value) * inverse)
    }
}

impl<S: Real, const N: usize> Add<f64> for Dual<S, N> {
    type Output = Self;
    #[inline]
    fn add(self, o: f64) -> Self {
        Dual { value: self.value + o, derivative: self.derivative }
    }
}

impl<S: Real, const N: usize> Sub<f64> for Dual<S, N> {
    type Output = Self;
    #[inline]
    fn sub(self, o: f64) -> Self {
        Dual { value: self.value - o, derivative: self.derivative }
    }
}

impl<S: Real, const N: usize> Mul<f64> for Dual<S, N> {
    type Output = Self;
    #[inline]
    fn mul(self, o: f64) -> Self {
        Dual { value: self.value * o, derivative: self.derivative.map(|d| d * o) }
    }
}

impl<S: Real, const N: usize> Div<f64> for Dual<S, N> {
    type Output = Self;
    #[inline]
    fn div(self, o: f64) -> Self {
        Dual { value: self.value / o, derivative: self.derivative.map(|d| d / o) }
    }
}

impl<S: Real, const N: usize> AddAssign for Dual<S, N> {
    #[inline]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl<S: Real, const N: usize> SubAssign for Dual<S, N> {
    #[inline]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}

impl<S: Real, const N: usize> Real for Dual<S, N> {
    type Mask = S::Mask;

    fn c(x: f64) -> Self {
        Self::constant(S::c(x))
    }
    fn look_up(self, f: impl Fn(f64) -> f64) -> Self {
        Self::constant(self.value.look_up(f))
    }
    #[inline]
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, S::c(0.5) / root)
    }
    fn exp(self) -> Self {
        let e = self.value.exp();
        self.chain(e, e)
    }
    fn ln(self) -> Self {
        self.chain(self.value.ln(), S::c(1.0) / self.value)
    }
    fn sin_cos(self) -> (Self, Self) {
        let (s, c) = self.value.sin_cos();
        (self.chain(s, c), self.chain(c, -s))
    }
    fn tanh(self) -> Self {
        // The slope from the value: finite for every argument, where sinh/cosh would overflow.
        let t = self.value.tanh();
        self.chain(t, S::c(1.0) - t * t)
    }
    #[inline]
    fn abs(self) -> Self {
        let slope = S::select(self.value.lt(S::c(0.0)), S::c(-1.0), S::c(1.0));
        self.chain(self.value.abs(), slope)
    }
    fn lt(self, other: Self) -> S::Mask {
        self.value.lt(other.value)
    }
    fn le(self, other: Self) -> S::Mask {
        self.value.le(other.value)
    }
    #[inline]
    fn select(mask: S::Mask, a: Self, b: Self) -> Self {
        a.zip(b, S::select(mask, a.value, b.value), |x, y| S::select(mask, x, y))
    }
}
