//! What a controller knows of its crane: geometry, masses, oil, answers of the valves.

pub(crate) mod bristles;
pub mod controller_model;
pub mod feed_forward;
pub(crate) mod full_speed;
pub mod inverse_kinematics;
pub mod oil_displacement;
pub mod oil_modes;
pub mod signal_chain;
pub mod slewing;
pub mod valve_answer;
