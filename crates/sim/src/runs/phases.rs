//! Runs in phases: each has another controller, other sticks, or other values of the machine.
//!
//! A phase continues with the state, the load, the energies, the sticks and the sent commands of the previous one; its
//! controller and its sensors start as at the start of a run. theory: docs/theory/simulation.md

use crate::event_loop::driven::{stepper, Driven};
use crate::event_loop::recorder::Recorder;
use crate::event_loop::EventLoop;
use crate::inputs::faults::{start_fault, state_fault};
use crate::inputs::options::{Commands, Run, RunOptions};
use crate::model::model_change::{ModelChange, ModelChanges};
use crate::model::Model;
use crate::outcome::{Outcome, OutcomeKind};
use crate::runs::sampled::{plan_fault, Event, Sampled, SampledPlan, Samples, Sampling};
use crate::runs::schedule::Schedule;
use crate::warning::Warning;
use hydrocrane_control::interface::controller::{Alarm, Controller};

/// The source of the spool commands.
pub enum Driver<'a> {
    Commands(&'a Commands),
    /// A controller with its sensors, sticks and delay.
    Controller(&'a mut dyn Controller, &'a SampledPlan),
}

impl Driver<'_> {
    /// The reason if it cannot be used.
    fn fault(&self) -> Option<String> {
        match self {
            Driver::Commands(_) => None,
            Driver::Controller(controller, plan) => plan_fault(plan, controller.period()),
        }
    }
}

/// `model` with `driver`, from a time on.
pub struct Phase<'a> {
    /// s; of the first phase zero.
    pub from: f64,
    pub model: &'a dyn Model,
    /// Machines that take its place during the phase, in order of time.
    pub changes: Vec<ModelChange<'a>>,
    pub driver: Driver<'a>,
}

/// A run with the samples of each phase that began.
#[derive(Debug, Clone)]
pub struct PhasedRun {
    pub run: Run,
    pub samples: Vec<Samples>,
    pub events: Vec<Event>,
}

/// Runs `first` from `x0`, then each of `later` from its time on, to `end`, recording states at `record` (ascending
/// times). A row at the begin of a phase has the values before it.
pub fn simulate_phases<'a>(
    x0: &[f64],
    end: f64,
    first: Phase<'a>,
    later: Vec<Phase<'a>>,
    record: &[f64],
    options: &RunOptions,
    keep_going: &mut dyn FnMut(f64) -> bool,
) -> PhasedRun {
    let mut recorder = Recorder::new(first.model, record, options);
    if let Some(message) = start_fault(first.model, x0, options).or_else(|| fault(&first, &later)) {
        return bad_start(recorder, message);
    }
    let mut driven = Driven::new(first.model, options, 0.0);
    driven.changes = ModelChanges::new(first.changes);
    let Some(stepper) = stepper(x0, first.model, options) else {
        return bad_start(recorder, format!("no method `{}`", options.method));
    };
    let mut going = EventLoop::new(stepper, &driven);
    let mut sampled = None;
    let (mut samples, mut events) = (Vec::new(), Vec::new());
    let mut coming = later.into_iter().filter(|phase| phase.from < end).peekable();
    let mut driver = first.driver;
    let outcome = loop {
        // What a controller does about an error is not in the equations that carry it on.
        going.stepper.follow_error(matches!(driver, Driver::Commands(_)));
        let until = coming.peek().map_or(end, |next| next.from);
        let outcome = match &mut driver {
            Driver::Commands(commands) => {
                let mut schedule = Schedule::new(commands, driven.model);
                schedule.begin(going.stepper.t, &mut driven);
                samples.push(Samples::default());
                going.run(&mut driven, &mut schedule, &mut recorder, until, options, keep_going)
            }
            Driver::Controller(controller, plan) => {
                let state = begin(&mut sampled, &going, &mut driven, plan);
                let mut sampling = Sampling { state, controller: *controller };
                let outcome = going.run(&mut driven, &mut sampling, &mut recorder, until, options, keep_going);
                samples.push(Samples { learnt: controller.learnt(), ..std::mem::take(&mut state.samples) });
                events.append(&mut state.events);
                outcome
            }
        };
        match coming.next() {
            Some(next) if outcome.kind == OutcomeKind::Completed => {
                if let Some(message) = state_fault(next.model, &going.stepper.x) {
                    break Outcome { kind: OutcomeKind::BadState, time: next.from, message };
                }
                going.go_on(&mut driven, next.model);
                driven.changes = ModelChanges::new(next.changes);
                driver = next.driver;
            }
            _ => break outcome,
        }
    };
    let mut run = recorder.finish(outcome, Some((&going.stepper, &driven, &mut going.watch)));
    run.warnings.extend(alarms(&events).chain(sampled.and_then(|mut sampled| sampled.paths.warning())));
    events.retain(|event| event.alarm.is_none());
    run.warnings.sort_by(|a, b| a.time.total_cmp(&b.time));
    PhasedRun { run, samples, events }
}

/// Warnings that a controller gives: each time that it stops the crane because of a sensor, and once that its loop oscillates or the tip
/// leaves its path.
fn alarms(events: &[Event]) -> impl Iterator<Item = Warning> + '_ {
    let first = [Alarm::Oscillates, Alarm::Strays].map(|of| events.iter().position(|event| event.alarm == Some(of)));
    events.iter().enumerate().filter_map(move |(i, Event { time, text, alarm })| {
        let (kind, cure) = match alarm.as_ref()? {
            Alarm::SensorStop => (
                "sensor-stop",
                "if the sensor is in order, state its errors in its `[sensor]` table, and those of valves and supply in \
                 `[control.plausibility]`",
            ),
            _ if !first.contains(&Some(i)) => return None,
            Alarm::Oscillates => (
                "controller-oscillates",
                "state the true `delay` and `natural-frequency` of each valve, or a lower `control.tip.damping-ratio`; a loop \
                 that swings amplifies errors of integration: `verify` states how far the run is off",
            ),
            Alarm::Strays => (
                "tip-off-path",
                "correct what the text names in the machine file, fit it to a log (`hc.fit`), or drive slower with \
                 `full-speed`; such a loop may amplify errors of integration: `verify` states how far the run is off",
            ),
        };
        Some(Warning { time: *time, kind, key: None, text: text.clone(), cure: cure.to_string() })
    })
}

/// Begins a phase with a controller; sticks and sent commands continue from the last such phase.
pub(crate) fn begin<'s>(
    sampled: &'s mut Option<Sampled>,
    going: &EventLoop,
    driven: &mut Driven,
    plan: &SampledPlan,
) -> &'s mut Sampled {
    let (now, x) = (going.stepper.t, &going.stepper.x);
    match sampled {
        Some(state) => {
            state.go_on(now, x, driven, plan);
            state
        }
        None => {
            driven.hold(now);
            sampled.insert(Sampled::new(now, x, driven, plan))
        }
    }
}

fn bad_start(recorder: Recorder, message: String) -> PhasedRun {
    let run = recorder.finish(Outcome { kind: OutcomeKind::BadState, time: 0.0, message }, None);
    PhasedRun { run, samples: vec![Samples::default()], events: Vec::new() }
}

/// The reason if phases cannot follow each other.
fn fault(first: &Phase, later: &[Phase]) -> Option<String> {
    let changes = |phase: &Phase| changes_fault(phase.model, &phase.changes, phase.from);
    if let Some(message) = first.driver.fault().or_else(|| changes(first)) {
        return Some(message);
    }
    let mut time = 0.0;
    for phase in later {
        if !(phase.from.is_finite() && phase.from > time) {
            return Some(format!(
                "a phase begins at {} s after {time} s; their times must be positive and increasing",
                phase.from
            ));
        }
        time = phase.from;
        let found = states_fault(first.model, phase.model).or_else(|| order_fault(phase));
        if let Some(message) = found.or_else(|| phase.driver.fault()).or_else(|| changes(phase)) {
            return Some(format!("in the phase from {time} s on: {message}"));
        }
    }
    None
}

/// Commands against time are possible only at the start of a run: later a controller's commands may not have arrived
/// yet.
fn order_fault(phase: &Phase) -> Option<String> {
    matches!(phase.driver, Driver::Commands(_)).then(|| "spool commands against time begin with the run".to_string())
}

/// The reason if a machine cannot change like this after the time `from` (s).
pub(crate) fn changes_fault(model: &dyn Model, changes: &[ModelChange], from: f64) -> Option<String> {
    if changes.is_empty() || !cfg!(feature = "chains") {
        return None;
    }
    let times: Vec<f64> = std::iter::once(from).chain(changes.iter().map(|change| change.time)).collect();
    if let Some(pair) = times.windows(2).find(|pair| !(pair[1].is_finite() && pair[1] > pair[0])) {
        return Some(format!("the machine changes at {} s after {} s; its times must increase", pair[1], pair[0]));
    }
    changes.iter().find_map(|change| states_fault(model, change.model))
}

/// The reason if one machine cannot continue from the state of another.
pub(crate) fn states_fault(before: &dyn Model, after: &dyn Model) -> Option<String> {
    let (old, new) = (&before.layout().names, &after.layout().names);
    if old == new {
        return None;
    }
    let lost = old.iter().find(|name| !new.contains(name));
    let gained = new.iter().find(|name| !old.contains(name));
    let name = lost.or(gained).map_or("in another order", String::as_str);
    Some(format!(
        "the machine has other states ({name}); during a run its values can change, but not its set of states"
    ))
}
