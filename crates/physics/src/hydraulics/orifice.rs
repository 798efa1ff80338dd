//! Flow through one metering edge.                             theory: docs/theory/hydraulics/orifice.md
//!
//! q = C_0 x_s g(dp)                                                             thesis (64)-(74)
//! g = sign(dp) sqrt|dp|                               |dp| >= p_tr  (turbulent)
//! g = dp (3 - |dp|/p_tr) / (2 sqrt p_tr)              |dp| <  p_tr  (laminar, joins with equal slope)
//! C_0 = Q_N / ((x_max - overlap) sqrt(dp_N per edge))                           thesis (65), where the overlap is zero
//!
//! | symbol | meaning | unit |
//! | q      | volume flow in the direction of falling pressure | m^3/s |
//! | x_s    | opening of the edge, >= 0                        | m     |
//! | dp     | pressure drop                                    | Pa    |
//!
//! Departs from the source: the thesis's laminar law is quadratic and its program lost the "3 -" (E3), which also leaves
//! a jump by two at p_tr on five of the six ports (E4). [`printed_root`] is that law, for reproduction.

use hydrocrane_num::{functions::smooth, Real};

/// Share of the opening within which its ends are rounded.
pub const ROUNDING: f64 = 0.1;
/// Share of the coefficient that keeps the slope of a series of two closed edges finite.
pub const LEAST: f64 = 1e-9;

parameters! {
    pub struct Orifice {
        /// C_0, m^2 sqrt(m/kg): flow per opening and root of pressure.
        coefficient,
        /// Pa
        transition_pressure,
        /// 1/(2 p_tr^(3/2)), [`smooth::root_curvature`] of the transition pressure, Pa^(-3/2).
        laminar_curvature,
        /// Thresholds of the printed blend (74), Pa.
        blend_low,
        blend_high,
        ;
        law: OrificeLaw,
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OrificeLaw {
    TwoRegime,
    /// As printed: quadratic below the threshold; `blended` says whether the transition (74) is reached.
    Printed {
        blended: bool,
    },
}

hydrocrane_num::stored!([] enum OrificeLaw { 0: TwoRegime {}, 1: Printed { blended: bool } });

impl<T: Real> Orifice<T> {
    /// m^3/s through an edge of `opening` (m) under the pressure drop `dp` (Pa).
    pub fn flow(&self, opening: T, dp: T) -> T {
        opening * self.flow_per_opening(dp)
    }

    /// C_0 g(dp), m^2/s
    #[inline(always)]
    pub fn flow_per_opening(&self, dp: T) -> T {
        let root = match self.law {
            OrificeLaw::TwoRegime => smooth::signed_root(dp, self.transition_pressure, self.laminar_curvature),
            OrificeLaw::Printed { blended } => self.printed_root(dp, blended),
        };
        self.coefficient * root
    }

    /// g(dp)/dp, 1/sqrt(Pa), and the slope of g at a drop `dp` (Pa) not below 0, by the corrected law.
    #[inline(always)]
    pub fn root_per_drop(&self, dp: T) -> (T, T) {
        smooth::root_over_argument(dp, self.transition_pressure, self.laminar_curvature)
    }

    #[inline(always)]
    fn printed_root(&self, dp: T, blended: bool) -> T {
        let p_tr = self.transition_pressure;
        let magnitude = dp.abs();
        let root = magnitude.max(T::c(1e-12)).sqrt();
        let turbulent = T::select(dp.lt(T::c(0.0)), -root, root);
        let quadratic = dp * (magnitude / p_tr) / (p_tr.sqrt() * 2.0);
        if !blended {
            return T::select(magnitude.lt(p_tr), quadratic, turbulent);
        }
        let weight = ((magnitude - self.blend_low) / (self.blend_high - self.blend_low)).abs();
        let blend = weight * turbulent + (T::c(1.0) - weight) * quadratic;
        let outer = T::select(magnitude.lt(self.blend_high), blend, turbulent);
        T::select(magnitude.lt(self.blend_low), quadratic, outer)
    }
}

/// An opening from 0 to 1 with rounded ends, from the `share` of the pressure that opens fully.
#[inline(always)]
pub fn share_of_opening<T: Real>(share: T) -> T {
    smooth::rounded_positive_part(share, ROUNDING) - smooth::rounded_positive_part(share - T::c(1.0), ROUNDING)
}

/// Flow per root of the drop over two edges in series, m^3/(s sqrt(Pa)), from that over each; both may be closed down to `least`.
#[inline(always)]
pub fn in_series<T: Real>(own: T, edge: T, least: T) -> T {
    own * edge / (own.square() + edge.square() + least.square()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use hydrocrane_num::{Dual, Field};

    fn edge(law: OrificeLaw) -> Orifice<f64> {
        Orifice {
            coefficient: 1e-4 / (0.05 * 75e5f64.sqrt()),
            transition_pressure: 3e5,
            laminar_curvature: smooth::root_curvature(3e5),
            blend_low: 2e5,
            blend_high: 4e5,
            law,
        }
    }

    #[test]
    fn nominal_flow_at_nominal_pressure_drop() {
        assert!((edge(OrificeLaw::TwoRegime).flow(0.05, 75e5) / 1e-4 - 1.0).abs() < 1e-14);
    }

    #[test]
    fn flow_is_odd_and_its_slope_at_zero_finite() {
        let e = edge(OrificeLaw::TwoRegime);
        for dp in [0.0, 1e4, 2.9e5, 3.1e5, 80e5] {
            assert_eq!(e.flow(0.02, -dp), -e.flow(0.02, dp));
        }
        let slope = e.lift::<Dual<f64, 1>>().flow(Dual::c(0.02), Dual::variable(0.0, 0)).derivative[0];
        assert!((slope - e.coefficient * 0.02 * 1.5 / 3e5f64.sqrt()).abs() < 1e-20);
    }

    #[test]
    fn printed_law_gives_the_flows_of_erratum_3_and_the_jump_of_erratum_4() {
        let jumping = edge(OrificeLaw::Printed { blended: false });
        let per_opening = |e: &Orifice<f64>, bar: f64| e.flow(1.0, bar * 1e5) / e.coefficient;
        for (bar, printed, smooth) in [(1.0, 30.0, 243.0), (2.0, 122.0, 426.0)] {
            assert!((per_opening(&jumping, bar) - printed).abs() < 1.0);
            assert!((per_opening(&edge(OrificeLaw::TwoRegime), bar) - smooth).abs() < 1.0);
        }
        let jump = per_opening(&jumping, 3.0) / per_opening(&jumping, 3.0 - 1e-9);
        assert!((jump - 2.0).abs() < 1e-6);
        let blended = edge(OrificeLaw::Printed { blended: true });
        let smooth_there = per_opening(&blended, 3.0) / per_opening(&blended, 3.0 - 1e-9);
        assert!((smooth_there - 1.0).abs() < 1e-6);
    }
}
