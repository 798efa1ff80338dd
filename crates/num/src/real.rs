//! The number type of the laws.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, Neg, Not, Sub, SubAssign};

/// Outcome of a comparison, one truth value per lane of the number it came from.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {}

impl Mask for bool {}

/// A real number: `f64` or a dual number over another `Real`.
///
/// There is no ordering and no equality on purpose: a law cannot branch on a value, it computes both sides
/// and [`select`](Real::select)s. So derivatives and lanes take the same path as plain numbers.
pub trait Real:
    Copy
    + Debug
    + Default
    + Send
    + Sync
    + 'static
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
    + AddAssign
    + SubAssign
{
    type Mask: Mask;

    /// The constant `x`.
    fn c(x: f64) -> Self;
    /// The plain value, for diagnostics and table look-up; laws compute with the number itself.
    fn value(self) -> f64;

    fn sqrt(self) -> Self;
    fn exp(self) -> Self;
    fn ln(self) -> Self;
    fn sin_cos(self) -> (Self, Self);
    fn tanh(self) -> Self;
    /// Absolute value; slope +1 at zero.
    fn abs(self) -> Self;

    fn lt(self, other: Self) -> Self::Mask;
    fn le(self, other: Self) -> Self::Mask;
    /// `a` where the mask holds, else `b`.
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self;

    fn min(self, other: Self) -> Self {
        Self::select(self.lt(other), self, other)
    }
    fn max(self, other: Self) -> Self {
        Self::select(other.lt(self), self, other)
    }
    fn clamp(self, low: Self, high: Self) -> Self {
        self.max(low).min(high)
    }
    fn square(self) -> Self {
        self * self
    }
    /// Neither infinite nor NaN.
    fn finite(self) -> Self::Mask {
        self.abs().le(Self::c(f64::MAX))
    }
}

impl Real for f64 {
    type Mask = bool;

    fn c(x: f64) -> f64 {
        x
    }
    fn value(self) -> f64 {
        self
    }
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }
    fn exp(self) -> f64 {
        f64::exp(self)
    }
    fn ln(self) -> f64 {
        f64::ln(self)
    }
    fn sin_cos(self) -> (f64, f64) {
        f64::sin_cos(self)
    }
    fn tanh(self) -> f64 {
        f64::tanh(self)
    }
    fn abs(self) -> f64 {
        f64::abs(self)
    }
    fn lt(self, other: f64) -> bool {
        self < other
    }
    fn le(self, other: f64) -> bool {
        self <= other
    }
    fn select(mask: bool, a: f64, b: f64) -> f64 {
        if mask {
            a
        } else {
            b
        }
    }
}
