//! What an FMU of a machine is: its variables, and what happens when a simulation tool sets, steps and reads them.
//!
//! A plant goes on by the loop of `hydrocrane-sim`, a controller by its samples; nothing here knows the C interface of FMI, which
//! is `crates/fmi`.

mod controller;
mod names;
mod parameters;
mod part;
mod plant;
mod resources;
mod variable;

pub use part::{open, Fault, Part};
pub use resources::{Resources, Role, Settings};
pub use variable::{Kind, Use, Variable};
