//! Runs, steps, batches and drives.

pub(crate) mod batch;
pub(crate) mod live;
pub(crate) mod own_controller;
pub(crate) mod record;
pub(crate) mod run;
pub(crate) mod sensitivity;
pub(crate) mod simulation;
pub(crate) mod stepped_controller;
