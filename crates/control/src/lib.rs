//! Control: sees geometry and measurements, never the plant.

pub mod inverse_kinematics;
