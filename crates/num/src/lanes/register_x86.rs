//! The vector registers of x86-64 processors: SSE2, which all of them have, AVX2 and AVX-512.

use crate::lanes::register::Register;
use crate::Mask;
use core::arch::x86_64::*;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

impl Mask for u8 {}

macro_rules! register {
    (
        $name:ident($raw:ty), $width:literal, $text:literal, features $features:literal, detect $($feature:tt)&&+;
        mask $mask:ty;
        set $set:ident, load $load:ident, store $store:ident, sqrt $sqrt:ident;
        arithmetic $add:ident $sub:ident $mul:ident $div:ident;
        logic $and:ident $or:ident $xor:ident;
        whole $integer:ident, $double:ident, $plus:ident $minus:ident $left:ident $right:ident;
        comparison $less:expr, $less_or_equal:expr, $select:expr, $any:expr;
    ) => {
        #[doc = concat!("A register of ", $text, ".")]
        #[derive(Debug, Clone, Copy)]
        #[repr(transparent)]
        pub struct $name($raw);

        register!(@operators $name: Add add $add, Sub sub $sub, Mul mul $mul, Div div $div);

        impl Neg for $name {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                self.xor(Self::splat(-0.0))
            }
        }

        // SAFETY of every block: values of this type are made and used by code that `run` runs, which asserts that the
        // processor has the instruction set.
        impl Register for $name {
            type Mask = $mask;
            const NAME: &'static str = $text;
            const WIDTH: usize = $width;

            #[inline(always)]
            fn is_available() -> bool {
                $(is_x86_feature_detected!($feature))&&+
            }
            #[inline(always)]
            fn run<O>(f: impl FnMut() -> O) -> O {
                #[inline(never)]
                #[target_feature(enable = $features)]
                unsafe fn compiled<O>(mut f: impl FnMut() -> O) -> O {
                    f()
                }
                assert!(Self::is_available(), "a processor without {}", $text);
                unsafe { compiled(f) }
            }

            #[inline(always)]
            fn splat(x: f64) -> Self {
                unsafe { $name($set(x)) }
            }
            #[inline(always)]
            fn load(from: &[f64]) -> Self {
                unsafe { $name($load(from[..$width].as_ptr())) }
            }
            #[inline(always)]
            fn store(self, to: &mut [f64]) {
                unsafe { $store(to[..$width].as_mut_ptr(), self.0) }
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                unsafe { $name($sqrt(self.0)) }
            }
            #[inline(always)]
            fn lt(self, other: Self) -> $mask {
                unsafe { $less(self.0, other.0) }
            }
            #[inline(always)]
            fn le(self, other: Self) -> $mask {
                unsafe { $less_or_equal(self.0, other.0) }
            }
            #[inline(always)]
            fn select(mask: $mask, a: Self, b: Self) -> Self {
                unsafe { $name($select(mask, a.0, b.0)) }
            }
            #[inline(always)]
            fn any(mask: $mask) -> bool {
                unsafe { $any(mask) }
            }
            #[inline(always)]
            fn and(self, other: Self) -> Self {
                unsafe { $name($and(self.0, other.0)) }
            }
            #[inline(always)]
            fn or(self, other: Self) -> Self {
                unsafe { $name($or(self.0, other.0)) }
            }
            #[inline(always)]
            fn xor(self, other: Self) -> Self {
                unsafe { $name($xor(self.0, other.0)) }
            }
            #[inline(always)]
            fn plus_bits(self, other: Self) -> Self {
                unsafe { $name($double($plus($integer(self.0), $integer(other.0)))) }
            }
            #[inline(always)]
            fn minus_bits(self, other: Self) -> Self {
                unsafe { $name($double($minus($integer(self.0), $integer(other.0)))) }
            }
            #[inline(always)]
            fn shift_left<const N: i32>(self) -> Self {
                unsafe { $name($double($left($integer(self.0), _mm_cvtsi64_si128(N as i64)))) }
            }
            #[inline(always)]
            fn shift_right<const N: i32>(self) -> Self {
                unsafe { $name($double($right($integer(self.0), _mm_cvtsi64_si128(N as i64)))) }
            }
        }
    };
    (@operators $name:ident: $($trait:ident $method:ident $operation:ident),*) => {$(
        impl $trait for $name {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                unsafe { $name($operation(self.0, o.0)) }
            }
        }
    )*};
}

/// A mask that fills a register: all bits of a number set or none.
macro_rules! full_mask {
    ($name:ident($raw:ty): $and:ident $or:ident $xor:ident $integer:ident $double:ident $ones:ident) => {
        #[derive(Debug, Clone, Copy)]
        #[repr(transparent)]
        pub struct $name($raw);

        impl Mask for $name {}

        impl BitAnd for $name {
            type Output = Self;
            #[inline(always)]
            fn bitand(self, o: Self) -> Self {
                unsafe { $name($and(self.0, o.0)) }
            }
        }
        impl BitOr for $name {
            type Output = Self;
            #[inline(always)]
            fn bitor(self, o: Self) -> Self {
                unsafe { $name($or(self.0, o.0)) }
            }
        }
        impl Not for $name {
            type Output = Self;
            #[inline(always)]
            fn not(self) -> Self {
                unsafe { $name($xor(self.0, $double($ones(-1)))) }
            }
        }
    };
}

full_mask!(Mask128(__m128d): _mm_and_pd _mm_or_pd _mm_xor_pd _mm_castpd_si128 _mm_castsi128_pd _mm_set1_epi64x);
full_mask!(Mask256(__m256d): _mm256_and_pd _mm256_or_pd _mm256_xor_pd _mm256_castpd_si256 _mm256_castsi256_pd _mm256_set1_epi64x);

register! {
    Sse2(__m128d), 2, "sse2", features "sse2", detect "sse2";
    mask Mask128;
    set _mm_set1_pd, load _mm_loadu_pd, store _mm_storeu_pd, sqrt _mm_sqrt_pd;
    arithmetic _mm_add_pd _mm_sub_pd _mm_mul_pd _mm_div_pd;
    logic _mm_and_pd _mm_or_pd _mm_xor_pd;
    whole _mm_castpd_si128, _mm_castsi128_pd, _mm_add_epi64 _mm_sub_epi64 _mm_sll_epi64 _mm_srl_epi64;
    comparison
        |a, b| Mask128(_mm_cmplt_pd(a, b)),
        |a, b| Mask128(_mm_cmple_pd(a, b)),
        |m: Mask128, a, b| _mm_or_pd(_mm_and_pd(m.0, a), _mm_andnot_pd(m.0, b)),
        |m: Mask128| _mm_movemask_pd(m.0) != 0;
}

register! {
    Avx2(__m256d), 4, "avx2", features "avx2", detect "avx2";
    mask Mask256;
    set _mm256_set1_pd, load _mm256_loadu_pd, store _mm256_storeu_pd, sqrt _mm256_sqrt_pd;
    arithmetic _mm256_add_pd _mm256_sub_pd _mm256_mul_pd _mm256_div_pd;
    logic _mm256_and_pd _mm256_or_pd _mm256_xor_pd;
    whole _mm256_castpd_si256, _mm256_castsi256_pd, _mm256_add_epi64 _mm256_sub_epi64 _mm256_sll_epi64 _mm256_srl_epi64;
    comparison
        |a, b| Mask256(_mm256_cmp_pd::<_CMP_LT_OQ>(a, b)),
        |a, b| Mask256(_mm256_cmp_pd::<_CMP_LE_OQ>(a, b)),
        |m: Mask256, a, b| _mm256_blendv_pd(b, a, m.0),
        |m: Mask256| _mm256_movemask_pd(m.0) != 0;
}

register! {
    Avx512(__m512d), 8, "avx512", features "avx512f,avx512vl,avx512dq,avx512bw",
    detect "avx512f" && "avx512vl" && "avx512dq" && "avx512bw";
    mask u8;
    set _mm512_set1_pd, load _mm512_loadu_pd, store _mm512_storeu_pd, sqrt _mm512_sqrt_pd;
    arithmetic _mm512_add_pd _mm512_sub_pd _mm512_mul_pd _mm512_div_pd;
    logic _mm512_and_pd _mm512_or_pd _mm512_xor_pd;
    whole _mm512_castpd_si512, _mm512_castsi512_pd, _mm512_add_epi64 _mm512_sub_epi64 _mm512_sll_epi64 _mm512_srl_epi64;
    comparison
        |a, b| _mm512_cmp_pd_mask::<_CMP_LT_OQ>(a, b),
        |a, b| _mm512_cmp_pd_mask::<_CMP_LE_OQ>(a, b),
        |m: u8, a, b| _mm512_mask_blend_pd(m, b, a),
        |m: u8| _cvtmask8_u32(m) != 0;
}
