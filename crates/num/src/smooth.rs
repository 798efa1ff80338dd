//! Functions with a root, an absolute value or a sign in them, each with a finite value and slope everywhere.
//! The laws take these from here and nowhere else.

use crate::Real;

/// `max(x, 0)`; slope 1/2 at zero, the mean of both sides, so that two opposed edges that meet there leave a slope.
pub fn positive_part<T: Real>(x: T) -> T {
    let zero = T::c(0.0);
    T::select(zero.lt(x), x, T::select(x.lt(zero), zero, x * 0.5))
}

/// `|x|^exponent` for `exponent >= 1`, rounded off within `scale` of zero (there it is about `scale^exponent`).
pub fn power_of_magnitude<T: Real>(x: T, exponent: T, scale: f64) -> T {
    let r2 = x * x + scale * scale;
    (r2.ln() * exponent * 0.5).exp()
}

/// `sign(x) |x|^exponent` for `exponent >= 1`: odd, exactly linear for exponent 1.
pub fn signed_power<T: Real>(x: T, exponent: T, scale: f64) -> T {
    let r2 = x * x + scale * scale;
    x * (r2.ln() * (exponent - 1.0) * 0.5).exp()
}

/// `tanh(x / width)`: a sign that passes through zero over `width`.
pub fn soft_sign<T: Real>(x: T, width: T) -> T {
    (x / width).tanh()
}

/// `sign(x) sqrt(|x|)` where `|x| >= transition`, and below it the odd cubic-free parabola
/// `x (3 - |x|/transition) / (2 sqrt(transition))` that meets the root with equal value and slope.
pub fn signed_root<T: Real>(x: T, transition: T) -> T {
    let magnitude = x.abs();
    let inner = x * (T::c(3.0) - magnitude / transition) / (transition.sqrt() * 2.0);
    // The root sees an argument of at least `transition`, so its slope stays finite in the branch not taken.
    let root = magnitude.max(transition).sqrt();
    let outer = T::select(x.lt(T::c(0.0)), -root, root);
    T::select(magnitude.lt(transition), inner, outer)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Dual;

    type D = Dual<f64, 1>;

    #[test]
    fn signed_root_meets_the_root_with_equal_value_and_slope() {
        let p_t = D::c(3e5);
        for sign in [-1.0, 1.0] {
            let below = signed_root(D::variable(sign * 3e5 * (1.0 - 1e-12), 0), p_t);
            let above = signed_root(D::variable(sign * 3e5 * (1.0 + 1e-12), 0), p_t);
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
                signed_root(v, D::c(3e5)),
            ] {
                assert!(y.value.is_finite() && y.derivative[0].is_finite(), "at {x}: {y:?}");
            }
        }
    }

    #[test]
    fn signed_power_is_odd_and_linear_for_exponent_one() {
        for x in [1e-6, 0.3, 7.0] {
            assert_eq!(signed_power(x, 1.0, 1e-9), x);
            assert_eq!(signed_power(-x, 1.5, 1e-9), -signed_power(x, 1.5, 1e-9));
        }
        assert!((signed_power(0.04f64, 1.5, 1e-9) - 0.008).abs() < 1e-15);
    }
}
