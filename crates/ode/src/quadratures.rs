//! Integrals along a run, w' = g(x): Lobatto's rule with four nodes in every step.   theory: docs/theory/integration.md
//!
//! Inside a step x comes from the interpolant of the method, so methods need not treat quadratures. Between the nodes g is the
//! cubic through its four values.

use crate::linear::system::System;
use crate::methods::method::Method;

/// sqrt 5
const ROOT: f64 = 2.236_067_977_499_79;
/// Nodes between the start of a step and its end.
const INSIDE: [f64; 2] = [0.5 - 0.5 / ROOT, 0.5 + 0.5 / ROOT];

/// Integrals, and their rates at the nodes of the last step.
pub struct Quadratures {
    /// At the end of the last step.
    pub w: Vec<f64>,
    start: Vec<f64>,
    rates: [Vec<f64>; 4],
    /// Whether the last rate belongs to the present state.
    known: bool,
    /// Size of the last step.
    h: f64,
    /// Work space for a state inside a step.
    x: Vec<f64>,
}

impl Quadratures {
    /// `m` integrals, all zero, for `n` states.
    pub fn new(n: usize, m: usize) -> Self {
        let zeros = || vec![0.0; m];
        let rates = hydrocrane_num::array::from_fn(|_| zeros());
        Quadratures { w: zeros(), start: zeros(), rates, known: false, h: 0.0, x: vec![0.0; n] }
    }

    /// Restarts: the next step does not start where the last one ended, or g has changed.
    pub fn restart(&mut self) {
        self.known = false;
    }

    /// Begins a step from `x`.
    pub fn begin(&mut self, system: &dyn System, x: &[f64]) {
        if !self.known && !self.w.is_empty() {
            system.quadrature_rates(x, &mut self.rates[3]);
            self.known = true;
        }
    }

    /// Adds the integral over a step of size `h` by `method`, which ends at `x`.
    pub fn follow(&mut self, system: &dyn System, method: &dyn Method, h: f64, x: &[f64]) {
        if self.w.is_empty() {
            return;
        }
        self.rates.swap(0, 3);
        for (theta, rates) in INSIDE.into_iter().zip(&mut self.rates[1..]) {
            method.interpolate(theta, &mut self.x);
            system.quadrature_rates(&self.x, rates);
        }
        system.quadrature_rates(x, &mut self.rates[3]);
        self.h = h;
        self.start.copy_from_slice(&self.w);
        integrate(&self.start, h, &self.rates, 1.0, &mut self.w);
    }

    /// The integrals at the fraction `theta` of the last step.
    pub fn interpolate(&self, theta: f64, w: &mut [f64]) {
        integrate(&self.start, self.h, &self.rates, theta, w);
    }
}

/// w = start + the integral of the cubics through `rates` up to the fraction `theta` of a step of size `h`.
fn integrate(start: &[f64], h: f64, rates: &[Vec<f64>; 4], theta: f64, w: &mut [f64]) {
    let weights = weights(theta);
    for (i, (w, start)) in w.iter_mut().zip(start).enumerate() {
        let mean: f64 = weights.iter().zip(rates).map(|(weight, rates)| weight * rates[i]).sum();
        *w = start + h * mean;
    }
}

/// Integrals from 0 to `theta` of the cubics that are one at one of the nodes and zero at the others.
fn weights(theta: f64) -> [f64; 4] {
    let square = theta * theta;
    let inner = |other: f64| 5.0 * ROOT * square * (0.5 * other + theta * (0.25 * theta - (1.0 + other) / 3.0));
    [
        theta * (1.0 + theta * (-3.0 + theta * (10.0 / 3.0 - 1.25 * theta))),
        inner(INSIDE[1]),
        -inner(INSIDE[0]),
        square * (0.5 + theta * (1.25 * theta - 5.0 / 3.0)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rule_is_exact_for_cubics_everywhere_and_to_the_fifth_power_over_a_step() {
        let nodes = [0.0, INSIDE[0], INSIDE[1], 1.0f64];
        for (theta, highest) in [(0.0, 3), (0.3, 3), (0.8, 3), (1.0f64, 5)] {
            for power in 0..=highest {
                let found: f64 = weights(theta).iter().zip(nodes).map(|(weight, node)| weight * node.powi(power)).sum();
                let wanted = theta.powi(power + 1) / f64::from(power + 1);
                assert!((found - wanted).abs() < 1e-15, "power {power} to {theta}: {found} for {wanted}");
            }
        }
    }
}
