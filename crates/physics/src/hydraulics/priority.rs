//! Priority: the other sections give way when the pump cannot keep its pressure.  theory: docs/theory/hydraulics/priority.md
//!
//! q = y q_0,   y = (p_S - (p_set - p_m) - p_k)/p_r, from 0 to 1
//!
//! | symbol     | meaning | unit |
//! | q, q_0     | flow from the supply to a section that gives way, and without the priority element | m^3/s |
//! | p_S, p_set | pressure of the mains, and what the pump is set to                                 | Pa |
//! | p_m        | margin of the pump over the load-sensing line                                      | Pa |
//! | p_k        | margin that is kept for the section served first: the others are shut there        | Pa |
//! | p_r        | rise beyond it at which the others are free                                        | Pa |
//!
//! Below the highest pressure of the pump p_set - p_m is that of the load-sensing line. Source: Krus (1988) on margin and
//! saturation, and the static balance of a priority valve. Both ends are rounded within a tenth of p_r. Limits of
//! validity: the element follows at once, and it feels the highest of all loads.

use super::load_sensing::setting;
use super::orifice::share_of_opening;
use hydrocrane_num::Real;

parameters! {
    /// What a section that gives way has before its spool.
    pub struct Priority {
        /// What the pump keeps at most, Pa, and p_m, Pa.
        highest, margin,
        /// p_k, Pa
        kept,
        /// p_r, Pa
        range,
    }
}

impl<T: Real> Priority<T> {
    /// y, at the pressures of the mains and of the load-sensing line, Pa.
    #[inline(always)]
    pub fn share(&self, supply: T, load: T) -> T {
        let left = supply - setting(self.highest, load, self.margin) + self.margin;
        share_of_opening((left - self.kept) / self.range)
    }

    /// Power lost in the element, W, of a turbulent edge with it in series, while `flow` (m^3/s) has the drop `drop` (Pa) over both: the
    /// edge alone takes y^2 of it.
    #[inline(always)]
    pub fn loss(&self, supply: T, load: T, drop: T, flow: T) -> T {
        (T::c(1.0) - self.share(supply, load).square()) * drop * flow
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hydrocrane_num::{Dual, Field};

    /// Free 12 bar above the load, shut 8 bar above it.
    const OTHERS: Priority<f64> = Priority { highest: 180e5, margin: 20e5, kept: 8e5, range: 4e5 };

    #[test]
    fn the_others_are_free_while_the_pump_keeps_its_margin_and_shut_at_what_is_kept() {
        for load in [0.0, 60e5, 140e5] {
            assert!((OTHERS.share(load + 20e5, load) - 1.0).abs() < 1e-12);
            assert!((OTHERS.share(load + 10e5, load) - 0.5).abs() < 1e-12);
            assert_eq!(OTHERS.share(load + 7.5e5, load), 0.0);
        }
    }

    #[test]
    fn a_section_at_the_highest_pressure_does_not_shut_the_others() {
        // Its load pressure is that of the mains: no margin is left, but the pump gives all it is set to.
        assert!((OTHERS.share(179e5, 179e5) - 1.0).abs() < 1e-12);
        // 14 bar below it the pump is exhausted.
        assert_eq!(OTHERS.share(166e5, 175e5), 0.0);
    }

    #[test]
    fn the_loss_is_what_the_edge_does_not_take() {
        let [drop, flow] = [30e5, 2e-4];
        assert!((OTHERS.loss(90e5, 80e5, drop, flow) / (0.75 * drop * flow) - 1.0).abs() < 1e-12);
        assert!(OTHERS.loss(100e5, 80e5, drop, flow).abs() < 1e-9);
    }

    #[test]
    fn value_and_slopes_join_at_both_ends() {
        let law = OTHERS.lift::<Dual<f64, 2>>();
        let at = |p: f64| law.share(Dual::variable(80e5 + p, 0), Dual::variable(80e5, 1));
        for share in [-0.1, 0.1, 0.9, 1.1] {
            let kink = 8e5 + share * 4e5;
            let (before, after) = (at(kink - 1e-3), at(kink + 1e-3));
            assert!((before.value - after.value).abs() < 1e-7, "{share}");
            for i in 0..2 {
                assert!((before.derivative[i] - after.derivative[i]).abs() < 1e-12 && after.derivative[i].finite());
            }
        }
        assert!(at(10e5).derivative[0] > 0.0 && at(10e5).derivative[1] < 0.0);
    }
}
