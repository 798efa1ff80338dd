//! What a one-step method is.

use crate::system::System;

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
pub(crate) fn flush(x: &mut [f64]) {
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
