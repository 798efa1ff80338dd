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

pub use part::{Fault, Part};
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
