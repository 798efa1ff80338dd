//! What an FMU refuses, and why.

use hydrocrane_sim::Archive;

/// An error; its text states cause and cure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Fault {
    /// The request is invalid.
    Wrong(String),
    /// The machine cannot make this step; a smaller one may be possible.
    Impossible(String),
}

impl From<String> for Fault {
    fn from(text: String) -> Self {
        Fault::Wrong(text)
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
