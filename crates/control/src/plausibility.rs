//! Which sensor cannot be right.                              theory: docs/theory/control/plausibility.md
//!
//! A piston's displacement is estimated three times: by the position sensor and by the oil of either chamber
//! ([`oil_displacement`](crate::oil_displacement)). A residual is the gap between two of these intervals; two estimates that
//! agree outvote the third. Every reading must also be a number, and one that the machine can give.

use crate::controller::Measurement;
use crate::controller_model::ControllerModel;
use crate::feed_forward::{Moment, SupplyPressures};
use crate::oil_displacement::{oil_displacements, Interval, OilDisplacement, Trust};
use std::collections::VecDeque;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Signal {
    Joint(usize),
    /// Cylinder, and 0 for its piston side or 1 for its rod side.
    Pressure(usize, usize),
}

impl Signal {
    fn cylinder(self) -> usize {
        match self {
            Signal::Joint(c) | Signal::Pressure(c, _) => c,
        }
    }
}

/// What is wrong with a reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    NoReading,
    OutOfRange,
    /// By this much (rad, m or Pa) from one sample to the next, which nothing explains.
    Jump(f64),
    /// Unchanged while the piston must have moved this far, m.
    Frozen(f64),
}

/// Thresholds, SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings<const N: usize> {
    /// Piston displacement between two samples that no other estimate confirms, m.
    pub jump: f64,
    /// Piston displacement that an unchanged position reading must have missed, m.
    pub frozen: f64,
    /// Measured piston displacement over which no pressure stays the same to the last digit, m.
    pub frozen_pressure: f64,
    /// Time for which suspect sensors must read plausibly before they are trusted again, s.
    pub recovery_time: f64,
    /// Joint coordinates (rad or m) and piston positions (m) between which a reading must lie.
    pub joints: [[f64; 2]; N],
    pub strokes: [[f64; 2]; N],
    /// The same of both chamber pressures, Pa.
    pub pressures: [[f64; 2]; N],
    /// Largest difference of two readings of one joint at rest, rad or m.
    pub scatter: [f64; N],
    pub trust: [Trust; N],
    /// Time in which a spool forgets a command, s.
    pub memory: [f64; N],
}

/// A suspect sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Suspect {
    signal: Signal,
    kind: Kind,
    /// Expected piston position (m), or the pressure that does not change (Pa).
    expected: f64,
    /// Since when it reads plausibly again, s.
    plausible: Option<f64>,
}

/// One cylinder at its last sample, and what has happened since each of its readings last changed.
#[derive(Debug, Clone, Copy)]
struct Track {
    t: f64,
    moment: Moment,
    reading: f64,
    /// Displacement by the oil while the position reading stayed the same.
    missed: [OilDisplacement; 2],
    /// Piston position where each pressure last changed, m.
    changed: [f64; 2],
}

/// One cylinder between two samples.
#[derive(Debug, Clone, Copy)]
struct Passage {
    before: Track,
    now: Track,
    /// Displacements by the position sensor and by the oil of the chambers, m.
    measured: Interval,
    oil: [Interval; 2],
}

/// Least time between two samples that are compared, s: faster ones would drown in scatter.
const INTERVAL: f64 = 0.01;

pub struct Monitor<const N: usize> {
    model: ControllerModel<N>,
    settings: Settings<N>,
    tracks: [Option<Track>; N],
    /// (time, spool positions asked for), oldest first.
    sent: VecDeque<(f64, [f64; N])>,
    suspects: Vec<Suspect>,
}

impl<const N: usize> Monitor<N> {
    pub fn new(model: ControllerModel<N>, settings: Settings<N>) -> Self {
        Monitor { model, settings, tracks: [None; N], sent: VecDeque::new(), suspects: Vec::new() }
    }

    pub fn recovery_time(&self) -> f64 {
        self.settings.recovery_time
    }

    /// Forgets everything.
    pub fn reset(&mut self) {
        self.clear();
        self.sent.clear();
    }

    /// Trusts all sensors again.
    pub fn clear(&mut self) {
        self.suspects.clear();
        self.tracks = [None; N];
    }

    /// Takes note of the spool positions (m) asked for at time `t`.
    pub fn sent(&mut self, t: f64, spools: [f64; N]) {
        self.sent.push_back((t, spools));
        let memory = self.settings.memory.iter().fold(2.0 * INTERVAL, |a, b| a.max(b + 2.0 * INTERVAL));
        while self.sent.get(1).is_some_and(|(sent, _)| *sent < t - memory) {
            self.sent.pop_front();
        }
    }

    /// Whether any sensor is suspect, or was less than the recovery time ago.
    pub fn has_suspects(&self, t: f64) -> bool {
        let restored = |s: &Suspect| s.plausible.is_some_and(|since| t >= since + self.settings.recovery_time);
        !self.suspects.iter().all(restored)
    }

    /// Checks a sample; gives the sensors that become suspect.
    pub fn check(&mut self, m: &Measurement) -> Vec<(Signal, Kind)> {
        let q: [f64; N] = std::array::from_fn(|i| m.q.get(i).copied().unwrap_or(f64::NAN));
        // One unreadable joint must not hide the strokes of the others.
        let strokes = self.model.strokes(&q.map(|q| if q.is_finite() { q } else { 0.0 }));
        let mut found = Vec::new();
        for c in 0..N {
            let (stroke, lever_arm) = strokes[c];
            let moment = Moment { stroke, p: m.p.get(c).copied().unwrap_or([f64::NAN; 2]) };
            let scatter = self.settings.scatter[c] * lever_arm.abs();
            let mut wrong = self.beyond(c, q[c], &moment);
            let passage = if wrong.is_empty() { self.advance(m.t, c, q[c], moment, scatter) } else { None };
            if !wrong.is_empty() {
                self.tracks[c] = None;
            }
            self.reconsider(m.t, c, &moment, &wrong, passage.as_ref(), scatter);
            // A vote takes three sound estimates.
            if !self.suspects.iter().any(|s| s.signal.cylinder() == c) {
                wrong.extend(passage.iter().flat_map(|passage| self.faults(c, passage, scatter)));
            }
            for (signal, kind) in wrong {
                if !self.suspects.iter().any(|s| s.signal == signal) {
                    self.suspects.push(Suspect {
                        signal,
                        kind,
                        expected: expected(kind, signal, &moment, passage.as_ref()),
                        plausible: None,
                    });
                    found.push((signal, kind));
                }
            }
        }
        found
    }

    /// Readings that no machine in good order can give.
    fn beyond(&self, c: usize, q: f64, now: &Moment) -> Vec<(Signal, Kind)> {
        let judge = |signal, reading: f64, possible: bool| {
            let kind = if reading.is_finite() { Kind::OutOfRange } else { Kind::NoReading };
            (!reading.is_finite() || !possible).then_some((signal, kind))
        };
        let within = |value: f64, [low, high]: [f64; 2]| (low..=high).contains(&value);
        let s = &self.settings;
        let joint = judge(Signal::Joint(c), q, within(q, s.joints[c]) && within(now.stroke, s.strokes[c]));
        let pressure = |i: usize| judge(Signal::Pressure(c, i), now.p[i], within(now.p[i], s.pressures[c]));
        let mut wrong = Vec::new();
        [joint, pressure(0), pressure(1)].into_iter().for_each(|one| wrong.extend(one));
        wrong
    }

    /// Advances to a sample; `None` where it is the first or follows too soon.
    fn advance(&mut self, t: f64, c: usize, reading: f64, moment: Moment, scatter: f64) -> Option<Passage> {
        let first = Track { t, moment, reading, missed: [OilDisplacement::NOTHING; 2], changed: [moment.stroke; 2] };
        let before = *self.tracks[c].get_or_insert(first);
        if t - before.t < INTERVAL * (1.0 - 1e-6) {
            return None;
        }
        let n = &self.model;
        let supply_pressures = SupplyPressures { supply: n.supply, tank: n.tank };
        let spool = self.spools(c, before.t);
        let moments = [&before.moment, &moment];
        let estimates = oil_displacements(
            &n.cylinders[c],
            &n.fluid,
            &supply_pressures,
            moments,
            t - before.t,
            spool,
            &self.settings.trust[c],
        );
        let now = Track {
            missed: if reading == before.reading {
                [0, 1].map(|i| before.missed[i].then(estimates[i]))
            } else {
                first.missed
            },
            changed: [0, 1].map(|i| if moment.p[i] == before.moment.p[i] { before.changed[i] } else { moment.stroke }),
            ..first
        };
        self.tracks[c] = Some(now);
        let measured = Interval::around(moment.stroke - before.moment.stroke, scatter);
        Some(Passage { before, now, measured, oil: estimates.map(|estimate| estimate.displacement()) })
    }

    /// All positions that a spool can have had since `from`.
    fn spools(&self, c: usize, from: f64) -> Interval {
        let begin = from - self.settings.memory[c];
        let later = self.sent.partition_point(|(sent, _)| *sent <= begin);
        let acting = match later {
            0 => 0.0,
            n => self.sent[n - 1].1[c],
        };
        Interval::hull(self.sent.iter().skip(later).map(|(_, spools)| spools[c]).chain([acting]))
    }

    /// Which of the three estimates is outvoted, and which reading does not change while the piston moves.
    fn faults(&self, c: usize, passage: &Passage, scatter: f64) -> Vec<(Signal, Kind)> {
        let jump = self.jump(c, passage);
        let frozen = || self.frozen_joint(c, &passage.now, scatter);
        let stuck = || (0..2).filter_map(|side| self.frozen_pressure(c, side, &passage.now, scatter));
        match jump.or_else(frozen) {
            Some(found) => vec![found],
            None => stuck().collect(),
        }
    }

    fn jump(&self, c: usize, passage: &Passage) -> Option<(Signal, Kind)> {
        let (jump, now, before) = (self.settings.jump, &passage.now, &passage.before);
        let [one, two] = &passage.oil;
        if one.gap(two) <= jump {
            let outvoted = one.between(two).gap(&passage.measured) > jump;
            return outvoted.then_some((Signal::Joint(c), Kind::Jump(now.reading - before.reading)));
        }
        // The chambers contradict each other: the position decides, if it agrees with one of them.
        let side = match passage.oil.map(|oil| oil.gap(&passage.measured) > jump) {
            [true, false] => 0,
            [false, true] => 1,
            _ => return None,
        };
        Some((Signal::Pressure(c, side), Kind::Jump(now.moment.p[side] - before.moment.p[side])))
    }

    fn frozen_joint(&self, c: usize, now: &Track, scatter: f64) -> Option<(Signal, Kind)> {
        let [one, two] = now.missed.map(|m| m.displacement());
        let missed = one.between(&two);
        let frozen = self.settings.frozen;
        let outvoted = one.gap(&two) <= frozen && missed.gap(&Interval::around(0.0, scatter)) > frozen;
        outvoted.then_some((Signal::Joint(c), Kind::Frozen(missed.middle())))
    }

    fn frozen_pressure(&self, c: usize, side: usize, now: &Track, scatter: f64) -> Option<(Signal, Kind)> {
        let travel = (now.moment.stroke - now.changed[side]).abs();
        // A vacuum reads zero for as long as it lasts.
        let vacuum = now.moment.p[side].abs() <= self.settings.trust[c].pressure[side];
        let frozen = !vacuum && travel > self.settings.frozen_pressure + scatter;
        frozen.then_some((Signal::Pressure(c, side), Kind::Frozen(travel)))
    }

    /// Which suspects of cylinder `c` read plausibly again.
    fn reconsider(
        &mut self,
        t: f64,
        c: usize,
        now: &Moment,
        wrong: &[(Signal, Kind)],
        passage: Option<&Passage>,
        scatter: f64,
    ) {
        let near = scatter + self.settings.jump.min(0.5 * self.settings.frozen);
        for suspect in &mut self.suspects {
            if suspect.signal.cylinder() != c {
                continue;
            }
            let readable = !wrong.iter().any(|(signal, _)| *signal == suspect.signal);
            let fits = match (suspect.kind, suspect.signal) {
                (Kind::NoReading | Kind::OutOfRange, _) => true,
                (Kind::Jump(_) | Kind::Frozen(_), Signal::Joint(_)) => {
                    suspect.expected += passage.map_or(0.0, |p| narrow(&p.oil, near));
                    (now.stroke - suspect.expected).abs() <= near
                }
                (Kind::Jump(size), Signal::Pressure(_, side)) => {
                    let change = passage.map_or(0.0, |p| p.now.moment.p[side] - p.before.moment.p[side]);
                    suspect.plausible.is_some() || returned(change, size)
                }
                (Kind::Frozen(_), Signal::Pressure(_, side)) => now.p[side] != suspect.expected,
            };
            suspect.plausible = if readable && fits { suspect.plausible.or(Some(t)) } else { None };
        }
    }
}

/// Piston position or pressure by the other estimates, when a sensor becomes suspect.
fn expected(kind: Kind, signal: Signal, now: &Moment, passage: Option<&Passage>) -> f64 {
    match (signal, kind, passage) {
        (Signal::Joint(_), Kind::Jump(_), Some(p)) => p.before.moment.stroke + p.oil[0].between(&p.oil[1]).middle(),
        (Signal::Joint(_), Kind::Frozen(missed), _) => now.stroke + missed,
        (Signal::Joint(_), ..) => now.stroke,
        (Signal::Pressure(_, side), ..) => now.p[side],
    }
}

/// Middle of what both chambers say, where they know better than `within`.
fn narrow([one, two]: &[Interval; 2], within: f64) -> f64 {
    let oil = one.between(two);
    if oil.high - oil.low < within {
        oil.middle()
    } else {
        0.0
    }
}

/// Whether a pressure has taken back a jump of `size`.
fn returned(change: f64, size: f64) -> bool {
    (0.5..1.5).contains(&(-change / size))
}
