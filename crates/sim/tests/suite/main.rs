//! Runs, steps, batches and control on whole cranes. One binary: linking takes longer than compiling.

#[cfg(target_arch = "x86_64")]
mod axis_group;
mod batch;
mod batch_command_path;
mod batch_parameters;
mod block_arrow;
mod chamber_estimate;
mod command_path;
mod compensator_lag;
mod controllers;
mod crane_step;
mod crossover_relief;
mod effort;
mod fixed_steps;
mod ground;
mod hose_leak;
mod integrators;
mod keep_out;
mod ledger;
mod lines;
mod load_holding;
mod load_sensing;
mod meter_out;
mod metering;
mod method_choice;
mod motor;
mod oil;
mod outcomes;
mod parallel_cylinders;
mod parity;
mod payload;
mod phases;
mod plausibility;
mod playback;
mod port_valves;
mod prime_mover;
mod priority;
mod ride_through;
mod sampled_loop;
mod schedule;
mod sensitivity_inputs;
mod several_pumps;
mod steady_friction;
mod stick;
mod supply;
mod tank_line;
mod tip_control;
mod tip_rates;

use hydrocrane_machine::parse;
use hydrocrane_ode::StepControl;
use hydrocrane_sim::{build, Model};
use std::sync::Arc;

/// The bundled machine `base` with `more` in its file.
fn extended(base: &str, more: &str) -> Arc<dyn Model> {
    let text = format!("extends = \"{base}\"\n[machine]\nclass = \"assumed\"\n{more}");
    build(&parse(&text, "extended.toml", &[]).unwrap_or_else(|error| panic!("{error}"))).expect("it can be built")
}

/// How tests step by this method: evenly by the one that is made for it.
fn control(method: &str) -> StepControl {
    if method == "hc-rosenbrock-3" {
        StepControl::Even
    } else {
        StepControl::Adaptive
    }
}
