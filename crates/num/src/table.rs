//! One-dimensional tables with known derivatives.

use crate::Real;

/// A function on a uniform grid, interpolated by the quintic through value, slope and curvature at both knots
/// (error of sixth order in the spacing, twice continuously differentiable). Outside the grid it goes on straight.
#[derive(Debug, Clone)]
pub struct QuinticTable {
    start: f64,
    spacing: f64,
    /// Value, slope, curvature per knot.
    knots: Vec<[f64; 3]>,
}

impl QuinticTable {
    /// `knots[i]` holds value, slope and curvature at `start + i spacing`; at least two knots.
    pub fn new(start: f64, spacing: f64, knots: Vec<[f64; 3]>) -> Self {
        assert!(knots.len() >= 2 && spacing > 0.0, "a table needs two knots and a positive spacing");
        QuinticTable { start, spacing, knots }
    }

    #[inline(always)]
    pub fn eval<T: Real>(&self, x: T) -> T {
        let h = self.spacing;
        let last = self.knots.len() - 1;
        let position = (x - self.start) / h;
        let inside = position.clamp(T::c(0.0), T::c(last as f64));
        let i = inside.look_up(|p| (p as usize).min(last - 1) as f64);
        let s = inside - i;
        // Taylor part at the left knot, then the three terms that fit the right knot.
        let rise = self.of(i, |a, b| b[0] - a[0] - a[1] * h - 0.5 * (a[2] * h * h));
        let turn = self.of(i, |a, b| b[1] * h - a[1] * h - a[2] * h * h);
        let bend = self.of(i, |a, b| b[2] * h * h - a[2] * h * h);
        let (f0, d0, c0) = (self.of(i, |a, _| a[0]), self.of(i, |a, _| a[1] * h), self.of(i, |a, _| a[2] * h * h));
        let a3 = rise * 10.0 - turn * 4.0 + bend * 0.5;
        let a4 = rise * -15.0 + turn * 7.0 - bend;
        let a5 = rise * 6.0 - turn * 3.0 + bend * 0.5;
        let polynomial = ((((s * a5 + a4) * s + a3) * s + c0 * 0.5) * s + d0) * s + f0;
        let edge_slope = position.look_up(|p| if p <= 0.0 { self.knots[0][1] } else { self.knots[last][1] });
        polynomial + (position - inside) * h * edge_slope
    }

    /// What `f` says of the knots to the left and right of interval `i`.
    #[inline(always)]
    fn of<T: Real>(&self, i: T, f: impl Fn(&[f64; 3], &[f64; 3]) -> f64) -> T {
        i.look_up(|i| f(&self.knots[i as usize], &self.knots[i as usize + 1]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Dual;

    fn table() -> QuinticTable {
        let knots = (0..=20).map(|i| 0.1 * i as f64).map(|x: f64| [x.exp(), x.exp(), x.exp()]).collect();
        QuinticTable::new(0.0, 0.1, knots)
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
