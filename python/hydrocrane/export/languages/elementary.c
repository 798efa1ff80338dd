#include <math.h>
#include <stdint.h>
#include <string.h>

#ifdef __cplusplus
#define restrict __restrict
#endif
#ifndef HYDROCRANE_FUNCTION
#define HYDROCRANE_FUNCTION static inline
#define HYDROCRANE_TABLE static const double
#endif

#ifdef HYDROCRANE_LIBM
#define hydrocrane_exp exp
#define hydrocrane_ln log
#define hydrocrane_sin sin
#define hydrocrane_cos cos
#define hydrocrane_tanh tanh
#define hydrocrane_over(x, constant) ((x) * (1.0 / (constant)))
#else
#define hydrocrane_over(x, constant) ((x) / (constant))
/* The argument is reduced to a short interval around zero, where a polynomial does the rest. No branch, no table. */
#define HC_ROUNDER 6755399441055744.0
#define HC_ROUNDER_BITS 0x4338000000000000u
#define HC_ROOT_HALF 0x3FE6A09E667F3BCDu

HYDROCRANE_FUNCTION uint64_t hc_bits(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

HYDROCRANE_FUNCTION double hc_number(uint64_t bits)
{
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* e^r - 1 with x = n ln 2 + r; n is in the lowest bits of *shifted. */
HYDROCRANE_FUNCTION double hc_reduced_exp(double x, double *shifted)
{
    *shifted = x * 1.4426950408889634 + HC_ROUNDER;
    const double n = *shifted - HC_ROUNDER;
    const double r = (x - n * 0.6931471803691238) - n * 1.9082149292705877e-10;
    const double r2 = r * r;
    const double even = (((2.7620138719733994e-07 * r2 + 2.480152119021773e-05) * r2 + 0.0013888888917281794) * r2
                         + 0.04166666666662399) * r2 + 0.5000000000000001;
    const double odd = (((2.5100424157005067e-08 * r2 + 2.7557268378684192e-06) * r2 + 0.00019841269863105968) * r2
                        + 0.008333333333330051) * r2 + 0.16666666666666669;
    return r2 * (even + odd * r) + r;
}

HYDROCRANE_FUNCTION double hydrocrane_exp(double x)
{
    double shifted;
    x = 710.0 < x ? 710.0 : x;
    x = x < -746.0 ? -746.0 : x;
    const double rise = hc_reduced_exp(x, &shifted);
    const uint64_t n = hc_bits(shifted) - (HC_ROUNDER_BITS - 2048u), half = n >> 1;
    return (1.0 + rise) * hc_number((half - 1u) << 52) * hc_number((n - half - 1u) << 52);
}

HYDROCRANE_FUNCTION double hydrocrane_tanh(double x)
{
    double shifted, doubled = fabs(x) * 2.0;
    doubled = 44.0 < doubled ? 44.0 : doubled;
    const double rise = hc_reduced_exp(doubled, &shifted);
    const double scale = hc_number((hc_bits(shifted) - HC_ROUNDER_BITS + 1023u) << 52);
    const double e = scale * rise + (scale - 1.0);
    return hc_number(hc_bits(e / (e + 2.0)) | (hc_bits(x) & 0x8000000000000000u));
}

HYDROCRANE_FUNCTION double hydrocrane_ln(double x)
{
    const int subnormal = x < 2.2250738585072014e-308;
    const double scaled = subnormal ? x * 18014398509481984.0 : x;
    const uint64_t moved = hc_bits(scaled) + (0x3FF0000000000000u - HC_ROOT_HALF);
    const double biased = hc_number((moved >> 52) | 0x4330000000000000u);
    const double k = biased - (subnormal ? 4503599627371573.0 : 4503599627371519.0);
    const double m = hc_number((moved & 0xFFFFFFFFFFFFFu) + HC_ROOT_HALF);
    const double f = m - 1.0, s = f / (2.0 + f), s2 = s * s, half_square = 0.5 * f * f;
    const double s4 = s2 * s2;
    const double even = ((0.14617807153417325 * s4 + 0.1818289243253687) * s4 + 0.28571428626253836) * s4
                        + 0.666666666666667;
    const double odd = (0.15331611722055008 * s4 + 0.22222211089379496) * s4 + 0.3999999999989889;
    const double rest = s * (half_square + s2 * (even + odd * s2)) + k * 1.9082149292705877e-10;
    const double finite = k * 0.6931471803691238 - ((half_square - rest) - f);
    const double positive = x < INFINITY ? finite : INFINITY;
    return 0.0 <= x && x <= 0.0 ? -INFINITY : 0.0 < x ? positive : NAN;
}

/* Sine, or cosine if `ahead` is 1: for |x| <= 1e6, which no joint passes. */
HYDROCRANE_FUNCTION double hc_near_sin(double x, uint64_t ahead)
{
    const double shifted = x * 0.6366197723675814 + HC_ROUNDER, n = shifted - HC_ROUNDER;
    const double coarse = x - n * 1.5707963267341256, step = n * 6.077100506303966e-11, fine = coarse - step;
    const double low = ((coarse - fine) - step) - n * 2.0222662487959506e-21;
    const double r = fine + low, tail = (fine - r) + low;
    const double r2 = r * r, half = r2 * 0.5, most = 1.0 - half, r4 = r2 * r2;
    const double sin_even = (-2.5051129896450185e-08 * r4 + -0.00019841269836740532) * r4 + -0.16666666666666666;
    const double sin_odd = (1.5917988979397435e-10 * r4 + 2.7557316093198406e-06) * r4 + 0.008333333333330936;
    const double cos_even = (2.087614504941318e-09 * r4 + 2.48015872987544e-05) * r4 + 0.041666666666666664;
    const double cos_odd = (-1.138254464534925e-11 * r4 + -2.755731726587808e-07) * r4 + -0.0013888888888887389;
    const double sine = r + (r * r2 * (sin_even + sin_odd * r2) + tail * most);
    const double cosine = most + (((1.0 - most) - half) + (r2 * r2 * (cos_even + cos_odd * r2) - r * tail));
    /* The lowest bit of the quadrant exchanges sine and cosine, the next one turns the sign. */
    const uint64_t quadrant = hc_bits(shifted) + ahead;
    return hc_number(hc_bits(quadrant & 1u ? cosine : sine) ^ ((quadrant >> 1) << 63));
}

HYDROCRANE_FUNCTION double hydrocrane_sin(double x)
{
    return fabs(x) > 1e6 ? sin(x) : hc_near_sin(x, 0);
}

HYDROCRANE_FUNCTION double hydrocrane_cos(double x)
{
    return fabs(x) > 1e6 ? cos(x) : hc_near_sin(x, 1);
}
#endif

/* How many of the ascending starts of rows are at or below a number. */
HYDROCRANE_FUNCTION int hydrocrane_place(const double *starts, int count, double x)
{
    int place = 0;
    for (int i = 0; i < count; i++)
        place += starts[i] <= x;
    return place;
}
