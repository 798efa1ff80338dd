//! What moves the spools in a stage: spool commands, or a controller with its model, sensors and sticks.

use super::{commands, AssembledStage, AssemblyError, OwnedDriver, Surroundings};
use crate::event_loop::warnings::without_sensors;
use crate::inputs::sensing::{SensorFault, SensorMode, Sensors};
use crate::inputs::stick::{StickKind, Sticks};
use crate::model::controllers::LEVER;
use crate::model::Model;
use crate::runs::sampled::SampledPlan;
use crate::warning::Warning;
use hydrocrane_control::interface::controller::{self, Controller};
use hydrocrane_machine::scenario::{burst_times, ControllerChoice, Goal, Interpolation, Scenario, Stage};
use hydrocrane_machine::{Machine, OverrideValue};
use std::sync::Arc;

/// One stage of a scenario until `end` (s), ready to run.
pub(super) fn stage(
    scenario: &Scenario,
    stage: Stage,
    end: f64,
    surroundings: &mut dyn Surroundings,
) -> Result<AssembledStage, AssemblyError> {
    let model = surroundings.machine(None, &stage.machine_overrides())?;
    let burst = |time: f64| {
        let then = scenario.with_hoses(Stage { from: time, ..stage.clone() });
        Ok((time, surroundings.machine(None, &then.machine_overrides())?))
    };
    // Builds for the smallest chains only refuse the machine of such a scenario before.
    let times =
        if cfg!(feature = "chains") { burst_times(&scenario.faults.bursts, stage.from, end) } else { Vec::new() };
    let changes = times.into_iter().map(burst).collect::<Result<_, AssemblyError>>()?;
    let Some(choice) = &stage.controller else {
        let driver = OwnedDriver::Commands(commands(&scenario.commands, model.as_ref())?);
        return Ok(AssembledStage { controller_model: model.clone(), driver, model, changes, stage });
    };
    let known = controller_model(choice, &stage, &model, surroundings)?;
    let controller = match choice.own {
        None => known.controller(&choice.name)?,
        Some(number) => surroundings.own_controller(number, &stage, &known).ok_or_else(|| {
            "your own controllers run in Python only: by `hc.simulate` or `hc.LiveSimulator`".to_string()
        })?,
    };
    let controller = if choice.monitored() { known.with_sensor_monitor(controller, choice.delay) } else { controller };
    let plan = plan(scenario, &stage, choice, model.as_ref())?;
    Ok(AssembledStage {
        controller_model: known,
        driver: OwnedDriver::Controller(controller, Box::new(plan)),
        model,
        changes,
        stage,
    })
}

/// The controller model of a stage.
fn controller_model(
    choice: &ControllerChoice,
    stage: &Stage,
    model: &Arc<dyn Model>,
    surroundings: &mut dyn Surroundings,
) -> Result<Arc<dyn Model>, AssemblyError> {
    let (source, own) = match &choice.other_model {
        Some((source, overrides)) => {
            let of_loop = stage.loop_overrides().into_iter().map(|(key, value)| (key, OverrideValue::Number(value)));
            (Some(source.as_str()), replaced(overrides, of_loop))
        }
        None if choice.model.is_empty() => return Ok(model.clone()),
        None => (None, replaced(&stage.machine_overrides(), choice.model.iter().cloned())),
    };
    let known = surroundings.machine(source, &own)?;
    if kinds(known.as_ref()) != kinds(model.as_ref()) {
        return Err(format!(
            "the machine of the controller model must have the joints of {}, {}; {} has {}",
            model.machine().name,
            joints(model.as_ref()),
            known.machine().name,
            joints(known.as_ref())
        )
        .into());
    }
    Ok(known)
}

/// `overrides` with `others`, which have priority.
fn replaced(
    overrides: &[(String, OverrideValue)],
    others: impl Iterator<Item = (String, OverrideValue)>,
) -> Vec<(String, OverrideValue)> {
    let mut all = overrides.to_vec();
    for (key, value) in others {
        all.retain(|(own, _)| *own != key);
        all.push((key, value));
    }
    all
}

fn kinds(model: &dyn Model) -> &[&'static str] {
    &model.layout().units[..model.layout().joints()]
}

fn joints(model: &dyn Model) -> String {
    let all = model.machine().joints.iter().zip(kinds(model));
    all.map(|(joint, unit)| format!("{} ({unit})", joint.name)).collect::<Vec<_>>().join(", ")
}

fn plan(
    scenario: &Scenario,
    stage: &Stage,
    choice: &ControllerChoice,
    model: &dyn Model,
) -> Result<SampledPlan, AssemblyError> {
    let sensors = Sensors::new(model, choice.sensors, scenario.seed, &scenario.faults.sensors)?;
    Ok(SampledPlan { sticks: sticks(scenario, stage, model.machine())?, sensors, delay: choice.delay })
}

/// The sticks of a stage (centred if it states none) and the goals of the tip.
fn sticks(scenario: &Scenario, stage: &Stage, machine: &Machine) -> Result<Sticks, String> {
    let of = |goal: &Goal| controller::Goal {
        place: goal.place,
        speed: goal.speed,
        share: 1.0,
        given: goal.time,
        until: goal.until.unwrap_or(f64::INFINITY),
    };
    let goals = scenario.goals.iter().map(of).collect();
    let mode = stage.stick_mode();
    let axes = if mode == StickKind::Tip { machine.tip_axes().len() } else { machine.cylinders.len() };
    let centred = Sticks { goals, ..Sticks::centred(mode, axes) };
    let Some(stick) = &stage.joystick else { return Ok(centred) };
    if stick.axes.len() > axes {
        return Err(format!(
            "the stick has an axis `slew`, and machine `{}` does not slew: no first joint turns all others, which move in one \
             plane, about the vertical axis; leave that axis out",
            machine.name
        ));
    }
    // An axis that is not stated stays centred.
    let deflection = |row: usize, axis: usize| stick.axes.get(axis).map_or(0.0, |axis| axis[row]);
    Ok(Sticks {
        times: stick.time.clone(),
        deflections: (0..stick.time.len()).flat_map(|row| (0..axes).map(move |axis| deflection(row, axis))).collect(),
        linear: stick.interpolation == Interpolation::Linear,
        dead_zone: stick.dead_zone,
        ramp: stick.ramp,
        precision: stick.precision.clone(),
        ..centred
    })
}

/// Signals that the controller of a stage reads with data-sheet sensors, and that no sensor of the machine measures.
pub(super) fn unmeasured(stage: &AssembledStage) -> Option<Warning> {
    let Stage { from, controller, .. } = &stage.stage;
    let reads = |choice: &&ControllerChoice| choice.sensors == SensorMode::DataSheet && choice.name != LEVER;
    let choice = controller.as_ref().filter(reads)?;
    let OwnedDriver::Controller(driver, _) = &stage.driver else { return None };
    without_sensors(
        stage.model.machine(),
        *from,
        driver.reads_pressures(),
        choice.own.is_none() && choice.name == "tip",
    )
}

/// Why the tip cannot go to one of the goals of `scenario`, if it cannot. `stages` are those before its end, in order of time.
pub(super) fn goal_fault(scenario: &Scenario, stages: &[AssembledStage]) -> Option<String> {
    let due = scenario.goals.iter().filter(|goal| goal.time < scenario.duration);
    due.filter_map(|goal| {
        let stage = stages.iter().rev().find(|stage| stage.stage.from <= goal.time)?;
        let why = match &stage.driver {
            OwnedDriver::Commands(_) => Some("spool commands move the crane then".to_string()),
            OwnedDriver::Controller(controller, _) => controller.refuses(goal.place),
        };
        Some(format!(
            "the tip cannot go to the goal {} at {} s: {}",
            controller::PlaceName(goal.place),
            goal.time,
            why?
        ))
    })
    .next()
}

/// Levers, all centred, for use while spool commands are repeated and after them.
pub(crate) fn levers(
    model: &dyn Model,
    sensor_faults: &[SensorFault],
) -> Result<(Box<dyn Controller>, SampledPlan), String> {
    let sensors = Sensors::new(model, SensorMode::Ideal, 0, sensor_faults)?;
    let sticks = Sticks::centred(StickKind::Lever, model.machine().cylinders.len());
    Ok((model.controller(LEVER)?, SampledPlan { sticks, sensors, delay: 0.0 }))
}
