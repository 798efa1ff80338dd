//! Errors in a request for sensitivities.

use hydrocrane_machine::by_keys::KeyError;
use hydrocrane_machine::MachineError;
use hydrocrane_plant::errors::{BuildError, PoseError};

#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SensitivityError {
    /// An error of the machine, or an unknown key.
    #[error(transparent)]
    Machine(#[from] MachineError),
    #[error(transparent)]
    Build(#[from] BuildError),
    #[error(transparent)]
    Pose(#[from] PoseError),
    /// A key that is no numeric parameter, or a wrong value of one.
    #[error("{0}")]
    Key(String),
}

impl From<KeyError> for SensitivityError {
    fn from(error: KeyError) -> Self {
        match error {
            KeyError::Machine(error) => SensitivityError::Machine(error),
            KeyError::Key(text) => SensitivityError::Key(text),
        }
    }
}
