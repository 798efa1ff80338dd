//! What can be wrong with a request for sensitivities.

use hydrocrane_machine::MachineError;
use hydrocrane_plant::errors::{BuildError, PoseError};

#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SensitivityError {
    /// The machine, or a key that is none.
    #[error(transparent)]
    Machine(#[from] MachineError),
    #[error(transparent)]
    Build(#[from] BuildError),
    #[error(transparent)]
    Pose(#[from] PoseError),
    /// A key that nothing can be differentiated by, or a wrong value of one.
    #[error("{0}")]
    Key(String),
}
