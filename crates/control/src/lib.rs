//! Control: sees geometry and measurements, never the plant.
//!
//! Without the feature `std` it has neither a heap nor an operating system below it, and no messages.
#![cfg_attr(not(feature = "std"), no_std)]

pub mod estimate;
pub mod interface;
pub mod lever;
pub mod model;
pub mod monitor;
pub mod parameter_block;
pub mod reference;
pub mod regulate;
pub mod thesis;
pub mod tip;
pub mod valve;
