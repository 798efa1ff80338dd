//! Control: sees geometry and measurements, never the plant.

pub mod controller;
pub mod drive;
pub mod feed_forward;
pub mod guard;
pub mod heinze_pid;
pub mod holding;
pub mod inverse_kinematics;
pub mod keep_out;
pub mod lever;
pub mod nominal;
pub mod observer;
pub mod penalty;
pub mod pid;
pub mod plausibility;
pub mod redundancy;
pub mod set_point;
pub mod slow_down;
pub mod standstill;
pub mod tip;
pub mod witness;
pub mod working_area;
