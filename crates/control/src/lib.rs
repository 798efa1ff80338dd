//! Control: sees geometry and measurements, never the plant.

pub mod controller;
pub mod controller_model;
pub mod damping;
pub mod drive;
pub mod feed_forward;
pub mod heinze_pid;
pub mod holding;
pub mod inverse_kinematics;
pub mod keep_out;
pub mod lever;
pub mod observer;
pub mod oil_displacement;
pub mod oil_modes;
pub mod penalty;
pub mod pid;
pub mod plausibility;
pub mod readings;
pub mod redundancy;
pub mod safe_state;
pub mod set_point;
pub mod signal;
pub mod signal_chain;
pub mod slow_down;
pub mod standstill;
pub mod tip;
pub mod working_area;
