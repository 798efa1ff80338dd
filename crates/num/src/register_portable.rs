//! Four numbers side by side in plain loops, which the compiler turns into whatever vectors there are.

use crate::register::Register;
use crate::Mask;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Four numbers for every processor: a few cylinders that are to be looked at in one go.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
pub struct Four([f64; 4]);

/// One truth value per number: all bits set or none.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
pub struct FourMask([u64; 4]);

/// An array by its elements: a plain loop, since the array functions of the standard library are not always inlined.
macro_rules! each {
    ($zero:literal, $i:ident => $element:expr) => {{
        let mut out = [$zero; 4];
        for $i in 0..4 {
            out[$i] = $element;
        }
        out
    }};
}

macro_rules! operators {
    ($name:ident, $zero:literal: $($trait:ident $method:ident $operator:tt),*) => {$(
        impl $trait for $name {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                $name(each!($zero, i => self.0[i] $operator o.0[i]))
            }
        }
    )*};
}
operators!(Four, 0.0: Add add +, Sub sub -, Mul mul *, Div div /);
operators!(FourMask, 0: BitAnd bitand &, BitOr bitor |);

impl Neg for Four {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Four(each!(0.0, i => -self.0[i]))
    }
}

impl Not for FourMask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        FourMask(each!(0, i => !self.0[i]))
    }
}

impl Mask for FourMask {}

impl Four {
    #[inline(always)]
    fn of_bits(self, o: Self, f: impl Fn(u64, u64) -> u64) -> Self {
        Four(each!(0.0, i => f64::from_bits(f(self.0[i].to_bits(), o.0[i].to_bits()))))
    }
}

#[inline(always)]
fn mask(holds: bool) -> u64 {
    if holds {
        u64::MAX
    } else {
        0
    }
}

impl Register for Four {
    type Mask = FourMask;
    const NAME: &'static str = "portable";
    const WIDTH: usize = 4;

    fn is_available() -> bool {
        true
    }

    /// With AVX2 where the processor has it.
    #[inline(always)]
    fn run<O>(mut f: impl FnMut() -> O) -> O {
        #[cfg(target_arch = "x86_64")]
        {
            #[inline(never)]
            #[target_feature(enable = "avx2")]
            unsafe fn compiled<O>(mut f: impl FnMut() -> O) -> O {
                f()
            }
            if is_x86_feature_detected!("avx2") {
                // SAFETY: the processor has the instruction set.
                return unsafe { compiled(f) };
            }
        }
        f()
    }

    #[inline(always)]
    fn splat(x: f64) -> Self {
        Four([x; 4])
    }
    #[inline(always)]
    fn load(from: &[f64]) -> Self {
        Four([from[0], from[1], from[2], from[3]])
    }
    #[inline(always)]
    fn store(self, to: &mut [f64]) {
        to[..4].copy_from_slice(&self.0);
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Four(each!(0.0, i => self.0[i].sqrt()))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> FourMask {
        FourMask(each!(0, i => mask(self.0[i] < other.0[i])))
    }
    #[inline(always)]
    fn le(self, other: Self) -> FourMask {
        FourMask(each!(0, i => mask(self.0[i] <= other.0[i])))
    }
    #[inline(always)]
    fn select(mask: FourMask, a: Self, b: Self) -> Self {
        let bits = |i: usize| (a.0[i].to_bits() & mask.0[i]) | (b.0[i].to_bits() & !mask.0[i]);
        Four(each!(0.0, i => f64::from_bits(bits(i))))
    }
    #[inline(always)]
    fn any(mask: FourMask) -> bool {
        mask.0[0] | mask.0[1] | mask.0[2] | mask.0[3] != 0
    }
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        self.of_bits(other, |a, b| a & b)
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        self.of_bits(other, |a, b| a | b)
    }
    #[inline(always)]
    fn xor(self, other: Self) -> Self {
        self.of_bits(other, |a, b| a ^ b)
    }
    #[inline(always)]
    fn plus_bits(self, other: Self) -> Self {
        self.of_bits(other, u64::wrapping_add)
    }
    #[inline(always)]
    fn minus_bits(self, other: Self) -> Self {
        self.of_bits(other, u64::wrapping_sub)
    }
    #[inline(always)]
    fn shift_left<const N: i32>(self) -> Self {
        Four(each!(0.0, i => f64::from_bits(self.0[i].to_bits() << N)))
    }
    #[inline(always)]
    fn shift_right<const N: i32>(self) -> Self {
        Four(each!(0.0, i => f64::from_bits(self.0[i].to_bits() >> N)))
    }
}
