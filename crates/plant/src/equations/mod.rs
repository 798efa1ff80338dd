//! The equations of the whole machine: from its file to the right-hand side, its Jacobian and its outputs.

pub mod from_machine;
pub(crate) mod jacobian;
pub(crate) mod laws;
pub(crate) mod motion;
pub mod outputs;
pub mod plant;
pub mod rhs;
pub(crate) mod shared_states;
