//! The changing state of a part, as a simulation tool keeps it.

use crate::controller_state::ControllerState;
use crate::part::Fault;
use hydrocrane_sim::Archive;
use std::borrow::Cow;

pub enum Kept {
    Bytes(Vec<u8>),
    /// A controller is copied; only as bytes it is its samples.
    Controller(Box<ControllerState>),
}

impl Kept {
    /// # Errors
    /// The reason why it has no bytes.
    pub fn bytes(&self) -> Result<Cow<'_, [u8]>, Fault> {
        match self {
            Kept::Bytes(bytes) => Ok(bytes.into()),
            Kept::Controller(state) => Ok(state.bytes()?.into()),
        }
    }
}

/// Refuses bytes that are not those of a state.
pub fn sound(archive: &Archive) -> Result<(), Fault> {
    match archive.is_sound() {
        true => Ok(()),
        false => Err(NO_STATE.to_string().into()),
    }
}

pub const NO_STATE: &str = "this is no state of this FMU";
