//! The elementary functions against those of the standard library, and at their edges.

use hydrocrane_num::lanes::elementary;
use hydrocrane_num::RandomStream;

/// Distance in units of the last place of the reference.
fn ulps(value: f64, reference: f64) -> f64 {
    let unit = f64::from_bits(reference.abs().to_bits() + 1) - reference.abs();
    (value - reference).abs() / unit
}

/// Largest distance over many arguments between the bounds, some of them crowded about zero.
fn worst(f: impl Fn(f64) -> f64, reference: impl Fn(f64) -> f64, [low, high]: [f64; 2]) -> f64 {
    let mut random = RandomStream::new(3, "arguments");
    let arguments = (0..300_000).flat_map(|_| {
        let x = low + (high - low) * random.uniform();
        [x, x * random.uniform().powi(20)]
    });
    let inside = arguments.filter(|x| (low..=high).contains(x));
    inside.map(|x| ulps(f(x), reference(x))).fold(0.0, f64::max)
}

#[test]
fn functions_agree_with_the_standard_ones_to_the_last_places() {
    let ranges = [[-708.0, 709.7], [-1.0, 1.0], [0.0, f64::MAX], [0.0, 2.0], [-30.0, 30.0], [-1e6, 1e6]];
    let cases: [(&str, f64); 8] = [
        ("exp", worst(elementary::exp, f64::exp, ranges[0])),
        ("exp near zero", worst(elementary::exp, f64::exp, ranges[1])),
        ("ln", worst(elementary::ln, f64::ln, ranges[2])),
        ("ln near one", worst(elementary::ln, f64::ln, ranges[3])),
        ("tanh", worst(elementary::tanh, f64::tanh, ranges[4])),
        ("tanh near zero", worst(elementary::tanh, f64::tanh, ranges[1])),
        ("sine", worst(|x| elementary::sin_cos(x).0, f64::sin, ranges[5])),
        ("cosine", worst(|x| elementary::sin_cos(x).1, f64::cos, ranges[5])),
    ];
    for (name, error) in cases {
        // Errors of both sides add up: less than one unit each, two of both for tanh.
        let bound = if name.starts_with("tanh") { 4.0 } else { 2.0 };
        assert!(error <= bound, "{name}: {error}");
    }
}

#[test]
fn next_to_multiples_of_a_quarter_turn_nothing_cancels() {
    for i in 1..600_000 {
        let x = f64::from(i) * std::f64::consts::FRAC_PI_2;
        for x in [x, f64::from_bits(x.to_bits() + 1)] {
            let (s, c) = elementary::sin_cos(x);
            assert!(ulps(s, x.sin()) <= 2.0 && ulps(c, x.cos()) <= 2.0, "{x}");
        }
    }
}

/// Equal bits, or both not a number.
fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

#[test]
fn edges_are_those_of_the_standard_functions() {
    let edges = [0.0, -0.0, 1.0, -1.0, f64::INFINITY, f64::NEG_INFINITY, f64::NAN, 1e300, -1e300, 800.0, -800.0];
    for x in edges {
        assert!(same(elementary::tanh(x), x.tanh()) || x.abs() == 1.0, "tanh {x}");
        assert!(same(elementary::ln(x), x.ln()) || x == 1e300, "ln {x}");
        assert!(same(elementary::exp(x), x.exp()) || x.abs() == 1.0, "exp {x}");
        let (ours, theirs) = (elementary::sin_cos(x), x.sin_cos());
        assert!(ulps(ours.0, theirs.0) <= 1.0 || same(ours.0, theirs.0), "sin {x}");
        assert!(ulps(ours.1, theirs.1) <= 1.0 || same(ours.1, theirs.1), "cos {x}");
    }
}

#[test]
fn subnormal_numbers_are_numbers() {
    for x in [5e-324, 1e-310, f64::MIN_POSITIVE] {
        assert!(ulps(elementary::ln(x), x.ln()) <= 1.0, "{x}");
        assert_eq!(elementary::tanh(x), x);
        assert_eq!(elementary::exp(x), 1.0);
    }
    for x in [-708.5, -720.0, -744.0, -745.2] {
        assert!((elementary::exp(x) - x.exp()).abs() <= 1e-323, "{x}");
    }
    assert_eq!(elementary::exp(-746.0), 0.0);
    assert_eq!(elementary::exp(709.79), f64::INFINITY);
    assert!(elementary::exp(709.78).is_finite());
}
