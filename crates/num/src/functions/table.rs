//! One-dimensional tables with known derivatives.

use crate::Real;

/// A function on a uniform grid, interpolated by the quintic through value, slope and curvature at both knots
/// (error of sixth order in the spacing, twice continuously differentiable). Outside the grid it is linear.
#[derive(Debug, Clone)]
pub struct QuinticTable {
    start: f64,
    spacing: f64,
    /// Coefficients of the polynomial in each interval, by rising power of the share of the interval.
    intervals: Vec<[f64; 6]>,
    /// Slopes at both ends.
    edges: [f64; 2],
}

impl QuinticTable {
    /// `knots[i]` holds value, slope and curvature at `start + i spacing`; at least two knots.
    pub fn new(start: f64, spacing: f64, knots: &[[f64; 3]]) -> Self {
        assert!(knots.len() >= 2 && spacing > 0.0, "a table needs two knots and a positive spacing");
        let intervals = knots.windows(2).map(|ends| interval(spacing, &ends[0], &ends[1])).collect();
        QuinticTable { start, spacing, intervals, edges: [knots[0][1], knots[knots.len() - 1][1]] }
    }

    #[inline(always)]
    pub fn eval<T: Real>(&self, x: T) -> T {
        let last = self.intervals.len() - 1;
        let position = (x - self.start) / self.spacing;
        let inside = position.clamp(T::c(0.0), T::c(self.intervals.len() as f64));
        // In one go: each lane reads a row. Below the first one, the slope at its edge is another.
        let first = f64::from_bits(1);
        let [i, edge_slope, a0, a1, a2, a3, a4, a5] = position.look_up_row(
            |i| if i == 0 { Some(first) } else { (i <= last).then_some(i as f64) },
            #[inline(always)]
            |p| {
                let i = (p as usize).min(last);
                let [a0, a1, a2, a3, a4, a5] = self.intervals[i];
                [i as f64, self.edges[usize::from(p > 0.0)], a0, a1, a2, a3, a4, a5]
            },
        );
        let s = inside - i;
        let polynomial = ((((s * a5 + a4) * s + a3) * s + a2) * s + a1) * s + a0;
        polynomial + (position - inside) * self.spacing * edge_slope
    }
}

/// The Taylor part at the left knot, then the three terms that fit the right knot.
fn interval(h: f64, left: &[f64; 3], right: &[f64; 3]) -> [f64; 6] {
    let rise = right[0] - left[0] - left[1] * h - 0.5 * (left[2] * h * h);
    let turn = right[1] * h - left[1] * h - left[2] * h * h;
    let bend = right[2] * h * h - left[2] * h * h;
    [
        left[0],
        left[1] * h,
        left[2] * h * h * 0.5,
        rise * 10.0 - turn * 4.0 + bend * 0.5,
        rise * -15.0 + turn * 7.0 - bend,
        rise * 6.0 - turn * 3.0 + bend * 0.5,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Dual;

    fn table() -> QuinticTable {
        let knots = (0..=20).map(|i| 0.1 * i as f64).map(|x: f64| [x.exp(); 3]).collect::<Vec<_>>();
        QuinticTable::new(0.0, 0.1, &knots)
    }

    #[test]
    fn interpolates_to_sixth_order_with_its_slope() {
        for x in [0.0, 0.03, 0.77, 1.999, 2.0] {
            let y = table().eval(Dual::<f64, 1>::variable(x, 0));
            assert!((y.value / x.exp() - 1.0).abs() < 1e-10);
            assert!((y.derivative[0] / x.exp() - 1.0).abs() < 1e-7);
        }
    }

    #[test]
    fn goes_on_straight_outside() {
        let e2 = 2f64.exp();
        assert!((table().eval(3.0) - 2.0 * e2).abs() < 1e-12);
        assert!((table().eval(-1.0) - 0.0).abs() < 1e-12);
    }
}
