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
/// The same where the first run and a drive are some way apart: a drive that amplifies small differences amplifies the
/// adaptive run's own error, too.
pub const TIGHT: f64 = 1e-9;
/// Steps and processor time after which the drive is not judged.
const MOST_STEPS: u64 = 2_000_000;
const PATIENCE: Duration = Duration::from_secs(20);

/// The tip of a start moved by one joint, by this distance (m).
#[derive(Debug, Clone, Copy)]
pub struct Nudge {
    pub joint: usize,
    pub distance: f64,
}

/// A crane past its limits falls over its dead centre: what is small there grows without bound, in the adaptive run too.
const BEYOND: [&str; 2] = ["joint-outside-limits", "dead-centre-passed"];

/// The tip (x, z) at multiples of `interval` (s) from zero to the end of the saved drive, or until a joint leaves its limits;
/// an error where there is none. The drive starts with its tip moved by `nudge` alone.
pub fn tip(
    saved: &str,
    model: &dyn Model,
    interval: f64,
    tolerance: f64,
    nudge: Option<Nudge>,
) -> Result<Vec<[f64; 2]>, String> {
    let scenario = parse_scenario(saved, "drive.toml", &[]).map_err(|error| error.to_string())?;
    let step = Solver { method: "rodas5p".into(), rtol: tolerance, atol: None, max_step: 0.05, step: None };
    let scenario = Scenario { initial: start(&scenario, model, nudge), solver: step, ..scenario };
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
    Ok(rows.take_while(|(time, _)| **time < end).map(|(_, x)| x_and_z(model, &x[..n])).collect())
}

/// (x, z) of the tip in the inertial frame, m, also of a crane that slews.
pub fn x_and_z(model: &dyn Model, q: &[f64]) -> [f64; 2] {
    let [x, _, z] = model.tip(q);
    [x, z]
}

/// The drive's own start, or with the tip moved by `nudge`.
fn start(scenario: &Scenario, model: &dyn Model, nudge: Option<Nudge>) -> Initial {
    let mut initial = scenario.initial.clone();
    let Some(Nudge { joint, distance }) = nudge else { return initial };
    let at = |name: &str| initial.joints.iter().find(|(joint, _)| joint == name).map_or(0.0, |(_, q)| *q);
    let q: Vec<f64> = model.machine().joints.iter().map(|joint| at(&joint.name)).collect();
    let mut rates = vec![0.0; q.len()];
    rates[joint] = 1.0;
    let speed = model.tip_velocity(&q, &rates).into_iter().fold(0.0, portable::hypot);
    let moved = &model.machine().joints[joint].name;
    let found = initial.joints.iter_mut().filter(|(joint, _)| joint == moved);
    found.for_each(|(_, q)| *q += distance / speed);
    initial
}
