//! From files to one tree of values with their places.

pub(crate) mod bundled;
pub(crate) mod disk;
pub(crate) mod document;
pub(crate) mod merge;
pub(crate) mod toml_text;
