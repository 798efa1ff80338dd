//! Exact parameter sensitivities of an open-loop run.                       theory: docs/theory/sensitivities.md
//!
//! The machine file is read with dual numbers ([`hydrocrane_machine::by_keys`]), from which the parameters of the laws follow with their derivatives
//! ([`inputs`]), and from these states and outputs with theirs ([`tangent_system`]).

mod error;
pub mod inputs;
mod solve;
mod tangent_system;

pub use error::SensitivityError;
pub use hydrocrane_machine::by_keys::Parameter;
pub use solve::{parameters, sensitivities, Experiment, Sensitivities, Start};
