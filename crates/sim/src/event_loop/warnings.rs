//! Checks of a run, with warnings that state cause and cure.          reference: docs/reference/warnings.md

use crate::event_loop::driven::Driven;
use crate::event_loop::ledger::Audit;
use crate::event_loop::oil_lost::OilLost;
use crate::event_loop::promises;
use crate::inputs::sensing::unmeasured;
use crate::model::Model;
use crate::warning::Warning;
use hydrocrane_machine::model::{Cavitation, Unusual};
use hydrocrane_machine::Machine;
use hydrocrane_ode::Stepper;
use hydrocrane_plant::crane::limits::{in_words, JointLimits};
use hydrocrane_plant::crane::statics::{HeldBy, Unheld};
use hydrocrane_plant::resting::shortfall::{Limit, Shortfall};

/// Default rated pressure of a chamber, as a multiple of the supply pressure that the file states.
const RATING: f64 = 1.5;
/// Pressure below vacuum that is rounding, Pa.
const VACUUM_ROUNDING: f64 = 1e3;
/// Share of the atmosphere below which a chamber counts as torn open: free gas fills ten times its volume then. Time after which that is
/// reported, s: shorter ones close again within a stop.
const TORN: f64 = 0.1;
const TORN_TIME: f64 = 0.05;
/// Time after which a section that is short is reported, s: while spools open, pressures and pumps settle.
const STARVED_TIME: f64 = 0.1;
/// Share of a flow from which an error of the model is reported.
const TELLING: f64 = 0.01;
/// Time over which the estimated errors of fixed steps are averaged, s: those of a start or a stop are over before.
const ESTIMATE_TIME: f64 = 0.5;
/// Share of a state and its scale that this mean may have: 100 times the tolerance of a run that states none.
const ESTIMATE_SHARE: f64 = 0.01;
/// Share of what is promised of pressures from which their estimated error is reported: the estimate may be several times too small.
const OF_PRESSURE: f64 = 1.0 / 3.0;

/// The states whose estimated errors tell how exact fixed steps are. Spools count by their effect only. Static friction is taken by
/// its secant: what it acts on says little then, and only the supply counts, whose little oil is faster than that of any cylinder.
fn judged_of_fixed_steps(model: &dyn Model) -> Vec<usize> {
    let layout = model.layout();
    let (n, supply) = (layout.joints(), layout.blocks().shared);
    let bristles = (0..n).all(|c| layout.z(c).is_some());
    let own = (0..n).filter(|_| bristles).flat_map(|c| [layout.q(c), layout.qd(c), layout.p1(c), layout.p2(c)]);
    own.chain(supply.first..supply.first + supply.count).collect()
}

/// Kinds of findings, some with the number of a cylinder or joint.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Finding {
    AboveRating(usize),
    BelowVacuum(usize),
    OutsideLimits(usize),
    DeadCentre(usize),
    LedgerOpen,
    StepTooLong,
    StepInexact(usize),
    ToleranceTooLoose,
    /// Of a cylinder and its side, in pairs.
    PressureInexact(usize),
    /// Of the section of a cylinder.
    Starved(usize),
    /// Of a cylinder and its side, in pairs.
    AtVacuum(usize),
    /// Of a cylinder and its side, in pairs.
    OilLost(usize),
}

/// A finding with its begin and its extreme value: a pressure (Pa), a joint coordinate, a share of the energy or of a state, a step
/// (s), a distance (m), a missing flow (m^3/s), a time (s), or a volume (m^3).
#[derive(Debug, Clone, Copy)]
struct Found {
    what: Finding,
    time: f64,
    farthest: f64,
}

/// Checks every step of a run.
pub(crate) struct Watch {
    ratings: Vec<f64>,
    vacuum: f64,
    limits: Vec<[f64; 2]>,
    /// The tip moves no farther than this for a unit of any joint, m or 1.
    reach: f64,
    audit: Option<Audit>,
    /// Whether steps are fixed.
    fixed: bool,
    lost: Option<OilLost>,
    /// The worst shortfall of each section that had one.
    starved: Vec<Shortfall>,
    /// How long each section has been short, s.
    lacking: Vec<f64>,
    /// How long the sides of the cylinders have been at vacuum, s, in pairs.
    empty: Vec<f64>,
    /// Mean estimated errors of fixed steps, by state.
    estimates: Vec<(usize, f64)>,
    /// The largest distance that [`Self::carried`] found, m, or a bound of it; `None` if a step had no estimate.
    pub tip_error: Option<f64>,
    /// How long the pressures of the cylinders have been off by more than is promised, s, in pairs.
    astray: Vec<f64>,
    found: Vec<Found>,
    reported: usize,
}

impl Watch {
    /// From the state of `stepper` on.
    pub fn new(stepper: &Stepper, driven: &Driven) -> Self {
        let machine = driven.model.machine();
        let mut watch = Watch {
            ratings: vec![],
            vacuum: 0.0,
            limits: vec![],
            reach: 0.0,
            audit: Audit::begin(stepper, driven),
            fixed: stepper.fixed_step_error().is_some(),
            lost: OilLost::new(stepper, driven),
            starved: vec![],
            lacking: vec![0.0; machine.cylinders.len()],
            empty: vec![0.0; 2 * machine.cylinders.len()],
            estimates: vec![],
            tip_error: None,
            astray: vec![0.0; 2 * machine.cylinders.len()],
            found: vec![],
            reported: 0,
        };
        watch.take_bounds(driven.model);
        watch.look(stepper, driven);
        watch.tip_error = Some(0.0);
        watch
    }

    fn take_bounds(&mut self, model: &dyn Model) {
        let machine = model.machine();
        self.ratings = pressure_ratings(machine);
        self.vacuum = match machine.fluid.cavitation {
            Cavitation::FreeGas { vacuum } => vacuum,
            Cavitation::None => STANDARD_VACUUM,
        };
        self.limits = model.joint_limits().iter().map(JointLimits::widened).collect();
        self.reach = model.reach().max(1.0);
        if self.estimates.is_empty() {
            self.estimates = judged_of_fixed_steps(model).into_iter().map(|i| (i, 0.0)).collect();
        }
    }

    /// The values of the machine have changed from `before` to those of `driven`.
    pub fn follow(&mut self, before: &dyn Model, driven: &Driven, stepper: &Stepper) {
        self.take_bounds(driven.model);
        if let Some(lost) = self.lost.as_mut().filter(|_| cfg!(feature = "chains")) {
            lost.begin(stepper, driven);
        }
        if let Some(audit) = &mut self.audit {
            audit.follow(before, driven, stepper);
        }
    }

    /// Checks the present state and, from time to time, the ledger.
    pub fn look(&mut self, stepper: &Stepper, driven: &Driven) {
        let (layout, x, t) = (driven.model.layout(), &stepper.x, stepper.t);
        let mut risen = false;
        for c in 0..layout.joints() {
            let (p1, p2) = (x[layout.p1(c)], x[layout.p2(c)]);
            let (least, most) = (p1.min(p2), p1.max(p2));
            if most > self.ratings[c] {
                risen |= self.note(Finding::AboveRating(c), t, most);
            }
            if least < self.vacuum - VACUUM_ROUNDING {
                self.note(Finding::BelowVacuum(c), t, least);
            }
            self.cavities(c, [p1, p2], stepper);
            let (q, [lower, upper]) = (x[layout.q(c)], self.limits[c]);
            if q < lower || q > upper {
                self.beyond(driven.model, c, x, t);
            }
        }
        for short in driven.model.shortfalls(x) {
            let lacking = &mut self.lacking[short.cylinder];
            *lacking += t - stepper.previous_time();
            if *lacking < STARVED_TIME {
                continue;
            }
            self.note(Finding::Starved(short.cylinder), t, short.missing());
            match self.starved.iter_mut().find(|worst| worst.cylinder == short.cylinder) {
                Some(worst) if worst.missing() >= short.missing() => {}
                Some(worst) => *worst = short,
                None => self.starved.push(short),
            }
        }
        if let Some(mut lost) = self.lost.take().filter(|_| cfg!(feature = "chains")) {
            lost.add(stepper, driven);
            for (side, volume) in lost.volumes.iter().enumerate().filter(|(_, volume)| **volume > 0.0) {
                self.note(Finding::OilLost(side), t, *volume);
            }
            self.lost = Some(lost);
        }
        if let Some(since) = stepper.unresolved {
            self.note(Finding::StepTooLong, since, stepper.least_part());
        }
        if let Some(error) = stepper.fixed_step_error() {
            self.estimate(error, stepper, driven.model);
        }
        self.carried(stepper, driven.model);
        // The law of the oil holds the less the higher a pressure is; a peak is over at the next audit.
        if self.audit.as_ref().is_some_and(|audit| risen || t >= audit.next()) {
            self.audit(stepper, driven);
        }
    }

    /// How far tip and pressures are off by the errors of all steps, as far as they are estimated.
    fn carried(&mut self, stepper: &Stepper, model: &dyn Model) {
        let Some(error) = stepper.global_error() else {
            self.tip_error = None;
            return;
        };
        let n = model.layout().joints();
        // Mostly no pose can make as much of it as is promised, and none is worked out.
        let mut distance = error[..n].iter().map(|error| error.abs()).sum::<f64>() * self.reach;
        if distance > promises::TIP {
            let [x, y, z] = model.tip_velocity(&stepper.x[..n], &error[..n]);
            distance = (x * x + y * y + z * z).sqrt();
            if distance > promises::TIP {
                self.note(Finding::ToleranceTooLoose, stepper.t, distance);
            }
        }
        self.tip_error = self.tip_error.map(|most| most.max(distance.min(self.reach)));
        let promise = OF_PRESSURE * promises::PRESSURE * model.machine().supply.pressure;
        for at in 0..2 * n {
            let state = if at % 2 == 0 { model.layout().p1(at / 2) } else { model.layout().p2(at / 2) };
            let off = error[state].abs();
            self.astray[at] = if off > promise { self.astray[at] + stepper.t - stepper.previous_time() } else { 0.0 };
            if self.astray[at] > promises::BRIEF {
                self.note(Finding::PressureInexact(at), stepper.t, off);
            }
        }
    }

    /// Counts how long the oil of a cylinder has been torn open at its pressures (Pa).
    fn cavities(&mut self, c: usize, pressures: [f64; 2], stepper: &Stepper) {
        for (side, p) in pressures.into_iter().enumerate() {
            let at = 2 * c + side;
            if !(self.vacuum - VACUUM_ROUNDING..=self.vacuum * (1.0 - TORN)).contains(&p) {
                continue;
            }
            self.empty[at] += stepper.t - stepper.previous_time();
            if self.empty[at] > TORN_TIME {
                self.note(Finding::AtVacuum(at), stepper.t, self.empty[at]);
            }
        }
    }

    /// Fixed steps have no tolerance to keep: what their estimated errors are in the mean of some time.
    fn estimate(&mut self, error: &[f64], stepper: &Stepper, model: &dyn Model) {
        let layout = model.layout();
        let weight = ((stepper.t - stepper.previous_time()) / ESTIMATE_TIME).min(1.0);
        let mut worst = (0.0, 0);
        for (i, mean) in &mut self.estimates {
            *mean += weight * (error[*i].abs() - *mean);
            let share = *mean / (layout.scales[*i] + stepper.x[*i].abs());
            if share > worst.0 {
                worst = (share, *i);
            }
        }
        if worst.0 > ESTIMATE_SHARE {
            let first = self.found.iter().map(|found| found.what).find(|what| matches!(what, Finding::StepInexact(_)));
            self.note(first.unwrap_or(Finding::StepInexact(worst.1)), stepper.t, worst.0);
        }
    }

    /// Joint `i` is outside its limits; the linkage may also have gone past its dead centre.
    fn beyond(&mut self, model: &dyn Model, i: usize, x: &[f64], t: f64) {
        let n = model.layout().joints();
        let limits = &model.joint_limits()[i];
        let (mut strokes, mut lever_arms, mut middle) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        let mut q = x[..n].to_vec();
        model.strokes(&q, &mut strokes, &mut lever_arms);
        q[i] = 0.5 * (limits.lower + limits.upper);
        model.strokes(&q, &mut strokes, &mut middle);
        let turned = lever_arms[i] * middle[i] <= 0.0;
        self.note(if turned { Finding::DeadCentre(i) } else { Finding::OutsideLimits(i) }, t, x[i]);
    }

    fn audit(&mut self, stepper: &Stepper, driven: &Driven) {
        if let Some(open) = self.audit.as_mut().and_then(|audit| audit.open(stepper, driven)) {
            self.note(Finding::LedgerOpen, stepper.t, open);
        }
    }

    /// Keeps the farthest value of a finding; `true` if that is this one.
    fn note(&mut self, what: Finding, time: f64, value: f64) -> bool {
        let Some(found) = self.found.iter_mut().find(|found| found.what == what) else {
            self.found.push(Found { what, time, farthest: value });
            return true;
        };
        let farther = value.abs() > found.farthest.abs();
        if farther {
            found.farthest = value;
        }
        farther
    }

    /// All findings until the end of the run, in order of time.
    pub fn close(&mut self, stepper: &Stepper, driven: &Driven) -> Vec<Warning> {
        self.audit(stepper, driven);
        let mut all: Vec<Warning> = self.found.iter().map(|found| found.warning(driven.model, self)).collect();
        all.sort_by(|a, b| a.time.total_cmp(&b.time));
        all
    }

    /// Findings since the last call.
    pub fn news(&mut self, model: &dyn Model) -> Vec<Warning> {
        let news = self.found[self.reported..].iter().map(|found| found.warning(model, self)).collect();
        self.reported = self.found.len();
        news
    }
}

const SIDES: [&str; 2] = ["piston side", "rod side"];

/// Gauge pressure of vacuum for oil without a vacuum limit, Pa.
const STANDARD_VACUUM: f64 = -1e5;

impl Found {
    fn warning(&self, model: &dyn Model, watch: &Watch) -> Warning {
        let machine = model.machine();
        let bar = |p: f64| p / 1e5;
        let value = self.farthest;
        let (kind, text, cure) = match self.what {
            Finding::AboveRating(c) => (
                "pressure-above-rating",
                format!(
                    "the pressure in cylinder `{}` reaches {:.0} bar; it is rated for {:.0} bar",
                    machine.cylinders[c].name,
                    bar(value),
                    bar(watch.ratings[c])
                ),
                format!(
                    "carry less or move the spool more gently; if the cylinder is rated for it, state \
                     `cylinder.{}.pressure-rating`",
                    machine.cylinders[c].name
                ),
            ),
            Finding::BelowVacuum(c) => (
                "pressure-below-vacuum",
                format!(
                    "the pressure in cylinder `{}` falls to {:.1} bar, below vacuum: oil cannot carry such tension",
                    machine.cylinders[c].name,
                    bar(value)
                ),
                match machine.fluid.cavitation {
                    Cavitation::None => "state `fluid.vacuum` in place of the law as printed".to_string(),
                    Cavitation::FreeGas { .. } => "tighten `rtol` or shorten the step: the law of the oil forbids it".to_string(),
                },
            ),
            Finding::OutsideLimits(i) => (
                "joint-outside-limits",
                format!("joint {} is at {}", machine.joints[i].name, model.joint_limits()[i].compared(&machine.joints[i], value)),
                "stop the cylinder sooner; the model has no stop at this limit".to_string(),
            ),
            Finding::DeadCentre(i) => (
                "dead-centre-passed",
                format!(
                    "joint {} is past the dead centre of its linkage, at {}: its cylinder moves it in the opposite direction there",
                    machine.joints[i].name,
                    model.joint_limits()[i].compared(&machine.joints[i], value)
                ),
                "start farther inside the limits or stop the cylinder sooner; the result after this time is not what the machine does"
                    .to_string(),
            ),
            Finding::LedgerOpen => (
                "energy-ledger-open",
                format!("{:.2} % of the energy that flowed is unaccounted for", 100.0 * value),
                "tighten `rtol` or shorten the step; if pressures are far above the rating, the model is not valid"
                    .to_string(),
            ),
            Finding::StepTooLong => (
                "step-too-long",
                format!("fixed steps divided down to {:.0} us do not follow the motion everywhere", 1e6 * value),
                "shorten `step`, or use `rodas5p`, which has step size control".to_string(),
            ),
            Finding::StepInexact(state) => (
                "step-inexact",
                format!(
                    "fixed steps are too long: the estimated error of `{}`, averaged over {ESTIMATE_TIME} s, reaches {:.1} %",
                    model.layout().names[state],
                    100.0 * value
                ),
                "shorten `step`, or leave it out: steps by tolerance keep theirs".to_string(),
            ),
            Finding::ToleranceTooLoose | Finding::PressureInexact(_) => {
                let off = match self.what {
                    Finding::PressureInexact(at) => {
                        let name = &machine.cylinders[at / 2].name;
                        let off = estimated(1e-5 * value, bar(machine.supply.pressure), "bar");
                        format!("the pressure on the {} of cylinder `{name}` off by {off}", SIDES[at % 2])
                    }
                    _ => format!("the tip off by {}", estimated(1e3 * value, 1e3 * watch.reach, "mm")),
                };
                let (kind, cause, cure) = match watch.fixed {
                    true => ("step-inexact", "the steps are long", "shorten `step`, or leave it out"),
                    false => ("tolerance-too-loose", "the tolerance is loose", "tighten `rtol`"),
                };
                (
                    kind,
                    format!("the errors of all steps, carried along the motion, put {off}: the motion amplifies them, or {cause}"),
                    format!("{cure}; `verify` states how far the run is off"),
                )
            }
            Finding::Starved(c) => {
                let worst = watch.starved.iter().find(|short| short.cylinder == c).expect("noted with its finding");
                let Shortfall { asked, delivered, limit, shifted, .. } = *worst;
                let (reason, cure) = limited(limit, machine);
                let inexact = if shifted > TELLING {
                    format!("; in the model the shares of sections that share the flow are off by up to {:.0} % there", 100.0 * shifted)
                } else {
                    String::new()
                };
                (
                    "pump-saturated",
                    format!(
                        "the section of cylinder `{}` gets {:.2} of the {:.2} l/min that its spool asks for: {reason}{inexact}",
                        machine.cylinders[c].name,
                        60e3 * delivered,
                        60e3 * asked
                    ),
                    format!("{cure}; or move fewer functions at once. `tip` slows down for the pump that it knows, other controllers do not"),
                )
            }
            Finding::AtVacuum(place) => {
                let cylinder = &machine.cylinders[place / 2];
                let side = SIDES[place % 2];
                let cure = match cylinder.ports.valves[place % 2].anti_cavitation {
                    None => format!("state an anti-cavitation valve, `[anti-cavitation.<name>]` with `cylinder = \"{}\"` and this side, if the machine has one; lower more gently", cylinder.name),
                    Some(_) => "lower more gently, or state a larger anti-cavitation valve".to_string(),
                };
                (
                    "cavitation",
                    format!("the {side} of cylinder `{}` is at vacuum for {value:.2} s: its oil does not follow the piston", cylinder.name),
                    cure,
                )
            }
            Finding::OilLost(place) => (
                "oil-lost",
                format!(
                    "{:.3} l of oil left through the hose to the {} of cylinder `{}`",
                    1e3 * value,
                    SIDES[place % 2],
                    machine.cylinders[place / 2].name
                ),
                "a counterbalance, pilot-operated check or hose-burst valve at the cylinder keeps its oil in; nothing keeps what the \
                 spool valve feeds into the hose"
                    .to_string(),
            ),
        };
        Warning { time: self.time, kind, key: None, text, cure }
    }
}

/// Values of a file outside their usual ranges.
pub fn implausible(unusual: &[Unusual]) -> Vec<Warning> {
    unusual
        .iter()
        .map(|u| Warning {
            time: 0.0,
            kind: "implausible-value",
            key: Some(u.key.clone()),
            text: format!("{}: {} is {}", u.place, u.key, u.text),
            cure: u.cure.clone(),
        })
        .collect()
}

/// Warning on signals that a controller reads from `time` (s) on with data-sheet sensors although the file has no
/// sensors for them. `tip`: it is tip control, which can work without pressures.
pub fn without_sensors(machine: &Machine, time: f64, reads_pressures: bool, tip: bool) -> Option<Warning> {
    let mut signals = unmeasured(machine);
    signals.retain(|signal| reads_pressures || !signal.starts_with("cylinder."));
    let estimable = tip && signals.iter().any(|signal| signal.starts_with("cylinder."));
    let (first, others) = signals.split_first()?;
    let more = if others.is_empty() { String::new() } else { format!(" and {} other signals", others.len()) };
    let measured = format!("no sensor of {} measures `{first}`{more}", machine.name);
    Some(Warning {
        time,
        kind: "signal-without-sensor",
        key: None,
        text: format!("{measured}: the controller reads the true value there, although it uses data-sheet sensors"),
        cure: format!(
            "state `[sensor.<name>]` with `measures = \"{first}\"` in the machine file, or use ideal sensors{}",
            if estimable { "; without pressure sensors, state `control.tip.pressures = \"estimated\"`" } else { "" }
        ),
    })
}

/// Warnings on an equilibrium `x` that was asked for in the pose `q` with `payload` (kg): joints that rest on their end stops instead, and
/// loads that the circuit cannot hold.
pub fn doubts_at_rest(model: &dyn Model, q: &[f64], x: &[f64], payload: f64) -> Vec<Warning> {
    let machine = model.machine();
    let moved = machine.joints.iter().enumerate().filter(|(i, _)| x[model.layout().q(*i)] != q[*i]);
    moved
        .map(|(i, joint)| Warning {
            time: 0.0,
            kind: "start-rests-on-stop",
            key: None,
            text: format!(
                "joint {} rests on the end stop of cylinder `{}` at {}, not at {}: the supply pressure is too low to press it so far",
                joint.name,
                machine.cylinders[i].name,
                in_words(joint, x[model.layout().q(i)]),
                in_words(joint, q[i])
            ),
            cure: "start outside the zone of the end stop, or give the pressures at the start".to_string(),
        })
        .chain(model.unheld(x, payload).iter().map(|unheld| not_held(machine, unheld)))
        .collect()
}

/// Warning on a chamber that cannot hold its load.
fn not_held(machine: &Machine, unheld: &Unheld) -> Warning {
    let (cylinder, side) = (&machine.cylinders[unheld.cylinder].name, SIDES[unheld.side]);
    let (what, cure) = match unheld.held_by {
        HeldBy::Supply if machine.supply.measured => (
            "the measured supply has",
            "carry less, start in another pose, or check unit and column of the supply's log",
        ),
        HeldBy::Supply => ("the supply has", "carry less, start in another pose, or raise `supply.pressure`"),
        HeldBy::Relief => (
            "the relief valve at its port keeps",
            "carry less, start in another pose, or raise the setting of the valve",
        ),
    };
    let (needed, there_is) = (unheld.needed / 1e5, unheld.there_is / 1e5);
    Warning {
        time: 0.0,
        kind: "start-not-held",
        key: None,
        text: format!("the load at the start needs {needed:.0} bar in the {side} of cylinder `{cylinder}`; {what} {there_is:.0} bar"),
        cure: cure.to_string(),
    }
}

/// An estimated error in words. The estimate is linear in the errors of the steps: as large as `most` it says no size.
fn estimated(error: f64, most: f64, unit: &str) -> String {
    if error < most {
        format!("an estimated {error:.1} {unit}")
    } else {
        format!("more than {most:.0} {unit}")
    }
}

/// Why a section of a machine lacks oil, and the cure.
fn limited(limit: Limit, machine: &Machine) -> (&'static str, String) {
    let mains = machine.supply.mains.as_ref();
    let pump = mains.and_then(|mains| mains.pumps().next()).map_or("", |pump| pump.name.as_ref());
    match limit {
        Limit::Priority => ("the section with priority is served first", "use a larger pump".to_string()),
        Limit::Relief => ("the relief valve of the mains opens first", "raise `mains.relief-pressure`".to_string()),
        Limit::Torque => ("the pump is at its torque limit", format!("raise `pump.{pump}.torque-limit`")),
        Limit::Engine => {
            ("the engine has slowed down under its load", format!("lower `pump.{pump}.droop`, or set a `torque-limit`"))
        }
        Limit::Displacement => ("the pump is at full displacement", format!("use a larger `pump.{pump}.displacement`")),
        Limit::ControlRange => (
            "the pressure of the mains falls below what the section needs before the pump is at full displacement",
            format!("lower `pump.{pump}.control-range`, or raise `ls-margin`"),
        ),
        Limit::Pressure => (
            "the load takes so much of the supply pressure that the pump cuts off",
            "carry less, or raise `supply.pressure`".into(),
        ),
    }
}

/// The rating of each cylinder of a machine, Pa.
pub(crate) fn pressure_ratings(machine: &Machine) -> Vec<f64> {
    machine.cylinders.iter().map(|c| c.pressure_rating.unwrap_or(RATING * machine.supply.rated)).collect()
}
