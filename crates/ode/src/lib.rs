//! Ordinary differential equations x' = f(t, x) with quadratures, for stiff systems of some ten states.
//!
//! A [`System`] tells its right-hand side and its Jacobian, either dense or as a [`BlockArrow`]. A [`Method`] tries one
//! step; the [`Stepper`] chooses the step sizes. Nothing here knows a crane.

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
    /// Order of the solution that is carried on.
    fn order(&self) -> u32;
    /// Power of the step with which its error estimate is taken to go when the next size is chosen.
    fn estimate_order(&self) -> u32 {
        self.order()
    }
    /// Whether its steps are as long as they may be, whatever their error, as long as they follow the equations at all.
    fn even_steps(&self) -> bool {
        false
    }
    /// Prepares whatever the step from `(t, x)` shares between attempts. Called once per accepted state.
    fn begin(&mut self, system: &dyn System, t: f64, x: &[f64], restart: Restart);
    /// Tries a step of size `h` from `x`. Writes the new state and the error estimate; `false` where the linear system
    /// cannot be solved. Keeps what the interpolant needs.
    fn attempt(&mut self, system: &dyn System, t: f64, h: f64, x: &[f64], to: &mut Target) -> bool;
    /// The state at the fraction `theta` of the last attempt, before the next state is begun.
    fn interpolate(&self, theta: f64, x: &mut [f64]);
    /// Evaluations so far: right-hand sides, Jacobians, factorisations.
    fn effort(&self) -> Effort;
}

/// What has changed since the end of the last attempt, where a step begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Restart {
    /// Nothing.
    None,
    /// The input: the state is the same.
    Input,
    /// The state, or the right-hand side itself; or there was no attempt.
    State,
}

/// States smaller than this are zero: decaying spools would end in subnormal numbers, which are slow.
pub const FLUSH: f64 = 1e-30;

/// Sets to zero what is that small.
fn flush(x: &mut [f64]) {
    for x in x {
        *x = if x.abs() < FLUSH { 0.0 } else { *x };
    }
}

/// Where an attempt puts its results.
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
/// The method of a drive.
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
