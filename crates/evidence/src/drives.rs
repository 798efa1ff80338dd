//! Random drives of many cases, judged.

use crate::bound::{Bounds, MARGIN};
use crate::case::Case;
use crate::core::{Core, Native, Page};
use crate::course::{is_chamber, Course, Plan, Steps, PLACES};
use crate::energy::{worst_gap, Gap};
use crate::reference::{self, Nudge, TIGHT, TOLERANCE};
use crate::sticks::moves;
use hydrocrane_sim::Model;
use hydrocrane_web::TICK;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::Mutex;

/// A ledger closes to this share of the energy that flowed.
pub const LEDGER_SHARE: f64 = 0.01;
/// A tip stays this near to the adaptive run's, m.
pub const TIP: f64 = 5e-3;
/// A tip farther away than this from the first adaptive run is judged by the tight one: a drive that amplifies small
/// differences amplifies those of the adaptive run too, and the two can agree by chance.
const DOUBTFUL: f64 = 0.1 * TIP;
/// Starts whose tips lie this far away, moved by one joint each, tell how much a drive amplifies small differences, m.
const NUDGE: f64 = 1e-6;
const BAR: f64 = 1e5;
/// Stands for figures that are greater or no number: JSON has no word for them.
const MOST: f64 = 1e12;

fn figure(value: f64) -> f64 {
    if value.is_nan() {
        MOST
    } else {
        value.clamp(-MOST, MOST)
    }
}

/// How the drives are made.
#[derive(Debug, Clone)]
pub struct Options {
    pub drives: u64,
    pub seconds: f64,
    /// The tip is compared with the adaptive run until here, s.
    pub followed: f64,
    pub seed: u64,
    pub threads: usize,
    /// Where drives are kept whose tips are too far away, as scenarios that `hydrocrane simulate` repeats.
    pub keep: Option<String>,
    /// Script and compiled core of the page; the native core without them.
    pub page: Option<[String; 2]>,
}

/// The end of a drive: a digest of the bits of its last row's states, and the tip (x, z), m.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct End {
    pub digest: String,
    pub tip: [f64; 2],
}

/// What the drives of one case came to.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Figures {
    pub machine: String,
    pub mode: String,
    /// kg
    pub payload: f64,
    /// Why there are no drives.
    pub refused: Option<String>,
    pub drives: u64,
    pub seconds: f64,
    /// Drives that ended before their time, by the kind of their outcome.
    pub ended: BTreeMap<String, u32>,
    pub first_end: Option<String>,
    #[serde(flatten)]
    pub pressures: Peaks,
    /// Farthest that a joint was beyond its limits, as a share of its range.
    pub beyond: f64,
    pub ledger_share: f64,
    /// J
    pub ledger_residual: f64,
    /// Whether laws as the thesis printed them jump, so that no adaptive run judges the drives.
    pub printed: bool,
    #[serde(flatten)]
    pub agreement: Agreement,
    pub steps: Steps,
    /// Drives that the other core drove too, those that end there in the same bits, and the largest distance of tips' ends, mm.
    pub compared: u32,
    pub identical: Option<u32>,
    pub end_difference: Option<f64>,
    pub ends: Vec<End>,
}

/// Pressures of the drives of one case.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Peaks {
    /// Highest and lowest pressure, bar.
    pub peak: f64,
    pub lowest: f64,
    /// Highest share of a pressure in what supply and load can make: at rest and in motion, and at rest alone.
    pub bound_share: f64,
    pub rest_share: f64,
    /// The drive with the highest share.
    pub peak_drive: u64,
}

/// How well the drives of one case agree with adaptive runs.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Agreement {
    /// Largest distance of the tip from the adaptive run's, mm, and its drive.
    pub tip: f64,
    pub tip_drive: u64,
    /// Drives farther away than [`TIP`], and drives that no adaptive run could judge.
    pub tip_far: u32,
    /// Drives judged by the tight adaptive run.
    #[serde(default)]
    pub tightened: u32,
    /// Drives farther away than [`TIP`], but not farther than the adaptive run is from a repeat that starts 1 um away.
    pub sensitive: u32,
    /// How far apart those are, at most, mm.
    pub nudged: f64,
    pub unjudged: u32,
    pub first_unjudged: Option<String>,
}

/// What one drive came to.
struct Judged {
    course: Course,
    peak: f64,
    bound_share: f64,
    rest_share: f64,
    beyond: f64,
    gap: Gap,
    /// Nothing where laws jump.
    tip: Option<Result<Apart, String>>,
    end: End,
}

impl Judged {
    fn is_far(&self) -> bool {
        matches!(&self.tip, Some(Ok(apart)) if apart.most > TIP)
    }
}

/// How far a drive's tip is from the adaptive run's, m.
struct Apart {
    most: f64,
    /// Whether the adaptive run is the tight one, because the first was farther away than [`DOUBTFUL`].
    tightened: bool,
    /// Where that is more than [`TIP`]: how far the adaptive run is from its repeats that start [`NUDGE`] away, at most, and
    /// whether that explains the distance at every time.
    nudged: Option<(f64, bool)>,
}

/// Drives all cases; `tell` hears of each case that is done.
pub fn campaign(cases: &[Case], options: &Options, tell: &(dyn Fn(&Figures) + Sync)) -> Result<Vec<Figures>, String> {
    let next = AtomicUsize::new(0);
    let done: Mutex<Vec<Option<Figures>>> = Mutex::new(cases.iter().map(|_| None).collect());
    let work = || -> Result<(), String> {
        let mut core: Box<dyn Core> = match &options.page {
            Some([script, wasm]) => Box::new(Page::start(script, wasm)?),
            None => Box::new(Native),
        };
        loop {
            let at = next.fetch_add(1, Ordering::Relaxed);
            let Some(case) = cases.get(at) else { return Ok(()) };
            let figures = drive(case, options, core.as_mut())?;
            tell(&figures);
            if let Ok(mut done) = done.lock() {
                done[at] = Some(figures);
            }
        }
    };
    let results: Vec<Result<(), String>> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..options.threads.max(1)).map(|_| scope.spawn(work)).collect();
        threads.into_iter().map(|t| t.join().unwrap_or_else(|_| Err("a thread panicked".into()))).collect()
    });
    results.into_iter().collect::<Result<Vec<()>, String>>()?;
    Ok(done.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner()).into_iter().flatten().collect())
}

/// The drives of one case.
pub fn drive(case: &Case, options: &Options, core: &mut dyn Core) -> Result<Figures, String> {
    let (machine, model) = case.model()?;
    let mut figures = Figures::new(case, options);
    figures.refused = case.without(model.as_ref()).map(str::to_string);
    if figures.refused.is_some() {
        return Ok(figures);
    }
    let ticks = (options.seconds / TICK).round() as u32;
    let followed = (options.followed.min(options.seconds - 0.01) / TICK).round() as u32 / PLACES * PLACES;
    for number in 0..options.drives {
        let moves = moves(options.seed, number, case.axes(&machine), ticks);
        let course = core.drive(&Plan { request: case.request(), moves, followed })?;
        if course.refused.is_some() {
            figures.refused = course.refused;
            return Ok(figures);
        }
        let judged = judge(course, model.as_ref(), case.payload);
        let wanted = judged.is_far() || judged.course.ended.is_some();
        if let (Some(folder), true, Some(saved)) = (&options.keep, wanted, &judged.course.saved) {
            let name = format!("{}-{}-{}kg-{number}.toml", case.machine, case.mode, case.payload);
            let path = std::path::Path::new(folder).join(name);
            std::fs::write(&path, saved).map_err(|error| format!("{}: {error}", path.display()))?;
        }
        figures.add(number, &judged);
    }
    Ok(figures)
}

fn judge(course: Course, model: &dyn Model, payload: f64) -> Judged {
    let first = course.index(&model.layout().names[0]).unwrap_or(0);
    let n = model.layout().joints();
    let bounds = Bounds::new(model, payload);
    let (mut peak, mut bound_share, mut rest_share) = (f64::NEG_INFINITY, 0.0f64, 0.0f64);
    let chambers = course.signals.iter().enumerate().filter(|(_, name)| is_chamber(name));
    for (chamber, ((at, _), row)) in chambers.zip(&course.peaks).enumerate() {
        let bound = bounds.at(&row[first..first + n])[chamber];
        // A number that is none exceeds every bound.
        let pressure = if row[at].is_nan() { f64::INFINITY } else { row[at] };
        let shares =
            [pressure / bound.total(), pressure / bound.rest].map(|s| if s.is_nan() { f64::INFINITY } else { s });
        peak = peak.max(pressure);
        (bound_share, rest_share) = (bound_share.max(shares[0]), rest_share.max(shares[1]));
    }
    let end = course.rows.last().map_or(&[][..], |row| &row[first..first + model.layout().len()]);
    let end = End {
        digest: digest(end),
        tip: if end.is_empty() { [MOST; 2] } else { reference::x_and_z(model, &end[..n]).map(figure) },
    };
    let beyond = beyond(&course, model, first);
    let gap = worst_gap(model, &course.signals, &course.rows);
    let tip = smooth(model).then(|| distance(&course, model));
    Judged { course, peak, bound_share, rest_share, beyond, gap, tip, end }
}

/// Whether no law is switched to its printed form, which jumps: steps of an adaptive method then shrink to nothing.
fn smooth(model: &dyn Model) -> bool {
    let (states, cylinders) = (vec![0.0; model.layout().len()], vec![0.0; model.layout().joints()]);
    model.reference_derivative(&states, &cylinders, 0.0).is_some()
}

/// Farthest that a joint was beyond its limits, as a share of its range.
fn beyond(course: &Course, model: &dyn Model, first: usize) -> f64 {
    let over = model.joint_limits().iter().enumerate().map(|(i, limit)| {
        let out = (limit.lower - course.low[first + i]).max(course.high[first + i] - limit.upper);
        out / (limit.upper - limit.lower)
    });
    over.fold(0.0, f64::max)
}

fn distance(course: &Course, model: &dyn Model) -> Result<Apart, String> {
    let saved = course.saved.as_deref().ok_or("the drive could not be saved")?;
    let interval = f64::from(PLACES) * TICK;
    let apart_from = |exact: &[[f64; 2]]| growing(course.tip.iter().map(Vec::as_slice), exact);
    let adaptive = |tolerance, nudge| reference::tip(saved, model, interval, tolerance, nudge);
    let most = farthest(&apart_from(&adaptive(TOLERANCE, None)?));
    if most <= DOUBTFUL {
        return Ok(Apart { most, tightened: false, nudged: None });
    }
    let exact = adaptive(TIGHT, None)?;
    let apart = apart_from(&exact);
    let most = farthest(&apart);
    if most <= TIP {
        return Ok(Apart { most, tightened: true, nudged: None });
    }
    let mut nudged = vec![0.0; apart.len()];
    for joint in 0..model.layout().joints() {
        let moved = adaptive(TIGHT, Some(Nudge { joint, distance: NUDGE }))?;
        let by_joint = growing(exact.iter().map(|tip| &tip[..]), &moved);
        nudged.iter_mut().zip(by_joint).for_each(|(most, this)| *most = this.max(*most));
    }
    let explained = apart.iter().zip(&nudged).all(|(apart, nudged)| *apart <= TIP.max(*nudged));
    Ok(Apart { most, tightened: true, nudged: Some((farthest(&nudged), explained)) })
}

/// The largest distance of the tips `here` from those `there` until each time.
fn growing<'a>(here: impl Iterator<Item = &'a [f64]>, there: &[[f64; 2]]) -> Vec<f64> {
    let mut worst = 0.0f64;
    let distance = |(here, there): (&[f64], &[f64; 2])| {
        let d = (here[0] - there[0]).hypot(here[1] - there[1]);
        worst = if d.is_nan() { f64::INFINITY } else { worst.max(d) };
        worst
    };
    here.zip(there).map(distance).collect()
}

fn farthest(growing: &[f64]) -> f64 {
    growing.last().copied().unwrap_or(0.0)
}

/// FNV-1a over the bits.
fn digest(numbers: &[f64]) -> String {
    let bytes = numbers.iter().flat_map(|x| x.to_bits().to_le_bytes());
    let hash = bytes.fold(0xcbf2_9ce4_8422_2325u64, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01b3));
    format!("{hash:016x}")
}

impl Figures {
    fn new(case: &Case, options: &Options) -> Self {
        Figures {
            machine: case.machine.clone(),
            mode: case.mode.clone(),
            payload: case.payload,
            refused: None,
            drives: 0,
            seconds: options.seconds,
            ended: BTreeMap::new(),
            first_end: None,
            pressures: Peaks { lowest: MOST, ..Peaks::default() },
            beyond: 0.0,
            ledger_share: 0.0,
            ledger_residual: 0.0,
            printed: false,
            agreement: Agreement::default(),
            steps: Steps::default(),
            compared: 0,
            identical: None,
            end_difference: None,
            ends: Vec::new(),
        }
    }

    fn add(&mut self, number: u64, judged: &Judged) {
        self.drives += 1;
        if let Some(ended) = &judged.course.ended {
            *self.ended.entry(ended.kind.clone()).or_default() += 1;
            let first = || format!("drive {number} at {:.3} s: {}", ended.time, ended.message);
            self.first_end.get_or_insert_with(first);
        }
        let low = judged.course.signals.iter().zip(&judged.course.low).filter(|(name, _)| is_chamber(name));
        self.pressures.lowest = low.map(|(_, p)| figure(p / BAR)).fold(self.pressures.lowest, f64::min);
        self.pressures.peak = self.pressures.peak.max(figure(judged.peak / BAR));
        if judged.bound_share > self.pressures.bound_share {
            (self.pressures.bound_share, self.pressures.peak_drive) = (figure(judged.bound_share), number);
        }
        self.pressures.rest_share = self.pressures.rest_share.max(figure(judged.rest_share));
        self.beyond = self.beyond.max(figure(judged.beyond));
        if figure(judged.gap.share) > self.ledger_share {
            (self.ledger_share, self.ledger_residual) = (figure(judged.gap.share), figure(judged.gap.residual));
        }
        match &judged.tip {
            None => self.printed = true,
            Some(Ok(apart)) => {
                if figure(apart.most * 1e3) > self.agreement.tip {
                    (self.agreement.tip, self.agreement.tip_drive) = (figure(apart.most * 1e3), number);
                }
                self.agreement.tightened += u32::from(apart.tightened);
                if let Some((nudged, explained)) = apart.nudged {
                    self.agreement.sensitive += u32::from(explained);
                    self.agreement.tip_far += u32::from(!explained);
                    self.agreement.nudged = self.agreement.nudged.max(figure(1e3 * nudged));
                }
            }
            Some(Err(why)) => {
                self.agreement.unjudged += 1;
                self.agreement.first_unjudged.get_or_insert_with(|| format!("drive {number}: {why}"));
            }
        }
        self.steps.add(&judged.course.steps);
        self.ends.push(judged.end.clone());
    }

    /// Compares the drives' ends with those of the other core.
    pub fn compare(&mut self, others: &[Figures]) {
        let same = |other: &&Figures| {
            (&other.machine, &other.mode, other.payload) == (&self.machine, &self.mode, self.payload)
        };
        let Some(other) = others.iter().find(same) else { return };
        let pairs = || self.ends.iter().zip(&other.ends);
        let apart = pairs().map(|(a, b)| 1e3 * (a.tip[0] - b.tip[0]).hypot(a.tip[1] - b.tip[1]));
        self.end_difference = Some(apart.map(figure).fold(0.0, f64::max));
        self.compared = pairs().count() as u32;
        self.identical = Some(pairs().filter(|(a, b)| a.digest == b.digest).count() as u32);
    }

    /// What is wrong with the drives, a line each.
    pub fn faults(&self) -> Vec<String> {
        let mut faults = Vec::new();
        if !self.ended.is_empty() {
            let kinds: Vec<String> = self.ended.iter().map(|(kind, n)| format!("{n} {kind}")).collect();
            let first = self.first_end.as_deref().unwrap_or_default();
            faults.push(format!("{} of {} drives ended: {first}", kinds.join(", "), self.drives));
        }
        if self.pressures.bound_share > MARGIN {
            let (peak, share) = (self.pressures.peak, self.pressures.bound_share);
            faults.push(format!("{peak:.0} bar, {share:.2} times what supply and load can make"));
        }
        if self.ledger_share > LEDGER_SHARE {
            faults.push(format!(
                "the ledger is open by {:.3e} J, {:.2} %",
                self.ledger_residual,
                100.0 * self.ledger_share
            ));
        }
        if self.agreement.tip_far > 0 || self.agreement.unjudged > 0 {
            let why = self.agreement.first_unjudged.as_deref().unwrap_or_default();
            let (far, tip, unjudged) = (self.agreement.tip_far, self.agreement.tip, self.agreement.unjudged);
            faults.push(format!("{far} tips up to {tip:.1} mm from the adaptive run, {unjudged} not judged {why}"));
        }
        let compared = self.compared;
        if let (Some(identical), Some(apart)) = (self.identical, self.end_difference) {
            if identical < compared {
                let others = compared - identical;
                faults.push(format!(
                    "{others} drives end in other bits than in the other core, {apart:.1} mm away at most"
                ));
            }
        }
        faults
    }
}
