//! The interface of a system to be integrated.

use crate::linear::Linearisation;

/// A system x' = f(t, x) with quadratures w' = g(x), which do not act back on x.
pub trait System {
    fn dimension(&self) -> usize;
    /// Writes f.
    fn derivative(&self, t: f64, x: &[f64], dx: &mut [f64]);
    /// Writes g; by default there are no quadratures.
    fn quadrature_rates(&self, _x: &[f64], _dw: &mut [f64]) {}
    /// Number of forward sensitivities (tangents) appended to the state in `x`.
    fn tangents(&self) -> usize {
        0
    }
    /// Writes f and df/dx. With tangents df/dx is that of the state alone, followed, tangent by tangent, by its directional
    /// derivative along the tangent, which couples the tangent's equation to the state.
    fn linearise(&self, t: f64, x: &[f64], at: &mut Linearisation);
    /// Updates a linearisation at this state after a change of commands.
    fn update_input(&self, t: f64, x: &[f64], at: &mut Linearisation) {
        self.linearise(t, x, at);
    }
    /// Writes df/dt; returns `false` if it is zero.
    fn time_derivative(&self, t: f64, x: &[f64], dfdt: &mut [f64]) -> bool;
    /// Whether the equations are defined at `x`.
    fn admissible(&self, x: &[f64]) -> bool;
    /// Scale of each state for absolute tolerances; scales of tangents follow if they take part in step control.
    fn scales(&self) -> &[f64];
    /// Number of like parts of the system. An error in one of them counts the same, however many there are.
    fn parts(&self) -> usize {
        1
    }
    /// Narrows the `tolerances` of states that a step `from` one state `to` another must meet more closely than their scales say.
    fn narrow(&self, _from: &[f64], _to: &[f64], _tolerances: &mut [f64]) {}
    /// Size of the estimated `error` of a step `from` one state `to` another, as a norm: one if the error of each state
    /// equals its scale.
    fn error_size(&self, _from: &[f64], _to: &[f64], error: &[f64]) -> f64 {
        let squares: f64 = error.iter().zip(self.scales()).map(|(error, scale)| (error / scale).powi(2)).sum();
        (squares / error.len() as f64).sqrt()
    }
}
