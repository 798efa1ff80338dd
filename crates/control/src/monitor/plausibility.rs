//! Which sensor cannot be right.                              theory: docs/theory/control/plausibility.md
//!
//! A piston's displacement is estimated three times: by the position sensor and by the oil of either chamber
//! ([`oil_displacement`](crate::model::oil_displacement)). A residual is the gap between two of these intervals; two estimates that
//! agree outvote the third. Every reading must also be a number, and one that the machine can give; a piston must be within reach
//! ([`whereabouts`](crate::monitor::whereabouts)). Two sensors do not fail in the same sample: all of it is left out then.

use crate::interface::controller::Measurement;
pub use crate::interface::signal::Kind;
use crate::interface::signal::{OfSignals, Signal, MOST, PER_CYLINDER};
use crate::model::controller_model::{ControllerModel, CylinderModel};
use crate::model::feed_forward::Moment;
use crate::model::oil_displacement::{oil_displacements, Interval, OilDisplacement, Trust};
pub use crate::monitor::passage::INTERVAL;
use crate::monitor::passage::{Passage, Standing, Track};
use crate::monitor::spool_history::SpoolHistory;
pub use crate::monitor::suspect::Returned;
use crate::monitor::suspect::{returned, Judged, Suspect};
use crate::monitor::vanished::{self, Vanished, Verdict};
use crate::monitor::whereabouts::{Whereabouts, DYNAMIC};
use arrayvec::ArrayVec;

/// Thresholds, SI, most of them per cylinder.
#[derive(Debug, Clone)]
pub struct Settings<const N: usize> {
    /// Piston displacement between two samples that no other estimate confirms, m.
    pub jump: [f64; N],
    /// Piston displacement that an unchanged position reading must have missed, m.
    pub frozen: [f64; N],
    /// What one repeated pressure reading tells while the piston moves, bits: up to 1, none where noise hides no step of the sensor.
    pub against: [[f64; 2]; N],
    /// Change of a pressure that its reading need not show, Pa.
    pub resolution: [[f64; 2]; N],
    /// Time for which control goes on without a reading, s.
    pub ride_through: f64,
    /// Time for which suspect sensors must read plausibly before they are trusted again, s.
    pub recovery_time: f64,
    /// Joint coordinates (rad or m) and piston positions (m) between which a reading must lie.
    pub joints: [[f64; 2]; N],
    pub strokes: [[f64; 2]; N],
    /// The same of both chamber pressures, Pa.
    pub pressures: [[f64; 2]; N],
    /// Whether they are read. Joint sensors are else checked for a reading, its range and reach alone: there is no oil to ask.
    pub reads_pressures: bool,
    /// Largest difference of two readings of one joint at rest, rad or m.
    pub scatter: [f64; N],
    pub trust: [Trust; N],
    /// Time in which a spool forgets a command, s.
    pub memory: [f64; N],
}

hydrocrane_num::stored!([const N: usize] Settings<N> {
    jump: [f64; N],
    frozen: [f64; N],
    against: [[f64; 2]; N],
    resolution: [[f64; 2]; N],
    ride_through: f64,
    recovery_time: f64,
    joints: [[f64; 2]; N],
    strokes: [[f64; 2]; N],
    pressures: [[f64; 2]; N],
    reads_pressures: bool,
    scatter: [f64; N],
    trust: [Trust; N],
    memory: [f64; N],
});

/// What is wrong with the readings of one cylinder.
type Wrong = ArrayVec<(Signal, Kind), PER_CYLINDER>;

/// Whether what is wrong with a reading says nothing of the others of its sample.
fn alone(kind: Kind) -> bool {
    matches!(kind, Kind::NoReading | Kind::Vanished)
}

/// Bits that make a repeated pressure reading a fault: one false alarm in 10^9 readings in motion, 115 days of them at 100 Hz.
const MOST_AGAINST: f64 = 30.0;
/// Share of the displacement that counts as a jump beyond which a piston counts as moving: with its default, 1 % of its fastest motion.
const STIR: f64 = 0.04;

#[derive(Clone)]
pub struct Monitor<const N: usize> {
    settings: Settings<N>,
    tracks: [Option<Track>; N],
    sent: SpoolHistory<N>,
    suspects: OfSignals<Suspect>,
    whereabouts: [Option<Whereabouts>; N],
    /// Pressures that could be used last, and when, s.
    pressed: [Option<(f64, [f64; 2])>; N],
    /// Cylinders whose load has vanished from their oil, and those whose chambers both read nothing.
    vanished: [Option<Vanished<N>>; N],
    nothing: [bool; N],
    /// Last readings, so that a jump back is seen.
    last: [Option<(f64, [f64; 2])>; N],
}

impl<const N: usize> Monitor<N> {
    pub fn new(settings: Settings<N>) -> Self {
        const { assert!(PER_CYLINDER * N <= MOST) };
        let memory = settings.memory.iter().fold(2.0 * INTERVAL, |a, b| a.max(b + 2.0 * INTERVAL));
        Monitor {
            settings,
            tracks: [None; N],
            sent: SpoolHistory::new(memory),
            suspects: OfSignals::new(),
            whereabouts: [None; N],
            pressed: [None; N],
            vanished: [const { None }; N],
            nothing: [false; N],
            last: [None; N],
        }
    }

    pub fn recovery_time(&self) -> f64 {
        self.settings.recovery_time
    }

    /// Time for which control goes on without a sensor, s.
    pub fn ride_through(&self) -> f64 {
        self.settings.ride_through
    }

    /// Forgets everything.
    pub fn reset(&mut self) {
        self.clear();
        self.sent.clear();
    }

    /// Trusts all sensors again.
    pub fn clear(&mut self) {
        self.suspects.clear();
        (self.tracks, self.whereabouts, self.last) = ([None; N], [None; N], [None; N]);
        (self.pressed, self.vanished) = ([None; N], [const { None }; N]);
    }

    /// Takes note of the commands (m) to the valves at time `t`.
    pub fn sent(&mut self, model: &ControllerModel<N>, t: f64, commands: &[f64; N]) {
        let spool = |c: usize| {
            let CylinderModel { stroke, chain, .. } = &model.cylinders[c];
            chain.spool(commands[c].clamp(-stroke, *stroke))
        };
        self.sent.add(t, hydrocrane_num::array::from_fn(spool));
    }

    /// Whether any sensor is suspect, or was less than the recovery time ago.
    pub fn has_suspects(&self, t: f64) -> bool {
        let restored = |s: &Suspect| s.plausible.is_some_and(|since| t >= since + self.settings.recovery_time);
        !self.suspects.iter().all(restored) || self.doubted().next().is_some()
    }

    /// Sensors that are suspect, or were and are not trusted again yet.
    pub fn suspects(&self) -> impl Iterator<Item = (Signal, Kind)> + '_ {
        self.suspects.iter().map(|s| (s.signal, s.kind))
    }

    /// Sensors that must not be used now.
    pub fn gaps(&self) -> impl Iterator<Item = (Signal, Kind)> + '_ {
        self.suspects.iter().filter(|s| s.plausible.is_none()).map(|s| (s.signal, s.kind))
    }

    /// Pressures that are not used, with no word yet: a load has vanished, and the motion does not show whether anything carries it.
    /// What takes it from one cylinder may be what all of them share.
    pub fn doubted(&self) -> impl Iterator<Item = Signal> + '_ {
        let any = self.vanished.iter().any(Option::is_some);
        let own =
            (0..N).filter(move |&c| any && self.nothing[c]).flat_map(|c| [0, 1].map(|side| Signal::Pressure(c, side)));
        own.filter(move |signal| !self.suspects.iter().any(|s| s.signal == *signal))
    }

    /// Trusts the sensors again that read plausibly, and gives them.
    pub fn trust_again(&mut self) -> OfSignals<Returned> {
        let mut back = OfSignals::new();
        let tracks = &mut self.tracks;
        self.suspects.retain(|&mut Suspect { signal, kind, from, plausible, .. }| {
            if plausible.is_none() {
                return true;
            }
            // What its reading did meanwhile tells nothing of the others.
            if let Some(track) = &mut tracks[signal.cylinder()] {
                track.changed = [Standing { moment: track.moment, load: track.load }; 2];
                (track.against, track.stirred) = ([0.0; 2], [track.moment.stroke; 2]);
            }
            back.push(Returned { signal, kind, from });
            false
        });
        back
    }

    /// Checks a sample; gives the sensors that become suspect.
    pub fn check(&mut self, model: &ControllerModel<N>, m: &Measurement) -> OfSignals<(Signal, Kind)> {
        let q: [f64; N] = hydrocrane_num::array::from_fn(|i| m.q.get(i).copied().unwrap_or(f64::NAN));
        // One unreadable joint must not hide the strokes of the others.
        let strokes = model.strokes(&q.map(|q| if q.is_finite() { q } else { 0.0 }));
        // Only a coarse reading is explained by the load.
        let coarse = self.settings.against.iter().flatten().any(|bits| *bits < 1.0);
        let load = if coarse { model.cylinder_force(&q, &[0.0; N], model.payload) } else { [f64::NAN; N] };
        let (mut found, mut bad, before) = (OfSignals::new(), 0, self.tracks);
        for c in 0..N {
            let (stroke, lever_arm) = strokes[c];
            let moment = Moment { stroke, p: m.p.get(c).copied().unwrap_or([f64::NAN; 2]) };
            let scatter = self.settings.scatter[c] * lever_arm.abs();
            let mut wrong = self.beyond(model, m.t, c, q[c], &moment, scatter);
            let vanished = self.look_for_load(model, m.t, c, moment.p);
            let passage = match (&wrong[..], self.tracks[c]) {
                _ if !self.settings.reads_pressures => None,
                _ if vanished => {
                    self.tracks[c] = None;
                    None
                }
                ([], _) => self.advance(model, m.t, c, q[c], Standing { moment, load: load[c] }, scatter),
                // Without a reading of the joint the oil counts on from the last one.
                ([(Signal::Joint(_), _)], Some(before)) => {
                    let moment = Moment { stroke: before.moment.stroke, ..moment };
                    self.advance(model, m.t, c, before.reading, Standing { moment, load: load[c] }, scatter)
                }
                _ => {
                    self.tracks[c] = None;
                    None
                }
            };
            bad += self.reconsider(m.t, c, (q[c], &moment), &wrong, passage.as_ref(), scatter);
            // A vote takes three sound estimates.
            let sound = wrong.is_empty() && !vanished && !self.suspects.iter().any(|s| s.signal.cylinder() == c);
            if let Some(passage) = passage.as_ref().filter(|_| sound) {
                wrong = self.faults(c, passage, scatter);
            }
            for (signal, kind) in wrong {
                if !self.suspects.iter().any(|s| s.signal == signal) {
                    let suspect = self.suspect(model, m.t, (signal, kind), &moment, passage.as_ref(), scatter);
                    bad += usize::from(suspect.plausible.is_none() && !alone(kind));
                    self.suspects.push(suspect);
                    found.push((signal, suspect.kind));
                }
            }
        }
        if bad > 1 {
            self.leave_out(m, &before, &mut found);
        } else {
            self.weigh(model, m.t, &q);
        }
        self.remember(m, &q, &strokes);
        found
    }

    /// Leaves out all readings of a sample that holds several bad ones, as if it had never come.
    fn leave_out(&mut self, m: &Measurement, before: &[Option<Track>; N], found: &mut OfSignals<(Signal, Kind)>) {
        let of_cylinder = if self.settings.reads_pressures { PER_CYLINDER } else { 1 };
        for (c, place) in (0..N).flat_map(|c| (0..of_cylinder).map(move |place| (c, place))) {
            let signal = Signal::of_cylinder(c, place);
            match self.suspects.iter_mut().find(|s| s.signal == signal) {
                Some(suspect) => suspect.plausible = None,
                None => {
                    let (kind, expected) = (Kind::InBadSample, f64::NAN);
                    self.suspects.push(Suspect { signal, kind, from: m.t, expected, plausible: None });
                    found.push((signal, kind));
                }
            }
        }
        let fresh = |track: &Track| m.t - track.t <= self.settings.ride_through + INTERVAL;
        self.tracks = before.map(|track| track.filter(fresh));
    }

    /// Keeps what the next sample is held against.
    fn remember(&mut self, m: &Measurement, q: &[f64; N], strokes: &[(f64, f64); N]) {
        for c in 0..N {
            let p = m.p.get(c).copied().unwrap_or([f64::NAN; 2]);
            let usable = |signal| !self.suspects.iter().any(|s| s.signal == signal && s.plausible.is_none());
            let doubted = |signal| self.doubted().any(|of| of == signal);
            let p_usable = [0, 1].map(|side| {
                let signal = Signal::Pressure(c, side);
                if usable(signal) && !doubted(signal) {
                    p[side]
                } else {
                    f64::NAN
                }
            });
            if p_usable.iter().all(|p| p.is_finite()) {
                self.pressed[c] = Some((m.t, p_usable));
            }
            if usable(Signal::Joint(c)) {
                let moment = Moment { stroke: strokes[c].0, p: p_usable };
                self.whereabouts[c] = Some(Whereabouts::at(m.t, q[c], moment));
            }
            let (was, was_p) = self.last[c].unwrap_or((q[c], p));
            let known = |now: f64, was: f64| if now.is_finite() { now } else { was };
            self.last[c] = Some((known(q[c], was), [0, 1].map(|side| known(p[side], was_p[side]))));
        }
    }

    /// A sensor that becomes suspect at time `t` (s); one whose outlier has ended reads plausibly already.
    fn suspect(
        &self,
        model: &ControllerModel<N>,
        t: f64,
        (signal, kind): (Signal, Kind),
        now: &Moment,
        passage: Option<&Passage>,
        scatter: f64,
    ) -> Suspect {
        let outlier = passage.and_then(|passage| self.outlier(model, passage, scatter, signal, kind));
        let since =
            self.vanished[signal.cylinder()].as_ref().filter(|_| kind == Kind::Vanished).map_or(t, |of| of.since);
        let (kind, from) = outlier.unwrap_or((kind, since));
        let known = self.whereabouts[signal.cylinder()].map_or(now.stroke, |known| known.moment.stroke);
        let expected = match (signal, kind) {
            (Signal::Joint(c), Kind::Jump(_)) => known + passage.map_or(0.0, |p| p.agreed(self.settings.jump[c])),
            (Signal::Joint(_), Kind::Frozen(missed)) => now.stroke + missed,
            (Signal::Joint(_), _) => now.stroke,
            (Signal::Pressure(_, side), _) => now.p[side],
        };
        Suspect { signal, kind, from, expected, plausible: outlier.map(|_| t) }
    }

    /// Readings that no machine in good order can give.
    fn beyond(&mut self, model: &ControllerModel<N>, t: f64, c: usize, q: f64, now: &Moment, scatter: f64) -> Wrong {
        let judge = |signal, reading: f64, possible: bool| {
            let kind = if reading.is_finite() { Kind::OutOfRange } else { Kind::NoReading };
            (!reading.is_finite() || !possible).then_some((signal, kind))
        };
        let within = |value: f64, [low, high]: [f64; 2]| (low..=high).contains(&value);
        let known = self.whereabouts(model, t, c);
        let (s, cylinder) = (&self.settings, &model.cylinders[c]);
        let limits @ [lowest, highest] = s.pressures[c];
        let joint =
            judge(Signal::Joint(c), q, within(q, s.joints[c]) && within(now.stroke, s.strokes[c])).or_else(|| {
                let known = known.filter(|known| !known.reach(now.stroke, scatter, cylinder, &model.fluid, highest))?;
                (!self.carried_beyond(model, t, c, now)).then_some((Signal::Joint(c), Kind::Jump(q - known.q)))
            });
        if !s.reads_pressures {
            return joint.into_iter().collect();
        }
        let pressure = |i: usize| {
            let possible = within(now.p[i], limits) || now.p[i] > lowest && self.confirms(model, t, c, i, now);
            judge(Signal::Pressure(c, i), now.p[i], possible)
        };
        // Found by its motion, which an earlier sample has shown.
        let gone = vanished::nothing(now.p, &s.trust[c]) && self.vanished[c].as_ref().is_some_and(|of| of.carried);
        let pressures = [0, 1].map(|i| pressure(i).or(gone.then_some((Signal::Pressure(c, i), Kind::Vanished))));
        joint.into_iter().chain(pressures.into_iter().flatten()).collect()
    }

    /// Where the piston of cylinder `c` can be at time `t` (s).
    fn whereabouts(&mut self, model: &ControllerModel<N>, t: f64, c: usize) -> Option<Whereabouts> {
        let known = self.whereabouts[c]?;
        let (asked, [_, highest]) = (self.spools(model, c, known.t()), self.settings.pressures[c]);
        self.whereabouts[c] = Some(known.until(t, &model.cylinders[c], &self.settings.trust[c], asked, highest));
        self.whereabouts[c]
    }

    /// Whether the load of cylinder `c` has vanished from its oil: both chambers read nothing, and a short time ago they carried it.
    fn look_for_load(&mut self, model: &ControllerModel<N>, t: f64, c: usize, p: [f64; 2]) -> bool {
        let (s, known) = (&self.settings, self.whereabouts.map(|known| known.map_or(f64::NAN, |known| known.q)));
        self.nothing[c] = s.reads_pressures && vanished::nothing(p, &s.trust[c]);
        self.vanished[c] = self.vanished[c].take().filter(|_| self.nothing[c]).or_else(|| {
            let (read, before) = self.pressed[c].filter(|(read, _)| t - read <= s.ride_through + INTERVAL)?;
            (self.nothing[c] && read < t).then(|| Vanished::seen(model, c, t, &known, before, &s.trust[c]))?
        });
        self.vanished[c].is_some()
    }

    /// What the motion until `t` (s) tells of loads that have vanished.
    fn weigh(&mut self, model: &ControllerModel<N>, t: f64, q: &[f64; N]) {
        let unread = |i: usize| self.suspects.iter().any(|s| s.signal == Signal::Joint(i) && s.plausible.is_none());
        if (0..N).any(unread) {
            return;
        }
        let (scatter, trust) = (&self.settings.scatter, &self.settings.trust);
        for (c, vanished) in self.vanished.iter_mut().enumerate() {
            match vanished.as_mut().map(|of| of.judge(model, c, (t, q), scatter, &trust[c])) {
                Some(Verdict::Carried) => vanished.iter_mut().for_each(|of| of.carried = true),
                Some(Verdict::Falls) => *vanished = None,
                Some(Verdict::Unknown) | None => {}
            }
        }
    }

    /// Whether the oil of a chamber says that the piston has moved as it reads: so a pressure may be beyond its limit, since masses that a
    /// closing valve stops know none.
    fn confirms(&self, model: &ControllerModel<N>, t: f64, c: usize, side: usize, now: &Moment) -> bool {
        self.tracks[c].is_some_and(|before| {
            let oil = self.estimates(model, t, c, &before, now)[side].displacement();
            oil.gap(&Interval::at(now.stroke - before.moment.stroke)) <= self.settings.jump[c]
        })
    }

    /// Whether the oil of a chamber says that the piston is where it reads, at a pressure beyond those within which its reach is counted.
    fn carried_beyond(&self, model: &ControllerModel<N>, t: f64, c: usize, now: &Moment) -> bool {
        let [_, highest] = self.settings.pressures[c];
        let beyond = |before: Track, side: usize| {
            let most = before.moment.p[side].max(now.p[side]);
            most > highest || self.settings.trust[c].ends(side, most)
        };
        self.tracks[c]
            .is_some_and(|before| (0..2).any(|side| beyond(before, side) && self.confirms(model, t, c, side, now)))
    }

    /// Displacements by the oil since the sample `before`.
    fn estimates(
        &self,
        model: &ControllerModel<N>,
        t: f64,
        c: usize,
        before: &Track,
        now: &Moment,
    ) -> [OilDisplacement; 2] {
        let swung = before.earlier.map_or([0.0; 2], |(_, earlier)| [0, 1].map(|i| before.moment.p[i] - earlier.p[i]));
        let (moments, spool) = ([&before.moment, now], self.spools(model, c, before.t));
        oil_displacements(
            &model.cylinders[c],
            &model.fluid,
            moments,
            swung,
            t - before.t,
            spool,
            &self.settings.trust[c],
        )
    }

    /// Advances to a sample; `None` where it is the first or follows too soon.
    fn advance(
        &mut self,
        model: &ControllerModel<N>,
        t: f64,
        c: usize,
        reading: f64,
        now: Standing,
        scatter: f64,
    ) -> Option<Passage> {
        let Standing { moment, load } = now;
        let first = Track {
            t,
            moment,
            load,
            reading,
            missed: [OilDisplacement::NOTHING; 2],
            changed: [now; 2],
            earlier: None,
            against: [0.0; 2],
            stirred: [moment.stroke; 2],
        };
        let before = *self.tracks[c].get_or_insert(first);
        if t - before.t < INTERVAL * (1.0 - 1e-6) {
            return None;
        }
        let estimates = self.estimates(model, t, c, &before, &moment);
        let missed = [0, 1].map(|i| before.missed[i].then(estimates[i]));
        let missed_now = if reading == before.reading { missed } else { first.missed };
        let mut track = Track { missed: missed_now, earlier: Some((before.t, before.moment)), ..first };
        for side in (0..2).filter(|&i| moment.p[i] == before.moment.p[i]) {
            track.changed[side] = before.changed[side];
            let travel = (moment.stroke - before.stirred[side]).abs();
            let moves = travel > scatter + STIR * self.settings.jump[c];
            (track.stirred[side], track.against[side]) = match moves {
                true => (moment.stroke, self.against(&model.cylinders[c], (c, side), &before, &now)),
                false => (before.stirred[side], before.against[side]),
            };
        }
        self.tracks[c] = Some(track);
        let measured = Interval::around(moment.stroke - before.moment.stroke, scatter);
        let oil = estimates.map(|estimate| estimate.displacement());
        Some(Passage { before, now: track, measured, oil, total: missed.map(|missed| missed.displacement()) })
    }

    /// All positions that a spool can have had since `from`: any until the commands from before the first sample are forgotten, since
    /// another controller may have moved it.
    fn spools(&self, model: &ControllerModel<N>, c: usize, from: f64) -> Interval {
        self.sent.since(c, from - self.settings.memory[c], Interval::around(0.0, model.cylinders[c].stroke))
    }

    /// Which of the three estimates is outvoted, and which reading does not change while the piston moves.
    fn faults(&self, c: usize, passage: &Passage, scatter: f64) -> Wrong {
        let jumps = self.jumps(c, passage);
        if !jumps.is_empty() {
            return jumps;
        }
        match self.frozen_joint(c, &passage.now, scatter) {
            Some(found) => [found].into_iter().collect(),
            None => (0..2).filter_map(|side| self.frozen_pressure(c, side, &passage.now)).collect(),
        }
    }

    fn jumps(&self, c: usize, passage: &Passage) -> Wrong {
        let (jump, now, before) = (self.settings.jump[c], &passage.now, &passage.before);
        let [one, two] = &passage.oil;
        let joint = (Signal::Joint(c), passage.jumped());
        if one.gap(two) <= jump {
            let outvoted = one.between(two).gap(&passage.measured) > jump;
            return outvoted.then_some(joint).into_iter().collect();
        }
        let pressure =
            |side: usize| (Signal::Pressure(c, side), Kind::Jump(now.moment.p[side] - before.moment.p[side]));
        // The chambers contradict each other: the position decides, if it agrees with one of them. If it agrees with none, nobody
        // knows which to believe.
        match passage.oil.map(|oil| oil.gap(&passage.measured) > jump) {
            [true, false] => [pressure(0)].into_iter().collect(),
            [false, true] => [pressure(1)].into_iter().collect(),
            [true, true] => [joint, pressure(0), pressure(1)].into_iter().collect(),
            [false, false] => Wrong::new(),
        }
    }

    /// The outlier that a jump of a pressure ends, and when it came, s: it went unseen, and from the sample before it to this one
    /// piston and chamber agree.
    fn outlier(
        &self,
        model: &ControllerModel<N>,
        passage: &Passage,
        scatter: f64,
        signal: Signal,
        kind: Kind,
    ) -> Option<(Kind, f64)> {
        let (Signal::Pressure(c, side), Kind::Jump(back)) = (signal, kind) else { return None };
        let Passage { before, now, .. } = passage;
        let (t, moment) = before.earlier?;
        let size = before.moment.p[side] - moment.p[side];
        if !returned(back, size) || now.t - t > (2.0 + 1e-6) * INTERVAL {
            return None;
        }
        let oil = self.estimates(model, now.t, c, &Track { t, moment, earlier: None, ..*before }, &now.moment)[side]
            .displacement();
        let agree = oil.gap(&Interval::around(now.moment.stroke - moment.stroke, scatter)) <= self.settings.jump[c];
        agree.then_some((Kind::Jump(size), before.t))
    }

    fn frozen_joint(&self, c: usize, now: &Track, scatter: f64) -> Option<(Signal, Kind)> {
        let [one, two] = now.missed.map(|m| m.displacement());
        let missed = one.between(&two);
        let frozen = self.settings.frozen[c];
        let outvoted = one.gap(&two) <= frozen && missed.gap(&Interval::around(0.0, scatter)) > frozen;
        outvoted.then_some((Signal::Joint(c), Kind::Frozen(missed.middle())))
    }

    fn frozen_pressure(&self, c: usize, side: usize, now: &Track) -> Option<(Signal, Kind)> {
        // A vacuum reads zero for as long as it lasts, and what is beyond the end of a sensor reads the end.
        let (p, trust) = (now.moment.p[side], &self.settings.trust[c]);
        let ends = p.abs() <= trust.pressure[side] || trust.ends(side, p);
        let travel = now.moment.stroke - now.changed[side].moment.stroke;
        let frozen = !ends && now.against[side] > MOST_AGAINST;
        frozen.then_some((Signal::Pressure(c, side), Kind::Frozen(travel)))
    }

    /// Bits against a pressure sensor whose reading has repeated in motion, with those `before`.
    fn against(&self, cylinder: &CylinderModel, (c, side): (usize, usize), before: &Track, now: &Standing) -> f64 {
        let (own, against) = (self.settings.against[c][side], before.against[side]);
        match own < 1.0 && self.explained(cylinder, c, side, now, &before.changed[side]) {
            false => against + 1.0,
            // Without noise a reading tells nothing while its step explains it.
            true if own == 0.0 => 0.0,
            true => against + own,
        }
    }

    /// Whether the load, friction and the other chamber leave a pressure within the resolution of its sensor since `then`.
    fn explained(&self, cylinder: &CylinderModel, c: usize, side: usize, now: &Standing, then: &Standing) -> bool {
        let resolution = self.settings.resolution[c][side];
        let chambers = &cylinder.chambers;
        let areas = [chambers.area_1, -chambers.area_2];
        let other = areas[1 - side] * (now.moment.p[1 - side] - then.moment.p[1 - side]);
        let needed = (now.load - then.load - other) / areas[side];
        // The crane swings.
        let unknown = cylinder.friction_both_ways() + DYNAMIC * now.load.abs();
        // An unknown load explains everything.
        needed.is_nan()
            || needed.abs() <= resolution + self.settings.trust[c].pressure[side] + unknown / areas[side].abs()
    }

    /// Which suspects of cylinder `c` read plausibly again; gives the number of those that read wrongly.
    fn reconsider(
        &mut self,
        t: f64,
        c: usize,
        (q, now): (f64, &Moment),
        wrong: &[(Signal, Kind)],
        passage: Option<&Passage>,
        scatter: f64,
    ) -> usize {
        let (jump, frozen) = (self.settings.jump[c], self.settings.frozen[c]);
        let first = self.tracks[c].is_some_and(|track| track.t == t);
        let (was, was_p) = self.last[c].unwrap_or((q, now.p));
        let mut judged = Judged {
            now,
            known: self.whereabouts[c].map_or(now.stroke, |known| known.moment.stroke),
            passage,
            unjudged: first || !self.settings.reads_pressures,
            short: true,
            change: [q - was, now.p[0] - was_p[0], now.p[1] - was_p[1]],
            jump,
            near: scatter + jump.min(0.5 * frozen),
        };
        let mut bad = 0;
        for suspect in self.suspects.iter_mut().filter(|s| s.signal.cylinder() == c) {
            let own = wrong.iter().find(|(signal, _)| *signal == suspect.signal).map(|(_, kind)| *kind);
            judged.short = t - suspect.from <= self.settings.ride_through + INTERVAL;
            let fits = suspect.fits(own, &judged);
            suspect.plausible = if fits { suspect.plausible.or(Some(t)) } else { None };
            bad += usize::from(!fits && !own.is_some_and(alone));
        }
        bad
    }
}
