//! Laws of oil and curves, with ordinary branches.

use hydrocrane_machine::model::{Cavitation, Fluid};

/// Of the oil at a gauge pressure, Pa.
pub fn bulk_modulus(f: &Fluid, p: f64) -> f64 {
    let oil = |p: f64| 0.5 * f.bulk_modulus_max * (f.bulk_c1 * p / f.bulk_reference_pressure + f.bulk_c2).log10();
    match f.cavitation {
        Cavitation::FreeGas { vacuum } if p < 0.0 => {
            let y = ((p - vacuum) / -vacuum).max(1e-9);
            let gas_share = -vacuum / oil(0.0);
            oil(0.0) * y * (y + gas_share * (1.0 - y))
        }
        _ => oil(p.abs()),
    }
}

/// A positive part, rounded within `width`.
pub fn rounded(dp: f64, width: f64) -> f64 {
    match dp {
        dp if dp <= -width => 0.0,
        dp if dp < width => (dp + width).powi(2) / (4.0 * width),
        dp => dp,
    }
}

/// A smooth rise from 0 to 1 and its slope.
pub fn flank(t: f64) -> (f64, f64) {
    match t {
        t if t <= 0.0 => (0.0, 0.0),
        t if t >= 1.0 => (1.0, 0.0),
        t => (10.0 * t.powi(3) - 15.0 * t.powi(4) + 6.0 * t.powi(5), 30.0 * (t * (1.0 - t)).powi(2)),
    }
}

/// Monotone cubics through the `points`, in Hermite's form; linear beyond them.
pub fn curve(points: &[[f64; 2]], x: f64) -> f64 {
    let n = points.len();
    let h: Vec<f64> = points.windows(2).map(|p| p[1][0] - p[0][0]).collect();
    let d: Vec<f64> = points.windows(2).map(|p| (p[1][1] - p[0][1]) / (p[1][0] - p[0][0])).collect();
    let end = |h: [f64; 2], d: [f64; 2]| match ((2.0 * h[0] + h[1]) * d[0] - h[0] * d[1]) / (h[0] + h[1]) {
        slope if slope * d[0] <= 0.0 => 0.0,
        slope if d[0] * d[1] < 0.0 && slope.abs() > 3.0 * d[0].abs() => 3.0 * d[0],
        slope => slope,
    };
    let slope = |i: usize| match i {
        _ if n == 2 => d[0],
        0 => end([h[0], h[1]], [d[0], d[1]]),
        i if i == n - 1 => end([h[n - 2], h[n - 3]], [d[n - 2], d[n - 3]]),
        i if d[i - 1] * d[i] <= 0.0 => 0.0,
        i => {
            let (before, after) = (h[i - 1] + 2.0 * h[i], 2.0 * h[i - 1] + h[i]);
            (before + after) / (before / d[i - 1] + after / d[i])
        }
    };
    if x >= points[n - 1][0] {
        return points[n - 1][1] + slope(n - 1) * (x - points[n - 1][0]);
    }
    let i = (1..n - 1).filter(|i| points[*i][0] <= x).count();
    let t = (x - points[i][0]) / h[i];
    let (rising, falling) = (t * t * (3.0 - 2.0 * t), (1.0 - t) * (1.0 - t) * (1.0 + 2.0 * t));
    falling * points[i][1]
        + rising * points[i + 1][1]
        + h[i] * t * (1.0 - t) * ((1.0 - t) * slope(i) - t * slope(i + 1))
}
