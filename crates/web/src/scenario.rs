//! A page's request as a scenario.

use crate::problem::Problem;
use crate::request::Request;
use hydrocrane_machine::scenario::{
    ControllerChoice, Faults, Initial, Interpolation, Joystick, Load, Pressures, Recorded, Scenario, SensorQuality,
    Solver, StickMode,
};
use hydrocrane_machine::{Machine, OverrideValue};
use hydrocrane_sim::assembly::RunSettings;

/// The step of a drive, s.
pub const TICK: f64 = 1e-3;

/// Options of every drive, without an end time.
pub const SETTINGS: RunSettings = RunSettings { ledger: true, max_steps: u64::MAX };

/// The one method of the page's core.
pub fn solver() -> Solver {
    Solver { method: "hc-rosenbrock-3".into(), rtol: 1e-4, atol: None, max_step: TICK, step: Some(TICK) }
}

impl Request {
    /// The request as a scenario that starts at the joint coordinates `q`, on `machine` with its `overrides`.
    pub fn scenario(
        &self,
        machine: &Machine,
        overrides: &[(String, OverrideValue)],
        q: &[f64],
    ) -> Result<Scenario, Problem> {
        let bursts = self.bursts()?;
        let mode = self.stick_mode();
        let axes = if mode == StickMode::Tip { 2 } else { machine.cylinders.len() };
        let joystick = Joystick {
            mode,
            time: Vec::new(),
            axes: vec![Vec::new(); axes],
            log: None,
            interpolation: Interpolation::Hold,
            dead_zone: self.dead_zone,
            full_speed: None,
            ramp: self.ramp,
            precision: Vec::new(),
        };
        let sensors = if self.real_sensors { SensorQuality::DataSheet } else { SensorQuality::Ideal };
        let controller = ControllerChoice { delay: self.delay, sensors, ..ControllerChoice::named(self.law()) };
        let joints = machine.joints.iter().zip(q).map(|(joint, q)| (joint.name.clone(), *q)).collect();
        Ok(Scenario {
            name: "drive".into(),
            title: format!("{} driven by hand", machine.name),
            // The user's machine file is expected beside the scenario.
            machine: if self.text.is_some() { format!("./{}", self.machine) } else { self.machine.clone() },
            overrides: overrides.to_vec(),
            load: Load { payload: self.payload, changes: Vec::new() },
            duration: f64::INFINITY,
            record_interval: 0.01,
            initial: Initial { joints, places: Vec::new(), pressures: Pressures::Equilibrium },
            commands: Vec::new(),
            supply: None,
            cylinders: machine.cylinders.iter().map(|cylinder| cylinder.name.clone()).collect(),
            controller: Some(controller),
            joystick: Some(joystick),
            goals: Vec::new(),
            phases: Vec::new(),
            faults: Faults { sensors: Vec::new(), bursts },
            solver: solver(),
            seed: self.seed,
            recorded: Recorded::default(),
            warnings: Vec::new(),
        })
    }
}
