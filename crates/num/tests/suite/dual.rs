//! Dual numbers against num-dual, an independent implementation, and against themselves nested.

use hydrocrane_num::{Dual, Real};
use num_dual::{Dual64, DualNum};

fn ours<T: Real>(x: T, y: T) -> T {
    let (s, c) = (x * y).sin_cos();
    (x * s + y.exp() / (x * x + 1.0)).tanh() + (y * y + 2.0).sqrt() * c - (x * x + 0.5).ln() * y.abs() - x / y
}

fn theirs(x: Dual64, y: Dual64) -> Dual64 {
    let (s, c) = (x * y).sin_cos();
    let abs_y = if y.re < 0.0 { -y } else { y };
    (x * s + y.exp() / (x * x + 1.0)).tanh() + (y * y + 2.0).sqrt() * c - (x * x + 0.5).ln() * abs_y - x / y
}

#[test]
fn agrees_with_num_dual() {
    for (x, y) in [(0.3, -1.2), (2.0, 0.7), (-1.5, -0.1)] {
        let f = ours(Dual::<f64, 2>::variable(x, 0), Dual::variable(y, 1));
        let along_x = theirs(Dual64::from(x).derivative(), Dual64::from(y));
        let along_y = theirs(Dual64::from(x), Dual64::from(y).derivative());
        assert!((f.value - along_x.re).abs() < 1e-14 * (1.0 + f.value.abs()));
        assert!((f.derivative[0] - along_x.eps).abs() < 1e-13 * (1.0 + along_x.eps.abs()));
        assert!((f.derivative[1] - along_y.eps).abs() < 1e-13 * (1.0 + along_y.eps.abs()));
    }
}

#[test]
fn nests_to_second_derivatives() {
    type D2 = Dual<Dual<f64, 1>, 1>;
    let x = D2 { value: Dual::variable(0.4, 0), derivative: [Dual::constant(1.0)] };
    let y = (x * x * x).exp();
    let e = (0.4f64 * 0.4 * 0.4).exp();
    let exact = e * (9.0 * 0.4f64.powi(4) + 6.0 * 0.4);
    assert!((y.derivative[0].derivative[0] - exact).abs() < 1e-13);
}

#[test]
fn tanh_has_a_finite_slope_everywhere() {
    for x in [0.0, 300.0, -800.0, 1e6] {
        let t = Dual::<f64, 1>::variable(x, 0).tanh();
        assert!(t.value.is_finite() && t.derivative[0].is_finite());
    }
}
