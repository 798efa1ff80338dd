//! The vector register of WebAssembly: two numbers, where the module is compiled for simd128.

use crate::lanes::register::Register;
use crate::Mask;
use core::arch::wasm32::*;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

#[derive(Debug, Clone, Copy)]
#[repr(transparent)]
pub struct Simd128(v128);

/// All bits of a number set or none.
#[derive(Debug, Clone, Copy)]
#[repr(transparent)]
pub struct Mask128(v128);

impl Mask for Mask128 {}

macro_rules! operators {
    ($on:ident: $($trait:ident $method:ident $operation:ident),*) => {$(
        impl $trait for $on {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                $on($operation(self.0, o.0))
            }
        }
    )*};
}
operators!(Simd128: Add add f64x2_add, Sub sub f64x2_sub, Mul mul f64x2_mul, Div div f64x2_div);
operators!(Mask128: BitAnd bitand v128_and, BitOr bitor v128_or);

impl Not for Mask128 {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Mask128(v128_not(self.0))
    }
}

impl Neg for Simd128 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Simd128(f64x2_neg(self.0))
    }
}

impl Register for Simd128 {
    type Mask = Mask128;
    const NAME: &'static str = "simd128";
    const WIDTH: usize = 2;

    /// A browser without it does not load the module.
    #[inline(always)]
    fn is_available() -> bool {
        true
    }
    #[inline(never)]
    fn run<O>(mut f: impl FnMut() -> O) -> O {
        f()
    }

    #[inline(always)]
    fn splat(x: f64) -> Self {
        Simd128(f64x2_splat(x))
    }
    #[inline(always)]
    fn load(from: &[f64]) -> Self {
        Simd128(f64x2(from[0], from[1]))
    }
    #[inline(always)]
    fn store(self, to: &mut [f64]) {
        to[0] = f64x2_extract_lane::<0>(self.0);
        to[1] = f64x2_extract_lane::<1>(self.0);
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Simd128(f64x2_sqrt(self.0))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Mask128 {
        Mask128(f64x2_lt(self.0, other.0))
    }
    #[inline(always)]
    fn le(self, other: Self) -> Mask128 {
        Mask128(f64x2_le(self.0, other.0))
    }
    #[inline(always)]
    fn select(mask: Mask128, a: Self, b: Self) -> Self {
        Simd128(v128_bitselect(a.0, b.0, mask.0))
    }
    #[inline(always)]
    fn any(mask: Mask128) -> bool {
        v128_any_true(mask.0)
    }
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        Simd128(v128_and(self.0, other.0))
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        Simd128(v128_or(self.0, other.0))
    }
    #[inline(always)]
    fn xor(self, other: Self) -> Self {
        Simd128(v128_xor(self.0, other.0))
    }
    #[inline(always)]
    fn plus_bits(self, other: Self) -> Self {
        Simd128(i64x2_add(self.0, other.0))
    }
    #[inline(always)]
    fn minus_bits(self, other: Self) -> Self {
        Simd128(i64x2_sub(self.0, other.0))
    }
    #[inline(always)]
    fn shift_left<const N: i32>(self) -> Self {
        Simd128(i64x2_shl(self.0, N as u32))
    }
    #[inline(always)]
    fn shift_right<const N: i32>(self) -> Self {
        Simd128(u64x2_shr(self.0, N as u32))
    }
}
