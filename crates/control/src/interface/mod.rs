//! What a controller is: signals, notices, goals.

pub mod controller;
pub mod notice;
pub mod point_to_point;
pub mod signal;
