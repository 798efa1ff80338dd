//! Spool valve: four metering edges between supply, tank and the ports A and B.
//!                                                        theory: docs/theory/hydraulics/spool_valve.md
//!
//! x_s > 0:  q_A = q(x_s, p_S - p_A),   q_B = q(x_s, p_B - p_0)                           thesis (66)
//! x_s < 0:  q_A = -q(-x_s, p_A - p_0), q_B = -q(-x_s, p_S - p_B)                         thesis (67)
//! regenerative, x_s > 0:               q_B = q(x_s, p_B - p_S)                           thesis (68)
//!
//! | symbol | meaning | sign |
//! | x_s    | spool position, m                          | positive extends the piston |
//! | q_A    | flow from port A into the cylinder, m^3/s  | positive into the chamber   |
//! | q_B    | flow out of the cylinder into port B       | positive out of the chamber |
//!
//! The edges to the tank may be wider or narrower than those from the supply, by r_A and r_B: they meter out r times the flow.
//!
//! With a load check valve the flows from the supply are not below zero: oil does not return from a port. A pressure compensator
//! ([`super::compensator`]) takes its part of the drop from the supply to a port.
//!
//! Between a chamber and its port a valve that holds the load ([`super::load_holding`]) may stand in series with the edge to the
//! tank. The leakage of both edges of the port flows in proportion to its opening.
//!
//! Overlap closes both directions within +-overlap. Leakage (75) is laminar over each edge; unlike (75), which
//! opens it on the closed edges only, it is always there, so the law stays smooth (an open edge drowns it).

use super::compensator::Compensator;
use super::load_holding::{HeldPressures, LoadHolding};
use super::load_sensing::Connection;
use super::orifice::Orifice;
use hydrocrane_num::{smooth, Real};

/// Valve with its edges at port A and at port B (they differ only in the printed law).
#[derive(Debug, Clone, Copy)]
pub struct SpoolValve<T> {
    pub edge_a: Orifice<T>,
    pub edge_b: Orifice<T>,
    /// m
    pub overlap: T,
    /// Laminar conductance of an edge, m^3/(s Pa).
    pub leakage: T,
    /// r_A, r_B: areas of the edges to the tank over those from the supply.
    pub return_ratio: [T; 2],
    /// 1: port B is joined to the supply in both directions; 0: to the tank when extending.
    pub regenerative: T,
    /// A check valve before the edges from the supply.
    pub load_check: bool,
    pub compensator: Compensator<T>,
    pub connection: Connection<T>,
    /// Of the piston side and of the rod side.
    pub holding: [Option<LoadHolding<T>>; 2],
}

impl<T: Copy> SpoolValve<T> {
    /// The same valve with `f` of every number.
    pub fn map<U>(&self, f: &mut impl FnMut(T) -> U) -> SpoolValve<U> {
        SpoolValve {
            edge_a: self.edge_a.map(f),
            edge_b: self.edge_b.map(f),
            overlap: f(self.overlap),
            leakage: f(self.leakage),
            return_ratio: self.return_ratio.map(&mut *f),
            regenerative: f(self.regenerative),
            load_check: self.load_check,
            compensator: self.compensator.map(f),
            connection: self.connection.map(f),
            holding: self.holding.map(|valve| valve.map(|valve| valve.map(f))),
        }
    }

    /// Whether the flow of one port may depend on the pressure of the other.
    pub fn couples_ports(&self) -> bool {
        cfg!(feature = "mobile") && self.holding.iter().any(Option::is_some)
    }
}

/// Pressures around the valve, Pa.
#[derive(Debug, Clone, Copy, Default)]
pub struct PortPressures<T> {
    pub supply: T,
    /// Of the load-sensing line; counts behind a compensator of flow sharing only.
    pub load: T,
    pub tank: T,
    pub a: T,
    pub b: T,
}

/// Flow through each edge, m^3/s, in the direction its name reads.
#[derive(Debug, Clone, Copy, Default)]
pub struct EdgeFlows<T> {
    pub supply_to_a: T,
    pub a_to_tank: T,
    pub supply_to_b: T,
    pub b_to_tank: T,
}

impl<T: Real> SpoolValve<T> {
    #[inline(always)]
    pub fn flows(&self, spool: T, p: &PortPressures<T>) -> EdgeFlows<T> {
        let (supply_to_a, a_to_tank) = self.flows_at_a(spool, p);
        let (supply_to_b, b_to_tank) = self.flows_at_b(spool, p);
        EdgeFlows { supply_to_a, a_to_tank, supply_to_b, b_to_tank }
    }

    /// The same with the spool inside its overlap, where the edges only leak.
    #[inline(always)]
    pub fn closed(&self, p: &PortPressures<T>) -> EdgeFlows<T> {
        let drop = |port: T| self.compensator.drop(p.supply, p.load, port);
        let leakage = |port: usize, chamber: T| match self.holding(port) {
            Some(valve) => self.leakage * valve.closed(&HeldPressures { chamber, pilot: p.tank, tank: p.tank }),
            None => self.leakage,
        };
        let (of_a, of_b) = (leakage(0, p.a), leakage(1, p.b));
        EdgeFlows {
            supply_to_a: self.checked(0, of_a * drop(p.a)),
            a_to_tank: of_a * (p.a - p.tank),
            supply_to_b: self.checked(1, of_b * drop(p.b)),
            b_to_tank: of_b * (p.b - p.tank),
        }
    }

    /// Flows from the supply to port A and from there to the tank, m^3/s.
    #[inline(always)]
    pub fn flows_at_a(&self, spool: T, p: &PortPressures<T>) -> (T, T) {
        let (extend, retract) = self.openings(spool);
        let (fed, drained) = (self.compensator.drop(p.supply, p.load, p.a), p.a - p.tank);
        // At most one edge of a port is open: one root per port serves both.
        let per_opening = self.edge_a.flow_per_opening(T::select(spool.lt(T::c(0.0)), drained, fed));
        let (share, leakage) = self.held(0, spool, self.return_ratio[0] * retract, p);
        let from_supply = self.checked(0, extend * per_opening + leakage * fed);
        (from_supply, share * per_opening + leakage * drained)
    }

    /// The same for port B.
    #[inline(always)]
    pub fn flows_at_b(&self, spool: T, p: &PortPressures<T>) -> (T, T) {
        let (extend, retract) = self.openings(spool);
        let (fed, drained) = (self.compensator.drop(p.supply, p.load, p.b), p.b - p.tank);
        let zero = T::c(0.0);
        let regenerative = zero.lt(self.regenerative);
        let per_opening = self.edge_b.flow_per_opening(T::select(regenerative | spool.lt(zero), fed, drained));
        let to_supply = T::select(regenerative, extend + retract, retract);
        let to_tank = T::select(regenerative, zero, extend);
        let (share, leakage) = self.held(1, spool, self.return_ratio[1] * to_tank, p);
        let from_supply = self.checked(1, to_supply * per_opening + leakage * fed);
        (from_supply, share * per_opening + leakage * drained)
    }

    /// Opening (m) of the edge from a `port` to the tank that is left behind the valve that holds its load, if there is one, and the
    /// leakage that this lets pass.
    #[inline(always)]
    fn held(&self, port: usize, spool: T, opening: T, p: &PortPressures<T>) -> (T, T) {
        let Some(valve) = self.holding(port) else { return (opening, self.leakage) };
        let (chamber, edge) = if port == 0 { (p.a, &self.edge_a) } else { (p.b, &self.edge_b) };
        // The other port opens the valve while it is fed.
        let fed = self.connection.signal(spool, [p.a, p.b], p.tank);
        let extends = T::c(0.0).le(spool);
        let pilot = if port == 0 { T::select(extends, p.tank, fed) } else { T::select(extends, fed, p.tank) };
        let (held, open) = valve.held(&HeldPressures { chamber, pilot, tank: p.tank }, edge, opening);
        // Into the chamber the check valve is open.
        (T::select(chamber.lt(p.tank), opening, held), self.leakage * open)
    }

    #[inline(always)]
    fn holding(&self, port: usize) -> Option<&LoadHolding<T>> {
        self.holding[port].as_ref().filter(|_| cfg!(feature = "mobile"))
    }

    /// Losses of the compensator at the edges to port A and to port B, W, with the flows through `edges`.
    #[inline(always)]
    pub fn compensator_losses(&self, p: &PortPressures<T>, edges: &EdgeFlows<T>) -> [T; 2] {
        let taken = |port: T| p.supply - port - self.compensator.drop(p.supply, p.load, port);
        [taken(p.a) * edges.supply_to_a, taken(p.b) * edges.supply_to_b]
    }

    /// A flow from the supply to a `port` behind a check valve, if there is one: that of the section, or that of a valve that holds.
    #[inline(always)]
    fn checked(&self, port: usize, flow: T) -> T {
        if self.load_check || self.holding(port).is_some_and(LoadHolding::checks) {
            smooth::positive_part(flow)
        } else {
            flow
        }
    }

    /// Openings (m) of the edges that extend and of those that retract the piston.
    #[inline(always)]
    fn openings(&self, spool: T) -> (T, T) {
        (smooth::positive_part(spool - self.overlap), smooth::positive_part(-spool - self.overlap))
    }
}

impl<T: Real> EdgeFlows<T> {
    /// q_A: into the piston-side chamber.
    #[inline(always)]
    pub fn port_a(&self) -> T {
        self.supply_to_a - self.a_to_tank
    }
    /// q_B: out of the rod-side chamber.
    #[inline(always)]
    pub fn port_b(&self) -> T {
        self.b_to_tank - self.supply_to_b
    }
    /// Flow drawn from the pump.
    #[inline(always)]
    pub fn supply(&self) -> T {
        self.supply_to_a + self.supply_to_b
    }
    /// Flow returned to the tank.
    #[inline(always)]
    pub fn tank(&self) -> T {
        self.a_to_tank + self.b_to_tank
    }
}

#[cfg(test)]
mod tests {
    use super::super::counterbalance::Counterbalance;
    use super::super::orifice::OrificeLaw;
    use super::*;

    fn valve(regenerative: bool, overlap: f64) -> SpoolValve<f64> {
        let edge = Orifice {
            coefficient: 7.3e-7,
            transition_pressure: 3e5,
            laminar_curvature: smooth::root_curvature(3e5),
            blend_low: 2e5,
            blend_high: 4e5,
            law: OrificeLaw::TwoRegime,
        };
        SpoolValve {
            edge_a: edge,
            edge_b: edge,
            overlap,
            leakage: 0.0,
            return_ratio: [1.0; 2],
            regenerative: f64::from(u8::from(regenerative)),
            load_check: false,
            compensator: Compensator::None,
            connection: Connection { begins: 0.0, travel: 1e-3 },
            holding: [None; 2],
        }
    }

    const P: PortPressures<f64> = PortPressures { supply: 140e5, load: 0.0, tank: 0.0, a: 60e5, b: 50e5 };

    #[test]
    fn table_2_signs_of_the_four_three_valve() {
        let up = valve(false, 0.0).flows(0.01, &P);
        assert!(up.port_a() > 0.0 && up.port_b() > 0.0 && up.supply_to_b == 0.0);
        let down = valve(false, 0.0).flows(-0.01, &P);
        assert!(down.port_a() < 0.0 && down.port_b() < 0.0);
    }

    #[test]
    fn table_2_signs_of_the_regenerative_valve() {
        // Extending, oil leaves B against the supply only if p_B exceeds it; here both chambers are fed.
        let fed = valve(true, 0.0).flows(0.01, &P);
        assert!(fed.port_a() > 0.0 && fed.port_b() < 0.0 && fed.tank() == 0.0);
        let pushed = valve(true, 0.0).flows(0.01, &PortPressures { b: 170e5, ..P });
        assert!(pushed.port_b() > 0.0);
        let retract = valve(true, 0.0).flows(-0.01, &P);
        assert!(retract.port_a() < 0.0 && retract.port_b() < 0.0);
    }

    #[test]
    fn narrow_edges_to_the_tank_meter_out() {
        let (plain, narrow) = (valve(false, 0.0), SpoolValve { return_ratio: [0.25, 0.5], ..valve(false, 0.0) });
        let (up, down) = (plain.flows(0.01, &P), plain.flows(-0.01, &P));
        let (narrow_up, narrow_down) = (narrow.flows(0.01, &P), narrow.flows(-0.01, &P));
        assert_eq!((narrow_up.supply_to_a, narrow_up.b_to_tank), (up.supply_to_a, 0.5 * up.b_to_tank));
        assert_eq!((narrow_down.supply_to_b, narrow_down.a_to_tank), (down.supply_to_b, 0.25 * down.a_to_tank));
    }

    #[test]
    fn closed_or_overlapped_valve_passes_nothing() {
        for (overlap, spool) in [(0.0, 0.0), (1e-3, 0.9e-3), (1e-3, -0.9e-3)] {
            let f = valve(false, overlap).flows(spool, &P);
            assert_eq!((f.port_a(), f.port_b()), (0.0, 0.0));
        }
    }

    #[test]
    fn behind_a_check_valve_a_load_above_the_supply_is_held() {
        let checked = SpoolValve { load_check: true, leakage: 1e-13, ..valve(false, 0.0) };
        let heavy = PortPressures { a: 180e5, ..P };
        assert!(valve(false, 0.0).flows(0.01, &heavy).supply_to_a < 0.0);
        assert_eq!(checked.flows(0.01, &heavy).supply_to_a, 0.0);
        assert_eq!(
            checked.flows(0.01, &P).supply_to_a,
            SpoolValve { load_check: false, ..checked }.flows(0.01, &P).supply_to_a
        );
        // Towards the tank it acts on nothing.
        let open = SpoolValve { load_check: false, ..checked };
        assert_eq!(checked.flows(-0.01, &P).a_to_tank, open.flows(-0.01, &P).a_to_tank);
    }

    #[test]
    fn behind_a_compensator_the_flow_does_not_depend_on_the_load() {
        let plain = valve(false, 0.0);
        let compensated = SpoolValve { compensator: Compensator::Before(8e5), ..plain };
        let wanted = plain.flows(0.01, &PortPressures { a: P.supply - 8e5, ..P }).supply_to_a;
        for a in [10e5, 60e5, 120e5] {
            let p = PortPressures { a, ..P };
            let flows = compensated.flows(0.01, &p);
            assert!((flows.supply_to_a / wanted - 1.0).abs() < 1e-12);
            // Towards the tank it acts on nothing, and what the edge does not lose the compensator does.
            assert_eq!(flows.b_to_tank, plain.flows(0.01, &p).b_to_tank);
            let [lost, none] = compensated.compensator_losses(&p, &flows);
            assert!(((P.supply - a - 8e5) * wanted / lost - 1.0).abs() < 1e-9);
            assert_eq!(none, 0.0);
        }
    }

    #[test]
    fn a_counterbalance_valve_holds_until_the_other_port_is_fed() {
        let counterbalance =
            Counterbalance { setting: 120e5, pilot_ratio: 3.0, opening_pressure: 30e5, coefficient: 1e-6 };
        let plain = SpoolValve { leakage: 1e-13, ..valve(false, 0.0) };
        let held = SpoolValve { holding: [Some(LoadHolding::Counterbalance(counterbalance)), None], ..plain };
        // 60 bar hold until the other port has 20 bar.
        for (b, holds) in [(0.0, true), (10e5, true), (45e5, false)] {
            let p = PortPressures { b, ..P };
            let (down, free) = (held.flows(-0.02, &p), plain.flows(-0.02, &p));
            assert_eq!(down.a_to_tank == 0.0, holds, "{b}");
            assert!(down.a_to_tank < free.a_to_tank && down.supply_to_b == free.supply_to_b);
        }
        // In the middle it seals, leakage too; upwards it is no hindrance.
        assert_eq!(held.flows(0.0, &P).a_to_tank, 0.0);
        assert_eq!(held.flows(0.02, &P).supply_to_a, valve(false, 0.0).flows(0.02, &P).supply_to_a);
    }

    #[test]
    fn leakage_feeds_both_ports_of_a_closed_valve_and_vanishes_in_the_sum() {
        let leaking = SpoolValve { leakage: 1e-13, ..valve(false, 0.0) };
        let f = leaking.flows(0.0, &P);
        assert!((f.port_a() - 1e-13 * (P.supply - 2.0 * P.a + P.tank)).abs() < 1e-20);
        // What the pump gives and the tank takes differs by what the ports take.
        assert!((f.supply() - f.tank() - (f.port_a() - f.port_b())).abs() < 1e-20);
    }
}
