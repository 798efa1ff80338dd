//! One experiment: a run together with the derivatives of all recorded signals.

use super::inputs::{check_effect, machines_by, Differentiated, Inputs};
use super::tangent_system::{Group, TangentSystem};
use super::SensitivityError;
use crate::assembly::{options, RunSettings};
use crate::event_loop::driven::Driven;
use crate::event_loop::{EventLoop, Record};
use crate::inputs::faults::start_fault;
use crate::inputs::options::{Commands, RunOptions};
use crate::inputs::supply::place;
use crate::model::build::build;
use crate::model::method_choice::Task;
use crate::model::model_change::{ModelChange, ModelChanges, OwnedChanges};
use crate::model::payload::{PayloadChange, PayloadEvent};
use crate::model::Model;
use crate::outcome::{Outcome, OutcomeKind};
use crate::runs::schedule::Schedule;
use crate::warning::Warning;
use hydrocrane_machine::by_keys::{Keys, Parameter};
use hydrocrane_machine::scenario::{burst_fault, burst_times, tighten, with_hoses, Burst, Solver, SupplyPressure};
use hydrocrane_machine::{Machine, Number, OverrideValue, Template};
use hydrocrane_ode::System;
use hydrocrane_ode::{method, Effort, Stepper};
use hydrocrane_plant::equations::outputs::{self, OutputInfo, OIL_ENERGY};
use hydrocrane_plant::errors::BuildError;
use hydrocrane_plant::layout::Layout;
use hydrocrane_plant::EquilibriumMode;
use std::sync::Arc;

type Result<T> = std::result::Result<T, SensitivityError>;

/// Start of a run.
#[derive(Debug, Clone)]
pub enum Start {
    /// At rest in a pose: pressures follow from the machine, and depend on its parameters.
    Rest(Vec<f64>),
    /// In a given state, independent of the parameters.
    State(Vec<f64>),
}

/// The run and the parameters of its derivatives.
#[derive(Debug, Clone)]
pub struct Experiment {
    /// Machine file or bundled name, and overrides.
    pub source: String,
    pub overrides: Vec<(String, OverrideValue)>,
    pub keys: Vec<String>,
    pub start: Start,
    pub end: f64,
    pub commands: Commands,
    /// A measured supply pressure, for a machine that needs one.
    pub supply: Option<Arc<SupplyPressure>>,
    /// Hoses that burst; keys of the leaks that stand for them count from then on.
    pub bursts: Vec<Burst>,
    /// Loads picked up and released, in order of time; their masses do not depend on the parameters.
    pub payload_changes: Vec<PayloadChange>,
    /// Ascending times to record at, s.
    pub record: Vec<f64>,
    pub solver: Solver,
    /// Number of accepted steps after which a run ends.
    pub max_steps: u64,
    /// Whether the step size control includes the derivatives, or only the states as in a run without derivatives.
    pub resolve_sensitivities: bool,
}

/// A run and its derivatives, up to its end.
#[derive(Debug, Clone)]
pub struct Sensitivities {
    pub parameters: Vec<Parameter>,
    /// What each column of `values` is: states, then outputs.
    pub signals: Vec<OutputInfo>,
    pub times: Vec<f64>,
    /// Row-major, one row per time.
    pub values: Vec<f64>,
    /// `times x signals x parameters`.
    pub sensitivities: Vec<f64>,
    /// Spool commands, one row per time.
    pub commands: Vec<f64>,
    /// kg at the tip, one per time.
    pub payloads: Vec<f64>,
    pub payload_events: Vec<PayloadEvent>,
    /// Warnings in order of time.
    pub warnings: Vec<Warning>,
    pub outcome: Outcome,
    /// The method that was used.
    pub method: String,
    pub accepted: u64,
    pub rejected: u64,
    pub effort: Effort,
}

/// The keys with their values in the machine.
pub fn parameters(experiment: &Experiment) -> Result<Vec<Parameter>> {
    Ok(keys(experiment)?.parameters)
}

/// Of the machine whose hoses have all burst.
fn keys(experiment: &Experiment) -> Result<Keys> {
    if let Some((_, message, cure)) = burst_fault(&experiment.bursts) {
        return Err(SensitivityError::Key(format!("{message}; {cure}")));
    }
    let overrides = with_hoses(&experiment.bursts, experiment.overrides.clone(), f64::INFINITY);
    Ok(Keys::new(Template::open(&experiment.source, &overrides)?, &experiment.keys)?)
}

/// Runs the experiment with these `values` of its keys, or with the machine's own.
pub fn sensitivities(
    experiment: &Experiment,
    values: Option<&[f64]>,
    keep_going: &mut dyn FnMut(f64) -> bool,
) -> Result<Sensitivities> {
    let mut keys = keys(experiment)?;
    if experiment.supply.is_some() && keys.parameters.iter().any(|parameter| parameter.key == "supply.pressure") {
        let message = "`supply.pressure` does not enter the run: the supply pressure is a measured one";
        return Err(SensitivityError::Key(message.into()));
    }
    let values = values.map_or_else(|| keys.values(), <[f64]>::to_vec);
    let machine = keys.machine(&values)?;
    keys.parameters.iter_mut().zip(&values).for_each(|(parameter, value)| parameter.value = *value);
    match machine.joints.len() {
        1 => sized::<1>(experiment, &keys, &values, &machine, keep_going),
        2 => sized::<2>(experiment, &keys, &values, &machine, keep_going),
        3 => sized::<3>(experiment, &keys, &values, &machine, keep_going),
        4 => sized::<4>(experiment, &keys, &values, &machine, keep_going),
        5 => sized::<5>(experiment, &keys, &values, &machine, keep_going),
        6 => sized::<6>(experiment, &keys, &values, &machine, keep_going),
        n => Err(BuildError::Chain(n).into()),
    }
}

fn sized<const N: usize>(
    experiment: &Experiment,
    keys: &Keys,
    values: &[f64],
    machine: &Machine,
    keep_going: &mut dyn FnMut(f64) -> bool,
) -> Result<Sensitivities> {
    let differentiated = machines_by(keys, values)?;
    let (mut models, mut inputs) = (OwnedChanges::new(), Vec::new());
    for time in std::iter::once(0.0).chain(burst_times(&experiment.bursts, 0.0, experiment.end)) {
        models.push((time, build(&tight(experiment, machine, time))?));
        let machines = differentiated.iter().map(|machine| tight(experiment, machine, time));
        inputs.push(machines.map(|machine| Inputs::of(&machine)).collect::<Result<Vec<_>>>()?);
    }
    check_effect(keys, &inputs[inputs.len() - 1])?;
    let model = models[0].1.as_ref();
    let groups = inputs.into_iter().map(|inputs| Group::<N>::all(inputs, values.len(), model.layout()));
    let groups = groups.collect::<Vec<_>>();
    let start = start_state(experiment, model, &groups[0])?;
    let mut record = SensitivityRecord::new(keys, model, &groups, &experiment.record);
    let states = model.layout().len();
    let settings = RunSettings { ledger: false, max_steps: experiment.max_steps };
    let options = options(&experiment.solver, machine, Task::Sensitivities, machine.payload.mass, settings);
    let (supply, payload_changes) = (experiment.supply.clone(), experiment.payload_changes.clone());
    let options = RunOptions { supply, payload_changes, ..options };
    record.done.method.clone_from(&options.method);
    if let Some(message) = start_fault(model, &start[..states.min(start.len())], &options) {
        record.done.outcome = Outcome { kind: OutcomeKind::BadState, time: 0.0, message };
        return Ok(record.done);
    }
    let sizes: Vec<f64> = if experiment.resolve_sensitivities { values.iter().map(size).collect() } else { Vec::new() };
    let mut driven = Driven::new(model, &options, 0.0);
    driven.changes = ModelChanges::new(ModelChange::all(&models[1..]));
    let mut system = TangentSystem::new(driven, &groups, &sizes);
    let method = method(&options.method, system.dimension());
    let method = method.ok_or_else(|| SensitivityError::Key(format!("no method `{}`", options.method)))?;
    let stepper = Stepper::new(method, options.tolerances, 0.0, &start, 0).with_control(options.control);
    let mut going = EventLoop::new(stepper, &system.driven);
    let mut schedule = Schedule::new(&experiment.commands, model);
    schedule.begin(0.0, &mut system.driven);
    let outcome = going.run(&mut system, &mut schedule, &mut record, experiment.end, &options, keep_going);
    record.done.warnings = going.watch.close(&going.stepper, &system.driven);
    Ok(record.finish(outcome, &going.stepper, &system.driven))
}

/// The machine with the hoses tight that have not burst at the time `t` (s).
fn tight<T: Number>(experiment: &Experiment, machine: &Machine<T>, t: f64) -> Machine<T> {
    let mut machine = machine.clone();
    tighten(&experiment.bursts, &mut machine, t);
    machine
}

/// Typical change of a parameter: its value, or one in SI if it is zero.
fn size(value: &f64) -> f64 {
    if *value == 0.0 {
        1.0
    } else {
        value.abs()
    }
}

/// The start followed by its derivatives.
fn start_state<const N: usize>(experiment: &Experiment, model: &dyn Model, groups: &[Group<N>]) -> Result<Vec<f64>> {
    let layout = model.layout();
    let q = match &experiment.start {
        Start::State(x) => {
            let tangents = groups.iter().map(|group| group.count).sum::<usize>();
            return Ok([x.clone(), vec![0.0; x.len() * tangents]].concat());
        }
        Start::Rest(q) => q,
    };
    let mut x = model.equilibrium(q, EquilibriumMode::Hold, model.machine().payload.mass)?;
    x.resize(layout.len() * (1 + groups.iter().map(|group| group.count).sum::<usize>()), 0.0);
    // If the crane rests on an end stop, its pose differs from the requested one.
    let pose = hydrocrane_num::array::from_fn(|i| Differentiated::constant(x[layout.q(i)]));
    for group in groups {
        let inputs = &group.inputs;
        group.write(&inputs.plant.held(layout, &pose, inputs.back_pressure, inputs.payload), &mut x);
    }
    if let Some(supply) = &experiment.supply {
        place(supply, model, &mut x);
    }
    Ok(x)
}

/// Collects signals and their sensitivities at the record times.
struct SensitivityRecord<'a, const N: usize> {
    /// Of the machine at the start, then after each change of it.
    groups: &'a [Vec<Group<N>>],
    layout: &'a Layout,
    times: &'a [f64],
    next: usize,
    /// State and tangents at one time.
    row: Vec<f64>,
    done: Sensitivities,
}

impl<'a, const N: usize> SensitivityRecord<'a, N> {
    fn new(keys: &Keys, model: &'a dyn Model, groups: &'a [Vec<Group<N>>], times: &'a [f64]) -> Self {
        let layout = model.layout();
        let state = |i: usize| OutputInfo {
            name: layout.names[i].clone(),
            unit: layout.units[i],
            long_name: layout.long_names[i].clone(),
        };
        let outputs = model.output_info().iter().filter(|output| output.name != OIL_ENERGY).cloned();
        let done = Sensitivities {
            parameters: keys.parameters.clone(),
            signals: (0..layout.len()).map(state).chain(outputs).collect(),
            times: Vec::with_capacity(times.len()),
            values: Vec::new(),
            sensitivities: Vec::new(),
            commands: Vec::new(),
            payloads: Vec::new(),
            payload_events: Vec::new(),
            warnings: Vec::new(),
            outcome: Outcome { kind: OutcomeKind::Completed, time: 0.0, message: String::new() },
            method: String::new(),
            accepted: 0,
            rejected: 0,
            effort: Effort::default(),
        };
        let row = vec![0.0; layout.len() * (1 + keys.parameters.len())];
        SensitivityRecord { groups, layout, times, next: 0, row, done }
    }

    fn push(&mut self, t: f64, driven: &Driven) {
        let (signals, parameters) = (self.done.signals.len(), self.done.parameters.len());
        let first = self.done.sensitivities.len();
        self.done.times.push(t);
        self.done.commands.extend_from_slice(&driven.command(t)[..N]);
        self.done.payloads.push(driven.payload);
        self.done.sensitivities.resize(first + signals * parameters, 0.0);
        for group in &self.groups[driven.changes.done()] {
            let row = self.signals(group, driven);
            if group.first == 0 {
                self.done.values.extend(row.iter().map(|signal| signal.value));
            }
            for (signal, row) in row.iter().zip(self.done.sensitivities[first..].chunks_exact_mut(parameters)) {
                row[group.first..group.first + group.count].copy_from_slice(&signal.derivative[..group.count]);
            }
        }
    }

    /// States and outputs of the present row, with their derivatives by the parameters of one group.
    fn signals(&self, group: &Group<N>, driven: &Driven) -> Vec<Differentiated> {
        let (n, info) = (self.layout.len(), driven.model.output_info());
        let mut state = vec![Differentiated::constant(0.0); n];
        group.read(&self.row, n, &mut state);
        let mut all = vec![Differentiated::constant(0.0); info.len()];
        let at = group.evaluator.evaluated(self.layout, &state, group.payload(driven));
        // Tables of the oil's parameters are not differentiated.
        outputs::write(&group.inputs.plant, None::<fn(Differentiated) -> Differentiated>, &at, &mut all);
        state.extend(all.iter().zip(info).filter(|(_, output)| output.name != OIL_ENERGY).map(|(value, _)| *value));
        state
    }

    /// All results so far; a run that ended early also has its last state.
    fn finish(mut self, outcome: Outcome, stepper: &Stepper, driven: &Driven) -> Sensitivities {
        let last = self.done.times.last().copied().unwrap_or(-1.0);
        if outcome.kind != OutcomeKind::Completed && stepper.t > last {
            self.row.copy_from_slice(&stepper.x);
            self.push(stepper.t, driven);
        }
        self.done.outcome = outcome;
        self.done.payload_events.clone_from(&driven.loads.events);
        (self.done.accepted, self.done.rejected) = (stepper.accepted, stepper.rejected);
        self.done.effort = stepper.effort();
        self.done
    }
}

impl<const N: usize> Record for SensitivityRecord<'_, N> {
    /// Every record time up to the stepper's.
    fn take(&mut self, stepper: &Stepper, driven: &Driven) {
        while self.next < self.times.len() && self.times[self.next] <= stepper.t + 1e-12 {
            let t = self.times[self.next];
            stepper.interpolate(t, &mut self.row);
            self.push(t, driven);
            self.next += 1;
        }
    }
}
