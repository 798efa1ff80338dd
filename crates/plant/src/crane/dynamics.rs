//! Forces and accelerations of the chain.
//!
//! Slices of joints, cylinders and states have the lengths of the layout; SI units throughout.

use crate::crane::{array, Crane};
use hydrocrane_num::linear::small;

pub trait Dynamics {
    /// Row-major mass matrix and bias force.
    fn equations(&self, q: &[f64], qd: &[f64], payload: f64, mass: &mut [f64], bias: &mut [f64]);
    fn forward_dynamics(&self, q: &[f64], qd: &[f64], force: &[f64], payload: f64, qdd: &mut [f64]);
    fn static_force(&self, q: &[f64], payload: f64, force: &mut [f64]);
    /// The tip with `payload` picks up a `load` (kg) at rest: writes the joint rates after it, returns the loss (J).
    fn attach(&self, q: &[f64], qd: &[f64], payload: f64, load: f64, rates: &mut [f64]) -> f64;
    /// (kinetic, potential), J.
    fn energies(&self, q: &[f64], qd: &[f64], payload: f64) -> (f64, f64);
}

impl<const N: usize> Dynamics for Crane<N> {
    fn equations(&self, q: &[f64], qd: &[f64], payload: f64, mass: &mut [f64], bias: &mut [f64]) {
        let pose = self.plant().mechanics.pose(&array::<N>(q));
        let e = self.plant().equations(&pose, &array::<N>(qd), payload);
        for j in 0..N {
            mass[j * N..(j + 1) * N].copy_from_slice(&e.mass_matrix[j]);
        }
        bias.copy_from_slice(&e.bias);
    }

    fn forward_dynamics(&self, q: &[f64], qd: &[f64], force: &[f64], payload: f64, qdd: &mut [f64]) {
        let pose = self.plant().mechanics.pose(&array::<N>(q));
        let e = self.plant().equations(&pose, &array::<N>(qd), payload);
        let lever_arms = self.plant().strokes(&pose);
        let mut driving = hydrocrane_num::array::from_fn(|j| lever_arms[j].1 * force[j] - e.bias[j]);
        self.plant().add_contact(&pose, &array::<N>(qd), payload, &mut driving);
        qdd.copy_from_slice(&small::solve_spd(&e.mass_matrix, &driving));
    }

    fn static_force(&self, q: &[f64], payload: f64, force: &mut [f64]) {
        force.copy_from_slice(&self.plant().static_force(&array::<N>(q), payload));
    }

    fn attach(&self, q: &[f64], qd: &[f64], payload: f64, load: f64, rates: &mut [f64]) -> f64 {
        let pose = self.plant().mechanics.pose(&array::<N>(q));
        let attachment = self.plant().attach(&pose, &array::<N>(qd), payload, load);
        rates.copy_from_slice(&attachment.rates);
        attachment.loss
    }

    fn energies(&self, q: &[f64], qd: &[f64], payload: f64) -> (f64, f64) {
        let plant = self.plant();
        let pose = plant.mechanics.pose(&array::<N>(q));
        (plant.kinetic_energy(&pose, &array::<N>(qd), payload), plant.potential_energy(&pose, payload))
    }
}
