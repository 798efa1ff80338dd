//! The number type of the laws.

use crate::lanes::elementary;
use crate::lanes::register::Register;
use crate::portable;
use core::fmt::Debug;
use core::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, Neg, Not, Sub, SubAssign};

/// Outcome of a comparison, one truth value per lane of the number it came from.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {}

impl Mask for bool {}

/// A number that linear systems are solved in.
pub trait Field:
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
    + Mul<f64, Output = Self>
    + AddAssign
    + SubAssign
{
    type Mask: Mask;

    /// The constant `x`.
    fn c(x: f64) -> Self;
    /// `a` where the mask holds, else `b`.
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self;
    /// Whether it is nearer to zero than `other`.
    fn nearer_zero(self, other: Self) -> Self::Mask;
    /// Neither infinite nor NaN.
    fn finite(self) -> Self::Mask;
}

/// A real number: `f64`, several of them in lanes, or a dual number over another `Real`.
///
/// There is intentionally no ordering and no equality: a law cannot branch on a value, but computes both sides and
/// [`select`](Real::select)s. So derivatives and lanes take the same path as plain numbers.
pub trait Real: Field + Add<f64, Output = Self> + Sub<f64, Output = Self> + Div<f64, Output = Self> {
    /// The constants that `f` gives for the plain value, lane by lane: for rows of tables. Their derivatives are zero. `starts`
    /// are the ascending numbers from each of which on `f` gives another row, by their index; only a type that keeps the whole
    /// table asks for them.
    fn look_up_row<const K: usize>(
        self,
        starts: impl Fn(usize) -> Option<f64>,
        f: impl Fn(f64) -> [f64; K],
    ) -> [Self; K];

    /// Runs `f` where its code is not copied into every caller, if that matters for this number type: in lanes a law
    /// becomes long code and must know its instruction set. `f` is to be marked as always inlined.
    #[inline(always)]
    fn outlined<O>(mut f: impl FnMut() -> O) -> O {
        f()
    }

    /// As [`outlined`](Real::outlined) if this is a dual number, else in line: parts of a crane that are short for plain numbers
    /// and lanes are long for dual ones, and a function that holds several of them takes far longer to compile.
    #[inline(always)]
    fn outlined_if_dual<O>(mut f: impl FnMut() -> O) -> O {
        f()
    }

    fn sqrt(self) -> Self;
    fn exp(self) -> Self;
    fn ln(self) -> Self;
    fn sin_cos(self) -> (Self, Self);
    fn tanh(self) -> Self;
    /// Absolute value; slope +1 at zero.
    fn abs(self) -> Self;

    fn lt(self, other: Self) -> Self::Mask;
    fn le(self, other: Self) -> Self::Mask;

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(self.lt(other), self, other)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(other.lt(self), self, other)
    }
    #[inline(always)]
    fn clamp(self, low: Self, high: Self) -> Self {
        self.max(low).min(high)
    }
    #[inline(always)]
    fn square(self) -> Self {
        self * self
    }
}

impl Field for f64 {
    type Mask = bool;

    #[inline(always)]
    fn c(x: f64) -> f64 {
        x
    }
    #[inline(always)]
    fn select(mask: bool, a: f64, b: f64) -> f64 {
        if mask {
            a
        } else {
            b
        }
    }
    #[inline(always)]
    fn nearer_zero(self, other: f64) -> bool {
        f64::abs(self) < f64::abs(other)
    }
    #[inline(always)]
    fn finite(self) -> bool {
        f64::abs(self) <= f64::MAX
    }
}

impl Real for f64 {
    #[inline(always)]
    fn outlined<O>(f: impl FnMut() -> O) -> O {
        <f64 as Register>::run(f)
    }
    #[inline(always)]
    fn look_up_row<const K: usize>(self, _: impl Fn(usize) -> Option<f64>, f: impl Fn(f64) -> [f64; K]) -> [f64; K] {
        f(self)
    }
    #[inline(always)]
    fn sqrt(self) -> f64 {
        portable::sqrt(self)
    }
    #[inline(always)]
    fn exp(self) -> f64 {
        elementary::exp(self)
    }
    #[inline(always)]
    fn ln(self) -> f64 {
        elementary::ln(self)
    }
    #[inline(always)]
    fn sin_cos(self) -> (f64, f64) {
        elementary::sin_cos(self)
    }
    #[inline(always)]
    fn tanh(self) -> f64 {
        elementary::tanh(self)
    }
    #[inline(always)]
    fn abs(self) -> f64 {
        f64::abs(self)
    }
    #[inline(always)]
    fn lt(self, other: f64) -> bool {
        self < other
    }
    #[inline(always)]
    fn le(self, other: f64) -> bool {
        self <= other
    }
}
