//! What a one-step method is.

use crate::linear::system::System;
use hydrocrane_num::Archive;

/// A one-step method with an interpolant and an embedded error estimate.
pub trait Method: Send + Sync {
    /// Order of the solution.
    fn order(&self) -> u32;
    /// Exponent of the error estimate, for step control.
    fn estimate_order(&self) -> u32 {
        self.order()
    }
    /// Prepares what all attempts of the step from `(t, x)` share. Called once per accepted state.
    fn begin(&mut self, system: &dyn System, t: f64, x: &[f64], restart: Restart);
    /// Tries a step of size `h` from `x`. Writes the new state and the error estimate; `false` where the linear system
    /// cannot be solved. Keeps the data of the interpolant.
    fn attempt(&mut self, system: &dyn System, t: f64, h: f64, x: &[f64], to: &mut Target) -> bool;
    /// Carries an `error` of the state over the last attempt, of size `h`, by the equations linearised at its start; `false`
    /// where the method has no linearisation. Valid until the next `begin`.
    fn carry(&mut self, _h: f64, _error: &mut [f64]) -> bool {
        false
    }
    /// The state at the fraction `theta` of the last attempt; valid until the next `begin`.
    fn interpolate(&self, theta: f64, x: &mut [f64]);
    /// The same for these `states`, by increasing index; others may be written too.
    fn interpolate_some(&self, theta: f64, _states: &[usize], x: &mut [f64]) {
        self.interpolate(theta, x);
    }
    /// What the next step of the same `system` from time `t` needs of the last attempt.
    fn archive(&mut self, _system: &dyn System, _t: f64, _archive: &mut Archive) {}
    /// Evaluations so far: right-hand sides, Jacobians, factorisations.
    fn effort(&self) -> Effort;
}

/// What has changed at the beginning of a step since the end of the last attempt.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Restart {
    /// Nothing.
    None,
    /// The input; the state is the same.
    Input,
    /// The state or the right-hand side; or there was no attempt.
    #[default]
    State,
}

impl Restart {
    const ALL: [Restart; 3] = [Restart::None, Restart::Input, Restart::State];

    pub(crate) fn archive(&mut self, archive: &mut Archive) {
        let mut place = *self as u64;
        archive.whole(&mut place);
        *self = Self::ALL.get(place as usize).copied().unwrap_or(Restart::State);
    }
}

/// States smaller than this are set to zero: decaying spools would end in subnormal numbers, which are slow.
pub const FLUSH: f64 = 1e-30;

/// Sets states below [`FLUSH`] to zero.
pub(crate) fn flush(x: &mut [f64]) {
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
