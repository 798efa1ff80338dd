//! Openings of a valve as shares of the speed that they give.   theory: docs/theory/control/valve.md
//!
//! o = (|x| - overlap)/(stroke - overlap)                        where edges open in proportion to the spool
//! o = w_a f_a(|x|)/f_a(stroke) + w_b f_b(|x|)/f_b(stroke)       with curves f of the two open edges and what each gives at these pressures, w
//!
//! In steady motion
//! o = sqrt(R(stroke)/R(|x|)),   R = A_1^3/(C_a f_a)^2 + A_2^3/(C_b f_b)^2      with curves f of the two open edges
//! o = f(|x|)/f(stroke)                                          of the fed edge behind a compensator
//! This holds at all pressures where a spool of its own keeps the return pressure.

use crate::model::controller_model::CylinderModel;
use hydrocrane_num::{portable, Real};
use hydrocrane_physics::hydraulics::compensator::Compensator;
use hydrocrane_physics::hydraulics::metering::Edge;

/// Shares of the speed that a piston has at full stroke over that with closed edges, by the edges at port A and at port B, retracting and
/// extending.
pub type Shares = [[f64; 2]; 2];

/// Opening that counts as none.
const CLOSED: f64 = 1e-9;
/// Halvings that find a spool position.
const HALVINGS: usize = 45;

impl CylinderModel {
    /// Opening that commands reach towards `sense` (+1 or -1), as a share of the whole.
    pub fn reach(&self, sense: f64) -> f64 {
        let [low, high] = self.chain.reach(self.stroke);
        let spool = if sense > 0.0 { high } else { -low };
        if self.is_curved() {
            return self.share_of_speed(usize::from(sense > 0.0), spool);
        }
        ((spool - self.valve.overlap) / (self.stroke - self.valve.overlap)).clamp(0.0, 1.0)
    }

    /// Spool position (m) of an opening; the middle of the overlap where it is closed.
    pub fn spool(&self, opening: f64) -> f64 {
        if self.is_curved() {
            let travel = if opening == 0.0 { 0.0 } else { self.travel(usize::from(opening > 0.0), opening.abs()) };
            return travel.copysign(opening);
        }
        let overlap = if opening == 0.0 { 0.0 } else { self.valve.overlap };
        (overlap + opening.abs() * (self.stroke - self.valve.overlap)).copysign(opening)
    }
}

impl CylinderModel {
    /// Whether the two open edges do not open in proportion to the spool.
    fn is_curved(&self) -> bool {
        self.valve.metering().is_some() || (0..2).any(|port| self.valve.meter_out(port).is_some())
    }

    /// A_1^3/C_a^2 + A_2^3/C_b^2 with edges at port A and at port B that open by `ratios` of a metre per metre.
    pub(crate) fn resistance(&self, ratios: [f64; 2]) -> f64 {
        let coefficients = [self.valve.edge_a.coefficient, self.valve.edge_b.coefficient];
        let areas = [self.chambers.area_1, self.chambers.area_2];
        (0..2).map(|i| areas[i] * areas[i].square() / (ratios[i] * coefficients[i]).square()).sum()
    }

    /// Openings of the edges at port A and at port B over the nominal one at full stroke, retracting and extending.
    pub(crate) fn ratios_at_full_stroke(&self) -> [[f64; 2]; 2] {
        if self.is_curved() {
            return [0, 1].map(|side| self.ratios(side, self.stroke));
        }
        let [r_a, r_b] = self.valve.return_ratio;
        [[r_a, 1.0], [1.0, r_b]]
    }

    /// The same at `travel` (m) from the middle towards one side.
    fn ratios(&self, side: usize, travel: f64) -> [f64; 2] {
        let (valve, [r_a, r_b]) = (&self.valve, self.valve.return_ratio);
        let edges = [[Edge::AToTank, Edge::SupplyToB], [Edge::SupplyToA, Edge::BToTank]][side];
        let factors = [[r_a, 1.0], [1.0, r_b]][side];
        hydrocrane_num::array::from_fn(|port| {
            let drains = (port == 0) == (side == 0);
            if drains && valve.meter_out(port).is_some() {
                return factors[port];
            }
            let linear = (travel - valve.overlap).max(0.0);
            let opening =
                valve.metering().map_or(linear, |metering| metering.opening(edges[port], travel, valve.overlap));
            factors[port] * opening / (self.stroke - valve.overlap)
        })
    }

    /// Steady speed at `travel` (m) towards one side over that at full stroke.
    fn share_of_speed(&self, side: usize, travel: f64) -> f64 {
        let [now, full] = [travel.clamp(0.0, self.stroke), self.stroke].map(|travel| self.ratios(side, travel));
        if matches!(self.valve.compensator, Compensator::Before(_)) {
            let fed = 1 - side;
            return now[fed] / full[fed];
        }
        // A closed edge has infinite resistance.
        portable::sqrt(self.resistance(full) / self.resistance(now))
    }

    /// The same at the present pressures, of which the edges at port A and at port B give these `shares` at full stroke.
    fn share_now(&self, side: usize, shares: &[f64; 2], travel: f64) -> f64 {
        let [now, full] = [travel.clamp(0.0, self.stroke), self.stroke].map(|travel| self.ratios(side, travel));
        shares[0] * now[0] / full[0] + shares[1] * now[1] / full[1]
    }

    /// Displacement (m) towards one side that has a share of the steady speed at full stroke.
    fn travel(&self, side: usize, share: f64) -> f64 {
        self.least_travel(|travel| self.share_of_speed(side, travel) >= share)
    }

    /// The least displacement (m) for which something holds that holds beyond it too.
    fn least_travel(&self, holds: impl Fn(f64) -> bool) -> f64 {
        let (mut short, mut enough) = (0.0, self.stroke);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (short + enough);
            if holds(middle) {
                enough = middle;
            } else {
                short = middle;
            }
        }
        enough
    }
}

/// From an opening to the spool and back at the present pressures: what depends on the valve alone.
#[derive(Debug, Clone, Copy)]
pub struct Edges {
    /// Displacements (m) from which on the edges at port A and at port B pass oil, retracting and extending.
    begins: [[f64; 2]; 2],
    /// Whether each of the two opens along a curve of its own.
    apart: bool,
}

impl Edges {
    pub fn of(c: &CylinderModel) -> Self {
        let apart = c.valve.metering().is_some() && (0..2).all(|port| c.valve.meter_out(port).is_none());
        let opens = |side: usize, port: usize| c.least_travel(|travel| c.ratios(side, travel)[port] > CLOSED);
        let begins = [0, 1].map(|side| match (apart, c.is_curved()) {
            (true, _) => [opens(side, 0), opens(side, 1)],
            (false, true) => [c.travel(side, CLOSED); 2],
            (false, false) => [c.valve.overlap; 2],
        });
        Edges { begins, apart }
    }

    /// Half width of the closed zone in the mean of both senses, m, beyond which both edges are open.
    pub fn closed_zone(&self) -> f64 {
        let [retracting, extending] = self.begins.map(|[a, b]| a.max(b));
        0.5 * (retracting + extending)
    }

    /// Displacements (m) from which on the piston moves, retracting and extending, where edges give these `shares` of its speed.
    pub fn begin(&self, shares: &Shares) -> [f64; 2] {
        hydrocrane_num::array::from_fn(|side| {
            let (begins, shares) = (self.begins[side], shares[side]);
            let last = begins[0].max(begins[1]);
            (0..2).filter(|port| shares[*port] > 0.0).fold(last, |first, port| first.min(begins[port]))
        })
    }

    /// Opening with the spool at `spool` (m), as a signed share of the whole, where edges give these `shares` of the speed.
    pub fn opening(&self, c: &CylinderModel, shares: &Shares, spool: f64) -> f64 {
        let side = usize::from(spool > 0.0);
        let opening = match (self.apart, c.is_curved()) {
            (true, _) => c.share_now(side, &shares[side], spool.abs()),
            (false, true) => c.share_of_speed(side, spool.abs()),
            (false, false) => (spool.abs() - c.valve.overlap).max(0.0) / (c.stroke - c.valve.overlap),
        };
        opening.copysign(spool)
    }

    /// Spool position (m) of an opening, the other way.
    pub fn spool(&self, c: &CylinderModel, shares: &Shares, opening: f64) -> f64 {
        if !self.apart || opening == 0.0 {
            return c.spool(opening);
        }
        let side = usize::from(opening > 0.0);
        let travel = if opening.abs() < CLOSED {
            self.begin(shares)[side]
        } else {
            c.least_travel(|travel| c.share_now(side, &shares[side], travel) >= opening.abs())
        };
        travel.copysign(opening)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::feed_forward::{Ahead, Moment, Steady, SupplyPressures};
    use crate::model::signal_chain::SignalChain;
    use crate::model::valve_answer::ValveDynamics;
    use hydrocrane_num::functions::curve::MonotoneCurve;
    use hydrocrane_num::functions::smooth;
    use hydrocrane_physics::friction::StaticParameters;
    use hydrocrane_physics::hydraulics::chamber::Chambers;
    use hydrocrane_physics::hydraulics::edge_flows::PortPressures;
    use hydrocrane_physics::hydraulics::leakage::Leakage;
    use hydrocrane_physics::hydraulics::load_sensing::Connection;
    use hydrocrane_physics::hydraulics::metering::Metering;
    use hydrocrane_physics::hydraulics::orifice::{Orifice, OrificeLaw};
    use hydrocrane_physics::hydraulics::spool_valve::SpoolValve;

    const STROKE: f64 = 7e-3;

    /// Notched edges from the supply, wider ones to the tank.
    fn cylinder(compensator: Compensator<f64>) -> CylinderModel {
        let edge = Orifice {
            coefficient: 1e-5,
            transition_pressure: 1e4,
            laminar_curvature: smooth::root_curvature(1e4),
            blend_low: 0.0,
            blend_high: 1.0,
            law: OrificeLaw::TwoRegime,
        };
        let feed = MonotoneCurve::new(&[[0.0, 0.0], [0.12, 0.0], [0.5, 0.2], [1.0, 1.0]]);
        let back = MonotoneCurve::new(&[[0.0, 0.0], [0.1, 0.0], [0.5, 0.4], [1.0, 1.0]]);
        let curves = [Some(feed), Some(back), Some(feed), Some(back)];
        CylinderModel {
            chambers: Chambers {
                area_1: 7.8e-3,
                area_2: 5.4e-3,
                mid_volume_1: 2e-3,
                mid_volume_2: 1.5e-3,
                compliance_1: 0.0,
                compliance_2: 0.0,
                elastic: false,
                motor: false,
            },
            valve: SpoolValve {
                edge_a: edge,
                edge_b: edge,
                overlap: 0.8e-3,
                metering: Some(Metering { stroke: STROKE, full: [6.2e-3; 4], curves }),
                leakage: 0.0,
                return_ratio: [1.0; 2],
                regenerative: 0.0,
                load_check: true,
                compensator,
                nominal_opening: 6.2e-3,
                meter_out: [None; 2],
                connection: Connection { begins: 0.0, travel: 1e-4 },
                holding: [None; 2],
                lines: [None; 2],
            },
            leakage: Leakage { internal: 0.0, external: 0.0, external_from_piston_side: false },
            friction: StaticParameters {
                coulomb_extending: 0.0,
                coulomb_retracting: 0.0,
                breakaway_extending: 0.0,
                breakaway_retracting: 0.0,
                stribeck_velocity_extending: 1.0,
                stribeck_velocity_retracting: 1.0,
                stribeck_exponent_extending: 2.0,
                stribeck_exponent_retracting: 2.0,
                viscous_extending: 0.0,
                viscous_retracting: 0.0,
                viscous_exponent_extending: 1.0,
                viscous_exponent_retracting: 1.0,
                gaussian: true,
                three_halves: false,
            },
            bristle_stiffness: None,
            stroke: STROKE,
            chain: SignalChain::direct(STROKE),
            dynamics: ValveDynamics { delay: 0.0, natural_frequency: 400.0, damping_ratio: 0.7 },
            free: [-0.25, 0.25],
            tight_to: [f64::INFINITY; 2],
        }
    }

    #[test]
    fn the_spool_of_an_opening_gives_that_share_of_the_steady_speed() {
        let supply = SupplyPressures { supply: 140e5, tank: 1e5 };
        for compensator in [Compensator::None, Compensator::Before(8e5)] {
            let c = cylinder(compensator);
            for share in [-1.0, -0.6, -0.05, 0.02, 0.3, 0.9] {
                let (spool, sense) = (c.spool(share), f64::signum(share));
                // Flows at the steady pressures of this speed, by the law of the valve itself.
                let v = share.abs() * Steady::new(&c, &supply).speed(4e3 * sense, sense);
                let [area_1, area_2] = [c.chambers.area_1, c.chambers.area_2];
                let mut low = [supply.tank, supply.supply];
                for _ in 0..200 {
                    let p2 = 0.5 * (low[0] + low[1]);
                    let p1 = (4e3 * sense + p2 * area_2) / area_1;
                    let ports = PortPressures {
                        supply: supply.supply,
                        load: 0.0,
                        tank: supply.tank,
                        a: p1,
                        b: p2,
                        opening: None,
                    };
                    let flows = c.valve.flows(spool, &ports);
                    // The pressures rise where more flows in than leaves.
                    let more = flows.port_a() * area_2 > flows.port_b() * area_1;
                    low[usize::from(!more)] = p2;
                    if (low[1] - low[0]).abs() < 1e-3 {
                        assert!((flows.port_a() / area_1 - v).abs() < 2e-3 * v.abs() + 1e-7, "{share}: {v}");
                    }
                }
            }
            assert!((Edges::of(&c).closed_zone() - 0.12 * STROKE).abs() < 0.01 * STROKE && c.reach(1.0) == 1.0);
            let moment = Moment { stroke: 0.0, p: [60e5, 40e5] };
            assert_eq!(c.level_rate(&fluid(), &supply, &moment, 0.5e-3), 0.0);
        }
    }

    #[test]
    fn at_any_pressures_a_spool_gives_the_speed_that_its_edges_pass() {
        let supply = SupplyPressures { supply: 140e5, tank: 1e5 };
        for compensator in [Compensator::None, Compensator::Before(8e5)] {
            let (c, edges) = (cylinder(compensator), Edges::of(&cylinder(compensator)));
            for p in [[60e5, 40e5], [60e5, 1e5], [15e5, 90e5], [1e5, 30e5]] {
                let moment = Moment { stroke: 0.05, p };
                let by = |c: &CylinderModel| c.capacity(&fluid(), &supply, &moment);
                let now = by(&c);
                let gained = now.full.map(|full| full - now.closed);
                let shares: Shares = [0, 1].map(|side| now.shares(side, Some(gained[side])));
                for opening in [-1.0, -0.4, -1e-3, 1e-3, 0.05, 0.7] {
                    let spool = edges.spool(&c, &shares, opening);
                    assert!((edges.opening(&c, &shares, spool) - opening).abs() < 1e-9, "{p:?} {opening}");
                    // The law of the valve itself, with this as its largest displacement.
                    let side = usize::from(opening > 0.0);
                    let speed = by(&CylinderModel { stroke: spool.abs(), ..c }).full[side] - now.closed;
                    assert!((speed / gained[side] - opening.abs()).abs() < 1e-9, "{p:?} {opening}: {speed}");
                }
                // An edge from or to a chamber at the pressure behind it moves nothing: 0.1 and 0.12 of the stroke.
                let begin = edges.begin(&shares).map(|travel| travel / STROKE);
                let first = [if p[0] > 1e5 { 0.1 } else { 0.12 }, if p[1] > 1e5 { 0.1 } else { 0.12 }];
                assert!((0..2).all(|side| (begin[side] - first[side]).abs() < 1e-3), "{p:?} {begin:?}");
                assert_eq!(edges.spool(&c, &shares, f64::MIN_POSITIVE), begin[1] * STROKE);
            }
        }
    }

    #[test]
    fn a_chamber_that_runs_empty_leaves_the_force_to_the_other_one() {
        // A load pulls the piston out, and its feed is choked: chamber 1 runs empty.
        let c = cylinder(Compensator::Before(8e5));
        let supply = SupplyPressures { supply: 140e5, tank: 0.0 };
        let m = Moment { stroke: 0.0, p: [5e5, 40e5] };
        let force = |p: [f64; 2]| c.chambers.force(p[0], p[1]);
        for time in [0.25, 1.0] {
            let p = c.ahead(&fluid(), &supply, &m, &Ahead { time, force: 0.0, spool: 0.5 * STROKE }).p;
            assert!(p[0] < 0.1e5, "{time}: {p:?}");
            assert!((force(p) - force(m.p)).abs() < 1e-6 * force(m.p).abs(), "{time}: {p:?}");
        }
    }

    fn fluid() -> hydrocrane_physics::hydraulics::fluid::Fluid<f64> {
        hydrocrane_physics::hydraulics::fluid::Fluid {
            density: 870.0,
            bulk_max: 1e9,
            rise: 0.0,
            c2: 100.0,
            vacuum: -1e5,
            ignore_cavitation: false,
        }
    }
}
