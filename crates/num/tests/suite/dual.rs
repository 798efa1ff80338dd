//! Dual numbers against symbolic derivatives, and against themselves nested.

use hydrocrane_num::{Dual, Real};

fn f<T: Real>(x: T, y: T) -> T {
    let (s, c) = (x * y).sin_cos();
    (x * s + y.exp() / (x * x + 1.0)).tanh() + (y * y + 2.0).sqrt() * c - (x * x + 0.5).ln() * y.abs() - x / y
}

/// x, y, and what SymPy gives for `f`, `diff(f, x)` and `diff(f, y)` there, rounded from 20 digits.
const SYMBOLIC: [[f64; 5]; 3] = [
    [0.3, -1.2, 2.7879947607693256, -1.9883238746547167, -0.3785529135510604],
    [2.0, 0.7, -2.6589943601540345, -3.1085665929193813, -0.420149180353788],
    [-1.5, -0.1, -13.645134003843838, 10.683396736335679, -146.24455116003006],
];

#[test]
fn agrees_with_symbolic_derivatives() {
    for [x, y, value, along_x, along_y] in SYMBOLIC {
        let found = f(Dual::<f64, 2>::variable(x, 0), Dual::variable(y, 1));
        assert!((found.value - value).abs() < 1e-14 * (1.0 + value.abs()), "{} {value}", found.value);
        for (derivative, exact) in found.derivative.into_iter().zip([along_x, along_y]) {
            assert!((derivative - exact).abs() < 1e-13 * (1.0 + exact.abs()), "{derivative} {exact}");
        }
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
