//! A drive under way: what is in force, its replay, and how it goes on under other settings.

use crate::friction_level;
use crate::offered;
use crate::problem::Problem;
use crate::replay::{Phase, Replay};
use crate::request::Request;
use hydrocrane_machine::{Machine, OverrideValue};
use hydrocrane_ode::Tolerances;
use hydrocrane_sim::controller::Controller;
use hydrocrane_sim::{
    build, implausible, moved_starts, BuildError, EquilibriumMode, Live, Model, RunOptions, SampledPlan, SensorMode,
    Sensors, StickKind, Sticks, Warning,
};
use std::sync::Arc;

/// The step of a drive, s.
pub const TICK: f64 = 1e-3;

/// A drive under way.
pub struct Drive {
    pub now: Setting,
    /// What was in force before on this drive, and what was done with the sticks under it.
    pub earlier: Vec<(Setting, Sticks)>,
    pub live: Live,
    /// Start pose, rad or m.
    pub pose: Vec<f64>,
    pub replay: Option<Replay>,
    pub ticks: u64,
    pub loads_told: usize,
    /// Whether a phase of a replay has begun since the last call of [`crate::Cockpit::events`].
    pub changed: bool,
    /// Why the next phase of a replay cannot begin.
    pub stuck: Option<Problem>,
    /// What makes the start doubtful, until it is told.
    pub doubts: Vec<Warning>,
}

/// What is in force from a time on.
pub struct Setting {
    /// s
    pub from: f64,
    pub request: Request,
    pub overrides: Vec<(String, OverrideValue)>,
    pub model: Arc<dyn Model>,
}

impl Drive {
    pub fn continued(&self) -> bool {
        !self.earlier.is_empty()
    }

    /// Whoever moves a stick, a load or a knob drives.
    pub fn take_over(&mut self) {
        self.live.take_over();
        self.live.end_phase_at(f64::INFINITY);
        if let Some(replay) = &mut self.replay {
            replay.phases.clear();
        }
    }

    /// When the next phase of a replay begins, s.
    pub fn next_phase(&self) -> f64 {
        self.replay.as_ref().and_then(|replay| replay.phases.front()).map_or(f64::INFINITY, |phase| phase.from)
    }

    /// Goes on to time `until` (s), from phase to phase of a replay; whether it goes on after that.
    pub fn advance(&mut self, until: f64) -> bool {
        while self.next_phase() <= until && self.stuck.is_none() && self.live.advance(self.next_phase()).is_ok() {
            self.stuck = self.next_stage().err();
        }
        self.stuck.is_none() && self.live.advance(until).is_ok()
    }

    /// The next phase of a replay begins.
    fn next_stage(&mut self) -> Result<(), Problem> {
        let Some(phase) = self.replay.as_mut().and_then(|replay| replay.phases.pop_front()) else { return Ok(()) };
        let (setting, _) = setting(friction_level::settled(phase.request.clone()), &self.now.overrides)?;
        self.go_on(Setting { from: phase.from, ..setting }, Some(&phase))?;
        self.live.end_phase_at(self.next_phase());
        self.changed = true;
        Ok(())
    }

    /// How the drive ended, if it has: kind, time (s), message.
    pub fn ended(&self) -> Option<(&'static str, f64, String)> {
        let stuck = self.stuck.as_ref().map(|problem| {
            let reason = problem.message();
            let message =
                format!("the next phase of the replay cannot begin: {reason}; move a stick before it and drive on");
            ("bad-state", self.live.time(), message)
        });
        stuck.or_else(|| self.live.outcome().map(|o| (o.kind.name(), o.time, o.message.clone())))
    }

    fn go_on(&mut self, setting: Setting, phase: Option<&Phase>) -> Result<(), Problem> {
        let (controller, plan) = surroundings(&setting, phase)?;
        let sticks = self.live.go_on(setting.model.clone(), controller, &plan).map_err(Problem::plain)?;
        self.earlier.push((std::mem::replace(&mut self.now, setting), sticks));
        Ok(())
    }

    /// Goes on under other settings by hand, at the next sample; whether that could be.
    pub fn change(&mut self, request: &Request) -> Result<bool, Problem> {
        let (own, other) = (&self.now.request, request);
        if (&own.machine, &own.text) != (&other.machine, &other.text) || self.live.outcome().is_some() {
            return Ok(false);
        }
        let request = Request { seed: own.seed, ..request.clone() };
        let (setting, machine) = setting(request, &self.now.overrides)?;
        offered::check(&machine, &setting.request.controller)?;
        if setting.model.layout().names != self.now.model.layout().names {
            return Ok(false);
        }
        self.take_over();
        let Ok(from) = self.live.finish_sample(self.now.from) else { return Ok(false) };
        self.ticks = (self.live.time() / TICK).round() as u64;
        self.go_on(Setting { from, ..setting }, None)?;
        Ok(true)
    }
}

/// A drive from rest, moved by a replay where there is one.
pub fn begin(request: Request, phase: Option<Phase>, replay: Option<Replay>) -> Result<Drive, Problem> {
    let (now, machine) = setting(request, &[])?;
    let payload = now.request.payload.unwrap_or(machine.payload.mass);
    let stated = now.request.pose(&machine)?;
    let limits = now.model.joint_limits();
    let pose: Vec<f64> = stated.iter().zip(limits).map(|(q, l)| q.unwrap_or(0.5 * (l.lower + l.upper))).collect();
    let pose = if replay.is_none() { clear_of_the_ground(&now, pose, payload) } else { pose };
    let at_rest = now.model.equilibrium(&pose, EquilibriumMode::Hold, payload);
    let x0 = at_rest.map_err(|error| Problem::plain(error.to_string()))?;
    let doubts = [implausible(&machine), moved_starts(now.model.as_ref(), &pose, &x0)].concat();
    let (controller, plan) = surroundings(&now, phase.as_ref())?;
    let options = RunOptions {
        method: "ros3l".into(),
        tolerances: Tolerances { relative: 1e-4, absolute: 1e-4, max_step: TICK },
        payload,
        payload_changes: replay.as_ref().map(|replay| replay.loads.clone()).unwrap_or_default(),
        ledger: true,
        max_steps: u64::MAX,
    };
    let live = Live::new(now.model.clone(), controller, &x0, &plan, options).map_err(Problem::plain)?;
    let mut drive = Drive {
        now,
        earlier: Vec::new(),
        live,
        pose,
        replay,
        ticks: 0,
        loads_told: 0,
        changed: false,
        stuck: None,
        doubts,
    };
    drive.live.end_phase_at(drive.next_phase());
    Ok(drive)
}

/// A start that the request leaves open is raised by the first joint until the load hangs clear of the ground.
fn clear_of_the_ground(now: &Setting, pose: Vec<f64>, payload: f64) -> Vec<f64> {
    const PARTS: u32 = 50;
    let stated = now.request.joints.contains_key(&now.model.machine().joints[0].name);
    if stated || now.model.ground_energy(&pose, payload) == 0.0 {
        return pose;
    }
    let limits = &now.model.joint_limits()[0];
    let raised = |end: f64, part: u32| {
        let first = pose[0] + (end - pose[0]) * f64::from(part) / f64::from(PARTS + 1);
        [&[first], &pose[1..]].concat()
    };
    let tries = (1..=PARTS).flat_map(|part| [limits.upper, limits.lower].map(|end| raised(end, part)));
    tries.into_iter().find(|q| now.model.ground_energy(q, payload) == 0.0).unwrap_or_else(|| pose.clone())
}

/// What a request puts in force from time zero on, after what was changed `before`.
fn setting(request: Request, before: &[(String, OverrideValue)]) -> Result<(Setting, Machine), Problem> {
    let (machine, overrides) = request.machine(before)?;
    let model = build(&machine).map_err(|error| {
        let slug = if matches!(error, BuildError::Chain(_)) { "chain" } else { "cannot-build" };
        Problem::named(slug, format!("{}: [cannot-build] {error}", request.machine))
    })?;
    Ok((Setting { from: 0.0, request, overrides, model }, machine))
}

/// Controller, sensors and sticks, as a scenario with the same settings has them.
fn surroundings(setting: &Setting, phase: Option<&Phase>) -> Result<(Box<dyn Controller>, SampledPlan), Problem> {
    let (request, model) = (&setting.request, &setting.model);
    let mut controller = model.controller(&request.controller).map_err(Problem::plain)?;
    if !request.lever() {
        controller = model.with_sensor_monitor(controller, request.delay);
    }
    let kind = if request.lever() { StickKind::Lever } else { StickKind::Tip };
    let centred = Sticks::centred(kind, model.machine().cylinders.len());
    let sticks = phase.map_or_else(|| centred.clone(), |phase| phase.sticks(centred.clone()));
    let mode = if request.real_sensors { SensorMode::DataSheet } else { SensorMode::Ideal };
    let plan = SampledPlan {
        sticks: Sticks { dead_zone: request.dead_zone, ramp: request.ramp, ..sticks },
        sensors: Sensors::new(model.as_ref(), mode, request.seed, &[]).map_err(Problem::plain)?,
        delay: request.delay,
    };
    Ok((controller, plan))
}
