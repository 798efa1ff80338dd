//! The FMU of a machine: its variables, and their setting, stepping and reading by a simulation tool.
//!
//! A plant advances by the loop of `hydrocrane-sim`, a controller by its samples. The C interface of FMI is in
//! `crates/fmi`.

mod controller;
mod controller_state;
mod fault;
mod history;
mod kept;
mod names;
mod parameters;
mod part;
mod plant;
mod resources;
mod variable;

pub use fault::{Fault, NO_STATE};
pub use kept::Kept;
pub use part::Part;
pub use resources::{Resources, Role, Settings};
pub use variable::{Kind, Use, Variable};

use controller::ControllerPart;
use plant::PlantPart;

/// The part that these files describe.
///
/// # Errors
/// What is wrong with them.
pub fn open(resources: &Resources) -> Result<Box<dyn Part>, String> {
    Ok(match resources.settings.role {
        Role::Plant => Box::new(PlantPart::open(resources)?),
        Role::Controller => Box::new(ControllerPart::open(resources)?),
    })
}
