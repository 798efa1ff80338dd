//! From a wanted flow to a spool command.

pub mod commanded;
pub(crate) mod compression;
pub(crate) mod opening;
pub(crate) mod overlap;
pub mod pump_limit;
