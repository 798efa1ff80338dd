//! Drives in the cockpit. One binary: linking takes longer than compiling.

mod bounds;
mod bursts;
mod cockpit;
mod common;
mod files;
mod goals;
mod ground;
