//! A monotone curve through given points.

use crate::Real;

/// Most points of a curve.
pub const MOST_POINTS: usize = 16;

/// A cubic in each interval, with a continuous slope: between increasing points the curve increases, and between equal
/// ones it is constant. Slopes at the points are harmonic means of those beside them, Fritsch and Butland (1984), at
/// the ends those of three points. After the last point it is linear; before the first one it must not be evaluated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MonotoneCurve {
    count: usize,
    /// Per interval its start and the coefficients of the cubic by rising power of the distance from there; the last
    /// interval is unbounded.
    rows: [[f64; 5]; MOST_POINTS],
}

crate::stored!([] MonotoneCurve { count: usize, rows: [[f64; 5]; MOST_POINTS] });

impl MonotoneCurve {
    /// Through the points (x, y) with increasing x.
    ///
    /// # Panics
    /// If there are fewer than two points, or more than [`MOST_POINTS`].
    pub fn new(points: &[[f64; 2]]) -> Self {
        assert!((2..=MOST_POINTS).contains(&points.len()), "a curve has 2 to {MOST_POINTS} points");
        let mut rows = [[0.0; 5]; MOST_POINTS];
        let slopes = slopes(points);
        for (i, ends) in points.windows(2).enumerate() {
            let h = ends[1][0] - ends[0][0];
            let mean = (ends[1][1] - ends[0][1]) / h;
            let [left, right] = [slopes[i], slopes[i + 1]];
            let square = (3.0 * mean - 2.0 * left - right) / h;
            rows[i] = [ends[0][0], ends[0][1], left, square, (left + right - 2.0 * mean) / (h * h)];
        }
        let last = points.len() - 1;
        rows[last] = [points[last][0], points[last][1], slopes[last], 0.0, 0.0];
        MonotoneCurve { count: points.len(), rows }
    }

    #[inline(always)]
    pub fn eval<T: Real>(&self, x: T) -> T {
        let [start, a0, a1, a2, a3] = x.look_up_row(
            |i| self.rows[1..self.count].get(i).map(|row| row[0]),
            #[inline(always)]
            |x| self.row(x),
        );
        let t = x - start;
        ((a3 * t + a2) * t + a1) * t + a0
    }

    #[inline(always)]
    fn row(&self, x: f64) -> [f64; 5] {
        self.rows[self.rows[1..self.count].iter().take_while(|row| row[0] <= x).count()]
    }
}

fn slopes(points: &[[f64; 2]]) -> [f64; MOST_POINTS] {
    let mut slopes = [0.0; MOST_POINTS];
    let width = |i: usize| points[i + 1][0] - points[i][0];
    let rise = |i: usize| (points[i + 1][1] - points[i][1]) / width(i);
    let last = points.len() - 1;
    if last == 1 {
        slopes[..2].fill(rise(0));
        return slopes;
    }
    for i in 1..last {
        let [before, after] = [rise(i - 1), rise(i)];
        if before * after > 0.0 {
            let [near, far] = [2.0 * width(i) + width(i - 1), width(i) + 2.0 * width(i - 1)];
            slopes[i] = (near + far) / (near / before + far / after);
        }
    }
    slopes[0] = end_slope([width(0), width(1)], [rise(0), rise(1)]);
    slopes[last] = end_slope([width(last - 1), width(last - 2)], [rise(last - 1), rise(last - 2)]);
    slopes
}

/// Slope at an end by three points, kept where the curve stays monotone; the interval at the end comes first.
fn end_slope([own, next]: [f64; 2], [rise, next_rise]: [f64; 2]) -> f64 {
    let slope = ((2.0 * own + next) * rise - own * next_rise) / (own + next);
    if slope * rise <= 0.0 {
        0.0
    } else if rise * next_rise < 0.0 && slope.abs() > 3.0 * rise.abs() {
        3.0 * rise
    } else {
        slope
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Dual;

    /// A closed zone, a fine notch, the full area, and a land that is open.
    const POINTS: [[f64; 2]; 6] = [[0.0, 0.0], [0.15, 0.0], [0.2, 0.02], [0.5, 0.2], [0.9, 1.0], [1.0, 1.0]];

    #[test]
    fn it_meets_its_points_rises_everywhere_and_has_no_kink() {
        let curve = MonotoneCurve::new(&POINTS);
        for [x, y] in POINTS {
            assert!((curve.eval(x) - y).abs() < 1e-15, "{x}");
            let side = |x: f64| curve.eval(Dual::<f64, 1>::variable(x, 0)).derivative[0];
            assert!(x == 0.0 || (side(x - 1e-9) - side(x + 1e-9)).abs() < 1e-6, "{x}");
        }
        let samples: Vec<f64> = (0..=1200).map(|i| curve.eval(f64::from(i) * 1e-3)).collect();
        assert!(samples.windows(2).all(|pair| pair[1] >= pair[0] - 1e-15), "{samples:?}");
        assert!(samples[..150].iter().all(|y| *y == 0.0) && samples[900..].iter().all(|y| (*y - 1.0).abs() < 1e-15));
    }

    #[test]
    fn two_points_make_a_straight_line() {
        let line = MonotoneCurve::new(&[[0.0, 0.0], [1.0, 1.0]]);
        for x in [0.0, 0.3, 1.0, 1.7] {
            assert!((line.eval(x) - x).abs() < 1e-15);
        }
    }

    #[test]
    fn slopes_are_those_of_the_source() {
        // By hand: widths 1 and 2, rises 1 and 4.
        let found = slopes(&[[0.0, 0.0], [1.0, 1.0], [3.0, 9.0]]);
        let middle = (5.0 + 4.0) / (5.0 / 1.0 + 4.0 / 4.0);
        assert!((found[1] - middle).abs() < 1e-15);
        assert!((found[0] - 0.0).abs() < 1e-15 && (found[2] - (8.0 * 0.0 + (5.0 * 4.0 - 2.0) / 3.0)).abs() < 1e-15);
    }
}
