//! The thesis's controller.

pub mod heinze_pid;
pub mod penalty;
pub mod pid;
pub mod working_area;
