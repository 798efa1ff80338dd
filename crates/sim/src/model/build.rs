//! From a machine description to its model, by the number of joints.

use crate::model::Model;
use hydrocrane_machine::model as file;
use hydrocrane_plant::errors::BuildError;
use hydrocrane_plant::Crane;
use std::sync::Arc;

/// Builds the model of a machine.
pub fn build(machine: &file::Machine) -> Result<Arc<dyn Model>, BuildError> {
    let model: Arc<dyn Model> = match machine.joints.len() {
        1 => Arc::new(Crane::<1>::new(machine)?),
        #[cfg(feature = "chains")]
        2 => Arc::new(Crane::<2>::new(machine)?),
        3 => Arc::new(Crane::<3>::new(machine)?),
        #[cfg(feature = "chains")]
        4 => Arc::new(Crane::<4>::new(machine)?),
        #[cfg(feature = "chains")]
        5 => Arc::new(Crane::<5>::new(machine)?),
        #[cfg(feature = "chains")]
        6 => Arc::new(Crane::<6>::new(machine)?),
        n => return Err(BuildError::Chain(n)),
    };
    Ok(model)
}
