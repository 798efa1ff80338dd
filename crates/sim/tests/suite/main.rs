//! Runs, steps, batches and control on whole cranes. One binary: linking takes longer than compiling.

mod batch;
mod block_arrow;
mod chamber_estimate;
mod crane_step;
mod effort;
mod fixed_steps;
mod ground;
mod integrators;
mod keep_out;
mod outcomes;
mod parity;
mod payload;
mod phases;
mod plausibility;
mod ride_through;
mod sampled_loop;
mod supply;
mod tip_control;

use hydrocrane_ode::StepControl;

/// How tests step by this method: evenly by the one that is made for it.
fn control(method: &str) -> StepControl {
    if method == "hc-rosenbrock-3" {
        StepControl::Even
    } else {
        StepControl::Adaptive
    }
}
