//! Smooth functions, curves, tables, and where functions are zero.

pub(crate) mod bisect;
pub mod curve;
pub(crate) mod root;
pub mod smooth;
#[cfg(feature = "std")]
pub mod table;
