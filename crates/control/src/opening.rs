//! Openings of a valve as shares of the speed that they give.   theory: docs/theory/control/feed_forward.md
//!
//! o = (|x| - overlap)/(stroke - overlap)                        where edges open in proportion to the spool
//! o = sqrt(R(stroke)/R(|x|)),   R = A_1^3/(C_a f_a)^2 + A_2^3/(C_b f_b)^2      with curves f of the two open edges
//! o = f(|x|)/f(stroke)                                          of the fed edge behind a compensator

use crate::controller_model::CylinderModel;
use hydrocrane_num::{portable, Real};
use hydrocrane_physics::hydraulics::compensator::Compensator;
use hydrocrane_physics::hydraulics::metering::Edge;

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

    /// Opening with the spool at `spool` (m), as a signed share of the whole; the steady speed is proportional to it.
    pub fn opening(&self, spool: f64) -> f64 {
        if self.is_curved() {
            return self.share_of_speed(usize::from(spool > 0.0), spool.abs()).copysign(spool);
        }
        let share = (spool.abs() - self.valve.overlap).max(0.0) / (self.stroke - self.valve.overlap);
        share.copysign(spool)
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

    /// Half width of the closed zone, m; with curves in the mean of both senses.
    pub fn closed_zone(&self) -> f64 {
        if !self.is_curved() {
            return self.valve.overlap;
        }
        0.5 * (self.travel(0, CLOSED) + self.travel(1, CLOSED))
    }

    /// The same over the rest of the stroke.
    pub fn overlap(&self) -> f64 {
        let closed = self.closed_zone();
        closed / (self.stroke - closed)
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

    /// Displacement (m) towards one side that has a share of the speed at full stroke.
    fn travel(&self, side: usize, share: f64) -> f64 {
        self.least_travel(|travel| self.share_of_speed(side, travel) >= share)
    }

    /// Ways of the spool (m), retracting and extending, on which one of its edges is open already and the piston has no speed yet.
    pub fn half_open(&self) -> [f64; 2] {
        if !self.is_curved() {
            return [0.0; 2];
        }
        [0, 1].map(|side| {
            let opens = |travel: f64| self.ratios(side, travel).iter().any(|ratio| *ratio > CLOSED);
            (self.travel(side, CLOSED) - self.least_travel(opens)).max(0.0)
        })
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feed_forward::{Ahead, Moment, Steady, SupplyPressures};
    use crate::signal_chain::SignalChain;
    use crate::valve_answer::ValveDynamics;
    use hydrocrane_num::curve::MonotoneCurve;
    use hydrocrane_num::smooth;
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
        }
    }

    #[test]
    fn the_spool_of_an_opening_gives_that_share_of_the_steady_speed() {
        let supply = SupplyPressures { supply: 140e5, tank: 1e5 };
        for compensator in [Compensator::None, Compensator::Before(8e5)] {
            let c = cylinder(compensator);
            for share in [-1.0, -0.6, -0.05, 0.02, 0.3, 0.9] {
                let (spool, sense) = (c.spool(share), f64::signum(share));
                assert!((c.opening(spool) - share).abs() < 1e-9, "{share}");
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
            assert!((c.closed_zone() - 0.12 * STROKE).abs() < 0.01 * STROKE && c.reach(1.0) == 1.0);
            for (side, half_open) in c.half_open().into_iter().enumerate() {
                let open = |travel: f64| c.ratios(side, travel).iter().any(|ratio| *ratio > CLOSED);
                let shut = c.travel(side, CLOSED) - half_open;
                assert!(half_open > 0.0 && !open(0.999 * shut) && open(shut + 1e-6), "{side}: {shut}");
            }
            let moment = Moment { stroke: 0.0, p: [60e5, 40e5] };
            assert_eq!(c.level_rate(&fluid(), &supply, &moment, 0.5e-3), 0.0);
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
