//! Displacement of a piston, estimated by the oil of each chamber.    theory: docs/theory/control/plausibility.md
//!
//! A_1 dx = h (q_1 - q_int) - V_1/E_1 dp_1,     A_2 dx = h (q_2 - q_int + q_ext) + V_2/E_2 dp_2
//!
//! over a time h, from (94) and (95). Flows follow from commands, pressures and the valve law; load, payload and friction do not enter.
//! Every term is an interval, as wide as late commands, valve tolerances, errors of the pressure sensors and a supply that is not
//! measured make it. Where the oil determines little, as in a chamber under vacuum, the interval is wide and makes no sensor suspect.

use crate::controller_model::CylinderModel;
use crate::feed_forward::Moment;
use hydrocrane_physics::hydraulics::compensator::Compensator;
use hydrocrane_physics::hydraulics::crossover_relief::CrossoverRelief;
use hydrocrane_physics::hydraulics::edge_flows::{EdgeFlows, PortPressures};
use hydrocrane_physics::hydraulics::fluid::Fluid;
use hydrocrane_physics::hydraulics::port_valves::PortValves;
use hydrocrane_physics::hydraulics::spool_valve::SpoolValve;

/// All values from `low` to `high`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    pub low: f64,
    pub high: f64,
}

impl Interval {
    pub const ZERO: Interval = Interval { low: 0.0, high: 0.0 };
    /// Holds nothing.
    pub const NONE: Interval = Interval { low: f64::INFINITY, high: f64::NEG_INFINITY };

    pub fn at(value: f64) -> Self {
        Interval { low: value, high: value }
    }

    pub fn around(value: f64, half: f64) -> Self {
        Interval { low: value - half, high: value + half }
    }

    /// From the one value to the other, whichever is less.
    pub fn spanning(a: f64, b: f64) -> Self {
        Interval { low: a.min(b), high: a.max(b) }
    }

    /// The smallest that holds all of `values`.
    pub fn hull(values: impl IntoIterator<Item = f64>) -> Self {
        values.into_iter().fold(Interval::NONE, Interval::with)
    }

    /// The smallest that holds both.
    pub fn joined(self, other: Interval) -> Self {
        Interval { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// The smallest that holds all of this and `value`.
    fn with(self, value: f64) -> Self {
        self.joined(Interval::at(value))
    }

    pub fn plus(self, other: Interval) -> Self {
        Interval { low: self.low + other.low, high: self.high + other.high }
    }

    pub fn times(self, factor: f64) -> Self {
        Interval::spanning(factor * self.low, factor * self.high)
    }

    /// Each end moved outwards by `margin`, and by `share` of its size.
    pub fn widened(self, margin: f64, share: f64) -> Self {
        Interval { low: self.low - margin - share * self.low.abs(), high: self.high + margin + share * self.high.abs() }
    }

    /// Space between two intervals; zero where they touch.
    pub fn gap(&self, other: &Interval) -> f64 {
        (self.low - other.high).max(other.low - self.high).max(0.0)
    }

    /// What two intervals share, or the space between them.
    pub fn between(&self, other: &Interval) -> Self {
        Interval::spanning(self.low.max(other.low), self.high.min(other.high))
    }

    pub fn middle(&self) -> f64 {
        0.5 * (self.low + self.high)
    }
}

/// How well the oil of a cylinder is known: accuracy of valve and pressure sensors, and what the controller model leaves out.
#[derive(Debug, Clone, Copy)]
pub struct Trust {
    /// Error of the valve law, as a share of the flow.
    pub flow: f64,
    /// Largest error of a pressure reading, Pa, and of the difference of two readings of one pressure.
    pub pressure: [f64; 2],
    pub scatter: [f64; 2],
    /// Lowest and highest pressures of the supply and of the tank line, Pa.
    pub supply: [f64; 2],
    pub tank: [f64; 2],
    /// Whether the compensator of the section keeps the drop over a fed edge at each moment.
    pub compensated: bool,
    /// At the piston side and at the rod side.
    pub port_valves: [PortValves<f64>; 2],
    pub crossover: CrossoverRelief<f64>,
    /// By how much more than the positions asked for those of the spool differ, as a share, and its hysteresis, m.
    pub swing: f64,
    pub play: f64,
}

hydrocrane_num::stored!([] Trust {
    flow: f64,
    pressure: [f64; 2],
    scatter: [f64; 2],
    supply: [f64; 2],
    tank: [f64; 2],
    compensated: bool,
    port_valves: [PortValves<f64>; 2],
    crossover: CrossoverRelief<f64>,
    swing: f64,
    play: f64,
});

/// Displacement of a piston estimated by one chamber, m; sums of it stay as narrow as they can.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OilDisplacement {
    /// By flow and by compression.
    moved: Interval,
    /// Of pressure readings: enters once, however long the time.
    scatter: f64,
}

impl OilDisplacement {
    pub const NOTHING: OilDisplacement = OilDisplacement { moved: Interval::ZERO, scatter: 0.0 };

    /// This and then `next`.
    pub fn then(self, next: OilDisplacement) -> Self {
        OilDisplacement { moved: self.moved.plus(next.moved), scatter: self.scatter.max(next.scatter) }
    }

    pub fn displacement(&self) -> Interval {
        self.moved.widened(self.scatter, 0.0)
    }
}

/// Estimates by both chambers over the time `h` between two samples, with the spool asked for positions (m) within `asked`.
pub fn oil_displacements(
    c: &CylinderModel,
    fluid: &Fluid<f64>,
    [before, now]: [&Moment; 2],
    h: f64,
    asked: Interval,
    trust: &Trust,
) -> [OilDisplacement; 2] {
    let spool = asked.widened(0.5 * trust.swing * (asked.high - asked.low) + trust.play, 0.0);
    let ranges: [Interval; 2] = hydrocrane_num::array::from_fn(|i| {
        range(Interval::spanning(before.p[i], now.p[i]).widened(trust.pressure[i], 0.0), fluid)
    });
    let [q1, q2] = flows(c, trust, spool, &ranges);
    let leaked = c.leakage.flows(ranges[0].middle(), ranges[1].middle(), trust.tank[0]);
    let crossed = Interval::spanning(
        trust.crossover.flow(ranges[0].low, ranges[1].high),
        trust.crossover.flow(ranges[0].high, ranges[1].low),
    );
    let passed = crossed.times(-1.0);
    // Of the seals' gaps little is known but the sense of their flow.
    let (internal, external) = (Interval::spanning(0.0, 2.0 * leaked.0), Interval::spanning(0.0, 2.0 * leaked.1));
    let inflow = [
        q1.widened(0.0, trust.flow).plus(internal.times(-1.0)).plus(passed),
        q2.widened(0.0, trust.flow).plus(internal.times(-1.0)).plus(external).plus(passed),
    ];
    let (v1, v2) = c.chambers.volumes(0.5 * (before.stroke + now.stroke));
    let least = 1e-3 * c.chambers.mid_volume_1;
    let (areas, volumes) = ([c.chambers.area_1, c.chambers.area_2], [v1.max(least), v2.max(least)]);
    hydrocrane_num::array::from_fn(|i| {
        let softness = softness(fluid, &ranges[i]).times(volumes[i] / areas[i]);
        let sense = if i == 0 { -1.0 } else { 1.0 };
        let squeezed = softness.times(sense * (now.p[i] - before.p[i]));
        let moved = inflow[i].times(h / areas[i]).plus(squeezed);
        OilDisplacement { moved, scatter: softness.high * trust.scatter[i] }
    })
}

/// Pressures behind readings within `seen`: a transmitter reads zero for any vacuum.
fn range(seen: Interval, fluid: &Fluid<f64>) -> Interval {
    Interval { low: if seen.low <= 0.0 { seen.low.min(fluid.vacuum) } else { seen.low }, ..seen }
}

/// q_1 and q_2 with those of the port valves, over all spools and pressures in question: both are monotone in the pressures and, on
/// either side of the centre, in the spool. A chamber takes most while its own pressure is low and those around it are high.
fn flows(c: &CylinderModel, trust: &Trust, spool: Interval, p: &[Interval; 2]) -> [Interval; 2] {
    let compensator = if trust.compensated { c.valve.compensator } else { Compensator::None };
    let valve = SpoolValve { compensator, ..c.valve };
    let mut flows = [Interval::NONE; 2];
    for (a, b, around) in [(p[0].low, p[1].low, 1), (p[0].high, p[1].high, 0)] {
        let (supply, tank) = (trust.supply[around], trust.tank[around]);
        let ports = PortPressures { supply, load: tank, tank, a, b, opening: None };
        let [of_a, of_b] = [(0, a), (1, b)].map(|(side, p)| trust.port_valves[side].flow(p, tank));
        let mut include = |edges: EdgeFlows<f64>| {
            for (flow, q) in flows.iter_mut().zip([edges.port_a() - of_a, edges.port_b() + of_b]) {
                *flow = flow.with(q);
            }
        };
        include(valve.flows(spool.low, &ports));
        if spool.high > spool.low {
            include(valve.flows(spool.high, &ports));
        }
        if spool.low < 0.0 && spool.high > 0.0 {
            include(valve.closed(&ports));
        }
    }
    flows
}

/// 1/E over a range of pressures, 1/Pa.
fn softness(fluid: &Fluid<f64>, p: &Interval) -> Interval {
    let at = |p: f64| 1.0 / fluid.bulk_modulus(p);
    let ends = Interval::spanning(at(p.low), at(p.high));
    // The law bends at zero.
    if p.low < 0.0 && p.high > 0.0 {
        ends.with(at(0.0))
    } else {
        ends
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_keep_what_they_hold() {
        let (a, b) = (Interval { low: -1.0, high: 2.0 }, Interval { low: 4.0, high: 5.0 });
        assert_eq!((a.gap(&b), b.gap(&a), a.gap(&a)), (2.0, 2.0, 0.0));
        assert_eq!(a.between(&b), Interval { low: 2.0, high: 4.0 });
        assert_eq!(a.between(&Interval { low: 0.0, high: 9.0 }), Interval { low: 0.0, high: 2.0 });
        assert_eq!(a.times(-2.0), Interval { low: -4.0, high: 2.0 });
        assert_eq!(a.widened(1.0, 0.5), Interval { low: -2.5, high: 4.0 });
    }

    #[test]
    fn scatter_enters_a_sum_once() {
        let one = OilDisplacement { moved: Interval::around(1e-3, 1e-4), scatter: 5e-4 };
        let sum = (0..9).fold(one, |sum, _| sum.then(one)).displacement();
        assert!((sum.low - (10e-3 - 1e-3 - 5e-4)).abs() < 1e-12 && (sum.high - 11.5e-3).abs() < 1e-12);
    }
}
