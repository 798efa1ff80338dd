//! Openings of the metering edges by curves.                   theory: docs/theory/hydraulics/metering.md
//!
//! o_e = o_N a_N f_e(s/x_N),   s = x_s of the edges that open as the piston extends, -x_s of the others, not below 0
//!
//! | symbol | meaning | unit |
//! | o_e    | opening of the edge e                                                    | m |
//! | o_N    | opening that has the nominal flow at the nominal drop: stroke less overlap | m |
//! | x_N    | stroke of the spool                                                      | m |
//! | f_e    | curve of the edge over the share of the stroke, from 0, rising           | - |
//! | a_N    | area that f_e = 1 stands for, as a share of that of the nominal flow     | - |
//!
//! Source of the curve: Fritsch and Butland (1984), in [`hydrocrane_num::functions::curve`]. Limits of validity: every edge is closed in the middle of the spool and opens in
//! one sense alone, so that no port is joined to supply and tank at once.

use hydrocrane_num::functions::curve::MonotoneCurve;
use hydrocrane_num::{functions::smooth, Real};

/// A metering edge, by what it joins. That of port B which opens as the piston extends joins B to the supply in a regenerative valve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edge {
    SupplyToA,
    AToTank,
    SupplyToB,
    BToTank,
}

/// Curves of the edges of a valve; those without one open in proportion beyond the overlap.
#[derive(Debug, Clone, Copy)]
pub struct Metering<T> {
    /// x_N, m
    pub stroke: T,
    /// o_N a_N per edge in the order of [`Edge`], m.
    pub full: [T; 4],
    pub curves: [Option<MonotoneCurve>; 4],
}

hydrocrane_num::stored!([] Metering<f64> { stroke: f64, full: [f64; 4], curves: [Option<MonotoneCurve>; 4] });

impl<T: Copy> Metering<T> {
    /// The same with `f` of every number.
    pub fn map<'a, U>(&'a self, f: &mut dyn FnMut(&'a T) -> U) -> Metering<U> {
        Metering { stroke: f(&self.stroke), full: self.full.each_ref().map(&mut *f), curves: self.curves }
    }
}

impl<T: Real> Metering<T> {
    /// Opening of an `edge`, m, with the spool displaced by `travel` (m) in the sense that opens it, and an `overlap` (m) for an edge
    /// without a curve.
    #[inline(always)]
    pub fn opening(&self, edge: Edge, travel: T, overlap: T) -> T {
        match &self.curves[edge as usize] {
            Some(curve) => self.full[edge as usize] * curve.eval(smooth::positive_part(travel) / self.stroke),
            None => smooth::positive_part(travel - overlap),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hydrocrane_num::{Dual, Field};

    fn metering() -> Metering<f64> {
        let notched = MonotoneCurve::new(&[[0.0, 0.0], [0.1, 0.0], [0.4, 0.2], [1.0, 1.0]]);
        Metering { stroke: 7e-3, full: [6e-3; 4], curves: [Some(notched), None, None, None] }
    }

    #[test]
    fn a_curve_says_the_opening_and_an_edge_without_one_has_its_overlap() {
        let m = metering();
        for (share, area) in [(-0.5, 0.0), (0.0, 0.0), (0.1, 0.0), (0.4, 0.2), (1.0, 1.0)] {
            assert!((m.opening(Edge::SupplyToA, share * 7e-3, 1e-3) - area * 6e-3).abs() < 1e-15, "{share}");
        }
        assert_eq!(m.opening(Edge::AToTank, 3e-3, 1e-3), 2e-3);
        assert_eq!(m.opening(Edge::AToTank, -3e-3, 1e-3), 0.0);
    }

    #[test]
    fn slopes_are_finite_and_join_at_the_points_and_in_the_middle() {
        let m = metering().map(&mut |x| Dual::<f64, 1>::c(*x));
        let slope = |x: f64| m.opening(Edge::SupplyToA, Dual::variable(x, 0), Dual::c(0.0)).derivative[0];
        for x in [0.0, 0.7e-3, 2.8e-3, 7e-3] {
            assert!((slope(x + 1e-12) - slope(x - 1e-12)).abs() < 1e-6 && slope(x).is_finite(), "{x}");
        }
        // Beyond the stroke, where a spool swings, it goes on.
        assert!(slope(8e-3) == slope(9e-3) && slope(8e-3) > 0.0);
    }
}
