//! The laws of a hydraulic crane, one file one law, generic over the number type.
//!
//! Every function takes plain parameter structs and numbers; none allocates, reads a file or knows time.
//! The theory pages under `docs/theory/` mirror this crate file by file.
#![cfg_attr(not(feature = "std"), no_std)]

#[macro_use]
mod parameters;
pub mod dynamics;
pub mod friction;
pub mod geometry;
pub mod hydraulics;
pub mod sensor;
