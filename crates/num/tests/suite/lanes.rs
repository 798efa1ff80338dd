//! A lane gives the bits of `f64` in every instruction set, whatever its neighbours hold, and duals go over lanes.

use hydrocrane_num::lanes::register::Register;
use hydrocrane_num::{Dual, Field, Lanes, RandomStream, Real};

const W: usize = 8;

/// Calls a test with every register of this processor.
macro_rules! in_every_register {
    ($test:ident) => {{
        $test::<f64>();
        #[cfg(target_arch = "x86_64")]
        {
            use hydrocrane_num::lanes::register_x86::{Avx2, Avx512, Sse2};
            Sse2::run(|| $test::<Sse2>());
            if Avx2::is_available() {
                Avx2::run(|| $test::<Avx2>());
            }
            if Avx512::is_available() {
                Avx512::run(|| $test::<Avx512>());
            }
        }
    }};
}

/// Values of every kind in every lane.
fn groups() -> Vec<[f64; W]> {
    let edges = [0.0, -0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 5e-324, -1e-310, 1e300, -745.1, 1.0, -2e6, 0.5];
    let mut random = RandomStream::new(11, "lanes");
    let mut value = |i: usize| match edges.get(i % 17) {
        Some(edge) => *edge,
        None => random.symmetric() * 10f64.powi(i as i32 % 7 - 2),
    };
    (0..200).map(|g| std::array::from_fn(|i| value(g * W + i))).collect()
}

fn assert_lanes<R: Register>(name: &str, lanes: Lanes<R>, of: impl Fn(usize) -> f64) {
    let mut numbers = [0.0; W];
    lanes.store(&mut numbers);
    for (i, &a) in numbers[..R::WIDTH].iter().enumerate() {
        let b = of(i);
        let set = R::NAME;
        assert!(a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()), "{name} in {set}, lane {i}: {a} {b}");
    }
}

#[test]
fn every_operation_of_a_lane_is_that_of_a_number() {
    in_every_register!(operations);
}

fn operations<R: Register>() {
    let groups = groups();
    for pair in groups.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let (x, y) = (Lanes::<R>::load(&a), Lanes::<R>::load(&b));
        macro_rules! same {
            ($($name:literal: $p:ident, $q:ident => $operation:expr;)*) => {$(
                let lanes = { let ($p, $q) = (x, y); let _ = $q; $operation };
                assert_lanes($name, lanes, |i| { let ($p, $q) = (a[i], b[i]); let _ = $q; $operation });
            )*};
        }
        same! {
            "sum": p, q => p + q;
            "difference": p, q => p - q;
            "product": p, q => p * q;
            "quotient": p, q => p / q;
            "sum with a constant": p, q => p + 0.1;
            "difference with a constant": p, q => p - 0.1;
            "product with a constant": p, q => p * 0.1;
            "quotient by a constant": p, q => p / 0.3;
            "negative": p, q => -p;
            "root": p, q => Real::sqrt(p);
            "exp": p, q => Real::exp(p);
            "ln": p, q => Real::ln(p);
            "sine": p, q => Real::sin_cos(p).0;
            "cosine": p, q => Real::sin_cos(p).1;
            "tanh": p, q => Real::tanh(p);
            "magnitude": p, q => Real::abs(p);
            "smaller": p, q => Real::min(p, q);
            "larger": p, q => Real::max(p, q);
            "look-up": p, q => Real::look_up_row(p, |_| None, |v| [if v < 0.5 { 3.0 } else { v }])[0];
        }
    }
}

#[test]
fn masks_choose_lane_by_lane() {
    in_every_register!(masks);
}

fn masks<R: Register>() {
    for pair in groups().windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let (x, y) = (Lanes::<R>::load(&a), Lanes::<R>::load(&b));
        let (lt, le) = (Real::lt(x, y), Real::le(x, y));
        let zero = Lanes::<R>::c(0.0);
        assert_lanes("less", Lanes::<R>::select(lt, x, y), |i| if a[i] < b[i] { a[i] } else { b[i] });
        assert_lanes("equal", Lanes::<R>::select(le & !lt, x, zero), |i| if a[i] == b[i] { a[i] } else { 0.0 });
        assert_lanes("either", Lanes::<R>::select(lt | le, x, y), |i| if a[i] <= b[i] { a[i] } else { b[i] });
    }
}

#[test]
fn duals_over_lanes_have_the_slopes_of_duals_over_numbers() {
    in_every_register!(duals);
}

fn duals<R: Register>() {
    fn law<T: Real>(x: T, y: T) -> T {
        let (s, c) = (x * y).sin_cos();
        let kinked = T::select(x.lt(y), x.abs() * c, y.exp() - s);
        (kinked.tanh() + (x * x + 0.5).ln()) / (y * y + 2.0).sqrt()
    }
    for pair in groups().windows(2) {
        let lanes = law(
            Dual::<Lanes<R>, 2>::variable(Lanes::<R>::load(&pair[0]), 0),
            Dual::variable(Lanes::<R>::load(&pair[1]), 1),
        );
        let one = |i: usize| law(Dual::<f64, 2>::variable(pair[0][i], 0), Dual::variable(pair[1][i], 1));
        assert_lanes("value", lanes.value, |i| one(i).value);
        for d in 0..2 {
            assert_lanes("slope", lanes.derivative[d], |i| one(i).derivative[d]);
        }
    }
}
