//! Simulation: a machine description becomes a plant, the plant a system of ordinary differential equations,
//! and the system a run with a record, an energy ledger and an outcome.

mod build;
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
mod rhs;
mod run;
mod simulator;
pub mod system;
mod workspace;

pub mod reference;

pub use build::build;
pub use crane::Crane;
pub use drawing::{Shape, ShapeKind};
pub use equilibrium::EquilibriumMode;
pub use errors::{BuildError, PoseError, StrokeError};
pub use layout::Layout;
pub use ledger::{LEDGER_PER_CYLINDER, LEDGER_TERMS};
pub use limits::{JointLimits, LimitReason};
pub use model::{Model, Passivity};
pub use outcome::{Outcome, OutcomeKind};
pub use outputs::OutputInfo;
pub use plant::Plant;
pub use run::{simulate, Commands, Run, RunOptions};
pub use simulator::Simulator;
