//! A vector register of the processor: what elementary functions and lanes need of it.
//!
//! The numbers of a register never meet each other, and no operation is contracted with another one: every instruction set
//! gives the bits that `f64` gives.

use crate::{portable, Mask};
use core::fmt::Debug;
use core::ops::{Add, Div, Mul, Neg, Sub};

/// Numbers in the widest of them.
pub const WIDEST: usize = 8;

/// Numbers side by side in one register.
pub trait Register:
    Copy
    + Debug
    + Send
    + Sync
    + 'static
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
{
    type Mask: Mask + Debug;
    /// Of the instruction set.
    const NAME: &'static str;
    /// Numbers in it.
    const WIDTH: usize;

    /// Whether this processor has the instruction set.
    fn is_available() -> bool;
    /// Runs `f` as a function of its own, compiled for this instruction set with all that is inlined into it; `f` itself
    /// is to be marked as always inlined. What is not inlined calls every operation as a function, by way of memory, and is
    /// several times as slow: closures of any length are to be marked too, and handed to functions that are inlined
    /// themselves, which those of `Option`, arrays and iterators need not be.
    fn run<O>(f: impl FnMut() -> O) -> O;

    fn splat(x: f64) -> Self;
    /// The first numbers of the slice.
    fn load(from: &[f64]) -> Self;
    fn store(self, to: &mut [f64]);

    fn sqrt(self) -> Self;
    fn lt(self, other: Self) -> Self::Mask;
    fn le(self, other: Self) -> Self::Mask;
    /// `a` where the mask holds, else `b`.
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self;
    fn any(mask: Self::Mask) -> bool;

    // Bit patterns as whole numbers.
    fn and(self, other: Self) -> Self;
    fn or(self, other: Self) -> Self;
    fn xor(self, other: Self) -> Self;
    fn plus_bits(self, other: Self) -> Self;
    fn minus_bits(self, other: Self) -> Self;
    fn shift_left<const N: i32>(self) -> Self;
    fn shift_right<const N: i32>(self) -> Self;

    /// The number with these bits.
    #[inline(always)]
    fn bits(bits: u64) -> Self {
        Self::splat(f64::from_bits(bits))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.and(Self::bits(!SIGN))
    }
    /// The sign bit, over zeros.
    #[inline(always)]
    fn sign(self) -> Self {
        self.and(Self::bits(SIGN))
    }
}

const SIGN: u64 = 1 << 63;

/// The register of width one, which every processor has.
impl Register for f64 {
    type Mask = bool;
    const NAME: &'static str = "plain";
    const WIDTH: usize = 1;

    fn is_available() -> bool {
        true
    }
    #[inline(never)]
    fn run<O>(mut f: impl FnMut() -> O) -> O {
        f()
    }

    #[inline(always)]
    fn splat(x: f64) -> f64 {
        x
    }
    #[inline(always)]
    fn load(from: &[f64]) -> f64 {
        from[0]
    }
    #[inline(always)]
    fn store(self, to: &mut [f64]) {
        to[0] = self;
    }
    #[inline(always)]
    fn sqrt(self) -> f64 {
        portable::sqrt(self)
    }
    #[inline(always)]
    fn lt(self, other: f64) -> bool {
        self < other
    }
    #[inline(always)]
    fn le(self, other: f64) -> bool {
        self <= other
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
    fn any(mask: bool) -> bool {
        mask
    }
    #[inline(always)]
    fn and(self, other: f64) -> f64 {
        f64::from_bits(self.to_bits() & other.to_bits())
    }
    #[inline(always)]
    fn or(self, other: f64) -> f64 {
        f64::from_bits(self.to_bits() | other.to_bits())
    }
    #[inline(always)]
    fn xor(self, other: f64) -> f64 {
        f64::from_bits(self.to_bits() ^ other.to_bits())
    }
    #[inline(always)]
    fn plus_bits(self, other: f64) -> f64 {
        f64::from_bits(self.to_bits().wrapping_add(other.to_bits()))
    }
    #[inline(always)]
    fn minus_bits(self, other: f64) -> f64 {
        f64::from_bits(self.to_bits().wrapping_sub(other.to_bits()))
    }
    #[inline(always)]
    fn shift_left<const N: i32>(self) -> f64 {
        f64::from_bits(self.to_bits() << N)
    }
    #[inline(always)]
    fn shift_right<const N: i32>(self) -> f64 {
        f64::from_bits(self.to_bits() >> N)
    }
}
