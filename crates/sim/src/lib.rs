//! Simulation: a machine description becomes a plant, the plant a system of ordinary differential equations,
//! and the system a run with a record, an energy ledger and an outcome.

mod build;
pub mod controllers;
mod crane;
mod cylinder_unit;
mod drawing;
mod equilibrium;
mod errors;
mod from_machine;
pub mod integrator;
mod inverse;
mod jacobian;
mod layout;
mod ledger;
mod limits;
mod model;
mod outcome;
mod outputs;
mod plant;
mod recorder;
mod rhs;
mod run;
mod sampled;
mod sensing;
mod simulator;
mod stick;
pub mod system;
mod tip_rates;
mod valve_line;
mod workspace;

pub mod reference;

pub use build::build;
pub use crane::Crane;
pub use drawing::{Shape, ShapeKind};
pub use equilibrium::EquilibriumMode;
pub use errors::{BuildError, PoseError, StrokeError};
pub use hydrocrane_control::controller;
pub use layout::Layout;
pub use ledger::{LEDGER_PER_CYLINDER, LEDGER_TERMS};
pub use limits::{JointLimits, LimitReason};
pub use model::{Model, Passivity};
pub use outcome::{Outcome, OutcomeKind};
pub use outputs::OutputInfo;
pub use plant::Plant;
pub use run::{simulate, Commands, Run, RunOptions};
pub use sampled::{simulate_sampled, Event, SampledPlan, SampledRun, Samples, FAILURES_IN_A_ROW};
pub use sensing::{FaultKind, SensorFault, SensorMode, Sensors};
pub use simulator::Simulator;
pub use stick::{StickKind, Sticks};
pub use tip_rates::{resolve_rates, RateWish};
