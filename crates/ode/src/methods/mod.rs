//! The methods by name.

pub mod exponential4;
pub mod grk4t;
pub(crate) mod method;
pub(crate) mod poles;
pub mod rodas5p;
pub mod rosenbrock;
pub mod rosenbrock3;
pub mod tableau;
pub mod tsit5;

use crate::methods::method::Method;

/// The methods by name.
#[cfg(feature = "methods")]
pub const METHODS: [&str; 4] = ["rodas5p", "hc-exponential-4", "tsit5", "hc-rosenbrock-3"];
/// The only method that drives of the cockpit need.
#[cfg(not(feature = "methods"))]
pub const METHODS: [&str; 1] = ["hc-rosenbrock-3"];

/// A method by its name in [`METHODS`].
pub fn method(name: &str, dimension: usize) -> Option<Box<dyn Method>> {
    match name {
        #[cfg(feature = "methods")]
        "rodas5p" => Some(Box::new(rodas5p::Rodas5p::new(dimension))),
        #[cfg(feature = "methods")]
        "hc-exponential-4" => Some(exponential4::method(dimension)),
        #[cfg(feature = "methods")]
        "tsit5" => Some(Box::new(tsit5::Tsit5::new(dimension))),
        "hc-rosenbrock-3" => Some(Box::new(rosenbrock3::Rosenbrock3::new(dimension))),
        _ => None,
    }
}
