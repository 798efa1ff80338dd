//! Knobs that change a machine while it is driven.

pub(crate) mod friction;
pub(crate) mod ground;
pub(crate) mod values;
