//! Resistance of a line, alone and in series with a metering edge.   theory: docs/theory/hydraulics/line.md
//!
//! dp_l = R q + K q |q|                              laminar and turbulent                 Merritt (1967), 3-2 and 3-4
//! q = 2 dp_l / (R + sqrt(R^2 + 4 K |dp_l|))         the same, solved for the flow
//! dp_l(q) + dp_e = dp,   q = C_0 o g(dp_e)          in series with an edge
//!
//! | symbol | meaning | unit |
//! | q           | flow through the line                                          | m^3/s |
//! | dp_l, dp_e  | drops over the line and over the edge                          | Pa    |
//! | R, K        | laminar and turbulent coefficient                              | Pa s/m^3, Pa s^2/m^6 |
//! | o, C_0, g   | opening, coefficient and root of the law of [`super::orifice`] | m, ... |
//!
//! The share dp_e/dp is found by three steps of Newton's method, after which it holds to 1e-12. Limits of validity: the flow in the
//! line follows at once (no mass of the oil in it), and both coefficients are constant.

use super::orifice::Orifice;
use hydrocrane_num::Real;

parameters! {
    pub struct Resistance {
        /// R, Pa s/m^3
        laminar,
        /// K, Pa s^2/m^6
        turbulent,
    }
}

/// Steps of Newton's method.
const STEPS: usize = 3;

impl<T: Real> Resistance<T> {
    /// Pressure drop, Pa, in the direction of the flow `q` (m^3/s).
    #[inline(always)]
    pub fn drop(&self, q: T) -> T {
        q * (self.laminar + self.turbulent * q.abs())
    }

    /// Flow, m^3/s, in the direction of the drop `dp` (Pa); R must be above zero.
    #[inline(always)]
    pub fn flow(&self, dp: T) -> T {
        let root = (self.laminar.square() + self.turbulent * dp.abs() * 4.0).sqrt();
        dp * 2.0 / (self.laminar + root)
    }

    /// What the line leaves of the drop `whole` (Pa) to an `edge` of this `opening` (m, not below 0) in series with it, Pa.
    #[inline(always)]
    pub fn left(&self, edge: &Orifice<T>, opening: T, whole: T) -> T {
        // One piece of code for all edges: few machines have it.
        T::outlined(
            #[inline(always)]
            || self.share(edge, opening, whole) * whole,
        )
    }

    /// The same as a share of `whole`.
    #[inline(always)]
    fn share(&self, edge: &Orifice<T>, opening: T, whole: T) -> T {
        let (c, m) = (edge.coefficient * opening, whole.abs());
        let mut share = self.first(edge, c, m);
        for _ in 0..STEPS {
            let dp = share * m;
            let (per_drop, slope) = edge.root_per_drop(dp);
            let flow = c * per_drop;
            let open = share * (flow * self.laminar + self.turbulent * flow.square() * dp + 1.0) - 1.0;
            share -= open / (c * slope * (self.laminar + self.turbulent * flow * dp * 2.0) + 1.0);
        }
        share
    }

    /// A share to begin with, from the coefficient `c` of the edge and the whole drop `m`: exact while the edge is turbulent, else with the
    /// edge as a straight line.
    #[inline(always)]
    fn first(&self, edge: &Orifice<T>, c: T, m: T) -> T {
        let (one, four) = (T::c(1.0), T::c(4.0));
        let (by_laminar, by_turbulent) = self.terms(edge, c, m, m);
        let turbulent =
            (T::c(2.0) / (by_laminar + (by_laminar.square() + (one + by_turbulent) * four).sqrt())).square();
        let (by_laminar, by_turbulent) = self.terms(edge, c, m, (turbulent * m).min(edge.transition_pressure));
        let along = one + by_laminar;
        let straight = T::c(2.0) / (along + (along.square() + by_turbulent * four).sqrt());
        T::select((turbulent * m).lt(edge.transition_pressure), straight, turbulent)
    }

    /// Laminar and turbulent drop of the line per whole drop `m`, with the edge as it is at the drop `at`.
    #[inline(always)]
    fn terms(&self, edge: &Orifice<T>, c: T, m: T, at: T) -> (T, T) {
        let flow = c * edge.root_per_drop(at).0;
        (self.laminar * flow, self.turbulent * flow.square() * m)
    }
}

#[cfg(test)]
mod tests {
    use super::super::orifice::OrificeLaw;
    use super::*;
    use hydrocrane_num::{functions::smooth, Dual, Field};

    const P_TR: f64 = 3e5;

    fn edge() -> Orifice<f64> {
        Orifice {
            coefficient: 7.3e-7,
            transition_pressure: P_TR,
            laminar_curvature: smooth::root_curvature(P_TR),
            blend_low: 0.0,
            blend_high: 1.0,
            law: OrificeLaw::TwoRegime,
        }
    }

    #[test]
    fn its_drop_is_odd_and_the_sum_of_both_laws() {
        let line = Resistance { laminar: 2e8, turbulent: 5e11 };
        assert!((line.drop(1e-3) - (2e5 + 5e5)).abs() < 1e-6);
        assert_eq!(line.drop(-1e-3), -line.drop(1e-3));
        let slope = line.lift::<Dual<f64, 1>>().drop(Dual::variable(0.0, 0)).derivative[0];
        assert_eq!(slope, 2e8);
        for q in [-2e-3, 0.0, 1e-6, 1e-3] {
            assert!((line.flow(line.drop(q)) - q).abs() <= 1e-15, "{q}");
        }
        let slope = line.lift::<Dual<f64, 1>>().flow(Dual::variable(0.0, 0)).derivative[0];
        assert!((slope * 2e8 - 1.0).abs() < 1e-15, "{slope}");
    }

    #[test]
    fn edge_and_line_share_the_whole_drop_at_one_flow() {
        let edge = edge();
        for laminar in [0.0, 1e6, 1e9, 1e12] {
            for turbulent in [0.0, 1e9, 1e12, 1e15] {
                let line = Resistance { laminar, turbulent };
                for opening in [0.0, 1e-8, 1e-5, 1e-3, 0.05] {
                    for whole in [0.0, 1.0, 1e4, 2.9e5, 3.1e5, 40e5, 300e5, -40e5] {
                        let left = line.left(&edge, opening, whole);
                        let gap = left + line.drop(edge.flow(opening, left)) - whole;
                        assert!(gap.abs() <= 1e-11 * whole.abs(), "{laminar} {turbulent} {opening} {whole}: {gap}");
                    }
                }
            }
        }
    }

    #[test]
    fn by_hand_two_turbulent_drops_add_as_squares_of_the_flow() {
        let (edge, line) = (edge(), Resistance { laminar: 0.0, turbulent: 1e12 });
        let (opening, whole) = (0.02, 60e5);
        let by_hand = (whole / ((edge.coefficient * opening).powi(-2) + 1e12)).sqrt();
        assert!((edge.flow(opening, line.left(&edge, opening, whole)) / by_hand - 1.0).abs() < 1e-12);
    }

    #[test]
    fn slopes_are_finite_and_those_of_differences() {
        let edge = edge();
        let line = Resistance { laminar: 3e8, turbulent: 4e12 };
        let flow = |opening: f64, whole: f64| edge.flow(opening, line.left(&edge, opening, whole));
        let (lifted, on) = (edge.lift::<Dual<f64, 2>>(), line.lift::<Dual<f64, 2>>());
        for opening in [0.0, 1e-5, 0.02] {
            for whole in [0.0, 1e5, 3e5, 8e5, 60e5, -60e5] {
                let at = [Dual::variable(opening, 0), Dual::variable(whole, 1)];
                let q = lifted.flow(at[0], on.left(&lifted, at[0], at[1]));
                assert!(q.finite() && q.derivative.iter().all(|d| d.finite()), "{opening} {whole}");
                let by_whole = (flow(opening, whole + 1.0) - flow(opening, whole - 1.0)) / 2.0;
                assert!((q.derivative[1] - by_whole).abs() < 1e-5 * by_whole.abs() + 1e-18, "{opening} {whole}");
            }
        }
    }
}
