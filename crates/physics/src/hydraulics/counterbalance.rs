//! Counterbalance valve between a chamber and its port of the spool valve.
//!                                                     theory: docs/theory/hydraulics/counterbalance.md
//!
//! o = (p_c + R p_x - p_s)/p_o, from 0 to 1       opening, vented: the port's own pressure does not act
//! C = C_N o                                      on the way out; on the way in a check valve without a drop
//! q = C C_e/sqrt(C^2 + C_e^2) g(dp)              through valve and metering edge in series
//!
//! | symbol | meaning | unit |
//! | p_c, p_x | pressure of the chamber, and of the other port while it is fed     | Pa |
//! | R        | pilot ratio                                                        | -  |
//! | p_s      | setting: pressure of the chamber that opens the valve by itself    | Pa |
//! | p_o      | rise beyond it that opens the valve fully                          | Pa |
//! | C, C_e   | flow per root of the pressure drop of this valve, of the edge      | m^3/(s sqrt(Pa)) |
//!
//! Source: Handroos, Halme and Vilenius (1993). Both ends of the opening are rounded within a tenth of p_o. Limits of validity: the valve follows at once, its drop is
//! turbulent, and no pressure stands between it and the edge of a closed spool.

use hydrocrane_num::{smooth, Real};

parameters! {
    pub struct Counterbalance {
        /// p_s, Pa
        setting,
        /// R
        pilot_ratio,
        /// p_o, Pa
        opening_pressure,
        /// C_N, m^3/(s sqrt(Pa))
        coefficient,
    }
}

/// Share of the opening within which its ends are rounded.
const ROUNDING: f64 = 0.1;
/// Share of the coefficient that keeps the slope of a series of two closed edges finite.
const LEAST: f64 = 1e-9;

impl<T: Real> Counterbalance<T> {
    /// Opening, 0 to 1, at the pressures of the chamber and of the `pilot` (Pa).
    #[inline(always)]
    pub fn opening(&self, chamber: T, pilot: T) -> T {
        let share = (chamber + self.pilot_ratio * pilot - self.setting) / self.opening_pressure;
        smooth::rounded_positive_part(share, ROUNDING) - smooth::rounded_positive_part(share - T::c(1.0), ROUNDING)
    }

    /// Flow per root of the drop, m^3/(s sqrt(Pa)), of this valve at an `opening` in series with an edge of coefficient `edge`.
    #[inline(always)]
    pub fn in_series(&self, opening: T, edge: T) -> T {
        let (own, least) = (self.coefficient * opening, self.coefficient * LEAST);
        own * edge / (own.square() + edge.square() + least.square()).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hydrocrane_num::{Dual, Field};

    const VALVE: Counterbalance<f64> =
        Counterbalance { setting: 200e5, pilot_ratio: 4.0, opening_pressure: 40e5, coefficient: 1e-7 };

    #[test]
    fn the_pilot_opens_with_its_ratio_and_the_load_alone_at_the_setting() {
        assert_eq!(VALVE.opening(150e5, 0.0), 0.0);
        // 200 - 120 bar are left to the pilot: 20 bar at a ratio of 4.
        assert_eq!(VALVE.opening(120e5, 19e5 - 1e5), 0.0);
        assert!((VALVE.opening(120e5, 25e5) - 0.5).abs() < 1e-12);
        assert!((VALVE.opening(220e5, 0.0) - 0.5).abs() < 1e-12);
        assert_eq!(VALVE.opening(260e5, 10e5), 1.0);
    }

    #[test]
    fn two_edges_in_series_share_the_drop() {
        // Equal coefficients leave half the drop to each: the flow falls by the root of two.
        assert!((VALVE.in_series(1.0, 1e-7) * 2f64.sqrt() / 1e-7 - 1.0).abs() < 1e-12);
        assert!((VALVE.in_series(1.0, 1e-12) / 1e-12 - 1.0).abs() < 1e-6);
        assert_eq!(VALVE.in_series(0.0, 1e-7), 0.0);
        assert_eq!(VALVE.in_series(1.0, 0.0), 0.0);
    }

    #[test]
    fn slopes_are_finite_where_both_are_closed() {
        let valve = VALVE.lift::<Dual<f64, 2>>();
        let series = valve.in_series(Dual::variable(0.0, 0), Dual::variable(0.0, 1));
        assert!(series.value == 0.0 && series.derivative.iter().all(|d| d.finite()));
        for share in [-ROUNDING, ROUNDING, 1.0 - ROUNDING, 1.0 + ROUNDING] {
            let at = |offset: f64| valve.opening(Dual::variable(200e5 + 40e5 * share + offset, 0), Dual::c(0.0));
            let (before, after) = (at(-1.0), at(1.0));
            assert!((before.value - after.value).abs() < 1e-6);
            assert!((before.derivative[0] - after.derivative[0]).abs() < 1e-6 / 40e5 * 10.0);
        }
    }
}
