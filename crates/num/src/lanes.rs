//! Several numbers side by side that take the same path, in the registers of an instruction set.
//!
//! A lane of every result has the bits that `f64` would give for that lane of the arguments, whatever the other lanes
//! hold. Everything is inlined, so that the instruction set is that of the function around it, a law set
//! [apart](Real::apart).

use crate::register::Register;
use crate::{elementary, Mask, Real};
use std::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, Neg, Not, Sub, SubAssign};

/// The numbers of `K` registers.
#[derive(Debug, Clone, Copy)]
pub struct Lanes<R, const K: usize>([R; K]);

/// One truth value per lane.
#[derive(Debug, Clone, Copy)]
pub struct LaneMask<M, const K: usize>([M; K]);

/// An array by its elements: a plain loop, since the array functions of the standard library are not always inlined.
macro_rules! each {
    ($first:expr, $k:ident => $element:expr) => {{
        let mut out = $first;
        for $k in 0..K {
            out[$k] = $element;
        }
        out
    }};
}

impl<R: Register, const K: usize> Lanes<R, K> {
    /// Number of lanes.
    pub const WIDTH: usize = K * R::WIDTH;

    /// The first [`Self::WIDTH`] numbers of the slice.
    #[inline(always)]
    pub fn load(from: &[f64]) -> Self {
        Lanes(each!([R::splat(0.0); K], k => R::load(&from[k * R::WIDTH..])))
    }

    #[inline(always)]
    pub fn store(self, to: &mut [f64]) {
        for k in 0..K {
            self.0[k].store(&mut to[k * R::WIDTH..]);
        }
    }

    #[inline(always)]
    fn each(self, f: impl Fn(R) -> R) -> Self {
        Lanes(each!(self.0, k => f(self.0[k])))
    }

    /// With `f` of every number, one by one.
    #[inline(always)]
    fn one_by_one(self, f: impl Fn(f64) -> f64) -> Self {
        // No register is wider than this.
        let mut numbers = [0.0; 8];
        Lanes(each!(self.0, k => {
            self.0[k].store(&mut numbers);
            for i in 0..R::WIDTH {
                numbers[i] = f(numbers[i]);
            }
            R::load(&numbers)
        }))
    }
}

impl<R: Register, const K: usize> Default for Lanes<R, K> {
    #[inline(always)]
    fn default() -> Self {
        Lanes([R::splat(0.0); K])
    }
}

macro_rules! lane_by_lane {
    ($($trait:ident $method:ident $operator:tt),*) => {$(
        impl<R: Register, const K: usize> $trait for Lanes<R, K> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                Lanes(each!(self.0, k => self.0[k] $operator o.0[k]))
            }
        }

        impl<R: Register, const K: usize> $trait<f64> for Lanes<R, K> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: f64) -> Self {
                Lanes(each!(self.0, k => self.0[k] $operator R::splat(o)))
            }
        }
    )*};
}
lane_by_lane!(Add add +, Sub sub -, Mul mul *, Div div /);

impl<R: Register, const K: usize> Neg for Lanes<R, K> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.each(|r| -r)
    }
}

impl<R: Register, const K: usize> AddAssign for Lanes<R, K> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl<R: Register, const K: usize> SubAssign for Lanes<R, K> {
    #[inline(always)]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}

impl<M: Mask, const K: usize> BitAnd for LaneMask<M, K> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, o: Self) -> Self {
        LaneMask(each!(self.0, k => self.0[k] & o.0[k]))
    }
}

impl<M: Mask, const K: usize> BitOr for LaneMask<M, K> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, o: Self) -> Self {
        LaneMask(each!(self.0, k => self.0[k] | o.0[k]))
    }
}

impl<M: Mask, const K: usize> Not for LaneMask<M, K> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        LaneMask(each!(self.0, k => !self.0[k]))
    }
}

impl<M: Mask, const K: usize> Mask for LaneMask<M, K> {}

impl<R: Register, const K: usize> Real for Lanes<R, K> {
    type Mask = LaneMask<R::Mask, K>;

    #[inline(always)]
    fn c(x: f64) -> Self {
        Lanes([R::splat(x); K])
    }
    #[inline(always)]
    fn look_up(self, f: impl Fn(f64) -> f64) -> Self {
        self.one_by_one(f)
    }
    #[inline(always)]
    fn apart<O>(f: impl FnMut() -> O) -> O {
        R::run(f)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.each(|r| r.sqrt())
    }
    #[inline(always)]
    fn exp(self) -> Self {
        Lanes(each!(self.0, k => elementary::exp(self.0[k])))
    }
    #[inline(always)]
    fn ln(self) -> Self {
        Lanes(each!(self.0, k => elementary::ln(self.0[k])))
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (mut sine, mut cosine, mut far) = (self, self, false);
        for k in 0..K {
            (sine.0[k], cosine.0[k]) = elementary::near_sin_cos(self.0[k]);
            far |= R::any(R::splat(elementary::FAR).lt(self.0[k].abs()));
        }
        // Rare enough for a branch: no crane turns so far.
        if far {
            sine = self.one_by_one(|x| elementary::sin_cos(x).0);
            cosine = self.one_by_one(|x| elementary::sin_cos(x).1);
        }
        (sine, cosine)
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        Lanes(each!(self.0, k => elementary::tanh(self.0[k])))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.each(|r| r.abs())
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Self::Mask {
        let mut out = LaneMask([self.0[0].lt(other.0[0]); K]);
        for k in 1..K {
            out.0[k] = self.0[k].lt(other.0[k]);
        }
        out
    }
    #[inline(always)]
    fn le(self, other: Self) -> Self::Mask {
        let mut out = LaneMask([self.0[0].le(other.0[0]); K]);
        for k in 1..K {
            out.0[k] = self.0[k].le(other.0[k]);
        }
        out
    }
    #[inline(always)]
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self {
        Lanes(each!(a.0, k => R::select(mask.0[k], a.0[k], b.0[k])))
    }
}
