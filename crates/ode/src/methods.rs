//! The methods by name.

use crate::{method::Method, ros3l};
#[cfg(feature = "methods")]
use crate::{rodas5p, ros4l, tsit5};

/// The methods by name.
#[cfg(feature = "methods")]
pub const METHODS: [&str; 4] = ["rodas5p", "ros4l", "tsit5", "ros3l"];
/// The only method that drives of the cockpit need.
#[cfg(not(feature = "methods"))]
pub const METHODS: [&str; 1] = ["ros3l"];

/// A method by its name in [`METHODS`].
pub fn method(name: &str, dimension: usize) -> Option<Box<dyn Method>> {
    match name {
        #[cfg(feature = "methods")]
        "rodas5p" => Some(Box::new(rodas5p::Rodas5p::new(dimension))),
        #[cfg(feature = "methods")]
        "ros4l" => Some(ros4l::method(dimension)),
        #[cfg(feature = "methods")]
        "tsit5" => Some(Box::new(tsit5::Tsit5::new(dimension))),
        "ros3l" => Some(Box::new(ros3l::Ros3l::new(dimension))),
        _ => None,
    }
}
