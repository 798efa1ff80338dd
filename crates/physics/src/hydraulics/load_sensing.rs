//! Load sensing: the highest load pressure commands the pump.   theory: docs/theory/hydraulics/load_sensing.md
//!
//! s_i   = p_T + c(x_s) (p_i - p_T)           what section i gives to the shuttle valves
//! p_LS' = (max(p_T, s_1 .. s_n) - p_LS)/T    the line to the pump
//! p_set = min(p_max, p_LS + p_m)             what the pump, or the unloading valve of a fixed one, is set to
//!
//! | symbol | meaning | unit |
//! | p_i    | pressure of the port that the section feeds                      | Pa |
//! | c      | connection of that port, 0 to 1: open before the metering edge   | -  |
//! | p_LS   | pressure of the load-sensing line                                | Pa |
//! | p_m    | margin of the pump over it                                       | Pa |
//! | T      | time constant of the line                                        | s  |
//!
//! Source: Krus (1988). Limits of validity: the line takes no oil from the ports, its resistance and volume make one time
//! constant, and the shuttle valves switch at once.

use hydrocrane_num::{functions::smooth, Real};

parameters! {
    pub struct LoadSensing {
        /// p_m, Pa
        margin,
        /// T, s
        time_constant,
    }
}

parameters! {
    /// Where a spool connects the port that it feeds with the load-sensing line.
    pub struct Connection {
        /// Displacement from the middle at which the connection begins to open, m, and way until it is open, m.
        begins,
        travel,
    }
}

/// What the pressure of the mains is set to, Pa: a `margin` (Pa) over the pressure `load` (Pa) of the line, not above `highest` (Pa).
#[inline(always)]
pub fn setting<T: Real>(highest: T, load: T, margin: T) -> T {
    highest.min(load + margin)
}

impl<T: Real> LoadSensing<T> {
    /// What the pressure of the mains is set to, Pa, not above `highest` (Pa), at the pressure `load` (Pa) of the line.
    #[inline(always)]
    pub fn setting(&self, highest: T, load: T) -> T {
        setting(highest, load, self.margin)
    }

    /// Rate of the line's pressure `load`, Pa/s, while the sections give `signal` at most (Pa).
    #[inline(always)]
    pub fn rate(&self, signal: T, load: T) -> T {
        (signal - load) / self.time_constant
    }
}

impl<T: Real> Connection<T> {
    /// What a section with its spool at `spool` (m) gives to the line, Pa, from the ports' pressures and that of the tank, Pa.
    #[inline(always)]
    pub fn signal(&self, spool: T, [a, b]: [T; 2], tank: T) -> T {
        let fed = T::select(spool.lt(T::c(0.0)), b, a);
        let (open, _) = smooth::step((spool.abs() - self.begins) / self.travel);
        tank + open * (fed - tank)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pump_is_set_to_the_load_and_its_margin_up_to_its_highest_pressure() {
        let sensing = LoadSensing { margin: 20e5, time_constant: 0.02 };
        assert_eq!(sensing.setting(210e5, 90e5), 110e5);
        assert_eq!(sensing.setting(210e5, 200e5), 210e5);
        assert_eq!(sensing.rate(90e5, 70e5), 20e5 / 0.02);
    }

    #[test]
    fn a_section_tells_the_port_that_it_feeds_and_nothing_in_its_middle() {
        let connection = Connection { begins: 0.5e-3, travel: 0.2e-3 };
        let signal = |spool: f64| connection.signal(spool, [90e5, 40e5], 1e5);
        assert_eq!((signal(0.4e-3), signal(-0.4e-3)), (1e5, 1e5));
        assert_eq!((signal(1e-3), signal(-1e-3)), (90e5, 40e5));
        assert!(signal(0.6e-3) > 40e5 && signal(0.6e-3) < 50e5);
    }
}
