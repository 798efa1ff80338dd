//! A drive as a scenario file.

use crate::drive::{Drive, TICK};
use crate::problem::Problem;
use crate::replay::own_overrides;
use hydrocrane_machine::scenario::{Goal, Interpolation, Joystick, Load, Phase, Recorded, Scenario};
use hydrocrane_machine::{Machine, OverrideValue};
use hydrocrane_sim::{PlayedStage, Sticks};

/// The drive so far as text, for a replay.
pub fn scenario(drive: &Drive) -> Result<String, Problem> {
    let (live, end) = (&drive.playback.live, drive.playback.recorded_until());
    let parts: Vec<(&PlayedStage, &Sticks)> =
        drive.playback.played().filter(|(played, _)| played.stage.from < end).collect();
    let Some(((first, sticks), later)) = parts.split_first() else {
        return Err(Problem::plain("nothing has been driven yet"));
    };
    let overrides = |played: &PlayedStage| own_overrides(&drive.scenario, &played.stage);
    let (payload, loads) = live.loads();
    let mut phases = Vec::new();
    let mut before = *first;
    for (played, sticks) in later {
        phases.push(Phase {
            name: String::new(),
            time: played.stage.from,
            overrides: changed(overrides(played), &overrides(before)),
            controller: played.stage.controller.clone(),
            joystick: Some(joystick(sticks)),
        });
        before = played;
    }
    let begun = &drive.scenario;
    let request = &drive.request;
    let scenario = Scenario {
        name: "drive".into(),
        title: format!("{} driven by hand", first.model.machine().name),
        // The user's machine file is expected beside the scenario.
        machine: if request.text.is_some() { format!("./{}", request.machine) } else { request.machine.clone() },
        overrides: overrides(first),
        load: Load {
            payload: Some(payload),
            changes: loads.iter().filter(|load| load.time < end).map(|load| (load.time, load.mass[1])).collect(),
        },
        duration: end,
        controller: first.stage.controller.clone(),
        joystick: first.stage.controller.is_some().then(|| joystick(sticks)),
        goals: goals(live.sticks(), end),
        phases,
        recorded: Recorded {
            by: Some(env!("CARGO_PKG_VERSION").into()),
            on: request.text.is_some().then(|| request.plain_machine()).transpose()?.map(|own| own.contents()),
        },
        ..begun.clone()
    };
    let machines: Vec<&Machine> = parts.iter().map(|(played, _)| played.model.machine()).collect();
    let text = scenario.to_toml(&machines).map_err(|error| Problem::plain(error.0))?;
    debug_assert!(scenario.solver.step == Some(TICK), "a drive is repeated by the same steps");
    Ok(format!("# A drive in the cockpit, which `hydrocrane simulate` repeats.\n\n{text}"))
}

/// Those of the overrides that are not `before`.
fn changed(
    overrides: Vec<(String, OverrideValue)>,
    before: &[(String, OverrideValue)],
) -> Vec<(String, OverrideValue)> {
    overrides.into_iter().filter(|change| !before.contains(change)).collect()
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
