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
//! Both corners are rounded within +-p_round. With a time constant it follows late:
//!
//! dp = o^2 (p_S - p),   o' = (o_w - o)/T,   o_w = sqrt(dp_w/(p_S - p)), from 0 to 1
//!
//! | o    | opening: flow over that with the compensator fully open                 | -  |
//! | o_w  | the one that gives the drop dp_w of the law above, at the port that the spool feeds, or the tank where it feeds none | - |
//! | T    | time constant                                                           | s  |
//!
//! In series with an edge of area a, a compensator of area a_c has o = a_c/sqrt(a_c^2 + a^2): nearly a_c/a while it throttles.
//! Limits of validity: its own edge is large enough when open, and the flow forces on it are none; with a time constant also that
//! the spool opens slowly against it, for o does not follow a at once.

use hydrocrane_num::{functions::smooth, Real};

/// Where the compensator of a section stands.
#[derive(Debug, Clone, Copy, PartialEq)]
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
/// What the rounded corner takes of the drop of the section with the highest load behind the spool, Pa.
pub const TAKEN_AT_THE_CORNER: f64 = 0.25 * ROUNDING;
/// Share of the whole drop below which the opening is no longer its root.
const NEARLY_SHUT: f64 = 1e-3;

parameters! {
    /// How a compensator follows what its static law asks for.
    pub struct CompensatorLag {
        /// T, s
        time_constant,
    }
}

impl<T: Real> CompensatorLag<T> {
    /// Rate of the `opening`, 1/s, where the static law asks for `wanted`.
    #[inline(always)]
    pub fn rate(&self, opening: T, wanted: T) -> T {
        (wanted - opening) / self.time_constant
    }
}

impl<T: Copy> Compensator<T> {
    /// The same with `f` of its number.
    pub fn map<'a, U>(&'a self, f: &mut dyn FnMut(&'a T) -> U) -> Compensator<U> {
        match self {
            Compensator::None => Compensator::None,
            Compensator::Before(setting) => Compensator::Before(f(setting)),
            Compensator::Behind => Compensator::Behind,
        }
    }
}

impl<T: Real> Compensator<T> {
    /// Drop over the edge, Pa, between the `supply` and a `port` while the load-sensing line has the pressure `load` (Pa). A compensator
    /// that follows late has an `opening`.
    #[inline(always)]
    pub fn drop(&self, supply: T, load: T, opening: Option<T>, port: T) -> T {
        let whole = supply - port;
        match (*self, opening) {
            _ if !cfg!(feature = "mobile") => whole,
            (Compensator::None, _) => whole,
            (_, Some(opening)) => opening.square() * whole,
            (Compensator::Before(setting), None) => whole - smooth::rounded_positive_part(whole - setting, ROUNDING),
            (Compensator::Behind, None) => whole - smooth::rounded_positive_part(load - port, ROUNDING),
        }
    }

    /// Opening that gives the drop of the static law at a `port` (Pa). Where that law would return oil, it is shut.
    #[inline(always)]
    pub fn settled_opening(&self, supply: T, load: T, port: T) -> T {
        let whole = supply - port;
        let taken = whole - self.drop(supply, load, None, port);
        let share = (T::c(1.0) - taken / whole.max(T::c(ROUNDING))).clamp(T::c(0.0), T::c(1.0));
        let transition = T::c(NEARLY_SHUT);
        smooth::signed_root(share, transition, smooth::root_curvature(transition))
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
            assert!((before.drop(140e5, 0.0, None, port) - 8e5).abs() < 1e-6);
        }
        assert_eq!(before.drop(140e5, 0.0, None, 135e5), 5e5);
        assert_eq!(before.drop(140e5, 0.0, None, 150e5), -10e5);
    }

    #[test]
    fn behind_the_spool_every_section_has_the_drop_of_the_highest_load() {
        let behind = Compensator::<f64>::Behind;
        for port in [0.0, 60e5, 119e5] {
            assert!((behind.drop(140e5, 120e5, None, port) - 20e5).abs() < 1e-6);
        }
        // A load that rises faster than the line tells it.
        assert_eq!(behind.drop(140e5, 120e5, None, 130e5), 10e5);
    }

    #[test]
    fn value_and_derivatives_join_at_the_corners() {
        let at = |law: &Compensator<Dual<f64, 3>>, p: [f64; 3]| {
            let [supply, load, port] = [0, 1, 2].map(|i| Dual::variable(p[i], i));
            law.drop(supply, load, None, port)
        };
        for side in [-1.0, 1.0] {
            for (law, corner) in [(Compensator::Before(8e5), 132e5), (Compensator::Behind, 120e5)] {
                let law = law.map(&mut |x| Dual::constant(*x));
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

    #[test]
    fn settled_it_leaves_the_drop_of_the_static_law_at_every_port() {
        for law in [Compensator::Before(8e5), Compensator::Behind] {
            for [supply, load, port] in
                [[140e5, 120e5, 60e5], [140e5, 120e5, 0.0], [140e5, 90e5, 90e5], [95e5, 90e5, 89e5]]
            {
                let opening = law.settled_opening(supply, load, port);
                let (late, wanted) = (law.drop(supply, load, Some(opening), port), law.drop(supply, load, None, port));
                assert!((late - wanted).abs() < 1e-6, "{law:?} {port}: {late} {wanted}");
                assert_eq!(CompensatorLag { time_constant: 0.01 }.rate(opening, opening), 0.0);
            }
            // As much open as it can be, and shut, with finite slopes at both ends and at a port above the supply.
            for (port, opening) in [(139.7e5, 1.0), (150e5, 1.0)] {
                assert_eq!(law.settled_opening(140e5, 0.0, port), opening);
            }
            for port in [60e5, 139.7e5, 140e5, 150e5] {
                let law = law.map(&mut |x| Dual::<f64, 3>::constant(*x));
                let [supply, load, port] = [140e5, 141e5, port].map(Dual::<f64, 3>::constant);
                let opening = law.settled_opening(
                    Dual { derivative: [1.0, 0.0, 0.0], ..supply },
                    Dual { derivative: [0.0, 1.0, 0.0], ..load },
                    Dual { derivative: [0.0, 0.0, 1.0], ..port },
                );
                assert!(
                    opening.value >= 0.0 && opening.derivative.iter().all(|slope| slope.abs() < 1e-4),
                    "{opening:?}"
                );
            }
        }
        assert_eq!(Compensator::<f64>::Behind.settled_opening(140e5, 141e5, 60e5), 0.0);
    }

    #[test]
    fn half_open_it_leaves_a_quarter_of_the_drop() {
        assert_eq!(Compensator::Before(8e5).drop(140e5, 0.0, Some(0.5), 60e5), 20e5);
        // 8 bar of 80 bar: a root of 0.1, and from 0.5 there with 20 ms.
        let wanted = Compensator::Before(8e5).settled_opening(140e5, 0.0, 60e5);
        assert!((wanted - 0.1f64.sqrt()).abs() < 1e-12);
        assert!((CompensatorLag { time_constant: 0.02 }.rate(0.5, wanted) - (0.1f64.sqrt() - 0.5) / 0.02).abs() < 1e-9);
    }
}
