//! Counterbalance valve between a chamber and its port of the spool valve.
//!                                                     theory: docs/theory/hydraulics/counterbalance.md
//!
//! o = (p_c + R p_x - p_s)/p_o, from 0 to 1       opening, vented: the port's own pressure does not act
//! C = C_N o                                      on the way out; on the way in a check valve without a drop
//!
//! | symbol | meaning | unit |
//! | p_c, p_x | pressure of the chamber, and of the other port while it is fed     | Pa |
//! | R        | pilot ratio                                                        | -  |
//! | p_s      | setting: pressure of the chamber that opens the valve by itself    | Pa |
//! | p_o      | rise beyond it that opens the valve fully                          | Pa |
//! | C, C_N   | flow per root of the pressure drop, that of the open valve         | m^3/(s sqrt(Pa)) |
//!
//! Source: Handroos, Halme and Vilenius (1993). Both ends of the opening are rounded within a tenth of p_o. Limits of validity: the
//! valve follows at once, and no pressure stands between it and the edge of a closed spool. In series with an edge: [`super::load_holding`].

use super::orifice::share_of_opening;
use hydrocrane_num::Real;

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

impl<T: Real> Counterbalance<T> {
    /// Opening, 0 to 1, at the pressures of the chamber and of the `pilot` (Pa).
    #[inline(always)]
    pub fn opening(&self, chamber: T, pilot: T) -> T {
        share_of_opening((chamber + self.pilot_ratio * pilot - self.setting) / self.opening_pressure)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
