//! From the tree to values: fields with units, provenance, ranges.

pub(crate) mod at_cylinder;
pub(crate) mod field;
pub(crate) mod log;
pub(crate) mod plausible;
pub(crate) mod reader;
