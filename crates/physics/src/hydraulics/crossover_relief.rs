//! Cross-over relief valves between the two ports of a cylinder.  theory: docs/theory/hydraulics/crossover_relief.md
//!
//! q = g_A max(p_A - p_B - p_s,A, 0) - g_B max(p_B - p_A - p_s,B, 0)                     Watton (2009), chapter 2
//!
//! | symbol   | meaning | unit |
//! | q        | flow from port A to port B                                     | m^3/s |
//! | p_A, p_B | pressures of the ports                                         | Pa |
//! | p_s      | setting: pressure of a port above the other one                | Pa |
//! | g        | flow per pressure beyond the setting                           | m^3/(s Pa) |
//!
//! Both openings are rounded as [`ReliefValve`] states. Limits of validity: the valves follow at once, no hysteresis.

use super::relief_valve::ReliefValve;
use hydrocrane_num::Real;

/// The valves that relieve port A and port B, each into the other port.
#[derive(Debug, Clone, Copy)]
pub struct CrossoverRelief<T> {
    pub from: [Option<ReliefValve<T>>; 2],
}

hydrocrane_num::stored!([] CrossoverRelief<f64> { from: [Option<ReliefValve<f64>>; 2] });

impl<T: Copy> CrossoverRelief<T> {
    /// The same valves with `f` of every number.
    pub fn map<'a, U>(&'a self, f: &mut dyn FnMut(&'a T) -> U) -> CrossoverRelief<U> {
        CrossoverRelief { from: self.from.each_ref().map(|valve| valve.as_ref().map(|valve| valve.map(f))) }
    }

    /// Which of the two there are.
    pub fn kinds(&self) -> [bool; 2] {
        self.from.map(|valve| cfg!(feature = "mobile") && valve.is_some())
    }

    pub fn is_none(&self) -> bool {
        self.kinds() == [false; 2]
    }
}

impl<T: Real> CrossoverRelief<T> {
    /// Flow from port A to port B, m^3/s, at their pressures (Pa). Only one of the two valves is open at a time.
    #[inline(always)]
    pub fn flow(&self, a: T, b: T) -> T {
        if self.is_none() {
            return T::c(0.0);
        }
        self.through(0, a - b) - self.through(1, b - a)
    }

    /// Flow from this port to the other one, m^3/s, by the `drop` to it (Pa).
    #[inline(always)]
    fn through(&self, port: usize, drop: T) -> T {
        match &self.from[port] {
            Some(valve) => valve.flow(drop),
            None => T::c(0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hydrocrane_num::Dual;

    /// 60 l/min at 20 bar beyond 100 bar, and half of it beyond 150 bar the other way.
    const VALVES: CrossoverRelief<f64> = CrossoverRelief {
        from: [
            Some(ReliefValve { pressure: 100e5, gradient: 1e-3 / 20e5 }),
            Some(ReliefValve { pressure: 150e5, gradient: 0.5e-3 / 20e5 }),
        ],
    };

    #[test]
    fn the_difference_of_the_ports_opens_one_of_them() {
        for [a, b] in [[99e5, 0.0], [150e5, 51e5], [10e5, 150e5], [70e5, 70e5]] {
            assert_eq!(VALVES.flow(a, b), 0.0, "{a} {b}");
        }
        assert!((VALVES.flow(160e5, 40e5) / 1e-3 - 1.0).abs() < 1e-12);
        assert!((VALVES.flow(10e5, 180e5) / -0.5e-3 - 1.0).abs() < 1e-12);
        // What both ports have in common does nothing.
        assert!((VALVES.flow(260e5, 140e5) / VALVES.flow(160e5, 40e5) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn value_and_slopes_join_where_they_open() {
        let valves = VALVES.map(&mut |x| Dual::<f64, 2>::constant(*x));
        let at = |drop: f64| valves.flow(Dual::variable(40e5 + drop, 0), Dual::variable(40e5, 1));
        for kink in [100e5 - 0.5e5, 100e5 + 0.5e5, -150e5 - 0.5e5, -150e5 + 0.5e5] {
            let (before, after) = (at(kink - 1e-3), at(kink + 1e-3));
            assert!((before.value - after.value).abs() < 1e-11, "{kink}");
            for i in 0..2 {
                assert!((before.derivative[i] - after.derivative[i]).abs() < 1e-15, "{kink}");
            }
            assert_eq!(after.derivative[0], -after.derivative[1]);
        }
    }

    #[test]
    fn what_is_not_there_passes_nothing() {
        let one_way = CrossoverRelief { from: [VALVES.from[0], None] };
        assert!(one_way.flow(200e5, 0.0) > 0.0 && one_way.flow(0.0, 300e5) == 0.0);
        let none = CrossoverRelief { from: [None, None] };
        assert!(none.is_none() && !one_way.is_none() && none.flow(900e5, 0.0) == 0.0);
    }
}
