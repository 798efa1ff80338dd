//! The changing state of a part, as a simulation tool keeps it.

use crate::controller_state::ControllerState;
use crate::fault::Fault;
use std::borrow::Cow;

pub enum Kept {
    Bytes(Vec<u8>),
    /// A controller is copied; only as bytes it is its samples.
    Controller(Box<ControllerState>),
}

impl Kept {
    /// Number of its bytes.
    ///
    /// # Errors
    /// As [`Self::bytes`].
    pub fn length(&self) -> Result<usize, Fault> {
        match self {
            Kept::Bytes(bytes) => Ok(bytes.len()),
            Kept::Controller(state) => state.length(),
        }
    }

    /// # Errors
    /// The reason why it has no bytes.
    pub fn bytes(&self) -> Result<Cow<'_, [u8]>, Fault> {
        match self {
            Kept::Bytes(bytes) => Ok(bytes.into()),
            Kept::Controller(state) => Ok(state.bytes()?.into()),
        }
    }
}
