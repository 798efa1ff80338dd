//! Control: sees geometry and measurements, never the plant.

pub mod controller;
pub mod inverse_kinematics;
