//! Several numbers side by side that take the same path: plain arrays, whose loops the compiler turns into vectors.
//!
//! Lane `i` of every result has the bits that `f64` would give for lane `i` of the arguments, whatever the other lanes
//! hold. Everything is inlined, so that the instruction set is that of the function at the bottom of the stack.

use crate::{elementary, Mask, Real};
use std::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, Neg, Not, Sub, SubAssign};

/// `W` numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(32))]
pub struct Lanes<const W: usize>(pub [f64; W]);

/// One truth value per lane: all bits set or none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(align(32))]
pub struct LaneMask<const W: usize>(pub [u64; W]);

/// An array by its elements: a plain loop, since the array functions of the standard library are not always inlined.
macro_rules! each {
    ($zero:literal, $i:ident => $element:expr) => {{
        let mut out = [$zero; W];
        for $i in 0..W {
            out[$i] = $element;
        }
        out
    }};
}

impl<const W: usize> LaneMask<W> {
    /// Whether the mask holds in lane `i`.
    #[inline(always)]
    pub fn holds(&self, i: usize) -> bool {
        self.0[i] != 0
    }
}

impl<const W: usize> Default for Lanes<W> {
    #[inline(always)]
    fn default() -> Self {
        Lanes([0.0; W])
    }
}

macro_rules! lane_by_lane {
    ($($trait:ident $method:ident $operator:tt),*) => {$(
        impl<const W: usize> $trait for Lanes<W> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                Lanes(each!(0.0, i => self.0[i] $operator o.0[i]))
            }
        }

        impl<const W: usize> $trait<f64> for Lanes<W> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: f64) -> Self {
                Lanes(each!(0.0, i => self.0[i] $operator o))
            }
        }
    )*};
}
lane_by_lane!(Add add +, Sub sub -, Mul mul *, Div div /);

impl<const W: usize> Neg for Lanes<W> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Lanes(each!(0.0, i => -self.0[i]))
    }
}

impl<const W: usize> AddAssign for Lanes<W> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl<const W: usize> SubAssign for Lanes<W> {
    #[inline(always)]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}

impl<const W: usize> BitAnd for LaneMask<W> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, o: Self) -> Self {
        LaneMask(each!(0, i => self.0[i] & o.0[i]))
    }
}

impl<const W: usize> BitOr for LaneMask<W> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, o: Self) -> Self {
        LaneMask(each!(0, i => self.0[i] | o.0[i]))
    }
}

impl<const W: usize> Not for LaneMask<W> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        LaneMask(each!(0, i => !self.0[i]))
    }
}

impl<const W: usize> Mask for LaneMask<W> {}

impl<const W: usize> Real for Lanes<W> {
    type Mask = LaneMask<W>;

    #[inline(always)]
    fn c(x: f64) -> Self {
        Lanes([x; W])
    }
    #[inline(always)]
    fn look_up(self, f: impl Fn(f64) -> f64) -> Self {
        Lanes(each!(0.0, i => f(self.0[i])))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Lanes(each!(0.0, i => f64::sqrt(self.0[i])))
    }
    #[inline(always)]
    fn exp(self) -> Self {
        Lanes(each!(0.0, i => elementary::exp(self.0[i])))
    }
    #[inline(always)]
    fn ln(self) -> Self {
        Lanes(each!(0.0, i => elementary::ln(self.0[i])))
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (mut sine, mut cosine, mut far) = ([0.0; W], [0.0; W], false);
        for i in 0..W {
            (sine[i], cosine[i]) = elementary::near_sin_cos(self.0[i]);
            far |= self.0[i].abs() > elementary::FAR;
        }
        // Rare enough for a branch: no crane turns so far.
        if far {
            for i in 0..W {
                if self.0[i].abs() > elementary::FAR {
                    (sine[i], cosine[i]) = elementary::far_sin_cos(self.0[i]);
                }
            }
        }
        (Lanes(sine), Lanes(cosine))
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        Lanes(each!(0.0, i => elementary::tanh(self.0[i])))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Lanes(each!(0.0, i => f64::abs(self.0[i])))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> LaneMask<W> {
        LaneMask(each!(0, i => u64::from(self.0[i] < other.0[i]).wrapping_neg()))
    }
    #[inline(always)]
    fn le(self, other: Self) -> LaneMask<W> {
        LaneMask(each!(0, i => u64::from(self.0[i] <= other.0[i]).wrapping_neg()))
    }
    #[inline(always)]
    fn select(mask: LaneMask<W>, a: Self, b: Self) -> Self {
        Lanes(each!(0.0, i => if mask.0[i] != 0 { a.0[i] } else { b.0[i] }))
    }
}
