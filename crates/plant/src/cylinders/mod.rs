//! What belongs to one cylinder and its supply: states, flows, forces, powers, derivatives.

pub mod axis_derivatives;
pub mod axis_group;
pub mod hydraulic_axis;
pub(crate) mod in_chains;
pub mod ledger;
pub mod local;
pub mod supply;
