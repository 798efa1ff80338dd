//! Control: sees geometry and measurements, never the plant.
//!
//! Without the feature `std` it has neither a heap nor an operating system below it, and no messages.
#![cfg_attr(not(feature = "std"), no_std)]

mod braking;
mod bristles;
pub mod chamber_estimate;
pub mod commanded;
mod compression;
pub mod controller;
pub mod controller_model;
pub mod damping;
pub mod drive;
pub mod feed_forward;
mod full_speed;
pub mod heinze_pid;
pub mod holding;
pub mod inverse_kinematics;
pub mod keep_out;
pub mod lever;
pub mod model_error;
#[cfg(feature = "std")]
pub mod monitored;
pub mod notice;
pub mod observer;
pub mod oil_displacement;
pub mod oil_modes;
mod opening;
mod overlap;
pub mod parameter_block;
mod passage;
pub mod penalty;
pub mod pid;
pub mod plausibility;
pub mod point_to_point;
pub mod pump_limit;
#[cfg(feature = "std")]
pub mod reach;
pub mod readings;
pub mod redundancy;
mod rest;
pub mod safe_state;
pub mod set_point;
pub mod signal;
pub mod signal_chain;
pub mod slewing;
pub mod slow_down;
mod spool_history;
pub mod standstill;
mod suspect;
pub mod tip;
mod tip_settings;
pub mod valve_answer;
pub mod valve_learning;
mod wanted;
mod weighing;
mod whereabouts;
mod wish;
pub mod working_area;
