//! Linear algebra of small systems, complex numbers, vectors.

pub(crate) mod complex;
#[cfg(feature = "std")]
pub mod dense;
pub mod small;
pub mod symmetric;
pub(crate) mod vec2;
pub(crate) mod vec3;
