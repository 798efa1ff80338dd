//! Pilot-operated check valve between a chamber and its port of the spool valve.
//!                                                     theory: docs/theory/hydraulics/pilot_check.md
//!
//! o = (R (p_x - p_T) - (p_c - p_T) - p_s)/p_o, from 0 to 1       opening on the way out; on the way in no drop
//!
//! | symbol | meaning | unit |
//! | p_c, p_x | pressures of the chamber, and of the other port while it is fed    | Pa |
//! | p_T      | pressure of the tank                                               | Pa |
//! | R        | pilot ratio: area of the pilot piston over that of the seat        | -  |
//! | p_s, p_o | force of the spring, rise beyond it that opens fully, over the seat | Pa |
//!
//! Source: Watton (2009), chapter 2. Both ends of the opening are rounded within a tenth of p_o. Limits of validity: the valve
//! follows at once, the pressure behind the seat is that of the tank.

use super::orifice::share_of_opening;
use hydrocrane_num::Real;

parameters! {
    pub struct PilotCheck {
        /// R
        pilot_ratio,
        /// p_s, Pa
        spring,
        /// p_o, Pa
        opening_pressure,
        /// C_N, m^3/(s sqrt(Pa))
        coefficient,
    }
}

impl<T: Real> PilotCheck<T> {
    /// Opening, 0 to 1, at the pressures of the chamber, of the `pilot` and of the `tank` (Pa).
    #[inline(always)]
    pub fn opening(&self, chamber: T, pilot: T, tank: T) -> T {
        let beyond = self.pilot_ratio * (pilot - tank) - (chamber - tank) - self.spring;
        share_of_opening(beyond / self.opening_pressure)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VALVE: PilotCheck<f64> =
        PilotCheck { pilot_ratio: 3.0, spring: 2e5, opening_pressure: 10e5, coefficient: 1e-7 };

    #[test]
    fn only_the_pilot_opens_it_and_the_load_keeps_it_shut() {
        for chamber in [0.0, 100e5, 900e5] {
            assert_eq!(VALVE.opening(chamber, 1e5, 1e5), 0.0);
        }
        // 100 bar over the tank and the spring need 34 bar of pilot, 3 1/3 bar more to open fully.
        assert_eq!(VALVE.opening(101e5, 34.5e5, 1e5), 0.0);
        assert!((VALVE.opening(101e5, 1e5 + 107e5 / 3.0, 1e5) - 0.5).abs() < 1e-12);
        assert_eq!(VALVE.opening(101e5, 40e5, 1e5), 1.0);
    }
}
