//! Valves between a port of a cylinder and the tank.            theory: docs/theory/hydraulics/port_valves.md
//!
//! q_R = g max(p - p_T - p_s, 0)                out of the port: relief (shock) valve         Watton (2009), chapter 2
//! q_N = C root(max(p_T - p - p_o, 0))          into the port: anti-cavitation valve, a check valve from the tank
//!
//! | symbol   | meaning | unit |
//! | p, p_T   | pressures of the port and of the tank                              | Pa |
//! | p_s      | setting of the relief valve over the tank                          | Pa |
//! | g        | its flow per pressure beyond the setting                           | m^3/(s Pa) |
//! | p_o, C   | cracking pressure of the check valve, flow per root of what is left | Pa, m^3/(s sqrt(Pa)) |
//!
//! Both openings are rounded, the relief valve's as [`ReliefValve`] states, and the root is laminar below [`TRANSITION`]. Limits of
//! validity: both follow at once, no hysteresis, the tank always has oil.

use super::relief_valve::ReliefValve;
use hydrocrane_num::{functions::smooth, Real};

parameters! {
    /// A check valve from the tank to a port.
    pub struct AntiCavitation {
        /// p_o, Pa
        opening_pressure,
        /// C, m^3/(s sqrt(Pa))
        coefficient,
    }
}

/// Drop up to which the flow of the check valve is laminar, Pa.
const TRANSITION: f64 = 0.1e5;
/// Pressure within which its opening is rounded, Pa.
const ROUNDING: f64 = 0.02e5;

impl<T: Real> AntiCavitation<T> {
    /// Flow into the port, m^3/s, at its pressure and that of the tank (Pa).
    #[inline(always)]
    pub fn flow(&self, port: T, tank: T) -> T {
        let left = smooth::rounded_positive_part(tank - port - self.opening_pressure, ROUNDING);
        self.coefficient * smooth::signed_root(left, T::c(TRANSITION), smooth::root_curvature(T::c(TRANSITION)))
    }
}

/// What stands between a port and the tank.
#[derive(Debug, Clone, Copy)]
pub struct PortValves<T> {
    pub relief: Option<ReliefValve<T>>,
    pub anti_cavitation: Option<AntiCavitation<T>>,
}

hydrocrane_num::stored!([] PortValves<f64> { relief: Option<ReliefValve<f64>>, anti_cavitation: Option<AntiCavitation<f64>> });

impl<T: Copy> PortValves<T> {
    /// The same valves with `f` of every number.
    pub fn map<'a, U>(&'a self, f: &mut dyn FnMut(&'a T) -> U) -> PortValves<U> {
        PortValves {
            relief: self.relief.as_ref().map(|valve| valve.map(f)),
            anti_cavitation: self.anti_cavitation.as_ref().map(|valve| valve.map(f)),
        }
    }

    /// Which of the two there are.
    pub fn kinds(&self) -> [bool; 2] {
        [self.relief.is_some(), self.anti_cavitation.is_some()]
    }
}

impl<T: Real> PortValves<T> {
    /// Flow from the port to the tank, m^3/s, at their pressures (Pa). Only one of the two valves is open at a time.
    #[inline(always)]
    pub fn flow(&self, port: T, tank: T) -> T {
        let none = T::c(0.0);
        if !cfg!(feature = "mobile") {
            return none;
        }
        let relieved = match &self.relief {
            Some(valve) => valve.flow(port - tank),
            None => none,
        };
        match &self.anti_cavitation {
            Some(valve) => relieved - valve.flow(port, tank),
            None => relieved,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hydrocrane_num::Dual;

    const TANK: f64 = 2e5;
    const VALVES: PortValves<f64> = PortValves {
        relief: Some(ReliefValve { pressure: 200e5, gradient: 1e-3 / 20e5 }),
        anti_cavitation: Some(AntiCavitation { opening_pressure: 0.3e5, coefficient: 1e-6 }),
    };

    #[test]
    fn between_its_two_openings_a_port_is_closed() {
        for port in [TANK - 0.27e5, TANK, 100e5, 201e5] {
            assert_eq!(VALVES.flow(port, TANK), 0.0, "{port}");
        }
        // 20 bar beyond the setting, which counts from the tank.
        assert!((VALVES.flow(222e5, TANK) / 1e-3 - 1.0).abs() < 1e-12);
        // 1 bar below the tank the drop that is left is 0.7 bar.
        assert!((VALVES.flow(TANK - 1e5, TANK) / (-1e-6 * 0.7e5f64.sqrt()) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn value_and_slope_join_wherever_a_valve_opens() {
        let at = |port: f64| {
            VALVES.map(&mut |x| Dual::<f64, 1>::constant(*x)).flow(Dual::variable(port, 0), Dual::constant(TANK))
        };
        let opens = TANK - 0.3e5;
        for kink in [opens - ROUNDING, opens + ROUNDING, opens - TRANSITION, 202e5 - 0.5e5, 202e5 + 0.5e5] {
            let (before, after) = (at(kink - 1e-3), at(kink + 1e-3));
            assert!((before.value - after.value).abs() < 1e-10, "{kink}");
            assert!((before.derivative[0] - after.derivative[0]).abs() < 1e-13, "{kink}");
        }
    }

    #[test]
    fn what_is_not_there_passes_nothing() {
        let none = PortValves { relief: None, anti_cavitation: None };
        assert_eq!([none.flow(900e5, TANK), none.flow(-1e5, TANK)], [0.0; 2]);
        let relief = PortValves { anti_cavitation: None, ..VALVES };
        assert!(relief.flow(300e5, TANK) > 0.0 && relief.flow(-1e5, TANK) == 0.0);
    }
}
