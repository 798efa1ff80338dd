//! What holds the load of a chamber, in series with the metering edge to the tank.
//!                                                     theory: docs/theory/hydraulics/load_holding.md
//!
//! q = C C_e/sqrt(C^2 + C_e^2) g(p_c - p_T), C = C_N o                                   Watton (2009), chapter 2
//!
//! | symbol | meaning | unit |
//! | C_N, C_e | flow per root of the pressure drop: of the open valve, of the edge | m^3/(s sqrt(Pa)) |
//! | o        | opening of the valve                                               | -  |
//! | g        | root of the law of the edge, of the drop from chamber to tank      | sqrt(Pa) |
//!
//! Limits of validity: both drops are turbulent, and no oil is stored between the two.

use super::counterbalance::Counterbalance;
use super::hose_burst::HoseBurst;
use super::hose_leak::{Behind, HoseLeak};
use super::line::Resistance;
use super::orifice::{in_series, Orifice, LEAST};
use super::pilot_check::PilotCheck;
use hydrocrane_num::Real;

/// One of them on each side of a cylinder at most.
#[derive(Debug, Clone, Copy)]
pub enum LoadHolding<T> {
    Counterbalance(Counterbalance<T>),
    PilotCheck(PilotCheck<T>),
    HoseBurst(HoseBurst<T>),
}

hydrocrane_num::stored!([] enum LoadHolding<f64> {
    0: Counterbalance { 0: Counterbalance<f64> },
    1: PilotCheck { 0: PilotCheck<f64> },
    2: HoseBurst { 0: HoseBurst<f64> },
});

/// Beyond any pressure (Pa) and flow (m^3/s).
const FAR: f64 = 1e15;

/// What such a valve lets pass.
#[derive(Debug, Clone, Copy)]
pub struct Held<T> {
    /// What is left of the opening of the edge to the tank, m.
    pub edge: T,
    /// Opening of the valve, to which leakage flows in proportion.
    pub open: T,
    /// Where the hose behind it leaks.
    pub behind: Option<Behind<T>>,
}

/// Pressures that act on such a valve, Pa.
#[derive(Debug, Clone, Copy)]
pub struct HeldPressures<T> {
    pub chamber: T,
    /// Of the other port while it is fed, else of the tank.
    pub pilot: T,
    pub tank: T,
}

impl<T: Copy> LoadHolding<T> {
    /// The same with `f` of every number.
    pub fn map<'a, U>(&'a self, f: &mut dyn FnMut(&'a T) -> U) -> LoadHolding<U> {
        match self {
            LoadHolding::Counterbalance(valve) => LoadHolding::Counterbalance(valve.map(f)),
            LoadHolding::PilotCheck(valve) => LoadHolding::PilotCheck(valve.map(f)),
            LoadHolding::HoseBurst(valve) => LoadHolding::HoseBurst(valve.map(f)),
        }
    }
}

impl<T: Real> LoadHolding<T> {
    /// Whether oil gets out of the chamber through its opening alone: not against the flow from the supply.
    pub fn checks(&self) -> bool {
        !matches!(self, LoadHolding::HoseBurst(_))
    }

    /// Opening of the valve in front of a closed spool.
    #[inline(always)]
    pub fn closed(&self, p: &HeldPressures<T>) -> T {
        match self {
            LoadHolding::Counterbalance(valve) => valve.opening(p.chamber, p.pilot),
            LoadHolding::PilotCheck(valve) => valve.opening(p.chamber, p.pilot, p.tank),
            LoadHolding::HoseBurst(_) => T::c(1.0),
        }
    }

    /// The same valve as little and as far open at all pressures as it can be.
    pub fn ends(&self) -> [Self; 2] {
        let (far, near) = (T::c(FAR), T::c(1.0 / FAR));
        match *self {
            LoadHolding::Counterbalance(of) => {
                [far, -far].map(|setting| LoadHolding::Counterbalance(Counterbalance { setting, ..of }))
            }
            LoadHolding::PilotCheck(of) => {
                [far, -far].map(|spring| LoadHolding::PilotCheck(PilotCheck { spring, ..of }))
            }
            LoadHolding::HoseBurst(of) => {
                [near, far].map(|closing_flow| LoadHolding::HoseBurst(HoseBurst { closing_flow, ..of }))
            }
        }
    }

    /// What passes to the `edge` of this `opening` (m) to the tank. A `line` may lie between the two, and the hose may `leak`.
    #[inline(always)]
    pub fn held(
        &self,
        p: &HeldPressures<T>,
        edge: &Orifice<T>,
        opening: T,
        line: Option<&Resistance<T>>,
        leak: Option<&HoseLeak<T>>,
    ) -> Held<T> {
        let along = edge.coefficient * opening;
        let (coefficient, open) = match self {
            LoadHolding::Counterbalance(valve) => (valve.coefficient, valve.opening(p.chamber, p.pilot)),
            LoadHolding::PilotCheck(valve) => (valve.coefficient, valve.opening(p.chamber, p.pilot, p.tank)),
            LoadHolding::HoseBurst(valve) => {
                let whole = p.chamber - p.tank;
                let drop = match line {
                    Some(line) => {
                        let open = in_series(valve.coefficient, along, valve.coefficient * LEAST) / edge.coefficient;
                        line.left(edge, open, whole)
                    }
                    None => whole,
                };
                let root = edge.flow_per_opening(drop) / edge.coefficient;
                (valve.coefficient, valve.opening(leak.map_or(along, |leak| along + leak.coefficient), root))
            }
        };
        let (own, least) = (coefficient * open, coefficient * LEAST);
        match leak {
            Some(leak) => {
                let share = leak.share(own, along, least);
                let free = if self.checks() { T::c(0.0) } else { open };
                Held { edge: opening * share, open, behind: Some(Behind { share, free }) }
            }
            None => Held { edge: in_series(own, along, least) / edge.coefficient, open, behind: None },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::orifice::{share_of_opening, ROUNDING};
    use super::*;
    use hydrocrane_num::{Dual, Field};

    #[test]
    fn two_edges_in_series_share_the_drop() {
        // Equal coefficients leave half the drop to each: the flow falls by the root of two.
        assert!((in_series(1e-7, 1e-7, 1e-16) / 1e-7 * 2f64.sqrt() - 1.0).abs() < 1e-12);
        assert!((in_series(1e-7, 1e-12, 1e-16) / 1e-12 - 1.0).abs() < 1e-6);
        assert_eq!([in_series(0.0, 1e-7, 1e-16), in_series(1e-7, 0.0, 1e-16)], [0.0; 2]);
    }

    #[test]
    fn slopes_are_finite_where_both_are_closed() {
        let series = in_series(Dual::<f64, 2>::variable(0.0, 0), Dual::variable(0.0, 1), Dual::constant(1e-16));
        assert!(series.value == 0.0 && series.derivative.iter().all(|d| d.finite()));
        for share in [-ROUNDING, ROUNDING, 1.0 - ROUNDING, 1.0 + ROUNDING] {
            let at = |offset: f64| share_of_opening(Dual::<f64, 1>::variable(share + offset, 0));
            let (before, after) = (at(-1e-7), at(1e-7));
            assert!((before.value - after.value).abs() < 1e-6);
            assert!((before.derivative[0] - after.derivative[0]).abs() < 1e-5);
        }
    }
}
