//! Where a function is zero.

/// Most evaluations: halving alone needs about 60 for a number's last digit, and every third step at least halves.
const BUDGET: usize = 200;

/// A zero of `f` between `a` and `b`, to `tolerance`, by inverse quadratic interpolation or halving. Source: Chandrupatla (1997).
/// Where `f` has one sign at both ends, or is no number, that end at which it is nearer to zero.
pub fn root(mut a: f64, mut b: f64, tolerance: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
    let (mut fa, mut fb) = (f(a), f(b));
    if fa * fb > 0.0 || !(fa * fb).is_finite() {
        return if fa.abs() < fb.abs() { a } else { b };
    }
    let mut share = 0.5_f64;
    for _ in 0..BUDGET {
        let best = if fa.abs() < fb.abs() { a } else { b };
        let least = 0.5 * tolerance.max(4.0 * f64::EPSILON * best.abs()) / (b - a).abs();
        if fa == 0.0 || fb == 0.0 || least > 0.5 {
            return best;
        }
        let x = a + share.clamp(least, 1.0 - least) * (b - a);
        let fx = f(x);
        let (c, fc);
        if (fx > 0.0) == (fa > 0.0) {
            (c, fc) = (a, fa);
        } else {
            (c, fc, b, fb) = (b, fb, a, fa);
        }
        (a, fa) = (x, fx);
        let (xi, phi) = ((a - b) / (c - b), (fa - fb) / (fc - fb));
        let smooth = phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi;
        share = if smooth {
            fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        } else {
            0.5
        };
    }
    if fa.abs() < fb.abs() {
        a
    } else {
        b
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_zeros_of_smooth_kinked_and_jumping_functions_in_few_evaluations() {
        type Case = (fn(f64) -> f64, f64, usize);
        let cases: [Case; 4] = [
            (|x| x * x * x - 2.0, 1.259_921_049_894_873, 20),
            (|x| (x - 3.0).max(0.0) - 1e-3, 3.001, 60),
            (|x| if x < 2.0 { -1.0 } else { 1e3 }, 2.0, 120),
            (|x| 5.0 - x, 5.0, 6),
        ];
        for (f, wanted, most) in cases {
            let mut count = 0;
            let found = root(0.0, 100.0, 1e-10, |x| {
                count += 1;
                f(x)
            });
            assert!((found - wanted).abs() < 1e-9 && count <= most, "{found} {wanted} after {count}");
        }
    }

    #[test]
    fn without_a_change_of_sign_the_end_nearer_to_zero() {
        assert_eq!(root(1.0, 2.0, 1e-9, |x| x), 1.0);
        assert_eq!(root(-2.0, -1.0, 1e-9, |x| x), -1.0);
    }
}
