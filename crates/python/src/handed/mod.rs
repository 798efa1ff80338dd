//! What crosses the border: arrays, names, overrides, errors.

pub(crate) mod answers;
pub(crate) mod arrays;
pub(crate) mod errors;
pub(crate) mod overrides;
pub(crate) mod shared;
pub(crate) mod text_rows;
