//! Exact parameter sensitivities of an open-loop run.                       theory: docs/theory/sensitivities.md
//!
//! The derivative of a machine's laws by a key of its file is taken in two steps: from the key to the parameters of the
//! laws by differences ([`construction`]), from there to states and outputs by dual numbers ([`tangent_system`]).

mod construction;
mod error;
mod key;
mod solve;
mod tangent_system;

pub use error::SensitivityError;
pub use key::Parameter;
pub use solve::{parameters, sensitivities, Experiment, Sensitivities, Start};
