//! Elementary functions of double precision without branches, tables or calls, for any register: every instruction set gives
//! the same bits (no fused multiply-add).
//!
//! Each argument is reduced to a short interval around zero, where a polynomial does the rest. The polynomials are
//! Chebyshev fits, computed with 60 digits. Largest errors of 10^5 random arguments against arithmetic of 140 bits, in units
//! of the last place: exp 0.97, ln 0.77, sine and cosine 0.84, tanh 2.24. Signs of zeros are not kept by the sine.

use crate::lanes::register::Register;
use core::f64::consts::{FRAC_1_SQRT_2, FRAC_2_PI, LOG2_E};

/// 1.5 2^52: adding it rounds a number below 2^51 to the nearest integer, which then stands in the lowest bits.
const ROUNDER: f64 = 6_755_399_441_055_744.0;
/// ln 2 in two parts: the first has 20 zero bits, so that its product with an exponent is exact.
const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;
/// pi/2 in three parts, the first two with 20 zero bits.
const QUARTER: [f64; 3] = [1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_795_950_6e-21];
/// Up to here the product of a number of quarter turns with the parts above is exact, rad.
pub const FAR: f64 = 1e6;

const EXPONENT_BIAS: u64 = 1023;
const FRACTION_BITS: i32 = 52;
const TWO_TO_54: f64 = 18_014_398_509_481_984.0;

/// (e^r - 1 - r)/r^2 for |r| <= ln(2)/2.
const EXP: [f64; 10] = [
    0.500_000_000_000_000_1,
    0.166_666_666_666_666_69,
    0.041_666_666_666_623_99,
    0.008_333_333_333_330_051,
    0.001_388_888_891_728_179_4,
    0.000_198_412_698_631_059_68,
    2.480_152_119_021_773e-5,
    2.755_726_837_868_419_2e-6,
    2.762_013_871_973_399_4e-7,
    2.510_042_415_700_506_7e-8,
];
/// (2 artanh(s)/s - 2)/s^2 in powers of s^2 for s^2 <= 0.0295.
const LN: [f64; 7] = [
    0.666_666_666_666_667,
    0.399_999_999_998_988_9,
    0.285_714_286_262_538_36,
    0.222_222_110_893_794_96,
    0.181_828_924_325_368_7,
    0.153_316_117_220_550_08,
    0.146_178_071_534_173_25,
];
/// (sin(r) - r)/r^3 and (cos(r) - 1 + r^2/2)/r^4 in powers of r^2 for |r| <= pi/4.
const SIN: [f64; 6] = [
    -0.166_666_666_666_666_66,
    0.008_333_333_333_330_936,
    -0.000_198_412_698_367_405_32,
    2.755_731_609_319_840_6e-6,
    -2.505_112_989_645_018_5e-8,
    1.591_798_897_939_743_5e-10,
];
const COS: [f64; 6] = [
    0.041_666_666_666_666_664,
    -0.001_388_888_888_888_738_9,
    2.480_158_729_875_44e-5,
    -2.755_731_726_587_808e-7,
    2.087_614_504_941_318e-9,
    -1.138_254_464_534_925e-11,
];

/// Even and odd powers apart: half as long a chain of dependent operations.
#[inline(always)]
fn polynomial<R: Register, const N: usize>(coefficients: &[f64; N], x: R) -> R {
    let x2 = x * x;
    let (mut even, mut odd) = (R::splat(coefficients[(N - 1) & !1]), R::splat(coefficients[(N - 2) | 1]));
    for i in (0..N - 2).rev() {
        if i % 2 == 0 {
            even = even * x2 + R::splat(coefficients[i]);
        } else {
            odd = odd * x2 + R::splat(coefficients[i]);
        }
    }
    even + odd * x
}

/// `x = n ln 2 + r`: (n in the lowest bits of the rounder, e^r - 1).
#[inline(always)]
fn reduced_exp<R: Register>(x: R) -> (R, R) {
    let shifted = x * R::splat(LOG2_E) + R::splat(ROUNDER);
    let n = shifted - R::splat(ROUNDER);
    let r = (x - n * R::splat(LN_2_HIGH)) - n * R::splat(LN_2_LOW);
    (shifted, r * r * polynomial(&EXP, r) + r)
}

/// 2^(n - offset) of whole numbers n, for exponents from -1022 to 1023.
#[inline(always)]
fn power_of_two<R: Register>(n: R, offset: u64) -> R {
    n.plus_bits(R::bits(EXPONENT_BIAS.wrapping_sub(offset))).shift_left::<FRACTION_BITS>()
}

#[inline(always)]
pub fn exp<R: Register>(x: R) -> R {
    // Beyond these bounds the result is zero or infinite already; NaN passes.
    let x = R::select(R::splat(710.0).lt(x), R::splat(710.0), x);
    let x = R::select(x.lt(R::splat(-746.0)), R::splat(-746.0), x);
    let (shifted, rise) = reduced_exp(x);
    // 2^n in two factors, since neither the smallest nor the largest result is 2^n times something.
    const OFFSET: u64 = 2048;
    let n = shifted.minus_bits(R::bits(ROUNDER.to_bits() - OFFSET));
    let half = n.shift_right::<1>();
    (R::splat(1.0) + rise) * power_of_two(half, OFFSET / 2) * power_of_two(n.minus_bits(half), OFFSET / 2)
}

/// By e^(2|x|) - 1, which loses nothing near zero.
#[inline(always)]
pub fn tanh<R: Register>(x: R) -> R {
    // From 22 on the result rounds to one.
    let doubled = x.abs() * R::splat(2.0);
    let doubled = R::select(R::splat(44.0).lt(doubled), R::splat(44.0), doubled);
    let (shifted, rise) = reduced_exp(doubled);
    let scale = power_of_two(shifted.minus_bits(R::splat(ROUNDER)), 0);
    let e = scale * rise + (scale - R::splat(1.0));
    (e / (e + R::splat(2.0))).or(x.sign())
}

/// With x = 2^k m, sqrt(1/2) <= m < sqrt(2), and s = (m - 1)/(m + 1): ln x = k ln 2 + 2 artanh s.
#[inline(always)]
pub fn ln<R: Register>(x: R) -> R {
    let subnormal = x.lt(R::splat(f64::MIN_POSITIVE));
    let scaled = R::select(subnormal, x * R::splat(TWO_TO_54), x);
    const ROOT_HALF: u64 = FRAC_1_SQRT_2.to_bits();
    const FRACTION: u64 = (1 << FRACTION_BITS) - 1;
    let moved = scaled.plus_bits(R::bits((EXPONENT_BIAS << FRACTION_BITS) - ROOT_HALF));
    // The biased exponent as a number: put behind the bits of 2^52, and 2^52 taken away.
    const TWO_TO_52: f64 = 4_503_599_627_370_496.0;
    let biased = moved.shift_right::<FRACTION_BITS>().or(R::splat(TWO_TO_52));
    const BIAS: f64 = TWO_TO_52 + EXPONENT_BIAS as f64;
    let k = biased - R::select(subnormal, R::splat(BIAS + 54.0), R::splat(BIAS));
    let m = moved.and(R::bits(FRACTION)).plus_bits(R::bits(ROOT_HALF));

    let f = m - R::splat(1.0);
    let s = f / (R::splat(2.0) + f);
    let s2 = s * s;
    let half_square = R::splat(0.5) * f * f;
    // 2 artanh s = f - f^2/2 + s (f^2/2 + ...), so that the leading term is exact.
    let rest = s * (half_square + s2 * polynomial(&LN, s2)) + k * R::splat(LN_2_LOW);
    let finite = k * R::splat(LN_2_HIGH) - ((half_square - rest) - f);

    let (zero, infinity) = (R::splat(0.0), R::splat(f64::INFINITY));
    let positive = R::select(x.lt(infinity), finite, infinity);
    let defined = R::select(zero.lt(x), positive, R::splat(f64::NAN));
    R::select(zero.le(x) & x.le(zero), -infinity, defined)
}

/// Sine and cosine for |x| <= [`FAR`]; beyond, [`far_sin_cos`].
#[inline(always)]
pub fn near_sin_cos<R: Register>(x: R) -> (R, R) {
    let shifted = x * R::splat(FRAC_2_PI) + R::splat(ROUNDER);
    let n = shifted - R::splat(ROUNDER);
    // The remainder as a sum of two numbers: next to a multiple of pi/2 the first alone is not exact enough.
    let coarse = x - n * R::splat(QUARTER[0]);
    let step = n * R::splat(QUARTER[1]);
    let fine = coarse - step;
    let low = ((coarse - fine) - step) - n * R::splat(QUARTER[2]);
    let r = fine + low;
    let tail = (fine - r) + low;

    let r2 = r * r;
    let half = r2 * R::splat(0.5);
    let most = R::splat(1.0) - half;
    let sine = r + (r * r2 * polynomial(&SIN, r2) + tail * most);
    let cosine = most + (((R::splat(1.0) - most) - half) + (r2 * r2 * polynomial(&COS, r2) - r * tail));

    // The lowest bit of the quadrant exchanges sine and cosine, the next one turns the sign.
    let quadrant = shifted;
    let odd = quadrant.shift_left::<63>().or(R::splat(1.0)).lt(R::splat(0.0));
    let sign = |quadrant: R| quadrant.shift_right::<1>().shift_left::<63>();
    let (s, c) = (R::select(odd, cosine, sine), R::select(odd, sine, cosine));
    (s.xor(sign(quadrant)), c.xor(sign(quadrant.plus_bits(R::bits(1)))))
}

/// Sine and cosine of any argument.
#[cold]
#[inline(never)]
pub fn far_sin_cos(x: f64) -> (f64, f64) {
    crate::portable::sin_cos(x)
}

#[inline(always)]
pub fn sin_cos(x: f64) -> (f64, f64) {
    if x.abs() > FAR {
        far_sin_cos(x)
    } else {
        near_sin_cos(x)
    }
}
