//! What reaches a model from outside: commands on their path, sticks, readings, supply, faults, and the options of a run.

pub mod command_path;
pub(crate) mod faults;
pub(crate) mod options;
pub(crate) mod sensing;
pub mod stick;
pub(crate) mod supply;
