//! A scenario as Python hands it over, and as it gets one that was read from a file.

use crate::handed::arrays::{line, Row};
use crate::handed::overrides::{overrides, pairs_of, value};
use crate::machines::sensors::{fault_entry, sensor_faults, sensor_mode, FaultEntry};
use hydrocrane_machine::scenario::{
    stated, Burst, BurstEntry, ControllerChoice, Faults, Goal, Initial, Interpolation, Joystick, Load, Phase,
    Pressures, Recorded, Scenario, SensorQuality, Solver, SpoolCommand, StickMode, SupplyPressure,
};
use hydrocrane_machine::{suggestion, TIP_AXES};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyList;

/// Key of the machine, field, value and unit of what the fields of a scenario state in the machine's place; `controller` is a name.
#[pyfunction]
pub fn stated_fields(
    controller: Option<&str>,
    payload: Option<f64>,
    period: Option<f64>,
    full_speed: Option<f64>,
) -> Vec<(String, String, f64, &'static str)> {
    let in_python = |table: &str, field: &str| match table {
        "joystick" => format!("joystick.{}", field.replace('-', "_")),
        _ => field.to_string(),
    };
    let found = stated(payload, controller, period, full_speed);
    found.into_iter().map(|s| (s.key, in_python(s.table, s.field), s.value, s.unit)).collect()
}

/// Why a value (numbers in `unit`) and the override `other` of `key`, which stand for the same, contradict each other.
#[pyfunction]
pub fn contradiction(
    one: &Bound<'_, PyAny>,
    unit: &str,
    key: &str,
    other: &Bound<'_, PyAny>,
) -> PyResult<Option<String>> {
    Ok(hydrocrane_machine::scenario::contradiction(&value(one)?, unit, key, &value(other)?))
}

/// Why no scenario may have this quantity (SI) at `key`, with the cure, or `None`; then what is unusual about it and the cure, or `None`.
#[pyfunction]
pub fn judged_quantity(key: &str, value: f64) -> (Option<String>, Option<(String, String)>) {
    match hydrocrane_machine::scenario::check_quantity(key, value) {
        Ok(unusual) => (None, unusual.map(|of| (format!("{} is {}", of.key, of.text), of.cure))),
        Err(error) => {
            (Some([Some(error.message()), error.cure()].into_iter().flatten().collect::<Vec<_>>().join("; ")), None)
        }
    }
}

/// The choices that are declared at a key of scenario files.
#[pyfunction]
pub fn scenario_choices(key: &str) -> &'static [&'static str] {
    hydrocrane_machine::scenario::choices(key)
}

/// How a run is integrated.
#[derive(FromPyObject, IntoPyObject)]
#[pyo3(from_item_all)]
pub struct SolverEntry {
    method: String,
    rtol: f64,
    atol: Option<f64>,
    max_step: f64,
    /// Of a method with even steps.
    step: Option<f64>,
}

/// A controller by name, or by the number of one of somebody's own.
#[derive(FromPyObject, IntoPyObject)]
#[pyo3(from_item_all)]
pub struct ControllerEntry<'py> {
    name: String,
    own: Option<usize>,
    period: Option<f64>,
    delay: f64,
    sensors: String,
    controller_model: Bound<'py, PyList>,
    /// Source and overrides of another machine.
    other_model: Option<(String, Bound<'py, PyList>)>,
    monitor: Option<bool>,
}

#[derive(FromPyObject, IntoPyObject)]
#[pyo3(from_item_all)]
pub struct JoystickEntry<'py> {
    mode: String,
    time: Row<'py>,
    /// Deflections by axis; those left out stay centred.
    axes: Vec<(String, Row<'py>)>,
    /// Of a file: the log that has them.
    log: Option<String>,
    linear: bool,
    dead_zone: f64,
    full_speed: Option<f64>,
    ramp: f64,
    /// Share of the full speed at each time; empty: all of it.
    precision: Row<'py>,
}

#[derive(FromPyObject, IntoPyObject)]
#[pyo3(from_item_all)]
pub struct PhaseEntry<'py> {
    time: f64,
    overrides: Bound<'py, PyList>,
    controller: Option<ControllerEntry<'py>>,
    joystick: Option<JoystickEntry<'py>>,
}

/// Name, title, machine and version of its recorder.
pub type Head = (String, String, String, String);
/// Time, place, and speed and end where they are stated.
pub type GoalEntry = (f64, [f64; 2], Option<f64>, Option<f64>);

/// Everything of a scenario but its names and its machine.
#[derive(FromPyObject, IntoPyObject)]
#[pyo3(from_item_all)]
pub struct ScenarioEntry<'py> {
    overrides: Bound<'py, PyList>,
    payload: Option<f64>,
    payload_changes: Vec<(f64, f64)>,
    duration: f64,
    record_interval: f64,
    joints: Vec<(String, f64)>,
    /// Of the joints in a file, in their order.
    places: Vec<String>,
    /// `None`: those that hold the crane at rest.
    pressures: Option<Vec<(String, [f64; 2])>>,
    /// Cylinder, times, spool positions, and whether to join them.
    commands: Vec<(String, Row<'py>, Row<'py>, bool)>,
    /// Times, pressures, and whether to join them.
    supply: Option<(Row<'py>, Row<'py>, bool)>,
    controller: Option<ControllerEntry<'py>>,
    joystick: Option<JoystickEntry<'py>>,
    goals: Vec<GoalEntry>,
    phases: Vec<PhaseEntry<'py>>,
    sensor_faults: Vec<FaultEntry>,
    bursts: Vec<BurstEntry>,
    solver: SolverEntry,
    seed: u64,
}

impl<'py> ScenarioEntry<'py> {
    /// Of a scenario that was read from a file.
    pub fn of(py: Python<'py>, s: &Scenario) -> PyResult<Self> {
        let numbers = |values: &[f64]| line(py, values.to_vec());
        let linear = |how: Interpolation| how == Interpolation::Linear;
        let stick = |stick: &Joystick| JoystickEntry::of(py, stick, &s.cylinders);
        let choice = |choice: &ControllerChoice| ControllerEntry::of(py, choice);
        let phase = |phase: &Phase| {
            Ok(PhaseEntry {
                time: phase.time,
                overrides: pairs_of(py, &phase.overrides)?,
                controller: phase.controller.as_ref().map(choice).transpose()?,
                joystick: phase.joystick.as_ref().map(stick),
            })
        };
        Ok(ScenarioEntry {
            overrides: pairs_of(py, &s.overrides)?,
            payload: s.load.payload,
            payload_changes: s.load.changes.clone(),
            duration: s.duration,
            record_interval: s.record_interval,
            joints: s.initial.joints.clone(),
            places: s.initial.places.clone(),
            pressures: match &s.initial.pressures {
                Pressures::Equilibrium => None,
                Pressures::Explicit(pairs) => Some(pairs.clone()),
            },
            commands: s
                .commands
                .iter()
                .map(|c| (c.cylinder.clone(), numbers(&c.time), numbers(&c.spool), linear(c.interpolation)))
                .collect(),
            supply: s.supply.as_ref().map(|of| (numbers(&of.time), numbers(&of.pressure), linear(of.interpolation))),
            controller: s.controller.as_ref().map(choice).transpose()?,
            joystick: s.joystick.as_ref().map(stick),
            goals: s.goals.iter().map(|goal| (goal.time, goal.place, goal.speed, goal.until)).collect(),
            phases: s.phases.iter().map(phase).collect::<PyResult<_>>()?,
            sensor_faults: s.faults.sensors.iter().map(fault_entry).collect(),
            bursts: s.faults.bursts.iter().map(Burst::entry).collect(),
            solver: SolverEntry {
                method: s.solver.method.clone(),
                rtol: s.solver.rtol,
                atol: s.solver.atol,
                max_step: s.solver.max_step,
                step: s.solver.step,
            },
            seed: s.seed,
        })
    }

    /// The scenario for a machine with these cylinders.
    pub fn scenario(&self, cylinders: &[&str]) -> PyResult<Scenario> {
        let pressures = self.pressures.clone().map_or(Pressures::Equilibrium, Pressures::Explicit);
        Ok(Scenario {
            name: String::new(),
            title: String::new(),
            machine: String::new(),
            overrides: overrides(&self.overrides)?,
            load: Load { payload: self.payload, changes: self.payload_changes.clone() },
            duration: self.duration,
            record_interval: self.record_interval,
            initial: Initial { joints: self.joints.clone(), places: self.places.clone(), pressures },
            commands: self.commands()?,
            supply: self.supply()?,
            cylinders: cylinders.iter().map(|name| name.to_string()).collect(),
            controller: self.controller.as_ref().map(ControllerEntry::choice).transpose()?,
            joystick: self.joystick.as_ref().map(|stick| stick.joystick(cylinders)).transpose()?,
            goals: self.goals.iter().map(|&(time, place, speed, until)| Goal { time, place, speed, until }).collect(),
            phases: self.phases.iter().map(|phase| phase.phase(cylinders)).collect::<PyResult<_>>()?,
            faults: Faults {
                sensors: sensor_faults(&self.sensor_faults)?,
                bursts: self.bursts.iter().map(Burst::of).collect::<Result<_, _>>().map_err(PyValueError::new_err)?,
            },
            solver: self.solver.solver(),
            seed: self.seed,
            recorded: Recorded::default(),
            warnings: Vec::new(),
        })
    }

    /// The measured pressure of the supply.
    pub fn supply(&self) -> PyResult<Option<SupplyPressure>> {
        let read = |(time, pressure, linear): &(Row, Row, bool)| {
            Ok(SupplyPressure {
                time: time.as_slice()?.to_vec(),
                pressure: pressure.as_slice()?.to_vec(),
                interpolation: interpolation(*linear),
            })
        };
        self.supply.as_ref().map(read).transpose()
    }

    /// Every lever that one of the joysticks has: names of cylinders, where no machine tells them.
    pub fn levers(&self) -> Vec<&str> {
        let sticks = self.joystick.iter().chain(self.phases.iter().filter_map(|phase| phase.joystick.as_ref()));
        sticks
            .filter(|stick| stick.mode != "tip")
            .flat_map(|stick| stick.axes.iter().map(|(axis, _)| axis.as_str()))
            .collect()
    }

    /// The spool commands.
    pub fn commands(&self) -> PyResult<Vec<SpoolCommand>> {
        let command = |(cylinder, time, spool, linear): &(String, Row, Row, bool)| {
            Ok(SpoolCommand {
                cylinder: cylinder.clone(),
                time: time.as_slice()?.to_vec(),
                spool: spool.as_slice()?.to_vec(),
                interpolation: interpolation(*linear),
            })
        };
        self.commands.iter().map(command).collect()
    }
}

impl SolverEntry {
    pub fn solver(&self) -> Solver {
        Solver {
            method: self.method.clone(),
            rtol: self.rtol,
            atol: self.atol,
            max_step: self.max_step,
            step: self.step,
        }
    }
}

impl<'py> ControllerEntry<'py> {
    fn of(py: Python<'py>, c: &ControllerChoice) -> PyResult<Self> {
        Ok(ControllerEntry {
            name: c.name.clone(),
            own: c.own,
            period: c.period,
            delay: c.delay,
            sensors: if c.sensors == SensorQuality::Ideal { "ideal" } else { "data-sheet" }.into(),
            controller_model: pairs_of(py, &c.model)?,
            other_model: None,
            monitor: c.monitor,
        })
    }

    fn choice(&self) -> PyResult<ControllerChoice> {
        let other = |(source, pairs): &(String, Bound<PyList>)| Ok::<_, PyErr>((source.clone(), overrides(pairs)?));
        Ok(ControllerChoice {
            name: self.name.clone(),
            period: self.period,
            delay: self.delay,
            sensors: sensor_mode(&self.sensors)?,
            model: overrides(&self.controller_model)?,
            other_model: self.other_model.as_ref().map(other).transpose()?,
            monitor: self.monitor,
            own: self.own,
        })
    }
}

impl<'py> JoystickEntry<'py> {
    fn of(py: Python<'py>, stick: &Joystick, cylinders: &[String]) -> Self {
        let names: Vec<String> = match stick.mode {
            StickMode::Tip => TIP_AXES.map(str::to_string).to_vec(),
            _ => cylinders.to_vec(),
        };
        JoystickEntry {
            mode: stick.mode.name().into(),
            time: line(py, stick.time.clone()),
            axes: names.into_iter().zip(stick.axes.iter().map(|axis| line(py, axis.clone()))).collect(),
            log: stick.log.clone(),
            linear: stick.interpolation == Interpolation::Linear,
            dead_zone: stick.dead_zone,
            full_speed: stick.full_speed,
            ramp: stick.ramp,
            precision: line(py, stick.precision.clone()),
        }
    }

    fn joystick(&self, cylinders: &[&str]) -> PyResult<Joystick> {
        let (mode, names) = match self.mode.as_str() {
            "tip" if self.axes.iter().any(|(axis, _)| axis == TIP_AXES[2]) => (StickMode::Tip, &TIP_AXES[..]),
            "tip" => (StickMode::Tip, &TIP_AXES[..2]),
            "height" => (StickMode::Height, cylinders),
            _ => (StickMode::Lever, cylinders),
        };
        if let Some((axis, _)) = self.axes.iter().find(|(axis, _)| !names.contains(&axis.as_str())) {
            let near = suggestion(axis, names.iter().copied());
            return Err(PyValueError::new_err(format!("unknown stick axis `{axis}`; {near}")));
        }
        let time = self.time.as_slice()?.to_vec();
        let column = |name: &&str| match self.axes.iter().find(|(axis, _)| axis == name) {
            Some((_, values)) => Ok::<_, PyErr>(values.as_slice()?.to_vec()),
            None => Ok(vec![0.0; time.len()]),
        };
        Ok(Joystick {
            mode,
            axes: names.iter().map(column).collect::<PyResult<_>>()?,
            time,
            log: None,
            interpolation: interpolation(self.linear),
            dead_zone: self.dead_zone,
            full_speed: self.full_speed,
            ramp: self.ramp,
            precision: self.precision.as_slice()?.to_vec(),
        })
    }
}

impl PhaseEntry<'_> {
    fn phase(&self, cylinders: &[&str]) -> PyResult<Phase> {
        Ok(Phase {
            name: String::new(),
            time: self.time,
            overrides: overrides(&self.overrides)?,
            controller: self.controller.as_ref().map(ControllerEntry::choice).transpose()?,
            joystick: self.joystick.as_ref().map(|stick| stick.joystick(cylinders)).transpose()?,
        })
    }
}

fn interpolation(linear: bool) -> Interpolation {
    if linear {
        Interpolation::Linear
    } else {
        Interpolation::Hold
    }
}
