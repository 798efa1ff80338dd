//! Numbers for the laws: the [`Real`] trait, dual numbers over any `Real`, functions that are smooth where
//! physics has kinks, small linear algebra and tables. No physics and no I/O live here.
#![cfg_attr(not(feature = "std"), no_std)]

mod archive;
pub mod array;
mod bisect;
mod complex;
pub mod curve;
#[cfg(feature = "std")]
pub mod dense;
mod dual;
pub mod elementary;
mod lanes;
pub mod native;
mod pack;
pub mod portable;
mod random;
mod real;
pub mod register;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
pub mod register_wasm;
#[cfg(all(feature = "std", target_arch = "x86_64"))]
pub mod register_x86;
mod root;
pub mod small;
pub mod smooth;
pub mod stored;
pub mod symmetric;
#[cfg(feature = "std")]
pub mod table;
mod vec2;
mod vec3;

pub use archive::Archive;
pub use bisect::bisect;
pub use complex::Complex;
pub use dual::Dual;
pub use lanes::Lanes;
pub use pack::Pack;
pub use random::RandomStream;
pub use real::{Field, Mask, Real};
pub use root::root;
pub use stored::Stored;
pub use vec2::Vec2;
pub use vec3::Vec3;
