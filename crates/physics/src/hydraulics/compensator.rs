//! Pressure compensator of a valve section.                    theory: docs/theory/hydraulics/compensator.md
//!
//! dp = min(p_c, p_S - p)            before the spool: the edge's drop is that of its spring       Merritt (1967), 5-8
//! dp = p_S - max(p_LS, p)           behind the spool: all sections have the same drop (flow sharing)
//!
//! | symbol | meaning | unit |
//! | dp     | pressure drop over the metering edge from the supply to the port | Pa |
//! | p_S    | pressure of the supply                                           | Pa |
//! | p      | pressure of the port                                             | Pa |
//! | p_c    | setting of the spring                                            | Pa |
//! | p_LS   | pressure of the load-sensing line, that of the highest load      | Pa |
//!
//! Both corners are rounded within +-p_round. Limits of validity: the compensator follows at once, its own edge is large
//! enough when open, and the flow forces on it are none.

use hydrocrane_num::{smooth, Real};

/// Where the compensator of a section stands.
#[derive(Debug, Clone, Copy)]
pub enum Compensator<T> {
    /// There is none: the edge has the whole drop.
    None,
    /// Before the spool, with the setting of its spring, Pa.
    Before(T),
    /// Behind the spool.
    Behind,
}

hydrocrane_num::stored!([] enum Compensator<f64> { 0: None {}, 1: Before { 0: f64 }, 2: Behind {} });

/// p_round, Pa
const ROUNDING: f64 = 0.2e5;

impl<T: Copy> Compensator<T> {
    /// The same with `f` of its number.
    pub fn map<U>(&self, f: &mut dyn FnMut(T) -> U) -> Compensator<U> {
        match self {
            Compensator::None => Compensator::None,
            Compensator::Before(setting) => Compensator::Before(f(*setting)),
            Compensator::Behind => Compensator::Behind,
        }
    }
}

impl<T: Real> Compensator<T> {
    /// Drop over the edge, Pa, between the `supply` and a `port` while the load-sensing line has the pressure `load` (Pa).
    #[inline(always)]
    pub fn drop(&self, supply: T, load: T, port: T) -> T {
        let whole = supply - port;
        match *self {
            _ if !cfg!(feature = "mobile") => whole,
            Compensator::None => whole,
            Compensator::Before(setting) => whole - smooth::rounded_positive_part(whole - setting, ROUNDING),
            Compensator::Behind => whole - smooth::rounded_positive_part(load - port, ROUNDING),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hydrocrane_num::Dual;

    #[test]
    fn before_the_spool_the_drop_is_the_setting_while_the_supply_suffices() {
        let before = Compensator::Before(8e5);
        for port in [0.0, 60e5, 120e5] {
            assert!((before.drop(140e5, 0.0, port) - 8e5).abs() < 1e-6);
        }
        assert_eq!(before.drop(140e5, 0.0, 135e5), 5e5);
        assert_eq!(before.drop(140e5, 0.0, 150e5), -10e5);
    }

    #[test]
    fn behind_the_spool_every_section_has_the_drop_of_the_highest_load() {
        let behind = Compensator::<f64>::Behind;
        for port in [0.0, 60e5, 119e5] {
            assert!((behind.drop(140e5, 120e5, port) - 20e5).abs() < 1e-6);
        }
        // A load that rises faster than the line tells it.
        assert_eq!(behind.drop(140e5, 120e5, 130e5), 10e5);
    }

    #[test]
    fn value_and_derivatives_join_at_the_corners() {
        let at = |law: &Compensator<Dual<f64, 3>>, p: [f64; 3]| {
            let [supply, load, port] = [0, 1, 2].map(|i| Dual::variable(p[i], i));
            law.drop(supply, load, port)
        };
        for side in [-1.0, 1.0] {
            for (law, corner) in [(Compensator::Before(8e5), 132e5), (Compensator::Behind, 120e5)] {
                let law = law.map(&mut Dual::constant);
                let port = corner + side * ROUNDING;
                let (a, b) = (at(&law, [140e5, 120e5, port - 1e-3]), at(&law, [140e5, 120e5, port + 1e-3]));
                assert!((a.value - b.value).abs() < 1e-2);
                for i in 0..3 {
                    assert!((a.derivative[i] - b.derivative[i]).abs() < 1e-6);
                }
                // A pressure added everywhere changes no drop.
                assert!(a.derivative.iter().sum::<f64>().abs() < 1e-12);
            }
        }
    }
}
