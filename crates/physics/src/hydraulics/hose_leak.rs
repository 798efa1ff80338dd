//! A hose that leaks to the outside, alone and behind a valve that holds the load.
//!                                                          theory: docs/theory/hydraulics/hose_leak.md
//!
//! q_h(p) = C_h g(p),   C_h = c_d A sqrt(2/rho)       what leaves through the hole of a hose at p > 0     Merritt (1967), chapter 3
//! Without a valve between them, the hose has the pressure of its chamber: q_l = q_h(p_c). With one,
//! q_l = max(f q_h(p_c), min(q_h(p_c), q_o)),   f = C/sqrt(C^2 + (C_e + C_h)^2)
//! q_s = max(0, q_f - q_h(p_c)) + min(q_h(p_c), q_o)
//! p   = p_c (q_l/q_h(p_c))^2
//!
//! | symbol   | meaning                                                                      | unit |
//! | q_l, q_s | flow that is lost, and flow from the supply into the hose                    | m^3/s |
//! | p, p_c   | pressure of the hose, and of the chamber behind the valve                    | Pa |
//! | q_f      | flow that the supply would feed at the pressure of the chamber               | m^3/s |
//! | q_o      | flow from the supply through its edge and the hole in series to the outside  | m^3/s |
//! | C, C_e, C_h | flow per root of the pressure drop: of the valve that holds the load as far as it is open, of the edge from the hose to the tank, of the hole | m^3/(s sqrt(Pa)) |
//!
//! Where the valve is a hose-burst valve, which oil passes freely both ways while it is open, q_s is q_f as far as it is open. Limits of
//! validity: no oil is stored in the hose, nothing is drawn in through the hole, and of supply and chamber the stronger one alone
//! sets the pressure of the hose.

use super::line::Resistance;
use hydrocrane_num::{functions::smooth, Real};

parameters! {
    pub struct HoseLeak {
        /// C_h, m^3/(s sqrt(Pa))
        coefficient,
    }
}

/// Pressure of the hose below which the flow through the hole is laminar, Pa.
const TRANSITION: f64 = 0.1e5;
/// Coefficient that stands for none in a series, m^3/(s sqrt(Pa)).
const CLOSED: f64 = 1e-15;
/// Flow through the hole below which the hose counts as tight, m^3/s.
const TIGHT: f64 = 1e-12;

/// A hose that leaks, as its port of the spool valve meets it.
#[derive(Debug, Clone, Copy)]
pub struct Leaking<T> {
    /// q_o, m^3/s
    pub outward: T,
    /// The valve that holds the load, if there is one.
    pub behind: Option<Behind<T>>,
}

/// The valve between the chamber and a hose that leaks.
#[derive(Debug, Clone, Copy)]
pub struct Behind<T> {
    /// f
    pub share: T,
    /// How far it lets oil pass both ways: not at all where it is a check valve into the chamber.
    pub free: T,
}

/// What a hose that leaks makes of the flow to it.
#[derive(Debug, Clone, Copy)]
pub struct Spill<T> {
    /// q_s and q_l, m^3/s.
    pub fed: T,
    pub lost: T,
    /// p_c - p, Pa.
    pub drop: T,
}

impl<T: Real> HoseLeak<T> {
    /// q_h, m^3/s, from a hose at the pressure `p` (Pa).
    #[inline(always)]
    pub fn flow(&self, p: T) -> T {
        let transition = T::c(TRANSITION);
        self.coefficient * smooth::positive_part(smooth::signed_root(p, transition, smooth::root_curvature(transition)))
    }

    /// The hole as a resistance in series with an edge.
    #[inline(always)]
    pub fn resistance(&self) -> Resistance<T> {
        Resistance { laminar: T::c(0.0), turbulent: T::c(1.0) / (self.coefficient.square() + CLOSED * CLOSED) }
    }

    /// f, behind a valve of coefficient `own` and with an edge of coefficient `edge` from the hose to the tank, each of which may be closed
    /// down to `least`.
    #[inline(always)]
    pub fn share(&self, own: T, edge: T, least: T) -> T {
        own / (own.square() + (edge + self.coefficient).square() + least.square()).sqrt()
    }

    /// Flows at the pressure `chamber` (Pa), with `fed` (m^3/s) from the supply at that pressure.
    #[inline(always)]
    pub fn spill(&self, chamber: T, fed: T, leaking: &Leaking<T>) -> Spill<T> {
        let most = self.flow(chamber);
        let Some(Behind { share, free }) = leaking.behind else {
            return Spill { fed, lost: most, drop: T::c(0.0) };
        };
        let outward = most.min(leaking.outward);
        let checked = smooth::positive_part(fed - most) + outward;
        let lost = outward.max(share * most);
        let part = T::select(T::c(TIGHT).lt(most), lost / most.max(T::c(TIGHT)), T::c(1.0));
        Spill { fed: free * fed + (T::c(1.0) - free) * checked, lost, drop: chamber * (T::c(1.0) - part.square()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hydrocrane_num::{Dual, Field};

    /// 1 l/s at 100 bar.
    const HOSE: HoseLeak<f64> = HoseLeak { coefficient: 1e-6 / 3.162_277_660_168_379_5 };
    const CHECKED: Leaking<f64> = Leaking { outward: 4e-4, behind: Some(Behind { share: 0.0, free: 0.0 }) };

    #[test]
    fn by_hand_the_hole_passes_its_flow_outwards_only() {
        assert!((HOSE.flow(100e5) / 1e-3 - 1.0).abs() < 1e-12);
        assert!((HOSE.flow(25e5) / 0.5e-3 - 1.0).abs() < 1e-12);
        assert_eq!([HOSE.flow(0.0), HOSE.flow(-0.5e5)], [0.0; 2]);
    }

    #[test]
    fn without_a_valve_the_chamber_empties_through_the_hole() {
        let spill = HOSE.spill(100e5, 2e-4, &Leaking { outward: 4e-4, behind: None });
        assert!((spill.lost / 1e-3 - 1.0).abs() < 1e-12);
        assert_eq!((spill.fed, spill.drop), (2e-4, 0.0));
    }

    #[test]
    fn behind_a_closed_valve_only_the_supply_loses_oil() {
        // 0.4 l/s through the hole: 16 bar in the hose.
        let spill = HOSE.spill(100e5, 2e-4, &CHECKED);
        assert_eq!((spill.fed, spill.lost), (4e-4, 4e-4));
        assert!((spill.drop / 84e5 - 1.0).abs() < 1e-9);
        let held = HOSE.spill(100e5, 0.0, &Leaking { outward: 0.0, ..CHECKED });
        assert_eq!((held.fed, held.lost, held.drop), (0.0, 0.0, 100e5));
    }

    #[test]
    fn what_the_hole_cannot_pass_reaches_the_chamber() {
        // The hole passes 1 l/s of the 1.5 l/s that the supply feeds at 100 bar.
        let spill = HOSE.spill(100e5, 1.5e-3, &Leaking { outward: 1.8e-3, ..CHECKED });
        assert!((spill.lost / 1e-3 - 1.0).abs() < 1e-12 && (spill.fed / 1.5e-3 - 1.0).abs() < 1e-12);
        assert!(spill.drop.abs() < 1e-6);
    }

    #[test]
    fn an_open_hose_burst_valve_leaves_the_flow_and_a_tight_hose_changes_nothing() {
        let open = Behind { share: 0.8, free: 1.0 };
        let spill = HOSE.spill(100e5, -2e-4, &Leaking { outward: 0.0, behind: Some(open) });
        assert_eq!(spill.fed, -2e-4);
        assert!((spill.lost / 0.8e-3 - 1.0).abs() < 1e-12 && (spill.drop / 36e5 - 1.0).abs() < 1e-12);
        let tight = HoseLeak { coefficient: 0.0 };
        for (fed, behind) in [(3e-4, CHECKED.behind), (-2e-4, Some(open)), (3e-4, None)] {
            let spill = tight.spill(100e5, fed, &Leaking { outward: 0.0, behind });
            assert_eq!((spill.fed, spill.lost, spill.drop), (fed, 0.0, 0.0));
        }
        assert!(tight.resistance().turbulent.finite() && tight.share(1e-7, 0.0, 1e-16) == 1.0);
    }

    #[test]
    fn two_holes_in_a_row_share_the_drop() {
        // A valve as wide as the hole leaves half the pressure to the hose: the flow falls by the root of two.
        let share = HOSE.share(HOSE.coefficient, 0.0, 1e-16);
        assert!((share * 2f64.sqrt() - 1.0).abs() < 1e-8);
        // An edge to the tank as wide as the hole takes as much again.
        let share = HOSE.share(HOSE.coefficient, HOSE.coefficient, 1e-16);
        assert!((share * 5f64.sqrt() - 1.0).abs() < 1e-8);
    }

    #[test]
    fn slopes_are_finite_everywhere_and_values_join() {
        let law = |coefficient: f64| HoseLeak { coefficient: Dual::<f64, 3>::constant(coefficient) };
        for coefficient in [0.0, HOSE.coefficient] {
            for chamber in [-0.9e5, 0.0, 10.0, 0.1e5, 100e5] {
                for (fed, outward) in [(0.0, 0.0), (-1e-4, 0.0), (1e-3, 1e-3), (1.2e-3, 2e-3)] {
                    for (own, free) in [(0.0, 0.0), (1e-7, 0.0), (1e-7, 1.0)] {
                        let hose = law(coefficient);
                        let share = hose.share(Dual::constant(own), Dual::constant(0.0), Dual::constant(1e-16));
                        let leaking = Leaking {
                            outward: Dual::variable(outward, 2),
                            behind: Some(Behind { share, free: Dual::constant(free) }),
                        };
                        let spill = hose.spill(Dual::variable(chamber, 0), Dual::variable(fed, 1), &leaking);
                        for number in [spill.fed, spill.lost, spill.drop] {
                            assert!(number.finite() && number.derivative.iter().all(|d| d.finite()), "{spill:?}");
                        }
                    }
                }
            }
        }
        // Where the supply begins to reach the chamber.
        let at = |fed: f64| HOSE.spill(100e5, fed, &Leaking { outward: 1e-3 + 0.7 * (fed - 1e-3), ..CHECKED });
        let (before, after) = (at(1e-3 - 1e-12), at(1e-3 + 1e-12));
        assert!((before.fed - after.fed).abs() < 1e-11 && (before.drop - after.drop).abs() < 1.0);
    }
}
