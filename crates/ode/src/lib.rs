//! Ordinary differential equations x' = f(t, x) with quadratures, for stiff systems of some ten states.
//!
//! A [`System`] gives its right-hand side and its Jacobian, either dense or as a [`BlockArrow`]. A [`Method`] tries one
//! step. The [`Stepper`] chooses the step sizes. This crate does not depend on cranes.

mod block_arrow;
pub mod grk4t;
mod linear;
mod poles;
mod quadratures;
pub mod rodas5p;
pub mod ros3l;
pub mod ros4l;
mod rows;
mod schur;
mod stepper;
mod system;
pub mod tsit5;

pub use block_arrow::{AxisDerivatives, AxisStates, BlockArrow, Row, MAX_BORDER};
pub use linear::{Factored, Linearisation};
pub use schur::{ScalarOver, SchurFactors};
pub use stepper::{StepFailure, Stepper, Tolerances, CRAWL_ATTEMPTS};
pub use system::System;

/// A one-step method with an interpolant and an embedded error estimate.
pub trait Method: Send + Sync {
    /// Order of the solution.
    fn order(&self) -> u32;
    /// Exponent of the error estimate, for step control.
    fn estimate_order(&self) -> u32 {
        self.order()
    }
    /// Whether the method takes fixed steps: they are shortened only if they do not follow the equations.
    fn even_steps(&self) -> bool {
        false
    }
    /// Prepares what all attempts of the step from `(t, x)` share. Called once per accepted state.
    fn begin(&mut self, system: &dyn System, t: f64, x: &[f64], restart: Restart);
    /// Tries a step of size `h` from `x`. Writes the new state and the error estimate; `false` where the linear system
    /// cannot be solved. Keeps the data of the interpolant.
    fn attempt(&mut self, system: &dyn System, t: f64, h: f64, x: &[f64], to: &mut Target) -> bool;
    /// The state at the fraction `theta` of the last attempt; valid until the next `begin`.
    fn interpolate(&self, theta: f64, x: &mut [f64]);
    /// Evaluations so far: right-hand sides, Jacobians, factorisations.
    fn effort(&self) -> Effort;
}

/// What has changed at the beginning of a step since the end of the last attempt.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Restart {
    /// Nothing.
    None,
    /// The input; the state is the same.
    Input,
    /// The state or the right-hand side; or there was no attempt.
    State,
}

/// States smaller than this are set to zero: decaying spools would end in subnormal numbers, which are slow.
pub const FLUSH: f64 = 1e-30;

/// Sets states below [`FLUSH`] to zero.
fn flush(x: &mut [f64]) {
    for x in x {
        *x = if x.abs() < FLUSH { 0.0 } else { *x };
    }
}

/// Results of an attempt.
pub struct Target {
    pub x: Vec<f64>,
    pub error: Vec<f64>,
}

impl Target {
    /// Room for `n` states.
    pub fn new(n: usize) -> Self {
        Target { x: vec![0.0; n], error: vec![0.0; n] }
    }
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Effort {
    pub derivatives: u64,
    pub jacobians: u64,
    pub factorisations: u64,
}

/// The methods by name.
#[cfg(feature = "methods")]
pub const METHODS: [&str; 4] = ["rodas5p", "ros4l", "tsit5", "ros3l"];
/// Name of the method for drives of the cockpit.
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
