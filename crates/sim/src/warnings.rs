//! Checks of a run, with warnings that state cause and cure.          reference: docs/reference/warnings.md

use crate::driven::Driven;
use crate::ledger::ledger_terms;
use crate::model::Model;
use crate::oil_lost::OilLost;
use crate::sampled::Event;
use crate::sensing::unmeasured;
use crate::warning::Warning;
use hydrocrane_machine::model::{Cavitation, Cylinder, Unusual};
use hydrocrane_machine::Machine;
use hydrocrane_ode::Stepper;
use hydrocrane_plant::limits::in_words;
use hydrocrane_plant::limits::JointLimits;
use hydrocrane_plant::outputs::energies;

/// Default rated pressure of a chamber, as a multiple of the supply pressure that the file states.
const RATING: f64 = 1.5;
/// Pressure below vacuum that is rounding, Pa.
const VACUUM_ROUNDING: f64 = 1e3;
/// Time between two checks of the energy ledger, s.
const AUDIT_INTERVAL: f64 = 0.5;
/// Allowed residual of the ledger, as a share of the energy that flowed.
const LEDGER_SHARE: f64 = 0.01;
/// Least energy for this check, as a share of the supply energy of one stroke of all pistons.
const LEDGER_FLOOR: f64 = 1e-4;
/// Share of the supply pressure, or of the load-sensing pressure at full displacement, below which the mains lack oil.
const MAINS_SHARE: f64 = 0.8;
/// Share of the displacement above which a load-sensing pump counts as saturated. Below it the pump only lags.
const FULL_DISPLACEMENT: f64 = 0.98;

/// Time over which the estimated errors of fixed steps are averaged, s: those of a start or a stop are over before.
const ESTIMATE_TIME: f64 = 0.5;
/// Share of a state and its scale that this mean may have: 100 times the tolerance of a run that states none.
const ESTIMATE_SHARE: f64 = 0.01;

/// Deficit of the mains pressure against the set pressure of the pump, Pa; `None` while the pump delivers the demand.
fn fall_of_saturated_mains(model: &dyn Model, x: &[f64]) -> Option<f64> {
    let (layout, supply) = (model.layout(), &model.machine().supply);
    let (p, mains) = (x[layout.mains()?], supply.mains.as_ref()?);
    let (set, least) = match (layout.load().map(|load| x[load]), &mains.load_sensing) {
        (Some(load), Some(sensing)) if load + sensing.margin < supply.pressure => {
            let ranges = mains.pumps().filter_map(|pump| pump.control.as_ref());
            let range = ranges.map(|control| control.range).fold(0.0, f64::max);
            (load + sensing.margin, load + MAINS_SHARE * (sensing.margin - range))
        }
        _ => (supply.pressure, MAINS_SHARE * supply.pressure),
    };
    let full = layout.load().is_none() || layout.swivels().all(|e| x[e] > FULL_DISPLACEMENT);
    (full && p < least).then_some(set - p)
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
    PumpSaturated,
    /// Of a cylinder and its side, in pairs.
    OilLost(usize),
}

/// A finding with its begin and its extreme value: a pressure (Pa), a joint coordinate, a share of the energy or of a state, a step
/// (s), a fall of pressure (Pa), or a volume (m^3).
#[derive(Debug, Clone, Copy)]
struct Found {
    what: Finding,
    time: f64,
    farthest: f64,
}

/// The energy ledger against the energies stored.
struct Audit {
    /// Stored energy at the start, with the changes by phases with another machine, J.
    start: f64,
    next: f64,
    floor: f64,
    outputs: Vec<f64>,
}

/// Checks every step of a run.
pub(crate) struct Watch {
    ratings: Vec<f64>,
    vacuum: f64,
    limits: Vec<[f64; 2]>,
    audit: Option<Audit>,
    lost: Option<OilLost>,
    /// Mean estimated errors of fixed steps, by state of the supply.
    estimates: Vec<f64>,
    found: Vec<Found>,
    told: usize,
}

impl Watch {
    /// From the state of `stepper` on.
    pub fn new(stepper: &Stepper, driven: &Driven) -> Self {
        let machine = driven.model.machine();
        let mut watch = Watch {
            ratings: vec![],
            vacuum: 0.0,
            limits: vec![],
            audit: None,
            lost: OilLost::new(stepper, driven),
            estimates: vec![],
            found: vec![],
            told: 0,
        };
        watch.take_bounds(driven.model);
        if !stepper.integrals().is_empty() {
            let mut outputs = vec![0.0; driven.model.output_info().len()];
            let start = stored(driven.model, driven.payload, stepper, &mut outputs);
            let per_stroke = |c: &Cylinder| std::f64::consts::FRAC_PI_4 * c.bore.powi(2) * c.stroke;
            let volume: f64 = machine.cylinders.iter().map(per_stroke).sum();
            let floor = LEDGER_FLOOR * volume * machine.supply.pressure;
            watch.audit = Some(Audit { start, next: AUDIT_INTERVAL, floor, outputs });
        }
        watch.look(stepper, driven);
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
    }

    /// The values of the machine have changed from `before` to those of `driven`.
    pub fn follow(&mut self, before: &dyn Model, driven: &Driven, stepper: &Stepper) {
        self.take_bounds(driven.model);
        if let Some(lost) = self.lost.as_mut().filter(|_| cfg!(feature = "chains")) {
            lost.begin(stepper, driven);
        }
        if let Some(audit) = &mut self.audit {
            let mut of = |model| stored(model, driven.payload, stepper, &mut audit.outputs);
            audit.start += of(driven.model) - of(before);
        }
    }

    /// Checks the present state and, from time to time, the ledger.
    pub fn look(&mut self, stepper: &Stepper, driven: &Driven) {
        let (layout, x, t) = (driven.model.layout(), &stepper.x, stepper.t);
        for c in 0..layout.joints() {
            let (p1, p2) = (x[layout.p1(c)], x[layout.p2(c)]);
            let (least, most) = (p1.min(p2), p1.max(p2));
            if most > self.ratings[c] {
                self.note(Finding::AboveRating(c), t, most);
            }
            if least < self.vacuum - VACUUM_ROUNDING {
                self.note(Finding::BelowVacuum(c), t, least);
            }
            let (q, [lower, upper]) = (x[layout.q(c)], self.limits[c]);
            if q < lower || q > upper {
                self.beyond(driven.model, c, x, t);
            }
        }
        if let Some(fall) = fall_of_saturated_mains(driven.model, x) {
            self.note(Finding::PumpSaturated, t, fall);
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
        if self.audit.as_ref().is_some_and(|audit| t >= audit.next) {
            self.audit(stepper, driven);
        }
    }

    /// Fixed steps have no tolerance to keep: what their estimated errors are in the mean of some time. Those of the supply count, whose
    /// little oil is faster than that of any cylinder; with static friction, which steps take by its secant, the others say little.
    fn estimate(&mut self, error: &[f64], stepper: &Stepper, model: &dyn Model) {
        let layout = model.layout();
        let weight = ((stepper.t - stepper.previous_time()) / ESTIMATE_TIME).min(1.0);
        let supply = layout.blocks().shared;
        self.estimates.resize(supply.count, 0.0);
        let mut worst = (0.0, 0);
        for (mean, i) in self.estimates.iter_mut().zip(supply.first..) {
            *mean += weight * (error[i].abs() - *mean);
            let share = *mean / (layout.scales[i] + stepper.x[i].abs());
            if share > worst.0 {
                worst = (share, i);
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
        let Some(audit) = &mut self.audit else { return };
        audit.next = stepper.t + AUDIT_INTERVAL;
        let gained = stored(driven.model, driven.payload, stepper, &mut audit.outputs) - audit.start;
        let machine = driven.model.machine();
        let energies = stepper.integrals().iter().chain(&driven.loads.account);
        let (mut balance, mut flowed) = (0.0, 0.0);
        for (energy, (_, (_, _, sign))) in energies.zip(ledger_terms(machine)) {
            balance += sign * energy;
            flowed += (sign * energy).abs();
        }
        // Energy that flows in flows out or is stored, so half of the sum has flowed.
        let open = (gained - balance).abs() / (0.5 * (flowed + gained.abs())).max(audit.floor / LEDGER_SHARE);
        if open > LEDGER_SHARE || open.is_nan() {
            self.note(Finding::LedgerOpen, stepper.t, open);
        }
    }

    fn note(&mut self, what: Finding, time: f64, value: f64) {
        let Some(found) = self.found.iter_mut().find(|found| found.what == what) else {
            self.found.push(Found { what, time, farthest: value });
            return;
        };
        if value.abs() > found.farthest.abs() {
            found.farthest = value;
        }
    }

    /// All findings until the end of the run, in order of time.
    pub fn close(&mut self, stepper: &Stepper, driven: &Driven) -> Vec<Warning> {
        self.audit(stepper, driven);
        let mut all: Vec<Warning> = self.found.iter().map(|found| found.warning(driven.model, &self.ratings)).collect();
        all.sort_by(|a, b| a.time.total_cmp(&b.time));
        all
    }

    /// Findings since the last call.
    pub fn news(&mut self, model: &dyn Model) -> Vec<Warning> {
        let news = self.found[self.told..].iter().map(|found| found.warning(model, &self.ratings)).collect();
        self.told = self.found.len();
        news
    }
}

/// Gauge pressure of vacuum for oil without a vacuum limit, Pa.
const STANDARD_VACUUM: f64 = -1e5;

/// Energy stored in crane and oil, J.
fn stored(model: &dyn Model, payload: f64, stepper: &Stepper, outputs: &mut [f64]) -> f64 {
    model.outputs(&stepper.x, payload, outputs);
    outputs[energies(model.machine())].iter().sum()
}

impl Found {
    fn warning(&self, model: &dyn Model, ratings: &[f64]) -> Warning {
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
                    bar(ratings[c])
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
                    "fixed steps are too long for the supply: the estimated error of `{}`, averaged over {ESTIMATE_TIME} s, reaches {:.1} %",
                    model.layout().names[state],
                    100.0 * value
                ),
                "shorten `step`, or leave it out: steps by tolerance keep theirs".to_string(),
            ),
            Finding::PumpSaturated => (
                "pump-saturated",
                format!(
                    "the pump delivers less than the valves demand: the mains pressure falls {:.0} bar below the set pressure",
                    bar(value)
                ),
                "move fewer functions at once, or more gently, or use a larger `pump.<name>.displacement`; `tip` \
                 slows down for the pump that it knows, other controllers do not"
                    .to_string(),
            ),
            Finding::OilLost(place) => (
                "oil-lost",
                format!(
                    "{:.3} l of oil left through the hose to the {} of cylinder `{}`",
                    1e3 * value,
                    ["piston side", "rod side"][place % 2],
                    machine.cylinders[place / 2].name
                ),
                "a counterbalance, pilot-operated check or hose-burst valve at the cylinder keeps its oil in; nothing keeps what the \
                 spool valve feeds into the hose"
                    .to_string(),
            ),
        };
        Warning { time: self.time, kind, text, cure }
    }
}

/// Values of a file outside their usual ranges.
pub fn implausible(unusual: &[Unusual]) -> Vec<Warning> {
    unusual
        .iter()
        .map(|u| Warning {
            time: 0.0,
            kind: "implausible-value",
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
        text: format!("{measured}: the controller reads the true value there, although it uses data-sheet sensors"),
        cure: format!(
            "state `[sensor.<name>]` with `measures = \"{first}\"` in the machine file, or use ideal sensors{}",
            if estimable { "; without pressure sensors, state `control.tip.pressures = \"estimated\"`" } else { "" }
        ),
    })
}

/// Warning that a controller has stopped the crane because of a sensor.
pub(crate) fn sensor_stop(Event { time, text, .. }: Event) -> Warning {
    Warning {
        time,
        kind: "sensor-stop",
        text,
        cure: "if the sensor is in order, state its errors in its `[sensor]` table, and those of valves and supply in \
               `[control.plausibility]`"
            .to_string(),
    }
}

/// Warning if an equilibrium `x` differs from the pose `q` because joints rest on their end stops.
pub fn moved_starts(model: &dyn Model, q: &[f64], x: &[f64]) -> Vec<Warning> {
    let machine = model.machine();
    let moved = machine.joints.iter().enumerate().filter(|(i, _)| x[model.layout().q(*i)] != q[*i]);
    moved
        .map(|(i, joint)| Warning {
            time: 0.0,
            kind: "start-rests-on-stop",
            text: format!(
                "joint {} rests on the end stop of cylinder `{}` at {}, not at {}: the supply pressure is too low to press it so far",
                joint.name,
                machine.cylinders[i].name,
                in_words(joint, x[model.layout().q(i)]),
                in_words(joint, q[i])
            ),
            cure: "start outside the zone of the end stop, or give the pressures at the start".to_string(),
        })
        .collect()
}

/// The rating of each cylinder of a machine, Pa.
pub(crate) fn pressure_ratings(machine: &Machine) -> Vec<f64> {
    machine.cylinders.iter().map(|c| c.pressure_rating.unwrap_or(RATING * machine.supply.rated)).collect()
}
