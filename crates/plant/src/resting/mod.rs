//! Equilibria and steady motion of the circuit.

pub mod equilibrium;
pub mod rest;
pub mod shortfall;
pub mod steady;
pub mod steady_friction;
