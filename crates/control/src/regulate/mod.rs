//! From the set-point to the commands of all cylinders: feed-forward, feedback, damping.

pub mod damping;
pub mod drive;
pub mod drive_state;
pub(crate) mod tip_settings;
pub(crate) mod weighing;
