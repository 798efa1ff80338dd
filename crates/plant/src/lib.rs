//! From a machine description to ordinary differential equations: state layout, right-hand side, exact Jacobian,
//! limits, equilibrium, outputs, energy ledger, and a second, readable right-hand side. No time stepping, no controllers.

pub mod axis_derivatives;
pub mod axis_group;
mod crane;
mod drawing;
mod dynamics;
pub mod equilibrium;
pub mod errors;
pub mod from_machine;
pub mod hydraulic_axis;
mod hydraulics;
mod in_chains;
mod inverse;
mod jacobian;
mod kinematics;
mod laws;
pub mod layout;
pub mod ledger;
pub mod limits;
mod load_pressure;
pub mod local;
mod motion;
pub mod oil;
pub mod outputs;
pub mod plant;
pub mod precision;
#[cfg(feature = "reference")]
pub mod reference;
pub mod rest;
pub mod rhs;
mod sensor_ranges;
mod shared_states;
pub mod shortfall;
mod state_space;
pub mod statics;
pub mod steady;
pub mod steady_friction;
pub mod supply;
mod workspace;

pub use crane::Crane;
pub use drawing::{Shape, ShapeKind};
pub use dynamics::Dynamics;
pub use errors::{BuildError, PoseError, StrokeError};
pub use hydraulics::{Hydraulics, Passivity};
pub use kinematics::Kinematics;
pub use layout::Layout;
pub use ledger::{shared_terms, Term, LEDGER_PER_CYLINDER, LEDGER_TERMS};
pub use limits::{JointLimits, LimitReason};
pub use outputs::OutputInfo;
pub use plant::Plant;
pub use rest::EquilibriumMode;
pub use state_space::StateSpace;
pub use statics::Statics;
pub use steady_friction::{map_point, MapPoint, MAP_PARAMETERS};
