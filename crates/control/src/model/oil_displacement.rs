//! Displacement of a piston, estimated by the oil of each chamber.    theory: docs/theory/control/plausibility.md
//!
//! A_1 dx = h (q_1 - q_int) - V_1/E_1 dp_1,     A_2 dx = h (q_2 - q_int + q_ext) + V_2/E_2 dp_2
//!
//! over a time h, from (94) and (95). Flows follow from commands, pressures and the valve law; load, payload and friction do not enter.
//! Every term is an interval, as wide as late commands, valve tolerances, errors of the pressure sensors and a supply that is not
//! measured make it. Where the oil determines little, as in a chamber under vacuum, the interval is wide and makes no sensor suspect.

use crate::model::controller_model::CylinderModel;
use crate::model::feed_forward::Moment;
use hydrocrane_physics::hydraulics::chamber::Chambers;
use hydrocrane_physics::hydraulics::compensator::Compensator;
use hydrocrane_physics::hydraulics::crossover_relief::CrossoverRelief;
use hydrocrane_physics::hydraulics::edge_flows::{EdgeFlows, PortPressures};
use hydrocrane_physics::hydraulics::fluid::Fluid;
use hydrocrane_physics::hydraulics::hose_leak::HoseLeak;
use hydrocrane_physics::hydraulics::load_holding::LoadHolding;
use hydrocrane_physics::hydraulics::parts::AnyParts;
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

/// How far a pressure that swings gets beyond two samples between them, in the sum of its last two changes: holds for 3.6 samples in a
/// swing and more.
const UNSEEN: f64 = 0.25;

/// Ends of the pressures: chambers give most while their own are high and those around them low, and take most in the opposite case.
const GIVES: usize = 0;
const BOTH: [usize; 2] = [1, GIVES];

/// How well the oil of a cylinder is known: accuracy of valve and pressure sensors, and what the controller model leaves out.
#[derive(Debug, Clone, Copy)]
pub struct Trust {
    /// Error of the valve law, as a share of the flow.
    pub flow: f64,
    /// Largest error of a pressure reading, Pa, and of the difference of two readings of one pressure.
    pub pressure: [f64; 2],
    pub scatter: [f64; 2],
    /// Reading at which the sensor of a pressure ends, Pa; infinite without an end.
    pub full: [f64; 2],
    /// Lowest and highest pressures of the supply and of the tank line, Pa.
    pub supply: [f64; 2],
    pub tank: [f64; 2],
    pub compensator: Compensator<f64>,
    /// Whether the compensator follows late, and whether the section gives way to another one: the fed edge then passes anything
    /// from nothing on.
    pub late: bool,
    pub gives_way: bool,
    /// At the piston side and at the rod side.
    pub port_valves: [PortValves<f64>; 2],
    pub crossover: CrossoverRelief<f64>,
    /// Of the hoses to the piston side and to the rod side.
    pub leaks: [Option<HoseLeak<f64>>; 2],
    /// By how much more than the positions asked for those of the spool differ, as a share, and its hysteresis, m.
    pub swing: f64,
    pub play: f64,
}

impl Trust {
    /// Whether the pressure of a side may be any higher than the reading `p` (Pa), at the end of its sensor.
    pub fn ends(&self, side: usize, p: f64) -> bool {
        p >= self.full[side] - self.scatter[side]
    }

    /// All positions of the spool (m) that is asked for those within `asked`.
    fn spool(&self, asked: Interval) -> Interval {
        asked.widened(0.5 * self.swing * (asked.high - asked.low) + self.play, 0.0)
    }
}

hydrocrane_num::stored!([] Trust {
    flow: f64,
    pressure: [f64; 2],
    scatter: [f64; 2],
    full: [f64; 2],
    supply: [f64; 2],
    tank: [f64; 2],
    compensator: Compensator<f64>,
    late: bool,
    gives_way: bool,
    port_valves: [PortValves<f64>; 2],
    crossover: CrossoverRelief<f64>,
    leaks: [Option<HoseLeak<f64>>; 2],
    swing: f64,
    play: f64,
});

/// Displacement of a piston estimated by one chamber, m; sums of it stay as narrow as they can.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OilDisplacement {
    /// By flow and by compression.
    moved: Interval,
    /// Of pressure readings, to either side: enters once, however long the time.
    scatter: Interval,
}

impl OilDisplacement {
    pub const NOTHING: OilDisplacement = OilDisplacement { moved: Interval::ZERO, scatter: Interval::ZERO };

    /// By compression: the oil gives way by `softness` (m/Pa) to a rise of the pressure, read within `scatter` (Pa). Soft oil moves the
    /// piston far; what is certain of a rise is what stiff oil makes of it.
    fn squeezed(softness: Interval, rise: f64, scatter: f64) -> Self {
        let moved = softness.times(rise);
        let [low, high] = [-scatter, scatter].map(|error| softness.times(rise + error));
        OilDisplacement { moved, scatter: Interval { low: low.low - moved.low, high: high.high - moved.high } }
    }

    /// This and then `next`.
    pub fn then(self, next: OilDisplacement) -> Self {
        OilDisplacement { moved: self.moved.plus(next.moved), scatter: self.scatter.joined(next.scatter) }
    }

    pub fn displacement(&self) -> Interval {
        self.moved.plus(self.scatter)
    }
}

/// Estimates by both chambers over the time `h` between two samples, with the spool asked for positions (m) within `asked`; each pressure
/// has `swung` so far (Pa) over as long a time before.
pub fn oil_displacements(
    c: &CylinderModel,
    fluid: &Fluid<f64>,
    [before, now]: [&Moment; 2],
    swung: [f64; 2],
    h: f64,
    asked: Interval,
    trust: &Trust,
) -> [OilDisplacement; 2] {
    let spool = trust.spool(asked);
    let pressures = |beyond: [f64; 2]| -> [Interval; 2] {
        hydrocrane_num::array::from_fn(|i| {
            range(Interval::spanning(before.p[i], now.p[i]).widened(trust.pressure[i] + beyond[i], 0.0), fluid)
        })
    };
    let unseen = [0, 1].map(|i| UNSEEN * (swung[i].abs() + (now.p[i] - before.p[i]).abs()));
    let inflow = inflows(c, trust, spool, &pressures(unseen), &BOTH);
    // What is compressed depends on the pressures at both ends of the time alone.
    let softness = softness(&c.chambers, fluid, 0.5 * (before.stroke + now.stroke), &pressures([0.0; 2]));
    let areas = [c.chambers.area_1, c.chambers.area_2];
    hydrocrane_num::array::from_fn(|i| {
        let sense = if i == 0 { -1.0 } else { 1.0 };
        let squeezed = OilDisplacement::squeezed(softness[i], sense * (now.p[i] - before.p[i]), trust.scatter[i]);
        let moved = squeezed.moved.plus(inflow[i].times(h / areas[i]));
        // A rise beyond the end of its sensor, up to twice of it, has moved the piston further; of a fall from there the begin is unknown.
        let further = softness[i].high * trust.full[i];
        let beyond = match [before.p[i], now.p[i]].map(|p| trust.ends(i, p)) {
            [false, false] => Interval::ZERO,
            [false, true] => Interval::spanning(0.0, sense * further),
            [true, _] => Interval::around(0.0, further),
        };
        OilDisplacement { moved: moved.plus(beyond), ..squeezed }
    })
}

/// Speeds (m/s) with which a piston can drive oil out of either chamber at any pressures up to `highest` (Pa), with the spool asked for
/// positions (m) within `asked`: it retracts no faster than chamber 1 drains, and extends no faster than chamber 2 does.
pub(crate) fn outflow(c: &CylinderModel, trust: &Trust, asked: Interval, highest: f64) -> Interval {
    // Chambers give most at their highest pressure, while those around are low.
    let [one, two] = inflows(c, trust, trust.spool(asked), &[Interval { low: 0.0, high: highest }; 2], &[GIVES]);
    Interval { low: (one.low / c.chambers.area_1).min(0.0), high: (two.high / c.chambers.area_2).max(0.0) }
}

/// How far a piston at `x` (m) can compress either chamber from the pressures `p` to `highest` (Pa), m.
pub(crate) fn compressed(c: &CylinderModel, fluid: &Fluid<f64>, x: f64, p: [f64; 2], highest: f64) -> Interval {
    let [one, two] = softness(&c.chambers, fluid, x, &p.map(|p| Interval::spanning(p.max(0.0), highest)));
    let rise = p.map(|p| (highest - p).max(0.0));
    Interval { low: -one.high * rise[0], high: two.high * rise[1] }
}

/// Flows into chamber 1 and out of chamber 2 over all spools in question and the pressures between these ends, m^3/s.
fn inflows(c: &CylinderModel, trust: &Trust, spool: Interval, p: &[Interval; 2], ends: &[usize]) -> [Interval; 2] {
    let [q1, q2] = flows(&c.valve, trust, spool, p, ends);
    let leaked = c.leakage.flows(p[0].middle(), p[1].middle(), trust.tank[0]);
    let crossed =
        Interval::spanning(trust.crossover.flow(p[0].low, p[1].high), trust.crossover.flow(p[0].high, p[1].low));
    let passed = crossed.times(-1.0);
    // Of the seals' gaps little is known but the sense of their flow.
    let (internal, external) = (Interval::spanning(0.0, 2.0 * leaked.0), Interval::spanning(0.0, 2.0 * leaked.1));
    // A valve that holds the load may keep the hose from its chamber.
    let lost = [0, 1].map(|i| Interval::spanning(0.0, trust.leaks[i].map_or(0.0, |leak| leak.flow(p[i].high))));
    [
        q1.widened(0.0, trust.flow).plus(internal.times(-1.0)).plus(passed).plus(lost[0].times(-1.0)),
        q2.widened(0.0, trust.flow).plus(internal.times(-1.0)).plus(external).plus(passed).plus(lost[1]),
    ]
}

/// Pressures behind readings within `seen`: a transmitter reads zero for any vacuum.
fn range(seen: Interval, fluid: &Fluid<f64>) -> Interval {
    Interval { low: if seen.low <= 0.0 { seen.low.min(fluid.vacuum) } else { seen.low }, ..seen }
}

/// q_1 and q_2 with those of the port valves, over all spools in question and the pressures between these ends. On either side of the
/// centre a flow is monotone in the spool.
fn flows(valve: &SpoolValve<f64>, trust: &Trust, spool: Interval, p: &[Interval; 2], ends: &[usize]) -> [Interval; 2] {
    // Copied where it differs alone: it is large.
    let own;
    let valve = if trust.compensator == valve.compensator {
        valve
    } else {
        own = SpoolValve { compensator: trust.compensator, ..*valve };
        &own
    };
    let mut flows = [Interval::NONE; 2];
    let held = valve.couples_ports().then(|| held(valve, spool, p, trust.tank[0]));
    for valve in held.as_ref().map_or(core::slice::from_ref(valve), |ends| &ends[..]) {
        include(&mut flows, trust, p, ends, |ports| valve.flows(spool.low, ports));
        if spool.high > spool.low {
            include(&mut flows, trust, p, ends, |ports| valve.flows(spool.high, ports));
        }
    }
    if spool.low < 0.0 && spool.high > 0.0 {
        include(&mut flows, trust, p, ends, |ports| valve.closed(ports));
    }
    flows
}

/// Widens `flows` by those of the `edges` and of the port valves at these ends of the pressures.
fn include(
    flows: &mut [Interval; 2],
    trust: &Trust,
    p: &[Interval; 2],
    ends: &[usize],
    edges: impl Fn(&PortPressures<f64>) -> EdgeFlows<f64>,
) {
    let openings: &[Option<f64>] = if trust.late { &[Some(0.0), Some(1.0)] } else { &[None] };
    for &around in ends {
        let [a, b] = if around == GIVES { [p[0].high, p[1].high] } else { [p[0].low, p[1].low] };
        let (supply, tank) = (trust.supply[around], trust.tank[around]);
        // What is told of the loads takes from the drop.
        let load = [trust.supply[1], trust.tank[0]][around];
        let of_ports = [(0, a), (1, b)].map(|(side, p)| trust.port_valves[side].flow(p, tank));
        for &opening in openings {
            let edges = edges(&PortPressures { supply, load, tank, a, b, opening });
            let mut passes = |edges: EdgeFlows<f64>| {
                flows[0] = flows[0].with(edges.port_a() - of_ports[0]);
                flows[1] = flows[1].with(edges.port_b() + of_ports[1]);
            };
            passes(edges);
            if trust.gives_way {
                passes(EdgeFlows { supply_to_a: 0.0, supply_to_b: 0.0, ..edges });
            }
        }
    }
}

/// The valve with what holds its loads as little and as far open as it can be: one that the other port opens can open and shut faster
/// than samples tell.
fn held(valve: &SpoolValve<f64>, spool: Interval, p: &[Interval; 2], tank: f64) -> [SpoolValve<f64>; 2] {
    let open = SpoolValve { holding: valve.holding.map(|of| of.map(|of| of.ends()[1])), ..*valve };
    // What a port drains at most while nothing holds its load back.
    let ports = PortPressures { supply: tank, load: tank, tank, a: p[0].high, b: p[1].high, opening: None };
    let most = [open.flows(spool.low, &ports).a_to_tank, open.flows(spool.high, &ports).b_to_tank];
    let least = hydrocrane_num::array::from_fn(|port| match valve.holding[port] {
        Some(LoadHolding::HoseBurst(of)) if most[port] <= of.closing_flow => open.holding[port],
        of => of.map(|of| of.ends()[0]),
    });
    [SpoolValve { holding: least, ..*valve }, open]
}

/// Oil that a chamber and its hoses take per pressure, over its area (m/Pa), at the piston position `x` (m) and over ranges of both
/// pressures.
fn softness(c: &Chambers<f64>, fluid: &Fluid<f64>, x: f64, p: &[Interval; 2]) -> [Interval; 2] {
    let (v1, v2) = c.volumes::<AnyParts>(x);
    let least = 1e-3 * c.mid_volume_1;
    // A reading beyond the stroke must not make a volume vanish.
    let c = Chambers { mid_volume_1: v1.max(least), mid_volume_2: v2.max(least), ..*c };
    let at = |side: usize, p: f64| {
        let bulk = fluid.bulk_modulus(p);
        let (one, two) = c.stiffness::<AnyParts>((bulk, bulk), 0.0, (p, p));
        [1.0 / (one * c.area_1), 1.0 / (two * c.area_2)][side]
    };
    hydrocrane_num::array::from_fn(|side| {
        let ends = Interval::spanning(at(side, p[side].low), at(side, p[side].high));
        // The law bends at zero.
        if p[side].low < 0.0 && p[side].high > 0.0 {
            ends.with(at(side, 0.0))
        } else {
            ends
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use hydrocrane_num::{functions::smooth, RandomStream};
    use hydrocrane_physics::hydraulics::counterbalance::Counterbalance;
    use hydrocrane_physics::hydraulics::hose_burst::HoseBurst;
    use hydrocrane_physics::hydraulics::load_sensing::Connection;
    use hydrocrane_physics::hydraulics::orifice::{Orifice, OrificeLaw};
    use hydrocrane_physics::hydraulics::pilot_check::PilotCheck;

    fn valve(holding: Option<LoadHolding<f64>>) -> SpoolValve<f64> {
        let edge = Orifice {
            coefficient: 7.3e-7,
            transition_pressure: 3e5,
            laminar_curvature: smooth::root_curvature(3e5),
            blend_low: 0.0,
            blend_high: 1.0,
            law: OrificeLaw::TwoRegime,
        };
        SpoolValve {
            edge_a: edge,
            edge_b: edge,
            overlap: 1e-3,
            metering: None,
            nominal_opening: 0.05,
            meter_out: [None; 2],
            leakage: 0.0,
            return_ratio: [1.0, 0.7],
            regenerative: 0.0,
            load_check: false,
            compensator: Compensator::None,
            connection: Connection { begins: 1e-3, travel: 1e-3 },
            holding: [holding, None],
            lines: [None; 2],
        }
    }

    fn trust(compensator: Compensator<f64>, late: bool, gives_way: bool) -> Trust {
        Trust {
            flow: 0.0,
            pressure: [0.0; 2],
            scatter: [0.0; 2],
            full: [f64::INFINITY; 2],
            supply: [140e5; 2],
            tank: [0.0, 2e5],
            compensator,
            late,
            gives_way,
            port_valves: [PortValves { relief: None, anti_cavitation: None }; 2],
            crossover: CrossoverRelief { from: [None; 2] },
            leaks: [None; 2],
            swing: 0.0,
            play: 0.0,
        }
    }

    /// Whether the flows at every spool and pressure of random intervals lie within what these are said to allow.
    fn hold_all(holding: Option<LoadHolding<f64>>, trust: &Trust) {
        let (valve, mut random) = (valve(holding), RandomStream::new(7, "flows"));
        let mut between = |low: f64, high: f64| low + (high - low) * random.uniform();
        for _ in 0..300 {
            let mut span = |low: f64, high: f64| Interval::spanning(between(low, high), between(low, high));
            let (spool, p) = (span(-0.05, 0.05), [span(0.0, 200e5), span(0.0, 200e5)]);
            let [q1, q2] = flows(&valve, trust, spool, &p, &BOTH);
            for _ in 0..30 {
                let [a, b] = p.map(|p| between(p.low, p.high));
                let (tank, opening) = (between(0.0, 2e5), trust.late.then(|| between(0.0, 1.0)));
                let (load, share) = (between(2e5, 140e5), if trust.gives_way { between(0.0, 1.0) } else { 1.0 });
                let ports = PortPressures { supply: 140e5, load, tank, a, b, opening };
                let at = between(spool.low, spool.high);
                let edges = SpoolValve { compensator: trust.compensator, ..valve }.flows(at, &ports);
                let passed = [share * edges.supply_to_a - edges.a_to_tank, edges.b_to_tank - share * edges.supply_to_b];
                for (q, passed) in [q1, q2].into_iter().zip(passed) {
                    assert!(
                        q.widened(1e-9, 0.0).gap(&Interval::at(passed)) == 0.0,
                        "{at} {ports:?}: {passed} in {q:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn flows_hold_those_of_every_valve_that_holds_a_load() {
        let counterbalance =
            Counterbalance { setting: 120e5, pilot_ratio: 3.0, opening_pressure: 30e5, coefficient: 1e-7 };
        let pilot_check = PilotCheck { pilot_ratio: 3.0, spring: 2e5, opening_pressure: 10e5, coefficient: 1e-7 };
        let hose_burst = HoseBurst { closing_flow: 3e-5, bleed: 0.02, coefficient: 1e-7 };
        for holding in [
            None,
            Some(LoadHolding::Counterbalance(counterbalance)),
            Some(LoadHolding::PilotCheck(pilot_check)),
            Some(LoadHolding::HoseBurst(hose_burst)),
        ] {
            hold_all(holding, &trust(Compensator::None, false, false));
        }
    }

    #[test]
    fn flows_hold_those_behind_late_compensators_and_of_sections_that_give_way() {
        for compensator in [Compensator::Before(8e5), Compensator::Behind] {
            for (late, gives_way) in [(false, false), (true, false), (false, true)] {
                hold_all(None, &trust(compensator, late, gives_way));
            }
        }
    }

    #[test]
    fn a_hose_that_gives_way_takes_oil_as_its_chamber_does() {
        let fluid =
            Fluid { density: 870.0, bulk_max: 1.4e9, rise: 0.0, c2: 100.0, vacuum: -1e5, ignore_cavitation: false };
        let stiff = Chambers {
            area_1: 1e-2,
            area_2: 5e-3,
            mid_volume_1: 2e-3,
            mid_volume_2: 1e-3,
            compliance_1: 0.0,
            compliance_2: 0.0,
            elastic: false,
            motor: false,
        };
        let soft = Chambers { compliance_1: 2e-3 / 1.4e9, elastic: true, ..stiff };
        let p = [Interval::at(0.0), Interval::at(0.0)];
        let [one, two] = [stiff, soft].map(|chambers| softness(&chambers, &fluid, 0.0, &p));
        assert!((one[0].high / (2e-3 / 1.4e9 / 1e-2) - 1.0).abs() < 1e-12 && one[0].high == one[0].low);
        assert!((two[0].high / one[0].high - 2.0).abs() < 1e-12 && two[1] == one[1]);
    }

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
    fn a_pressure_that_falls_to_nothing_tells_how_far_the_piston_has_moved_at_least() {
        // Oil that may be under vacuum: soft beyond any bound.
        let softness = Interval { low: 2e-10, high: 5e-6 };
        let fallen = OilDisplacement::squeezed(softness, 40e5, 1e5).displacement();
        assert!((fallen.low / (2e-10 * 39e5) - 1.0).abs() < 1e-9 && (fallen.high / (5e-6 * 41e5) - 1.0).abs() < 1e-9);
        let still = OilDisplacement::squeezed(softness, 0.0, 1e5).displacement();
        assert_eq!((still.low, still.high), (-5e-6 * 1e5, 5e-6 * 1e5));
    }

    #[test]
    fn scatter_enters_a_sum_once() {
        let one = OilDisplacement { moved: Interval::around(1e-3, 1e-4), scatter: Interval::around(0.0, 5e-4) };
        let sum = (0..9).fold(one, |sum, _| sum.then(one)).displacement();
        assert!((sum.low - (10e-3 - 1e-3 - 5e-4)).abs() < 1e-12 && (sum.high - 11.5e-3).abs() < 1e-12);
    }
}
