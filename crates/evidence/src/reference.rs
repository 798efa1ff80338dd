//! A saved drive simulated again by an adaptive method.

use crate::clock::thread_time;
use hydrocrane_machine::parse_scenario;
use hydrocrane_machine::scenario::{Initial, Scenario, Solver};
use hydrocrane_num::portable;
use hydrocrane_sim::assembly::{assemble, Machines, RunSettings};
use hydrocrane_sim::{Model, OutcomeKind};
use std::time::Duration;

/// Relative and absolute tolerance, in scales of the states.
pub const TOLERANCE: f64 = 1e-6;
/// Steps and processor time after which the drive is not judged.
const MOST_STEPS: u64 = 2_000_000;
const PATIENCE: Duration = Duration::from_secs(20);

/// A crane past its limits falls over its dead centre: what is small there grows without bound, in the adaptive run too.
const BEYOND: [&str; 2] = ["joint-outside-limits", "dead-centre-passed"];

/// The tip (x, z) at multiples of `interval` (s) from zero to the end of the saved drive, or until a joint leaves its limits;
/// an error where there is none. The drive starts with its tip `moved` (m) by the first joint.
pub fn tip(saved: &str, model: &dyn Model, interval: f64, moved: f64) -> Result<Vec<[f64; 2]>, String> {
    let scenario = parse_scenario(saved, "drive.toml", &[]).map_err(|error| error.to_string())?;
    let step = Solver { method: "rodas5p".into(), rtol: TOLERANCE, atol: None, max_step: 0.05, step: None };
    let scenario = Scenario { initial: moved_start(&scenario, model, moved), solver: step, ..scenario };
    let settings = RunSettings { ledger: false, max_steps: MOST_STEPS };
    let mut machines = Machines { machine: &scenario.machine, text: None };
    let mut assembly = assemble(&scenario, settings, &mut machines).map_err(|error| error.to_string())?;
    let record: Vec<f64> = (0..).map(|i| f64::from(i) * interval).take_while(|t| *t <= scenario.duration).collect();
    let began = thread_time();
    let done = assembly.run(&record, &mut |_| thread_time() - began < PATIENCE);
    if done.run.outcome.kind != OutcomeKind::Completed {
        return Err(format!("{} at {} s", done.run.outcome.message, done.run.outcome.time));
    }
    let beyond = done.run.warnings.iter().filter(|warning| BEYOND.contains(&warning.kind));
    let end = beyond.map(|warning| warning.time).fold(f64::INFINITY, f64::min);
    let (all, n) = (model.layout().len(), model.layout().joints());
    let rows = done.run.times.iter().zip(done.run.states.chunks_exact(all));
    Ok(rows.take_while(|(time, _)| **time < end).map(|(_, x)| model.tip(&x[..n])).collect())
}

/// The start with the tip `moved` (m) by the first joint.
fn moved_start(scenario: &Scenario, model: &dyn Model, moved: f64) -> Initial {
    let mut initial = scenario.initial.clone();
    let at = |name: &str| initial.joints.iter().find(|(joint, _)| joint == name).map_or(0.0, |(_, q)| *q);
    let q: Vec<f64> = model.machine().joints.iter().map(|joint| at(&joint.name)).collect();
    let mut rates = vec![0.0; q.len()];
    rates[0] = 1.0;
    let [x, z] = model.tip_velocity(&q, &rates);
    let first = &model.machine().joints[0].name;
    initial
        .joints
        .iter_mut()
        .filter(|(joint, _)| joint == first)
        .for_each(|(_, q)| *q += moved / portable::hypot(x, z));
    initial
}
