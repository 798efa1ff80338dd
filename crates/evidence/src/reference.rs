//! A saved drive simulated again by an adaptive method.

use crate::clock::thread_time;
use hydrocrane_machine::parse_scenario;
use hydrocrane_machine::scenario::{Interpolation, Joystick, Scenario, StickMode};
use hydrocrane_num::portable;
use hydrocrane_ode::Tolerances;
use hydrocrane_sim::{
    simulate_phases, Driver, EquilibriumMode, Model, OutcomeKind, Phase, RunOptions, SampledPlan, SensorMode, Sensors,
    StickKind, Sticks,
};
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
    let (Some(choice), Some(stick)) = (&scenario.controller, &scenario.joystick) else {
        return Err("the saved drive has no sticks".into());
    };
    let x0 = start(&scenario, model, moved)?;
    let mut controller = model.controller(&choice.name)?;
    if choice.name != "lever" {
        controller = model.with_sensor_monitor(controller, choice.delay);
    }
    let plan = SampledPlan {
        sticks: sticks(stick, model),
        sensors: Sensors::new(model, SensorMode::Ideal, scenario.seed, &[])?,
        delay: choice.delay,
    };
    let record: Vec<f64> = (0..).map(|i| f64::from(i) * interval).take_while(|t| *t <= scenario.duration).collect();
    let options = RunOptions {
        method: "rodas5p".into(),
        tolerances: Tolerances { relative: TOLERANCE, absolute: TOLERANCE, max_step: 0.05 },
        payload: scenario.payload.unwrap_or(0.0),
        payload_changes: Vec::new(),
        ledger: false,
        max_steps: MOST_STEPS,
    };
    let began = thread_time();
    let phase = Phase { from: 0.0, model, driver: Driver::Controller(controller.as_mut(), &plan) };
    let done = simulate_phases(&x0, scenario.duration, phase, Vec::new(), &record, &options, &mut |_| {
        thread_time() - began < PATIENCE
    });
    if done.run.outcome.kind != OutcomeKind::Completed {
        return Err(format!("{} at {} s", done.run.outcome.message, done.run.outcome.time));
    }
    let beyond = done.run.warnings.iter().filter(|warning| BEYOND.contains(&warning.kind));
    let end = beyond.map(|warning| warning.time).fold(f64::INFINITY, f64::min);
    let (all, n) = (model.layout().len(), model.layout().joints());
    let rows = done.run.times.iter().zip(done.run.states.chunks_exact(all));
    Ok(rows.take_while(|(time, _)| **time < end).map(|(_, x)| model.tip(&x[..n])).collect())
}

fn start(scenario: &Scenario, model: &dyn Model, moved: f64) -> Result<Vec<f64>, String> {
    let joints = &scenario.initial.joints;
    let at = |name: &str| joints.iter().find(|(joint, _)| joint == name).map_or(0.0, |(_, q)| *q);
    let mut q: Vec<f64> = model.machine().joints.iter().map(|joint| at(&joint.name)).collect();
    let mut rates = vec![0.0; q.len()];
    rates[0] = 1.0;
    let [x, z] = model.tip_velocity(&q, &rates);
    q[0] += moved / portable::hypot(x, z);
    let payload = scenario.payload.unwrap_or(0.0);
    model.equilibrium(&q, EquilibriumMode::Hold, payload).map_err(|error| error.to_string())
}

fn sticks(stick: &Joystick, model: &dyn Model) -> Sticks {
    let kind = if stick.mode == StickMode::Tip { StickKind::Tip } else { StickKind::Lever };
    Sticks {
        times: stick.time.clone(),
        deflections: (0..stick.time.len()).flat_map(|row| stick.axes.iter().map(move |axis| axis[row])).collect(),
        linear: stick.interpolation == Interpolation::Linear,
        dead_zone: stick.dead_zone,
        ramp: stick.ramp,
        ..Sticks::centred(kind, model.machine().cylinders.len())
    }
}
