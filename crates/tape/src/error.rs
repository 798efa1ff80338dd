//! Why a machine cannot be exported as asked.

use hydrocrane_machine::by_keys::KeyError;
use hydrocrane_machine::MachineError;
use hydrocrane_plant::errors::BuildError;

#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TapeError {
    /// An error of the machine, or an unknown key.
    #[error(transparent)]
    Machine(#[from] MachineError),
    #[error(transparent)]
    Build(#[from] BuildError),
    /// A key that can be no parameter, an output that is none, a law that no tape holds.
    #[error("{0}")]
    Request(String),
}

impl From<KeyError> for TapeError {
    fn from(error: KeyError) -> Self {
        match error {
            KeyError::Machine(error) => TapeError::Machine(error),
            KeyError::Key(text) => TapeError::Request(text),
        }
    }
}
