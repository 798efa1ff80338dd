//! Several numbers side by side that take the same path, in a register of an instruction set.
//!
//! A lane of every result has the bits that `f64` would give for that lane of the arguments, whatever the other lanes
//! hold. Everything is inlined, so that the instruction set is that of the function around it, a law set
//! outlined ([`Real::outlined`]).

pub mod elementary;
pub mod native;
pub(crate) mod pack;
pub mod register;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
pub mod register_wasm;
#[cfg(all(feature = "std", target_arch = "x86_64"))]
pub mod register_x86;

use crate::lanes::register::{Register, WIDEST};
use crate::{Field, Real};
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// The numbers of a register.
#[derive(Debug, Clone, Copy)]
#[repr(transparent)]
pub struct Lanes<R>(R);

impl<R: Register> Lanes<R> {
    /// The first numbers of the slice.
    #[inline(always)]
    pub fn load(from: &[f64]) -> Self {
        Lanes(R::load(from))
    }

    #[inline(always)]
    pub fn store(self, to: &mut [f64]) {
        self.0.store(to);
    }

    /// With `f` of every number, one by one.
    #[inline(always)]
    fn one_by_one(self, f: impl Fn(f64) -> f64) -> Self {
        let mut numbers = [0.0; WIDEST];
        self.0.store(&mut numbers);
        for number in &mut numbers[..R::WIDTH] {
            *number = f(*number);
        }
        Self::load(&numbers)
    }
}

impl<R: Register> Default for Lanes<R> {
    #[inline(always)]
    fn default() -> Self {
        Lanes(R::splat(0.0))
    }
}

macro_rules! lane_by_lane {
    ($($trait:ident $method:ident $operator:tt),*) => {$(
        impl<R: Register> $trait for Lanes<R> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                Lanes(self.0 $operator o.0)
            }
        }

        impl<R: Register> $trait<f64> for Lanes<R> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: f64) -> Self {
                Lanes(self.0 $operator R::splat(o))
            }
        }
    )*};
}
lane_by_lane!(Add add +, Sub sub -, Mul mul *, Div div /);

impl<R: Register> Neg for Lanes<R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Lanes(-self.0)
    }
}

impl<R: Register> AddAssign for Lanes<R> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl<R: Register> SubAssign for Lanes<R> {
    #[inline(always)]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}

impl<R: Register> Field for Lanes<R> {
    type Mask = R::Mask;

    #[inline(always)]
    fn c(x: f64) -> Self {
        Lanes(R::splat(x))
    }
    #[inline(always)]
    fn select(mask: R::Mask, a: Self, b: Self) -> Self {
        Lanes(R::select(mask, a.0, b.0))
    }
    #[inline(always)]
    fn nearer_zero(self, other: Self) -> R::Mask {
        self.0.abs().lt(other.0.abs())
    }
    #[inline(always)]
    fn finite(self) -> R::Mask {
        self.0.abs().le(R::splat(f64::MAX))
    }
}

impl<R: Register> Real for Lanes<R> {
    #[inline(always)]
    fn look_up_row<const K: usize>(self, _: impl Fn(usize) -> Option<f64>, f: impl Fn(f64) -> [f64; K]) -> [Self; K] {
        let (mut plain, mut rows) = ([0.0; WIDEST], [[0.0; WIDEST]; K]);
        self.0.store(&mut plain);
        for lane in 0..R::WIDTH {
            let row = f(plain[lane]);
            for k in 0..K {
                rows[k][lane] = row[k];
            }
        }
        let mut out = [self; K];
        for k in 0..K {
            out[k] = Lanes(R::load(&rows[k]));
        }
        out
    }
    #[inline(always)]
    fn outlined<O>(f: impl FnMut() -> O) -> O {
        R::run(f)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Lanes(self.0.sqrt())
    }
    #[inline(always)]
    fn exp(self) -> Self {
        Lanes(elementary::exp(self.0))
    }
    #[inline(always)]
    fn ln(self) -> Self {
        Lanes(elementary::ln(self.0))
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        // Rare enough for a branch: no crane turns so far.
        if R::any(R::splat(elementary::FAR).lt(self.0.abs())) {
            return (self.one_by_one(|x| elementary::sin_cos(x).0), self.one_by_one(|x| elementary::sin_cos(x).1));
        }
        let (sine, cosine) = elementary::near_sin_cos(self.0);
        (Lanes(sine), Lanes(cosine))
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        Lanes(elementary::tanh(self.0))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Lanes(self.0.abs())
    }
    #[inline(always)]
    fn lt(self, other: Self) -> R::Mask {
        self.0.lt(other.0)
    }
    #[inline(always)]
    fn le(self, other: Self) -> R::Mask {
        self.0.le(other.0)
    }
}
