//! Runs: under commands or a controller, in phases, from outside, live.

pub(crate) mod live;
pub(crate) mod phases;
pub(crate) mod run;
pub(crate) mod sampled;
pub mod schedule;
pub(crate) mod simulator;
