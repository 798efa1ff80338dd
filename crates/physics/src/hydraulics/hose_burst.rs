//! Hose-burst valve between a chamber and its port of the spool valve.
//!                                                     theory: docs/theory/hydraulics/hose_burst.md
//!
//! q_1 = C_1 g(p_c - p_T), C_1 = C_N C_e/sqrt(C_N^2 + C_e^2)       what would flow out if it stayed open
//! o = 1 - (1 - b) S((q_1/q_s - 1)/w)                              opening on the way out; on the way in it is open
//!
//! | symbol | meaning | unit |
//! | q_s    | flow at which it begins to close                                    | m^3/s |
//! | w      | share of that flow beyond which it has closed                       | -  |
//! | S      | smooth step from 0 to 1                                             | -  |
//! | b      | opening that a bleed leaves                                         | -  |
//! | C_N, C_e | flow per root of the pressure drop: of the open valve, of the edge | m^3/(s sqrt(Pa)) |
//!
//! Source: Watton (2009), chapter 2, for the plate that the flow closes against a spring. Limits of validity: static, so without its
//! latch: it opens as soon as no more than q_s would flow, where a real one waits until the pressures on both sides are equal.

use super::orifice::{in_series, LEAST};
use hydrocrane_num::{functions::smooth, Real};

parameters! {
    pub struct HoseBurst {
        /// q_s, m^3/s
        closing_flow,
        /// b
        bleed,
        /// C_N, m^3/(s sqrt(Pa))
        coefficient,
    }
}

/// w
const WIDTH: f64 = 0.1;

impl<T: Real> HoseBurst<T> {
    /// Opening while an edge of coefficient `edge` drains it, with the `root` of the pressure drop over both (sqrt(Pa)).
    #[inline(always)]
    pub fn opening(&self, edge: T, root: T) -> T {
        let open = in_series(self.coefficient, edge, self.coefficient * LEAST) * root;
        let (closed, _) = smooth::step((open / self.closing_flow - 1.0) / WIDTH);
        T::c(1.0) - (T::c(1.0) - self.bleed) * closed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hydrocrane_num::{Dual, Field};

    const VALVE: HoseBurst<f64> = HoseBurst { closing_flow: 1e-3, bleed: 0.01, coefficient: 1e-6 };

    #[test]
    fn it_closes_beyond_its_flow_and_leaves_its_bleed() {
        // An edge as wide as the valve: 1.4 l/s at a drop of 40 bar, 0.7 l/s at 10 bar.
        assert_eq!(VALVE.opening(1e-6, 10e5f64.sqrt()), 1.0);
        assert!((VALVE.opening(1e-6, 40e5f64.sqrt()) - 0.01).abs() < 1e-15);
        assert_eq!(VALVE.opening(0.0, 40e5f64.sqrt()), 1.0);
    }

    #[test]
    fn slopes_are_finite_everywhere() {
        for edge in [0.0, 1e-9, 1e-6, 1e-3] {
            for root in [0.0, 1.0, 1.4142e3, 1.5e3, 1e4] {
                let open = VALVE.lift::<Dual<f64, 2>>().opening(Dual::variable(edge, 0), Dual::variable(root, 1));
                assert!(open.finite() && open.derivative.iter().all(|d| d.finite()), "{edge} {root}");
            }
        }
    }
}
