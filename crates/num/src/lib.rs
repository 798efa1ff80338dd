//! Numbers for the laws: the [`Real`] trait, dual numbers over any `Real`, functions that are smooth where
//! physics has kinks, small linear algebra and tables. No physics and no I/O live here.
#![cfg_attr(not(feature = "std"), no_std)]

mod archive;
pub mod array;
mod dual;
pub mod functions;
pub mod lanes;
pub mod linear;
pub mod portable;
mod random;
mod real;
pub mod stored;

pub use archive::Archive;
pub use dual::Dual;
pub use functions::bisect::bisect;
pub use functions::root::root;
pub use lanes::pack::Pack;
pub use lanes::Lanes;
pub use linear::complex::Complex;
pub use linear::vec2::Vec2;
pub use linear::vec3::Vec3;
pub use random::RandomStream;
pub use real::{Field, Mask, Real};
pub use stored::Stored;
