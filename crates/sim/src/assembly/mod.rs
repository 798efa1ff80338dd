//! Assembly of a scenario for a run, common to all interfaces: machines, start, commands, controllers, sensors and
//! sticks.

mod commands;
mod drivers;
mod machines;
mod start;
mod unreached;

pub use commands::commands;
pub use machines::Machines;
pub use start::start;
pub use unreached::unreached;

use machines::Once;

pub(crate) use drivers::levers;

use crate::inputs::options::{Commands, RunOptions};
use crate::inputs::sensing::SensorFault;
use crate::model::method_choice::{method_for, step_control, Task};
use crate::model::model_change::{ModelChange, OwnedChanges};
use crate::model::payload::PayloadChange;
use crate::model::Model;
use crate::runs::live::Live;
use crate::runs::phases::{simulate_phases, Driver, Phase, PhasedRun};
use crate::runs::sampled::SampledPlan;
use crate::warning::Warning;
use crate::CHAINS;
use hydrocrane_control::interface::controller::Controller;
use hydrocrane_machine::scenario::{burst_fault, Scenario, Solver, Stage};
use hydrocrane_machine::{Machine, MachineError, OverrideValue};
use hydrocrane_ode::Tolerances;
use hydrocrane_plant::{BuildError, PoseError};
use std::sync::Arc;

/// Services that a scenario needs from its caller.
pub trait Surroundings {
    /// The scenario's machine with these overrides; or that of `source`, a bundled name or path.
    ///
    /// # Errors
    /// What is wrong with its file, its overrides, or the machine they describe.
    fn machine(
        &mut self,
        source: Option<&str>,
        overrides: &[(String, OverrideValue)],
    ) -> Result<Arc<dyn Model>, AssemblyError>;

    /// User-defined controller `number` for a stage, with its controller model. Some interfaces have none.
    fn own_controller(
        &mut self,
        number: usize,
        stage: &Stage,
        controller_model: &Arc<dyn Model>,
    ) -> Option<Box<dyn Controller>>;
}

/// Why a scenario cannot be run.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum AssemblyError {
    #[error(transparent)]
    Machine(#[from] MachineError),
    /// A valid description of a machine that cannot be simulated.
    #[error("{0}: [cannot-build] {1}")]
    Build(String, BuildError),
    /// A start that is not possible for the machine.
    #[error(transparent)]
    Pose(#[from] PoseError),
    /// With what stands before it: the place in a file.
    #[error("{0}{1}")]
    PoseOfFile(String, PoseError),
    #[error("{0}")]
    Scenario(String),
}

impl From<String> for AssemblyError {
    fn from(message: String) -> Self {
        AssemblyError::Scenario(message)
    }
}

/// An assembled scenario.
pub struct Assembly {
    /// State at time zero.
    pub x0: Vec<f64>,
    /// Warnings before the run.
    pub doubts: Vec<Warning>,
    /// s
    pub end: f64,
    pub options: RunOptions,
    /// The stages that begin before the end, in order of time.
    pub stages: Vec<AssembledStage>,
    pub sensor_faults: Vec<SensorFault>,
}

/// An assembled stage.
pub struct AssembledStage {
    pub stage: Stage,
    pub model: Arc<dyn Model>,
    /// Times (s) in order at which hoses burst during the stage, each with the machine from then on.
    pub changes: OwnedChanges,
    /// The controller model.
    pub controller_model: Arc<dyn Model>,
    pub driver: OwnedDriver,
}

/// The source of the spool commands in a stage.
pub enum OwnedDriver {
    Commands(Commands),
    Controller(Box<dyn Controller>, Box<SampledPlan>),
}

/// Settings of a run that the scenario does not state.
#[derive(Debug, Clone, Copy)]
pub struct RunSettings {
    /// Whether the energy ledger is integrated.
    pub ledger: bool,
    /// Number of accepted steps after which a run ends.
    pub max_steps: u64,
}

/// Assembles `scenario`.
///
/// # Errors
/// What is wrong with one of its machines, its start, its commands or its sensors.
pub fn assemble(
    scenario: &Scenario,
    settings: RunSettings,
    surroundings: &mut dyn Surroundings,
) -> Result<Assembly, AssemblyError> {
    at_start(scenario, settings, stages(scenario, surroundings)?)
}

/// The `stages` of `scenario`, ready to run from its start.
///
/// # Errors
/// What is wrong with the start.
pub fn at_start(
    scenario: &Scenario,
    settings: RunSettings,
    stages: Vec<AssembledStage>,
) -> Result<Assembly, AssemblyError> {
    let Some(first) = stages.first() else {
        return Err(format!("the duration is {} s; it must be greater than zero", scenario.duration).into());
    };
    let payload = scenario.load.payload.unwrap_or(first.model.machine().payload.mass);
    let (x0, mut doubts) = start(scenario, first.model.as_ref(), payload)?;
    doubts.extend(stages.iter().find_map(drivers::unmeasured));
    doubts.extend(unreached(scenario, first.model.machine()));
    let changes = scenario.load.changes.iter().map(|&(time, mass)| PayloadChange { time, mass }).collect();
    let options = options(&scenario.solver, first.model.machine(), Task::States, payload, settings);
    let supply = scenario.supply.clone().map(Arc::new);
    let options = RunOptions { payload_changes: changes, supply, ..options };
    let sensor_faults = scenario.faults.sensors.clone();
    Ok(Assembly { x0, doubts, end: scenario.duration, options, stages, sensor_faults })
}

/// The stages of `scenario` that begin before its end, assembled for any state of the crane.
///
/// # Errors
/// As [`assemble`], without those of the start.
pub fn stages(scenario: &Scenario, surroundings: &mut dyn Surroundings) -> Result<Vec<AssembledStage>, AssemblyError> {
    if let Some((_, message, cure)) = burst_fault(&scenario.faults.bursts).filter(|_| CHAINS) {
        return Err(format!("{message}; {cure}").into());
    }
    let due: Vec<Stage> = scenario.stages().into_iter().filter(|stage| stage.from < scenario.duration).collect();
    let ends: Vec<f64> = due.iter().skip(1).map(|next| next.from).chain([scenario.duration]).collect();
    let mut once = Once { inner: surroundings, made: Vec::new() };
    let assembled = due.into_iter().zip(ends).map(|(stage, end)| drivers::stage(scenario, stage, end, &mut once));
    let stages = assembled.collect::<Result<Vec<_>, _>>()?;
    drivers::goal_fault(scenario, &stages).map_or(Ok(stages), |fault| Err(fault.into()))
}

/// Options for a `task` on a machine, without changes of its payload.
pub fn options(solver: &Solver, machine: &Machine, task: Task, payload: f64, settings: RunSettings) -> RunOptions {
    let (relative, max_step) = (solver.rtol, solver.step.unwrap_or(solver.max_step));
    RunOptions {
        method: method_for(solver, machine, task).to_string(),
        tolerances: Tolerances { relative, absolute: solver.atol.unwrap_or(relative), max_step },
        control: step_control(solver),
        payload,
        payload_changes: Vec::new(),
        supply: None,
        ledger: settings.ledger,
        max_steps: settings.max_steps,
    }
}

impl Assembly {
    /// Runs it, recording at `record` (ascending times); `keep_going` is called from time to time.
    pub fn run(&mut self, record: &[f64], keep_going: &mut dyn FnMut(f64) -> bool) -> PhasedRun {
        let mut phases = self.stages.iter_mut().map(|stage| Phase {
            from: stage.stage.from,
            model: stage.model.as_ref(),
            changes: ModelChange::all(&stage.changes),
            driver: match &mut stage.driver {
                OwnedDriver::Commands(commands) => Driver::Commands(commands),
                OwnedDriver::Controller(controller, plan) => Driver::Controller(controller.as_mut(), plan),
            },
        });
        let first = phases.next().expect("an assembly has a stage");
        simulate_phases(&self.x0, self.end, first, phases.collect(), record, &self.options, keep_going)
    }
}

impl AssembledStage {
    /// Begins a drive that repeats this stage from state `x0`, until an operator takes over or another stage begins.
    ///
    /// # Errors
    /// The reason why it cannot begin.
    pub fn live(self, x0: &[f64], options: RunOptions) -> Result<Live, String> {
        let (controller, plan, commands) = match self.driver {
            OwnedDriver::Controller(controller, plan) => (controller, *plan, None),
            OwnedDriver::Commands(commands) => {
                let (controller, plan) = levers(self.model.as_ref(), &[])?;
                (controller, plan, Some(commands))
            }
        };
        let live = Live::new((self.model, self.changes), controller, x0, &plan, options)?;
        Ok(match commands {
            Some(commands) => live.with_commands(&commands),
            None => live,
        })
    }
}
