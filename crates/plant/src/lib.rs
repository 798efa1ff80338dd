//! From a machine description to ordinary differential equations: state layout, right-hand side, exact Jacobian,
//! limits, equilibrium, outputs, energy ledger, and a second, readable right-hand side. No time stepping, no controllers.

pub mod crane;
pub mod cylinders;
pub mod equations;
pub mod errors;
pub mod layout;
pub mod oil;
pub mod precision;
#[cfg(feature = "reference")]
pub mod reference;
pub mod resting;

pub use crane::drawing::{Shape, ShapeKind};
pub use crane::dynamics::Dynamics;
pub use crane::hydraulics::{Hydraulics, Passivity};
pub use crane::kinematics::Kinematics;
pub use crane::limits::{JointLimits, LimitReason};
pub use crane::state_space::StateSpace;
pub use crane::statics::Statics;
pub use crane::Crane;
pub use cylinders::ledger::{shared_terms, Term, LEDGER_PER_CYLINDER, LEDGER_TERMS};
pub use equations::outputs::OutputInfo;
pub use equations::plant::Plant;
pub use errors::{BuildError, PoseError, StrokeError};
pub use layout::Layout;
pub use resting::rest::EquilibriumMode;
pub use resting::steady_friction::{map_point, MapPoint, MAP_PARAMETERS};
