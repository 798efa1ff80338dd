//! A drive as a scenario file.

use crate::drive::{Drive, Setting, TICK};
use crate::problem::Problem;
use hydrocrane_machine::scenario::{Goal, Interpolation, Joystick, Phase, Scenario};
use hydrocrane_machine::{Machine, OverrideValue};
use hydrocrane_sim::Sticks;

/// The drive so far as text, for a replay.
pub fn scenario(drive: &Drive) -> Result<String, Problem> {
    let live = &drive.live;
    let end = if live.follows_commands() { live.time() } else { live.sampled_until() };
    if end <= 0.0 {
        return Err(Problem::plain("nothing has been driven yet"));
    }
    let earlier = drive.earlier.iter().map(|(setting, sticks)| (setting, sticks));
    let parts: Vec<(&Setting, &Sticks)> =
        earlier.chain([(&drive.now, live.sticks())]).filter(|(setting, _)| setting.from < end).collect();
    let Some(((first, sticks), later)) = parts.split_first() else {
        return Err(Problem::plain("nothing has been driven yet"));
    };
    let (payload, loads) = live.loads();
    let mut phases = Vec::new();
    let mut before = *first;
    for (setting, sticks) in later {
        phases.push(Phase {
            name: String::new(),
            time: setting.from,
            overrides: changed(setting, before),
            controller: setting.controller.clone(),
            joystick: Some(joystick(sticks)),
        });
        before = setting;
    }
    let begun = &drive.scenario;
    let request = &first.request;
    let scenario = Scenario {
        name: "drive".into(),
        title: format!("{} driven by hand", first.model.machine().name),
        // The user's machine file is expected beside the scenario.
        machine: if request.text.is_some() { format!("./{}", request.machine) } else { request.machine.clone() },
        overrides: first.overrides.clone(),
        payload: Some(payload),
        payload_changes: loads.iter().filter(|load| load.time < end).map(|load| (load.time, load.mass[1])).collect(),
        duration: end,
        controller: first.controller.clone(),
        joystick: first.controller.is_some().then(|| joystick(sticks)),
        goals: goals(live.sticks(), end),
        phases,
        recorded_by: Some(env!("CARGO_PKG_VERSION").into()),
        ..begun.clone()
    };
    let machines: Vec<&Machine> = parts.iter().map(|(setting, _)| setting.model.machine()).collect();
    let text = scenario.to_toml(&machines).map_err(|error| Problem::plain(error.0))?;
    debug_assert!(scenario.solver.step == Some(TICK), "a drive is repeated by the same steps");
    Ok(format!("# A drive in the cockpit, which `hydrocrane simulate` repeats.\n\n{text}"))
}

/// Changes relative to `before`.
fn changed(setting: &Setting, before: &Setting) -> Vec<(String, OverrideValue)> {
    setting.overrides.iter().filter(|change| !before.overrides.contains(change)).cloned().collect()
}

/// The goals that were given before `end` (s).
fn goals(sticks: &Sticks, end: f64) -> Vec<Goal> {
    let due = sticks.goals.iter().filter(|goal| goal.given < end);
    let until = |until: f64| (until < end).then_some(until);
    due.map(|goal| Goal { time: goal.given, place: goal.place, speed: goal.speed, until: until(goal.until) }).collect()
}

/// Record of the sticks. Their speed is among the overrides.
fn joystick(sticks: &Sticks) -> Joystick {
    let column = |axis: usize| sticks.deflections.iter().skip(axis).step_by(sticks.axes).copied().collect();
    Joystick {
        mode: sticks.kind,
        time: sticks.times.clone(),
        axes: (0..sticks.axes).map(column).collect(),
        log: None,
        interpolation: if sticks.linear { Interpolation::Linear } else { Interpolation::Hold },
        dead_zone: sticks.dead_zone,
        full_speed: None,
        ramp: sticks.ramp,
        precision: sticks.precision.clone(),
    }
}
