//! Separate meter-out: the edge from a port to the tank keeps a return pressure.  theory: docs/theory/hydraulics/meter_out.md
//!
//! o = o_N c(s) y,   y = (p - p_r)/p_o, from 0 to 1
//!
//! | symbol | meaning | unit |
//! | o, o_N | opening of the edge to the tank, and its full one                    | m  |
//! | c      | 0 to 1: free as soon as the spool for the feed leaves its closed zone  | -  |
//! | s      | displacement of that spool in the sense that drains the port         | m  |
//! | p, p_r | pressure of the port, and the one that it keeps                      | Pa |
//! | p_o    | rise beyond that which opens the edge fully                          | Pa |
//!
//! Source: the valve block of the thesis's Figure 9 (2.2.2.2), and A. Jansson and J.-O. Palmberg (1990). Both ends of the opening are
//! rounded within a tenth of p_o. Limits of validity: the regulator of the spool for the return follows at once.

use super::load_sensing::Connection;
use hydrocrane_num::{functions::smooth, Real};

parameters! {
    pub struct MeterOut {
        /// p_r, Pa
        pressure,
        /// p_o, Pa
        range,
    }
}

/// Share of the range within which the ends of the opening are rounded.
const ROUNDING: f64 = 0.1;

impl<T: Real> MeterOut<T> {
    /// Share of the full opening at the pressure `port` (Pa) with the feeding spool displaced by `travel` (m) in the sense that
    /// drains the port; `connection` says where it leaves its closed zone.
    #[inline(always)]
    pub fn opening(&self, connection: &Connection<T>, travel: T, port: T) -> T {
        let share = (port - self.pressure) / self.range;
        let regulated =
            smooth::rounded_positive_part(share, ROUNDING) - smooth::rounded_positive_part(share - T::c(1.0), ROUNDING);
        let (free, _) = smooth::step((travel - connection.begins) / connection.travel);
        free * regulated
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hydrocrane_num::{Dual, Field};

    const OUT: MeterOut<f64> = MeterOut { pressure: 20e5, range: 4e5 };
    const CONNECTION: Connection<f64> = Connection { begins: 4.5e-3, travel: 0.5e-3 };

    #[test]
    fn it_opens_above_its_pressure_while_the_section_moves_that_way() {
        let at = |travel: f64, p: f64| OUT.opening(&CONNECTION, travel, p);
        assert_eq!((at(10e-3, 15e5), at(10e-3, 22e5), at(10e-3, 40e5)), (0.0, 0.5, 1.0));
        assert_eq!((at(4e-3, 40e5), at(-10e-3, 40e5)), (0.0, 0.0));
    }

    #[test]
    fn slopes_are_finite_and_join() {
        let out = OUT.lift::<Dual<f64, 2>>();
        let connection = CONNECTION.lift::<Dual<f64, 2>>();
        let at = |travel: f64, p: f64| out.opening(&connection, Dual::variable(travel, 0), Dual::variable(p, 1));
        for share in [-ROUNDING, ROUNDING, 1.0 - ROUNDING, 1.0 + ROUNDING] {
            let p = 20e5 + share * 4e5;
            let [before, after] = [at(8e-3, p - 1e-3), at(8e-3, p + 1e-3)];
            assert!((before.derivative[1] - after.derivative[1]).abs() < 1e-10, "{share}");
        }
        for travel in [4.5e-3, 5e-3] {
            let [before, after] = [at(travel - 1e-9, 22e5), at(travel + 1e-9, 22e5)];
            assert!(
                (before.derivative[0] - after.derivative[0]).abs() < 1.0 && after.derivative[0].finite(),
                "{travel}"
            );
        }
    }
}
