//! One-step methods with step size control and dense output.
//!
//! A method is a file with its coefficients and one attempt at a step; the [`Stepper`] controls the step size.

pub mod rodas5p;
pub mod tsit5;

mod linear;
mod stepper;

pub use linear::Linearisation;
pub use stepper::{StepFailure, Stepper, Tolerances};

use crate::system::System;

/// A one-step method of order five with an embedded error estimate and an interpolant.
pub trait Method: Send + Sync {
    /// Order of the solution that is carried on.
    fn order(&self) -> u32;
    /// Prepares whatever the step from `(t, x)` shares between attempts. Called once per accepted state.
    fn begin(&mut self, system: &dyn System, t: f64, x: &[f64]);
    /// Tries a step of size `h`. Writes the new state, the new quadratures (from `w`) and the error estimate;
    /// `false` where the linear system cannot be solved.
    fn attempt(&mut self, system: &dyn System, t: f64, h: f64, from: Point, to: &mut Target) -> bool;
    /// Keeps what the interpolant needs of an accepted step.
    fn accept(&mut self, from: Point, to: Point);
    /// State and quadratures at the fraction `theta` of the last accepted step.
    fn interpolate(&self, theta: f64, x: &mut [f64], w: &mut [f64]);
    /// Evaluations so far: right-hand sides, Jacobians, factorisations.
    fn effort(&self) -> Effort;
}

/// A state with its quadratures.
#[derive(Clone, Copy)]
pub struct Point<'a> {
    pub x: &'a [f64],
    pub w: &'a [f64],
}

/// Where an attempt puts its results.
pub struct Target {
    pub x: Vec<f64>,
    pub w: Vec<f64>,
    pub error: Vec<f64>,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Effort {
    pub derivatives: u64,
    pub jacobians: u64,
    pub factorisations: u64,
}

/// The methods by name.
pub const METHODS: [&str; 2] = ["rodas5p", "tsit5"];

/// A method by its name in [`METHODS`].
pub fn method(name: &str, dimension: usize, quadratures: usize) -> Option<Box<dyn Method>> {
    match name {
        "rodas5p" => Some(Box::new(rodas5p::Rodas5p::new(dimension, quadratures))),
        "tsit5" => Some(Box::new(tsit5::Tsit5::new(dimension, quadratures))),
        _ => None,
    }
}

/// y += a x
fn axpy(y: &mut [f64], a: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}
