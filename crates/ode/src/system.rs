//! What an integrator may know of the thing it integrates.

use crate::linear::Linearisation;

/// A system x' = f(t, x) with quadratures w' = g(x) that nothing depends on.
pub trait System {
    fn dimension(&self) -> usize;
    /// Writes f.
    fn derivative(&self, t: f64, x: &[f64], dx: &mut [f64]);
    /// Writes g; there are no quadratures unless a system says so.
    fn quadrature_rates(&self, _x: &[f64], _dw: &mut [f64]) {}
    /// Copies of the state, behind it in `x`, that follow the linearised equations: derivatives with respect to parameters.
    fn tangents(&self) -> usize {
        0
    }
    /// Writes f and df/dx. With tangents these derivatives are of the state alone, followed, tangent by tangent, by their
    /// derivative along it: what couples the tangent's equations to the state.
    fn linearise(&self, t: f64, x: &[f64], at: &mut Linearisation);
    /// Brings a linearisation at this state up to commands that have changed since.
    fn update_input(&self, t: f64, x: &[f64], at: &mut Linearisation) {
        self.linearise(t, x, at);
    }
    /// Writes df/dt, or says `false` where all of it is zero.
    fn time_derivative(&self, t: f64, x: &[f64], dfdt: &mut [f64]) -> bool;
    /// Whether `x` lies where the equations mean something.
    fn admissible(&self, x: &[f64]) -> bool;
    /// Size below which each state is resolved absolutely; that of tangents may follow, where they are to be resolved too.
    fn scales(&self) -> &[f64];
    /// Size of the estimated `error` of a step that led to the state `reached`, relative to what counts: one where each
    /// state errs by its scale.
    fn error_size(&self, _reached: &[f64], error: &[f64]) -> f64 {
        let squares: f64 = error.iter().zip(self.scales()).map(|(error, scale)| (error / scale).powi(2)).sum();
        (squares / error.len() as f64).sqrt()
    }
}
