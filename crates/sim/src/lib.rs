//! Simulation: a plant and what drives it become a run with a record, an energy ledger, warnings and an outcome.

pub mod assembly;
#[cfg(feature = "batch")]
pub mod batch;
mod build;
pub mod command_path;
mod controller_model;
pub mod controllers;
mod driven;
mod event_loop;
mod faults;
mod gain;
mod ledger;
mod live;
mod method_choice;
mod model;
mod model_change;
mod oil_lost;
mod options;
mod outcome;
mod payload;
mod phases;
mod playback;
pub mod promises;
mod recorder;
mod run;
mod sampled;
pub mod schedule;
mod sensing;
pub mod sensitivity;
mod sensor_monitor;
mod simulator;
mod stepping;
pub mod stick;
mod supply;
mod tip_rates;
mod warning;
mod warnings;

/// Whether this build has the laws of every machine; that of the page's first core has those of the smallest chains alone.
pub const CHAINS: bool = cfg!(feature = "chains");

pub use build::build;
pub use command_path::{at_spools, has_hysteresis, longest_delay};
pub use controller_model::controller_model;
pub use hydrocrane_control::controller;
pub use hydrocrane_control::parameter_block::memory as controller_memory;
pub use hydrocrane_num::Archive;
#[cfg(feature = "reference")]
pub use hydrocrane_plant::reference;
pub use hydrocrane_plant::{
    map_point, BuildError, Crane, Dynamics, EquilibriumMode, Hydraulics, JointLimits, Kinematics, Layout, LimitReason,
    MapPoint, OutputInfo, Passivity, Plant, PoseError, Shape, ShapeKind, StateSpace, StrokeError, MAP_PARAMETERS,
};
pub use ledger::{ledger_terms, ledger_totals, total_terms};
pub use live::Live;
pub use method_choice::{method_for, Task};
pub use model::Model;
pub use model_change::{ModelChange, OwnedChanges};
pub use options::{Commands, Run, RunOptions};
pub use outcome::{Outcome, OutcomeKind};
pub use payload::{change_payload, PayloadChange, PayloadEvent};
pub use phases::{simulate_phases, Driver, Phase, PhasedRun};
pub use playback::{Playback, PlayedStage};
pub use run::{simulate, simulate_sampled, SampledRun};
pub use sampled::{Event, SampledPlan, Samples, FAILURES_IN_A_ROW};
pub use sensing::{FaultKind, SensorFault, SensorMode, Sensors};
pub use simulator::Simulator;
pub use stick::{StickKind, Sticks};
pub use tip_rates::{resolve_rates, RateWish};
pub use warning::Warning;
pub use warnings::{doubts_at_rest, implausible};
