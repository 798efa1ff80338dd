//! Open-loop runs: spool commands in, a record and an outcome out.

use crate::model::{Model, MAX_JOINTS};
use crate::outcome::{Outcome, OutcomeKind};
use crate::payload::{self, Loads, PayloadChange, PayloadEvent};
use crate::recorder::Recorder;
use crate::warnings::{Warning, Watch};
use hydrocrane_ode::System;
use hydrocrane_ode::{method, Effort, Linearisation, StepFailure, Stepper, Tolerances, CRAWL_ATTEMPTS, METHODS};
use hydrocrane_plant::ledger::{ground_terms, LEDGER_PER_CYLINDER};

/// Spool commands against time: one row per time, one column per cylinder, m.
#[derive(Debug, Clone, Default)]
pub struct Commands {
    /// Ascending, s.
    pub times: Vec<f64>,
    /// Row-major, `times.len() x cylinders`.
    pub values: Vec<f64>,
    /// Straight between the rows instead of held.
    pub linear: bool,
}

#[derive(Debug, Clone)]
pub struct RunOptions {
    /// Name of a method in [`METHODS`].
    pub method: String,
    pub tolerances: Tolerances,
    /// kg at the tip
    pub payload: f64,
    /// Loads taken up and let go on the way, in order of time.
    pub payload_changes: Vec<PayloadChange>,
    /// Integrate the energy ledger along.
    pub ledger: bool,
    /// Accepted steps after which a run is given up.
    pub max_steps: u64,
}

impl RunOptions {
    /// Number of energies integrated along.
    pub(crate) fn quadratures(&self, model: &dyn Model) -> usize {
        if self.ledger {
            LEDGER_PER_CYLINDER * model.layout().joints() + ground_terms(model.machine()).len()
        } else {
            0
        }
    }
}

/// What a run computed, up to wherever it got.
#[derive(Debug, Clone)]
pub struct Run {
    pub times: Vec<f64>,
    /// Row-major, one row per time.
    pub states: Vec<f64>,
    /// Energies (J) since the start, one row per time: the cylinders' terms, that of the ground where there is one,
    /// those of the payload; empty without ledger.
    pub ledger: Vec<f64>,
    /// kg at the tip, one per time. A row at the instant of a change has the state before it.
    pub payloads: Vec<f64>,
    /// Spool commands after delay and limits, m, one row per time.
    pub commands: Vec<f64>,
    pub payload_events: Vec<PayloadEvent>,
    /// What makes the run doubtful, in order of time.
    pub warnings: Vec<Warning>,
    pub outcome: Outcome,
    pub accepted: u64,
    pub rejected: u64,
    pub effort: Effort,
}

/// The model under commands, as the integrator sees it.
pub(crate) struct Driven<'a> {
    pub model: &'a dyn Model,
    pub payload: f64,
    pub loads: Loads,
    /// Commands at `since` and their rates of change, constant over the interval at hand.
    pub base: [f64; MAX_JOINTS],
    pub slope: [f64; MAX_JOINTS],
    pub since: f64,
}

impl<'a> Driven<'a> {
    /// The model with its spools centred.
    pub fn new(model: &'a dyn Model, options: &RunOptions, since: f64) -> Self {
        Driven {
            model,
            payload: options.payload,
            loads: Loads::new(&options.payload_changes),
            base: [0.0; MAX_JOINTS],
            slope: [0.0; MAX_JOINTS],
            since,
        }
    }

    pub fn command(&self, t: f64) -> [f64; MAX_JOINTS] {
        std::array::from_fn(|c| self.base[c] + self.slope[c] * (t - self.since))
    }

    /// Takes up and lets go the loads that are due where `stepper` is.
    pub fn change_payload(&mut self, stepper: &mut Stepper) {
        if self.loads.come_and_go(self.model, stepper.t, &mut stepper.x, &mut self.payload) {
            stepper.restart();
        }
    }
}

impl System for Driven<'_> {
    fn dimension(&self) -> usize {
        self.model.layout().len()
    }
    fn derivative(&self, t: f64, x: &[f64], dx: &mut [f64]) {
        self.model.derivative(x, &self.command(t), self.payload, dx);
    }
    fn quadrature_rates(&self, x: &[f64], dw: &mut [f64]) {
        self.model.powers(x, self.payload, dw);
    }
    fn linearise(&self, t: f64, x: &[f64], at: &mut Linearisation) {
        let (rate, jacobian) = at.block_arrow(self.model.layout().axes(), 0);
        self.model.linearise(x, &self.command(t), self.payload, rate, &mut jacobian[0]);
    }
    fn update_input(&self, t: f64, x: &[f64], at: &mut Linearisation) {
        let (rate, jacobian) = at.block_arrow(self.model.layout().axes(), 0);
        self.model.update_input(x, &self.command(t), rate, &mut jacobian[0]);
    }
    fn time_derivative(&self, _t: f64, _x: &[f64], dfdt: &mut [f64]) -> bool {
        let driven = self.slope != [0.0; MAX_JOINTS];
        if driven {
            self.model.command_derivative(&self.slope, dfdt);
        }
        driven
    }
    fn admissible(&self, x: &[f64]) -> bool {
        self.model.admissible(x)
    }
    fn scales(&self) -> &[f64] {
        &self.model.layout().scales
    }
    fn error_size(&self, reached: &[f64], error: &[f64]) -> f64 {
        self.model.error_size(reached, error)
    }
}

/// Commands as the spools receive them: each delayed by its valve and kept within its stroke.
pub(crate) struct Schedule {
    /// Times at which any command or its slope changes.
    pub breaks: Vec<f64>,
    columns: Vec<Column>,
}

struct Column {
    times: Vec<f64>,
    values: Vec<f64>,
    linear: bool,
    delay: f64,
    limit: f64,
}

impl Column {
    /// Value and slope just after `t`.
    fn at(&self, t: f64) -> (f64, f64) {
        let t = t - self.delay;
        let next = self.times.partition_point(|&time| time <= t + 1e-12);
        if next == 0 {
            return (0.0, 0.0);
        }
        let here = self.values[next - 1];
        let (value, slope) = match (self.linear, self.times.get(next)) {
            (true, Some(&end)) => {
                let slope = (self.values[next] - here) / (end - self.times[next - 1]);
                (here + slope * (t - self.times[next - 1]), slope)
            }
            _ => (here, 0.0),
        };
        let limited = value.clamp(-self.limit, self.limit);
        (limited, if limited == value { slope } else { 0.0 })
    }
}

impl Schedule {
    pub fn new(commands: &Commands, model: &dyn Model) -> Self {
        let n = model.layout().joints();
        let machine = model.machine();
        let columns: Vec<Column> = (0..n)
            .map(|c| Column {
                times: commands.times.clone(),
                values: commands.values.iter().skip(c).step_by(n).copied().collect(),
                linear: commands.linear,
                delay: machine.cylinders[c].valve.delay,
                limit: machine.cylinders[c].valve.stroke,
            })
            .collect();
        let mut breaks: Vec<f64> = columns.iter().flat_map(Column::breaks).collect();
        breaks.sort_by(f64::total_cmp);
        breaks.dedup_by(|a, b| (*a - *b).abs() < 1e-12);
        Schedule { breaks, columns }
    }

    pub fn apply(&self, t: f64, driven: &mut Driven) {
        driven.since = t;
        for (c, column) in self.columns.iter().enumerate() {
            (driven.base[c], driven.slope[c]) = column.at(t);
        }
    }
}

impl Column {
    /// Its times as the spool sees them, and where a ramp meets the end of the spool's stroke.
    fn breaks(&self) -> Vec<f64> {
        let mut breaks: Vec<f64> = self.times.iter().map(|t| t + self.delay).collect();
        if self.linear {
            for (t, v) in self.times.windows(2).zip(self.values.windows(2)) {
                for limit in [-self.limit, self.limit] {
                    if (v[0] - limit) * (v[1] - limit) < 0.0 {
                        breaks.push(t[0] + (limit - v[0]) / (v[1] - v[0]) * (t[1] - t[0]) + self.delay);
                    }
                }
            }
        }
        breaks
    }
}

/// Runs `model` from `x0` to `end`, recording at `record` (ascending times). `keep_going` is asked now and then.
pub fn simulate(
    model: &dyn Model,
    x0: &[f64],
    end: f64,
    commands: &Commands,
    record: &[f64],
    options: &RunOptions,
    keep_going: &mut dyn FnMut(f64) -> bool,
) -> Run {
    let mut recorder = Recorder::new(model, record, options);
    if let Some(message) = start_fault(model, x0, options) {
        return recorder.finish(Outcome { kind: OutcomeKind::BadState, time: 0.0, message }, None);
    }
    let schedule = Schedule::new(commands, model);
    let mut driven = Driven::new(model, options, 0.0);
    let Some(mut stepper) = stepper(x0, model, options) else {
        let message = format!("no method `{}`", options.method);
        return recorder.finish(Outcome { kind: OutcomeKind::BadState, time: 0.0, message }, None);
    };
    let mut watch = Watch::new(&stepper, &driven);
    let outcome = drive(&mut stepper, &mut watch, &mut driven, &schedule, end, options, &mut recorder, keep_going);
    recorder.finish(outcome, Some((&stepper, &driven, &mut watch)))
}

/// A stepper at time zero; `None` where there is no such method, which [`start_fault`] finds first.
pub(crate) fn stepper(x0: &[f64], model: &dyn Model, options: &RunOptions) -> Option<Stepper> {
    let method = method(&options.method, x0.len())?;
    let stepper = Stepper::new(method, options.tolerances, 0.0, x0, options.quadratures(model));
    Some(stepper.with_jumps(!model.machine().errata.friction_map))
}

/// One step, at most to `limit`, and a look at where it led.
pub(crate) fn step(stepper: &mut Stepper, watch: &mut Watch, driven: &Driven, limit: f64) -> Result<(), Outcome> {
    step_of(driven, stepper, watch, driven, limit)
}

/// One step of `system`, whose states begin with those of the crane that is `driven`.
pub(crate) fn step_of(
    system: &dyn System,
    stepper: &mut Stepper,
    watch: &mut Watch,
    driven: &Driven,
    limit: f64,
) -> Result<(), Outcome> {
    let stepped = stepper.step(system, limit).map_err(|failure| failed(driven.model, stepper, failure));
    watch.look(stepper, driven);
    stepped
}

/// Steps from break to break until the end or until something stops it.
#[allow(clippy::too_many_arguments)]
fn drive(
    stepper: &mut Stepper,
    watch: &mut Watch,
    driven: &mut Driven,
    schedule: &Schedule,
    end: f64,
    options: &RunOptions,
    recorder: &mut Recorder,
    keep_going: &mut dyn FnMut(f64) -> bool,
) -> Outcome {
    schedule.apply(0.0, driven);
    recorder.take(stepper, driven);
    while stepper.t < end {
        driven.change_payload(stepper);
        let next = schedule.breaks.iter().copied().find(|&b| b > stepper.t + 1e-12);
        let limit = next.into_iter().chain(driven.loads.next_time()).fold(end, f64::min);
        if let Err(outcome) = step(stepper, watch, driven, limit) {
            return outcome;
        }
        recorder.take(stepper, driven);
        if next.is_some_and(|at| stepper.t >= at) {
            schedule.apply(stepper.t, driven);
            stepper.restart();
        }
        if let Some(outcome) = given_up(stepper, options, keep_going) {
            return outcome;
        }
    }
    Outcome { kind: OutcomeKind::Completed, time: stepper.t, message: "reached the end".to_string() }
}

/// Why a run ends early though every step so far was good.
pub(crate) fn given_up(
    stepper: &mut Stepper,
    options: &RunOptions,
    keep_going: &mut dyn FnMut(f64) -> bool,
) -> Option<Outcome> {
    if stepper.accepted >= options.max_steps {
        let message = format!("gave up after {} steps; loosen the tolerance or shorten the run", stepper.accepted);
        return Some(Outcome { kind: OutcomeKind::SolverFailed, time: stepper.t, message });
    }
    if let Some(advance) = stepper.crawls() {
        let message = format!(
            "{CRAWL_ATTEMPTS} steps went on by only {advance:.1e} s; a law jumps here (friction or orifice law as printed?): \
             take `ros3l`, whose steps are even, smooth the friction by `smoothing-velocity`, or loosen the tolerance"
        );
        return Some(Outcome { kind: OutcomeKind::SolverFailed, time: stepper.t, message });
    }
    if stepper.accepted.is_multiple_of(256) && !keep_going(stepper.t) {
        let message = "stopped from outside".to_string();
        return Some(Outcome { kind: OutcomeKind::Interrupted, time: stepper.t, message });
    }
    None
}

/// Why a state cannot be started from, if it cannot.
pub(crate) fn start_fault(model: &dyn Model, x0: &[f64], options: &RunOptions) -> Option<String> {
    if !METHODS.contains(&options.method.as_str()) {
        return Some(format!("no method `{}`; there are {}", options.method, METHODS.join(", ")));
    }
    payload::fault(&options.payload_changes).or_else(|| state_fault(model, x0))
}

/// Why no crane can be in this state, if none can.
pub(crate) fn state_fault(model: &dyn Model, x0: &[f64]) -> Option<String> {
    let layout = model.layout();
    if x0.len() != layout.len() {
        return Some(format!("the initial state has {} numbers, the machine {} states", x0.len(), layout.len()));
    }
    if let Some(i) = x0.iter().position(|v| !v.is_finite()) {
        return Some(format!("initial state `{}` is {}; it must be a finite number", layout.names[i], x0[i]));
    }
    (!model.admissible(x0)).then(|| format!("the initial state is impossible: {}", outside(model, x0)))
}

/// Names the piston that stands nearest to an end of its stroke, or beyond it, or the linkage that is torn.
fn outside(model: &dyn Model, x: &[f64]) -> String {
    let Some((c, position)) = outermost(model, x) else { return "a linkage does not close".to_string() };
    let cylinder = &model.machine().cylinders[c];
    let half = cylinder.stroke / 2.0;
    format!("the piston of `{}` is at {position:.4} m, its ends are at -{half:.4} and {half:.4} m", cylinder.name)
}

/// The cylinder whose piston is relatively farthest out, with its position; `None` where a linkage is torn.
fn outermost(model: &dyn Model, x: &[f64]) -> Option<(usize, f64)> {
    let n = model.layout().joints();
    let (mut position, mut gain) = (vec![0.0; n], vec![0.0; n]);
    model.strokes(&x[..n], &mut position, &mut gain);
    let fill = |c: usize| position[c].abs() / (model.machine().cylinders[c].stroke / 2.0);
    let c = (0..n).max_by(|&a, &b| fill(a).total_cmp(&fill(b)))?;
    position[c].is_finite().then(|| (c, position[c]))
}

fn failed(model: &dyn Model, stepper: &Stepper, failure: StepFailure) -> Outcome {
    let beyond = outermost(model, &stepper.x)
        .is_none_or(|(c, position)| position.abs() >= model.machine().cylinders[c].stroke / 2.0);
    // With a piston in its dead volume any step fails, whatever the solver complains of.
    let (kind, message) = if failure == StepFailure::NotAdmissible || beyond {
        (OutcomeKind::StrokeLimit, format!("a piston left its cylinder: {}", outside(model, &stepper.x)))
    } else if failure == StepFailure::NotFinite {
        let least = 1e6 * stepper.least_part();
        let message = format!(
            "even steps cut to {least:.0} us do not follow the motion either; shorten the step, or take `rodas5p`, \
             which chooses its steps"
        );
        (OutcomeKind::SolverFailed, message)
    } else {
        let message = "the step size fell below rounding; a law jumps here (as-printed friction or orifice law?) \
                       or the tolerance is too tight";
        (OutcomeKind::SolverFailed, message.to_string())
    };
    Outcome { kind, time: stepper.t, message }
}
