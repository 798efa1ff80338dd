//! What readings say of states and of the machine.

pub mod chamber_estimate;
pub mod model_error;
pub mod observer;
pub mod readings;
pub(crate) mod rest;
pub mod standstill;
pub mod valve_learning;
