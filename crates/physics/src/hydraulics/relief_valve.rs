//! Pressure relief valve.                                      theory: docs/theory/hydraulics/relief_valve.md
//!
//! q = g max(p - p_crack, 0)        rounded within +-p_round of the cracking pressure    Watton (2009), chapter 2
//!
//! | symbol  | meaning | unit |
//! | q       | flow from the mains to the tank            | m^3/s     |
//! | p_crack | pressure at which the valve begins to open | Pa        |
//! | g       | flow per pressure beyond it                | m^3/(s Pa) |
//!
//! Static: the poppet follows at once. Limits of validity: a straight line up to the valve's rated flow, no hysteresis, and
//! the flow does not depend on the pressure of the tank.

use hydrocrane_num::{functions::smooth, Real};

parameters! {
    pub struct ReliefValve {
        /// p_crack, Pa
        pressure,
        /// g, m^3/(s Pa)
        gradient,
    }
}

/// p_round, Pa
const ROUNDING: f64 = 0.5e5;

impl<T: Real> ReliefValve<T> {
    /// m^3/s at the pressure `p` (Pa) of the mains.
    #[inline(always)]
    pub fn flow(&self, p: T) -> T {
        self.gradient * smooth::rounded_positive_part(p - self.pressure, ROUNDING)
    }

    /// Highest pressure, Pa, at which nothing flows.
    #[inline(always)]
    pub fn tight_to(&self) -> T {
        self.pressure - ROUNDING
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hydrocrane_num::Dual;

    const VALVE: ReliefValve<f64> = ReliefValve { pressure: 250e5, gradient: 2e-3 / 20e5 };

    #[test]
    fn it_is_closed_below_and_passes_its_rated_flow_at_its_override() {
        assert_eq!(VALVE.flow(249e5), 0.0);
        assert!((VALVE.flow(270e5) / 2e-3 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn value_and_slope_join_where_it_opens() {
        for side in [-1.0, 1.0] {
            let at =
                |offset: f64| VALVE.lift::<Dual<f64, 1>>().flow(Dual::variable(250e5 + side * ROUNDING + offset, 0));
            let (before, after) = (at(-1e-3), at(1e-3));
            assert!((before.value - after.value).abs() < 1e-11);
            assert!((before.derivative[0] - after.derivative[0]).abs() < 1e-6 * VALVE.gradient);
        }
    }
}
