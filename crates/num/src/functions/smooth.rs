//! Functions with a root, an absolute value or a sign in them, each with a finite value and slope everywhere.
//! The laws take these from here and nowhere else.

use crate::Real;

/// exp(-700) is about 1e-304, short of the subnormal numbers.
const MOST_DECAY: f64 = 700.0;

/// `max(x, 0)`; slope 1/2 at zero, the mean of both sides, so that two opposed edges that meet there leave a slope.
#[inline(always)]
pub fn positive_part<T: Real>(x: T) -> T {
    let zero = T::c(0.0);
    T::select(zero.lt(x), x, T::select(x.lt(zero), zero, x * 0.5))
}

/// `max(x, 0)`, within `width` of zero the parabola that meets both sides with their slopes.
#[inline(always)]
pub fn rounded_positive_part<T: Real>(x: T, width: f64) -> T {
    let parabola = (x + width).square() * (0.25 / width);
    in_three(x, width, parabola, x)
}

/// Integral of [`rounded_positive_part`] from minus infinity.
#[inline(always)]
pub fn rounded_positive_integral<T: Real>(x: T, width: f64) -> T {
    let from_the_edge = x + width;
    let cubic = from_the_edge.square() * from_the_edge * (1.0 / (12.0 * width));
    in_three(x, width, cubic, x.square() * 0.5 + width * width / 6.0)
}

/// Zero below `-width`, `middle` up to `width`, `above` from there on.
#[inline(always)]
fn in_three<T: Real>(x: T, width: f64, middle: T, above: T) -> T {
    T::select(x.lt(T::c(-width)), T::c(0.0), T::select(T::c(width).lt(x), above, middle))
}

/// From zero at `x <= 0` to one at `x >= 1`, with two continuous derivatives, and the first of them.
#[inline(always)]
pub fn step<T: Real>(x: T) -> (T, T) {
    let x = x.clamp(T::c(0.0), T::c(1.0));
    let rest = T::c(1.0) - x;
    (x.square() * x * ((x * 6.0 - 15.0) * x + 10.0), x.square() * rest.square() * 30.0)
}

/// `|x|^exponent` for `exponent >= 1`, rounded off within `scale` of zero (there it is about `scale^exponent`).
#[inline(always)]
pub fn power_of_magnitude<T: Real>(x: T, exponent: T, scale: f64) -> T {
    let r2 = x * x + scale * scale;
    (r2.ln() * exponent * 0.5).exp()
}

/// `sign(x) |x|^exponent` for `exponent >= 1`: odd, exactly linear for exponent 1.
#[inline(always)]
pub fn signed_power<T: Real>(x: T, exponent: T, scale: f64) -> T {
    let r2 = x * x + scale * scale;
    x * (r2.ln() * (exponent - 1.0) * 0.5).exp()
}

/// `sign(x) |x|^(3/2)`, rounded off within `scale` of zero: [`signed_power`] by roots alone.
#[inline(always)]
pub fn signed_three_halves<T: Real>(x: T, scale: f64) -> T {
    x * (x * x + scale * scale).sqrt().sqrt()
}

/// `exp(-x)` for `x >= 0`, constant where it would be subnormal: such numbers have no effect and are slow.
#[inline(always)]
pub fn exp_neg<T: Real>(x: T) -> T {
    (-(x.min(T::c(MOST_DECAY)))).exp()
}

/// `tanh(x / width)`: a sign that passes through zero over `width`.
#[inline(always)]
pub fn soft_sign<T: Real>(x: T, width: T) -> T {
    (x / width).tanh()
}

/// `sign(x) sqrt(|x|)` where `|x| >= transition`, and below it the odd cubic-free parabola
/// `x (3 - |x|/transition) / (2 sqrt(transition))` that meets the root with equal value and slope. `curvature` is that of
/// the parabola, [`root_curvature`] of the transition.
#[inline(always)]
pub fn signed_root<T: Real>(x: T, transition: T, curvature: T) -> T {
    let magnitude = x.abs();
    let inner = x * (transition * 3.0 - magnitude) * curvature;
    // The root sees an argument of at least `transition`, so its slope stays finite in the branch not taken.
    let root = magnitude.max(transition).sqrt();
    let outer = T::select(x.lt(T::c(0.0)), -root, root);
    T::select(magnitude.lt(transition), inner, outer)
}

/// [`signed_root`] of `x >= 0` over `x`, and its slope: both finite at zero.
#[inline(always)]
pub fn root_over_argument<T: Real>(x: T, transition: T, curvature: T) -> (T, T) {
    let inner = (transition * 3.0 - x) * curvature;
    let inner_slope = (transition * 3.0 - x * 2.0) * curvature;
    let outer = T::c(1.0) / x.max(transition).sqrt();
    let laminar = x.lt(transition);
    (T::select(laminar, inner, outer), T::select(laminar, inner_slope, outer * 0.5))
}

/// `1 / (2 transition^(3/2))`
#[inline(always)]
pub fn root_curvature<T: Real>(transition: T) -> T {
    T::c(0.5) / (transition * transition.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Dual, Field};

    type D = Dual<f64, 1>;

    #[test]
    fn signed_root_meets_the_root_with_equal_value_and_slope() {
        let (p_t, curvature) = (D::c(3e5), D::c(root_curvature(3e5)));
        for sign in [-1.0, 1.0] {
            let below = signed_root(D::variable(sign * 3e5 * (1.0 - 1e-12), 0), p_t, curvature);
            let above = signed_root(D::variable(sign * 3e5 * (1.0 + 1e-12), 0), p_t, curvature);
            assert!((below.value - above.value).abs() < 1e-8 * above.value.abs());
            assert!((below.derivative[0] - above.derivative[0]).abs() < 1e-8 * above.derivative[0]);
        }
    }

    #[test]
    fn values_and_slopes_are_finite_at_every_kink() {
        for x in [0.0, -0.0, 1e-300, -1e-300, 1e3, -1e3, 1e9] {
            let v = D::variable(x, 0);
            for y in [
                positive_part(v),
                power_of_magnitude(v, D::c(2.0), 1e-9),
                power_of_magnitude(v, D::c(1.0), 1e-9),
                signed_power(v, D::c(1.5), 1e-9),
                soft_sign(v, D::c(1e-3)),
                signed_root(v, D::c(3e5), D::c(root_curvature(3e5))),
                signed_three_halves(v, 1e-9),
                exp_neg(v.abs()),
                rounded_positive_part(v, 1e-3),
                rounded_positive_integral(v, 1e-3),
                step(v).0,
                step(v).1,
            ] {
                assert!(y.value.is_finite() && y.derivative[0].is_finite(), "at {x}: {y:?}");
            }
        }
    }

    #[test]
    fn a_root_over_its_argument_is_that_of_the_signed_root() {
        let (p_t, curvature) = (3e5, root_curvature(3e5));
        for x in [1.0, 1e5, 2.999e5, 3.001e5, 4e7] {
            let root = signed_root(D::variable(x, 0), D::c(p_t), D::c(curvature));
            let (over, slope) = root_over_argument(x, p_t, curvature);
            assert!((over * x / root.value - 1.0).abs() < 1e-14 && (slope / root.derivative[0] - 1.0).abs() < 1e-14);
        }
        assert_eq!(root_over_argument(0.0, p_t, curvature), (3.0 * p_t * curvature, 3.0 * p_t * curvature));
    }

    #[test]
    fn signed_power_is_odd_and_linear_for_exponent_one() {
        for x in [1e-6, 0.3, 7.0] {
            assert_eq!(signed_power(x, 1.0, 1e-9), x);
            assert_eq!(signed_power(-x, 1.5, 1e-9), -signed_power(x, 1.5, 1e-9));
        }
        assert!((signed_power(0.04f64, 1.5, 1e-9) - 0.008).abs() < 1e-15);
        for x in [-2.0, -1e-5, 0.0, 3e-10, 0.04] {
            let (roots, power) = (signed_three_halves(x, 1e-9), signed_power(x, 1.5, 1e-9));
            assert!((roots - power).abs() <= 1e-14 * power.abs(), "{x}: {roots} {power}");
        }
    }

    #[test]
    fn a_rounded_positive_part_is_the_slope_of_its_integral_and_exact_outside_its_width() {
        for x in [-1.0, -0.2, -0.1, 0.03, 0.2, 0.5] {
            let (part, integral) = (rounded_positive_part(x, 0.2), rounded_positive_integral(D::variable(x, 0), 0.2));
            assert!((integral.derivative[0] - part).abs() < 1e-15, "{x}");
        }
        assert_eq!([-3.0, -0.2, 7.0].map(|x| rounded_positive_part(x, 0.2)), [0.0, 0.0, 7.0]);
        let edges = [-0.2, 0.2].map(|x| rounded_positive_part(D::variable(x, 0), 0.2).derivative[0]);
        assert!(edges[0] == 0.0 && (edges[1] - 1.0).abs() < 1e-15);
    }

    #[test]
    fn a_step_goes_from_zero_to_one_with_the_slope_it_states() {
        assert_eq!([-3.0, 0.0, 1.0, 2.0].map(step), [(0.0, 0.0), (0.0, 0.0), (1.0, 0.0), (1.0, 0.0)]);
        assert!((step(0.5f64).0 - 0.5).abs() < 1e-15);
        for x in [0.1, 0.5, 0.8] {
            let (value, slope) = step(D::variable(x, 0));
            assert!((value.derivative[0] - slope.value).abs() < 1e-14, "{x}");
        }
    }

    #[test]
    fn a_decay_ends_above_the_subnormal_numbers() {
        assert_eq!(exp_neg(3.0), (-3.0f64).exp());
        assert!(exp_neg(1e9f64).is_normal() && exp_neg(1e9f64) < 1e-300);
    }
}
