//! Simulation: a plant and what drives it become a run with a record, an energy ledger, warnings and an outcome.

pub mod assembly;
#[cfg(feature = "batch")]
pub mod batch;
pub mod event_loop;
pub mod inputs;
pub mod model;
mod outcome;
mod playback;
pub mod runs;
pub mod sensitivity;
mod tip_rates;
mod warning;

/// Whether this build has the laws of every machine; that of the page's first core has those of the smallest chains alone.
pub const CHAINS: bool = cfg!(feature = "chains");

pub use event_loop::ledger::{ledger_terms, ledger_totals, total_terms};
pub use event_loop::warnings::{doubts_at_rest, implausible};
pub use hydrocrane_control::interface::controller;
pub use hydrocrane_control::parameter_block::memory as controller_memory;
pub use hydrocrane_num::Archive;
#[cfg(feature = "reference")]
pub use hydrocrane_plant::reference;
pub use hydrocrane_plant::{
    map_point, BuildError, Crane, Dynamics, EquilibriumMode, Hydraulics, JointLimits, Kinematics, Layout, LimitReason,
    MapPoint, OutputInfo, Passivity, Plant, PoseError, Shape, ShapeKind, StateSpace, StrokeError, MAP_PARAMETERS,
};
pub use inputs::command_path::{at_spools, has_hysteresis, longest_delay};
pub use inputs::options::{Commands, Run, RunOptions};
pub use inputs::sensing::{FaultKind, SensorFault, SensorMode, Sensors};
pub use inputs::stick::{StickKind, Sticks};
pub use model::build::build;
pub use model::controller_model::controller_model;
pub use model::method_choice::{method_for, Task};
pub use model::model_change::{ModelChange, OwnedChanges};
pub use model::payload::{change_payload, PayloadChange, PayloadEvent};
pub use model::Model;
pub use outcome::{Outcome, OutcomeKind};
pub use playback::{Playback, PlayedStage};
pub use runs::live::Live;
pub use runs::phases::{simulate_phases, Driver, Phase, PhasedRun};
pub use runs::run::{simulate, simulate_sampled, SampledRun};
pub use runs::sampled::{Event, SampledPlan, Samples, FAILURES_IN_A_ROW};
pub use runs::simulator::Simulator;
pub use tip_rates::{resolve_rates, RateRequest};
pub use warning::Warning;
