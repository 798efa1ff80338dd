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
//! The line between a port and its chamber takes its part of the drop ([`super::line`]): `a` and `b` are the pressures behind the
//! lines, at the cylinder. The leakage takes no part in that.
//!
//! The edge from a port to the tank may have a spool of its own that keeps a return pressure ([`super::meter_out`]).
//!
//! Between a chamber and its port a valve that holds the load ([`super::load_holding`]) may stand in series with the edge to the
//! tank. The leakage of both edges of the port flows in proportion to its opening.
//!
//! Overlap closes both directions within +-overlap, where no curve ([`super::metering`]) says how an edge opens. Leakage (75) is laminar over each edge; unlike (75), which
//! opens it on the closed edges only, it is always there, so the law stays smooth (an open edge drowns it).

use super::compensator::Compensator;
use super::edge_flows::{EdgeFlows, PortFlows, PortPressures};
use super::hose_leak::{Behind, HoseLeak, Leaking};
use super::line::Resistance;
use super::load_holding::{Held, HeldPressures, LoadHolding};
use super::load_sensing::Connection;
use super::meter_out::MeterOut;
use super::metering::{Edge, Metering};
use super::orifice::Orifice;
use super::parts::{AnyParts, NoParts, Parts};
use hydrocrane_num::{functions::smooth, Real};

/// Valve with its edges at port A and at port B (they differ only in the printed law).
#[derive(Debug, Clone, Copy)]
pub struct SpoolValve<T> {
    pub edge_a: Orifice<T>,
    pub edge_b: Orifice<T>,
    /// m
    pub overlap: T,
    /// Opening that has the nominal flow at the nominal drop: stroke less overlap, m.
    pub nominal_opening: T,
    /// `None`: all edges open in proportion to the spool, beyond the overlap.
    pub metering: Option<Metering<T>>,
    /// Of the edges from port A and from port B to the tank; `None`: the same spool opens them.
    pub meter_out: [Option<MeterOut<T>>; 2],
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
    /// Between port A, port B and their chambers; `None`: without resistance.
    pub lines: [Option<Resistance<T>>; 2],
}

hydrocrane_num::stored!([] SpoolValve<f64> {
    edge_a: Orifice<f64>,
    edge_b: Orifice<f64>,
    overlap: f64,
    nominal_opening: f64,
    metering: Option<Metering<f64>>,
    meter_out: [Option<MeterOut<f64>>; 2],
    leakage: f64,
    return_ratio: [f64; 2],
    regenerative: f64,
    load_check: bool,
    compensator: Compensator<f64>,
    connection: Connection<f64>,
    holding: [Option<LoadHolding<f64>>; 2],
    lines: [Option<Resistance<f64>>; 2],
});

impl<T: Copy> SpoolValve<T> {
    /// The same valve with `f` of every number.
    pub fn map<'a, U>(&'a self, f: &mut dyn FnMut(&'a T) -> U) -> SpoolValve<U> {
        SpoolValve {
            edge_a: self.edge_a.map(f),
            edge_b: self.edge_b.map(f),
            overlap: f(&self.overlap),
            nominal_opening: f(&self.nominal_opening),
            metering: self.metering().map(|metering| metering.map(f)),
            meter_out: self.meter_out.each_ref().map(|of| AnyParts::part(of.as_ref()).map(|of| of.map(f))),
            leakage: f(&self.leakage),
            return_ratio: self.return_ratio.each_ref().map(&mut *f),
            regenerative: f(&self.regenerative),
            load_check: self.load_check,
            compensator: self.compensator.map(f),
            connection: self.connection.map(f),
            holding: self.holding.each_ref().map(|valve| AnyParts::part(valve.as_ref()).map(|valve| valve.map(f))),
            lines: self.lines.each_ref().map(|line| AnyParts::part(line.as_ref()).map(|line| line.map(f))),
        }
    }

    /// The curves of its edges.
    #[inline(always)]
    pub fn metering(&self) -> Option<&Metering<T>> {
        AnyParts::part(self.metering.as_ref())
    }

    /// Whether it has any of the parts that [`Parts`] counts.
    pub fn has_parts(&self) -> bool {
        // Every field is named, so that none is forgotten when one is added.
        let SpoolValve {
            edge_a: _,
            edge_b: _,
            overlap: _,
            nominal_opening: _,
            metering,
            meter_out,
            leakage: _,
            return_ratio: _,
            regenerative: _,
            load_check,
            compensator,
            connection: _,
            holding,
            lines,
        } = self;
        let at = |port: usize| meter_out[port].is_some() || holding[port].is_some() || lines[port].is_some();
        let of_section = metering.is_some() || *load_check || !matches!(compensator, Compensator::None);
        AnyParts::EXPECTED && (of_section || at(0) || at(1))
    }

    /// Whether the flow of one port may depend on the pressure of the other.
    pub fn couples_ports(&self) -> bool {
        AnyParts::EXPECTED && self.holding.iter().any(Option::is_some)
    }
}

impl<T: Real> SpoolValve<T> {
    /// Flows through all edges. A function of its own, in which a section without any part is spared the laws of parts.
    #[inline(never)]
    pub fn flows(&self, spool: T, p: &PortPressures<T>) -> EdgeFlows<T> {
        if self.has_parts() {
            self.flows_with::<AnyParts>(spool, p)
        } else {
            self.flows_with::<NoParts>(spool, p)
        }
    }

    /// The same where parts have to be expected or not.
    #[inline(always)]
    pub fn flows_with<P: Parts>(&self, spool: T, p: &PortPressures<T>) -> EdgeFlows<T> {
        let a = self.flows_at_a::<P>(spool, p, None);
        let b = self.flows_at_b::<P>(spool, p, None);
        EdgeFlows { supply_to_a: a.fed, a_to_tank: a.drained, supply_to_b: b.fed, b_to_tank: b.drained }
    }

    /// The same with the spool inside its overlap, where the edges only leak.
    #[inline(always)]
    pub fn closed(&self, p: &PortPressures<T>) -> EdgeFlows<T> {
        let drop = |port: T| self.compensated(p, port);
        let leakage = |port: usize, chamber: T| match self.holding(port) {
            Some(valve) => self.leakage * valve.closed(&HeldPressures { chamber, pilot: p.tank, tank: p.tank }),
            None => self.leakage,
        };
        let (of_a, of_b) = (leakage(0, p.a), leakage(1, p.b));
        EdgeFlows {
            supply_to_a: self.checked::<AnyParts>(0, of_a * drop(p.a)),
            a_to_tank: of_a * (p.a - p.tank),
            supply_to_b: self.checked::<AnyParts>(1, of_b * drop(p.b)),
            b_to_tank: of_b * (p.b - p.tank),
        }
    }

    /// Flows of port A, whose hose may `leak`.
    #[inline(always)]
    pub fn flows_at_a<P: Parts>(&self, spool: T, p: &PortPressures<T>, leak: Option<&HoseLeak<T>>) -> PortFlows<T> {
        let (extend, retract) = self.openings::<P>(spool, [Edge::SupplyToA, Edge::AToTank]);
        let retract = self.metered_out::<P>(0, -spool, p.a).unwrap_or(retract);
        let (fed, drained) = (self.fed_drop::<P>(p, p.a), p.a - p.tank);
        let (share, leakage, behind) = self.held::<P>(0, spool, self.return_ratio[0] * retract, p, leak);
        // At most one edge of a port is open: one root per port serves both.
        let drains = spool.lt(T::c(0.0));
        let open = |from_supply: T, to_tank: T| T::select(drains, to_tank, from_supply);
        let drop = match P::part(self.line(0)) {
            Some(line) => self.left(line, &self.edge_a, [extend, share], p.a, p, open),
            None => open(fed, drained),
        };
        let per_opening = self.edge_a.flow_per_opening(drop);
        PortFlows {
            fed: self.checked::<P>(0, extend * per_opening + leakage * fed),
            drained: share * per_opening + leakage * drained,
            leaking: self.leaking(0, extend, p, leak, behind),
        }
    }

    /// The same for port B.
    #[inline(always)]
    pub fn flows_at_b<P: Parts>(&self, spool: T, p: &PortPressures<T>, leak: Option<&HoseLeak<T>>) -> PortFlows<T> {
        let (extend, retract) = self.openings::<P>(spool, [Edge::BToTank, Edge::SupplyToB]);
        let (fed, drained) = (self.fed_drop::<P>(p, p.b), p.b - p.tank);
        let zero = T::c(0.0);
        let regenerative = zero.lt(self.regenerative);
        let to_supply = T::select(regenerative, extend + retract, retract);
        let to_tank = T::select(regenerative, zero, self.metered_out::<P>(1, spool, p.b).unwrap_or(extend));
        let (share, leakage, behind) = self.held::<P>(1, spool, self.return_ratio[1] * to_tank, p, leak);
        let feeds = regenerative | spool.lt(zero);
        let open = |from_supply: T, to_tank: T| T::select(feeds, from_supply, to_tank);
        let drop = match P::part(self.line(1)) {
            Some(line) => self.left(line, &self.edge_b, [to_supply, share], p.b, p, open),
            None => open(fed, drained),
        };
        let per_opening = self.edge_b.flow_per_opening(drop);
        PortFlows {
            fed: self.checked::<P>(1, to_supply * per_opening + leakage * fed),
            drained: share * per_opening + leakage * drained,
            leaking: self.leaking(1, to_supply, p, leak, behind),
        }
    }

    /// Drop over the edge from the supply to a port at this pressure, Pa.
    #[inline(always)]
    fn fed_drop<P: Parts>(&self, p: &PortPressures<T>, port: T) -> T {
        if P::EXPECTED {
            self.compensated(p, port)
        } else {
            p.supply - port
        }
    }

    /// Flow from the supply through an edge of this `opening` (m), the line and the hole of the hose to the outside, m^3/s, where the hose
    /// may `leak`, with the valve `behind` it.
    #[inline(always)]
    fn leaking(
        &self,
        port: usize,
        opening: T,
        p: &PortPressures<T>,
        leak: Option<&HoseLeak<T>>,
        behind: Option<Behind<T>>,
    ) -> Option<Leaking<T>> {
        let (hole, edge) = (leak?.resistance(), self.edge(port));
        let all = match self.line(port) {
            Some(line) => {
                Resistance { laminar: line.laminar + hole.laminar, turbulent: line.turbulent + hole.turbulent }
            }
            None => hole,
        };
        let drop = self.left(&all, edge, [opening; 2], T::c(0.0), p, |from_supply, _| from_supply);
        Some(Leaking { outward: smooth::positive_part(opening * edge.flow_per_opening(drop)), behind })
    }

    /// Drop (Pa) over that edge of a port which is `open`, of the one from the supply and the one to the tank with these `openings` (m),
    /// where a line lies between the port and its `chamber` (Pa).
    #[inline(always)]
    fn left(
        &self,
        line: &Resistance<T>,
        edge: &Orifice<T>,
        openings: [T; 2],
        chamber: T,
        p: &PortPressures<T>,
        open: impl Fn(T, T) -> T,
    ) -> T {
        let whole = open(p.supply - chamber, chamber - p.tank);
        // What follows late throttles its edge.
        let fed = match p.opening {
            Some(opening) => openings[0] * opening,
            None => openings[0],
        };
        let left = line.left(edge, open(fed, openings[1]), whole);
        // The compensator acts where more is left than it lets the edge have.
        open(self.compensated(p, p.supply - left), left)
    }

    /// Pressure of a `port` above that behind its line, Pa, with the flow into the cylinder through it (m^3/s).
    #[inline(always)]
    pub fn line_drop(&self, port: usize, inflow: T) -> T {
        match self.line(port) {
            Some(line) => line.drop(inflow),
            None => T::c(0.0),
        }
    }

    /// The law of the edges of a `port`.
    #[inline(always)]
    fn edge(&self, port: usize) -> &Orifice<T> {
        if port == 0 {
            &self.edge_a
        } else {
            &self.edge_b
        }
    }

    /// The line of a `port`, if it has a resistance.
    #[inline(always)]
    pub fn line(&self, port: usize) -> Option<&Resistance<T>> {
        AnyParts::part(self.lines[port].as_ref())
    }

    /// Opening (m) of the edge from a `port` to the tank that is left behind the valve that holds its load, if there is one, the leakage
    /// that this lets pass, and the valve itself where its hose may `leak`.
    #[inline(always)]
    fn held<P: Parts>(
        &self,
        port: usize,
        spool: T,
        opening: T,
        p: &PortPressures<T>,
        leak: Option<&HoseLeak<T>>,
    ) -> (T, T, Option<Behind<T>>) {
        let Some(valve) = P::part(self.holding(port)) else { return (opening, self.leakage, None) };
        let (chamber, edge) = (if port == 0 { p.a } else { p.b }, self.edge(port));
        // The other port opens the valve while it is fed.
        let fed = self.connection.signal(spool, [p.a, p.b], p.tank);
        let extends = T::c(0.0).le(spool);
        let pilot = if port == 0 { T::select(extends, p.tank, fed) } else { T::select(extends, fed, p.tank) };
        let pressures = HeldPressures { chamber, pilot, tank: p.tank };
        let Held { edge: held, open, behind } = valve.held(&pressures, edge, opening, self.line(port), leak);
        // Into the chamber the check valve is open.
        (T::select(chamber.lt(p.tank), opening, held), self.leakage * open, behind)
    }

    /// Opening (m) of the edge from a `port` to the tank that a spool of its own has, if there is one.
    #[inline(always)]
    fn metered_out<P: Parts>(&self, port: usize, travel: T, pressure: T) -> Option<T> {
        let of = P::part(self.meter_out(port))?;
        Some(self.nominal_opening * of.opening(&self.connection, travel, pressure))
    }

    /// The spool of its own of the edge from a `port` to the tank.
    #[inline(always)]
    pub fn meter_out(&self, port: usize) -> Option<&MeterOut<T>> {
        AnyParts::part(self.meter_out[port].as_ref())
    }

    #[inline(always)]
    fn holding(&self, port: usize) -> Option<&LoadHolding<T>> {
        AnyParts::part(self.holding[port].as_ref())
    }

    /// Openings (m) of the edges in the order of [`Edge`]. In a regenerative valve the one from the supply to port B opens both ways.
    pub fn edge_openings(&self, spool: T) -> [T; 4] {
        let (to_a, from_a) = self.openings::<AnyParts>(spool, [Edge::SupplyToA, Edge::AToTank]);
        let (from_b, to_b) = self.openings::<AnyParts>(spool, [Edge::BToTank, Edge::SupplyToB]);
        let (zero, regenerative) = (T::c(0.0), T::c(0.0).lt(self.regenerative));
        let to_tank = T::select(regenerative, zero, from_b * self.return_ratio[1]);
        [to_a, from_a * self.return_ratio[0], to_b + T::select(regenerative, from_b, zero), to_tank]
    }

    /// Drop over the edge from the supply to a port, Pa: what the compensator leaves.
    #[inline(always)]
    pub fn compensated(&self, p: &PortPressures<T>, port: T) -> T {
        self.compensator.drop(p.supply, p.load, p.opening, port)
    }

    /// Opening that a compensator that follows late wants: that of its static law at the port that is fed, or at the tank where none is.
    #[inline(always)]
    pub fn settled_opening(&self, spool: T, p: &PortPressures<T>) -> T {
        self.compensator.settled_opening(p.supply, p.load, self.connection.signal(spool, [p.a, p.b], p.tank))
    }

    /// Losses of the compensator at the edges to port A and to port B, W, with the flows through `edges`.
    #[inline(always)]
    pub fn compensator_losses(&self, p: &PortPressures<T>, edges: &EdgeFlows<T>) -> [T; 2] {
        [self.taken(p, p.a) * edges.supply_to_a, self.taken(p, p.b) * edges.supply_to_b]
    }

    /// What the compensator takes of the drop from the supply to the port that the spool feeds, Pa; zero where it feeds none, and where
    /// the compensator is fully open.
    pub fn compensator_drop(&self, spool: T, p: &PortPressures<T>) -> T {
        self.connection.signal(spool, [self.taken(p, p.a), self.taken(p, p.b)], T::c(0.0))
    }

    /// What the compensator takes of the drop to a `port` at this pressure (Pa), Pa.
    #[inline(always)]
    fn taken(&self, p: &PortPressures<T>, port: T) -> T {
        p.supply - port - self.compensated(p, port)
    }

    /// A flow from the supply to a `port` behind a check valve, if there is one: that of the section, or that of a valve that holds.
    #[inline(always)]
    fn checked<P: Parts>(&self, port: usize, flow: T) -> T {
        if P::EXPECTED && (self.load_check || self.holding(port).is_some_and(LoadHolding::checks)) {
            smooth::positive_part(flow)
        } else {
            flow
        }
    }

    /// Openings (m) of the edge of a port that extends and of the one that retracts the piston.
    #[inline(always)]
    fn openings<P: Parts>(&self, spool: T, [extending, retracting]: [Edge; 2]) -> (T, T) {
        match P::part(self.metering()) {
            Some(metering) => {
                (metering.opening(extending, spool, self.overlap), metering.opening(retracting, -spool, self.overlap))
            }
            None => (smooth::positive_part(spool - self.overlap), smooth::positive_part(-spool - self.overlap)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::counterbalance::Counterbalance;
    use super::super::orifice::OrificeLaw;
    use super::*;
    use hydrocrane_num::functions::curve::MonotoneCurve;

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
            metering: None,
            nominal_opening: 0.05,
            meter_out: [None; 2],
            leakage: 0.0,
            return_ratio: [1.0; 2],
            regenerative: f64::from(u8::from(regenerative)),
            load_check: false,
            compensator: Compensator::None,
            connection: Connection { begins: 0.0, travel: 1e-3 },
            holding: [None; 2],
            lines: [None; 2],
        }
    }

    const P: PortPressures<f64> =
        PortPressures { supply: 140e5, load: 0.0, tank: 0.0, a: 60e5, b: 50e5, opening: None };

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
    fn a_line_leaves_the_edge_its_part_and_a_compensator_what_it_can_spare() {
        let line = Resistance { laminar: 1e10, turbulent: 1e13 };
        let plain = valve(false, 0.0);
        let lined = SpoolValve { lines: [Some(line); 2], ..plain };
        for spool in [0.01, -0.01, 0.04] {
            let flows = lined.flows(spool, &P);
            // The flow is that of the valve alone between the pressures before the lines.
            let at_valve =
                PortPressures { a: P.a + line.drop(flows.port_a()), b: P.b + line.drop(-flows.port_b()), ..P };
            let alone = plain.flows(spool, &at_valve);
            assert!((flows.port_a() / alone.port_a() - 1.0).abs() < 1e-9, "{spool}");
            assert!((flows.port_b() / alone.port_b() - 1.0).abs() < 1e-9, "{spool}");
            assert!(flows.port_a().abs() < plain.flows(spool, &P).port_a().abs());
        }
        // 80 bar are enough for 8 bar over the edge and what the line takes; 8.5 bar are not.
        let compensated = SpoolValve { compensator: Compensator::Before(8e5), ..plain };
        let both = SpoolValve { lines: lined.lines, ..compensated };
        let ample = both.flows(0.05, &P).supply_to_a / compensated.flows(0.05, &P).supply_to_a;
        let p = PortPressures { a: P.supply - 8.5e5, ..P };
        let scarce = both.flows(0.05, &p).supply_to_a / lined.flows(0.05, &p).supply_to_a;
        assert!((ample - 1.0).abs() < 1e-12 && (scarce - 1.0).abs() < 1e-9, "{ample} {scarce}");
    }

    #[test]
    fn a_spool_of_its_own_for_the_return_keeps_its_pressure() {
        let out = SpoolValve { meter_out: [Some(MeterOut { pressure: 55e5, range: 10e5 }), None], ..valve(false, 0.0) };
        let plain = valve(false, 0.0);
        // At 60 bar it is half open, whatever the feed; below 55 bar it is closed.
        for spool in [-0.01, -0.04] {
            let (flows, full) = (out.flows(spool, &P), plain.flows(-0.05, &P));
            assert!((flows.a_to_tank / (0.5 * full.a_to_tank) - 1.0).abs() < 1e-12);
            assert_eq!(flows.supply_to_b, plain.flows(spool, &P).supply_to_b);
            assert_eq!(out.flows(spool, &PortPressures { a: 50e5, ..P }).a_to_tank, 0.0);
        }
        assert_eq!(out.flows(0.02, &P).a_to_tank, 0.0);
        assert_eq!(out.flows(0.02, &P).b_to_tank, plain.flows(0.02, &P).b_to_tank);
    }

    #[test]
    fn each_edge_opens_by_its_own_curve() {
        let notched = |area: f64| Some(MonotoneCurve::new(&[[0.0, 0.0], [0.2, 0.0], [0.6, area], [1.0, 1.0]]));
        let curves = [notched(0.1), notched(0.2), notched(0.3), notched(0.4)];
        let plain = valve(false, 0.0);
        let curved =
            SpoolValve { metering: Some(Metering { stroke: 0.05, full: [0.05; 4], curves }), ..valve(false, 0.0) };
        // At 60 % of the stroke; the plain edge has that opening.
        let (up, down) = (curved.flows(0.03, &P), curved.flows(-0.03, &P));
        let by_area = |area: f64, sense: f64| plain.flows(sense * 0.05 * area, &P);
        let near = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
        near(up.supply_to_a, by_area(0.1, 1.0).supply_to_a);
        near(up.b_to_tank, by_area(0.4, 1.0).b_to_tank);
        near(down.a_to_tank, by_area(0.2, -1.0).a_to_tank);
        near(down.supply_to_b, by_area(0.3, -1.0).supply_to_b);
        assert_eq!((curved.flows(0.009, &P).supply(), curved.flows(-0.009, &P).tank()), (0.0, 0.0));
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
            assert!((compensated.compensator_drop(0.01, &p) - (P.supply - a - 8e5)).abs() < 1e-6);
        }
        // In the middle no port is fed; without a compensator nothing is taken.
        assert_eq!((compensated.compensator_drop(0.0, &P), plain.compensator_drop(0.01, &P)), (0.0, 0.0));
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
