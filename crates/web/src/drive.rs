//! A running drive: its settings, its replay, and changes of settings.

use crate::offered;
use crate::problem::{problem, Problem};
use crate::replay::{own_overrides, Replay};
use crate::request::Request;
use crate::scenario::SETTINGS;
use hydrocrane_machine::scenario::{ControllerChoice, Scenario};
use hydrocrane_machine::OverrideValue;
use hydrocrane_sim::assembly::{at_start, stages, AssembledStage, Assembly, Machines, OwnedDriver};
use hydrocrane_sim::{implausible, Live, Model, OwnedChanges, Sticks, Warning};
use std::collections::VecDeque;
use std::sync::Arc;

pub use crate::scenario::TICK;

/// Rounding allowed between the time of a drive and the end of its commands, s.
const ROUNDING: f64 = 1e-9;

/// A running drive.
pub struct Drive {
    pub now: Setting,
    /// Earlier settings of this drive, with the record of the sticks.
    pub earlier: Vec<(Setting, Sticks)>,
    pub live: Live,
    /// Start pose, rad or m.
    pub pose: Vec<f64>,
    /// The scenario of the start: its start, commands, sensor faults and seed apply throughout.
    pub scenario: Scenario,
    /// Whether it is the replay of a scenario.
    pub replayed: bool,
    /// Remaining stages of the replay.
    pub coming: VecDeque<(AssembledStage, Request)>,
    pub ticks: u64,
    pub loads_told: usize,
    /// Whether a phase of a replay has begun since the last call of [`crate::Cockpit::events`].
    pub changed: bool,
    /// The reason if the next phase of a replay cannot begin.
    pub stuck: Option<Problem>,
    /// Warnings on the start that were not yet sent.
    pub doubts: Vec<Warning>,
}

/// Settings from a time on.
pub struct Setting {
    /// s
    pub from: f64,
    pub request: Request,
    pub overrides: Vec<(String, OverrideValue)>,
    pub model: Arc<dyn Model>,
    /// `None`: spool commands against time move the crane.
    pub controller: Option<ControllerChoice>,
}

impl Setting {
    fn of(scenario: &Scenario, stage: &AssembledStage, request: Request) -> Self {
        Setting {
            from: stage.stage.from,
            overrides: own_overrides(scenario, &stage.stage),
            controller: stage.stage.controller.clone(),
            model: stage.model.clone(),
            request,
        }
    }
}

impl Drive {
    pub fn continued(&self) -> bool {
        !self.earlier.is_empty()
    }

    /// Ends a replay when the operator moves a stick, a load or a knob. After repeated spool commands the levers are
    /// active.
    pub fn take_over(&mut self) {
        self.live.take_over();
        self.live.end_phase_at(f64::INFINITY);
        self.coming.clear();
        if self.live.follows_commands() && self.stuck.is_none() && self.live.outcome().is_none() {
            let request = self.now.request.clone();
            self.stuck = self.by_hand(request).err();
            self.changed = true;
        }
    }

    /// Time at which the next phase of a replay begins, or spool commands end, s.
    pub fn next_phase(&self) -> f64 {
        let end = self.scenario.duration;
        match self.coming.front() {
            Some((stage, _)) => stage.stage.from,
            None if self.live.follows_commands() && self.live.time() < end - ROUNDING => end,
            None => f64::INFINITY,
        }
    }

    /// Advances to time `until` (s) through the phases of a replay; returns whether it continues.
    pub fn advance(&mut self, until: f64) -> bool {
        while self.next_phase() <= until && self.stuck.is_none() && self.live.advance(self.next_phase()).is_ok() {
            self.stuck = self.next_stage().err();
        }
        self.stuck.is_none() && self.live.advance(until).is_ok()
    }

    /// The next phase of a replay begins.
    fn next_stage(&mut self) -> Result<(), Problem> {
        if let Some((stage, request)) = self.coming.pop_front() {
            self.go_on(Setting::of(&self.scenario, &stage, request), stage.changes, stage.driver)?;
            self.changed = true;
        }
        self.live.end_phase_at(self.next_phase());
        Ok(())
    }

    /// Outcome of the drive, if it has ended: kind, time (s), message.
    pub fn ended(&self) -> Option<(&'static str, f64, String)> {
        let stuck = self.stuck.as_ref().map(|problem| {
            let reason = problem.message();
            let message = format!(
                "the next phase of the replay cannot begin: {reason}; move a stick before that time to take over"
            );
            ("bad-state", self.live.time(), message)
        });
        stuck.or_else(|| self.live.outcome().map(|o| (o.kind.name(), o.time, o.message.clone())))
    }

    fn go_on(&mut self, setting: Setting, changes: OwnedChanges, driver: OwnedDriver) -> Result<(), Problem> {
        let OwnedDriver::Controller(controller, plan) = driver else {
            return Err(Problem::plain("spool commands against time begin with the drive"));
        };
        let machines = (setting.model.clone(), changes);
        let sticks = self.live.go_on(machines, controller, &plan).map_err(Problem::plain)?;
        self.earlier.push((std::mem::replace(&mut self.now, setting), sticks));
        Ok(())
    }

    /// Applies other settings at the next sample; returns whether that was possible.
    pub fn change(&mut self, request: &Request) -> Result<bool, Problem> {
        let (own, other) = (&self.now.request, request);
        if (&own.machine, &own.text) != (&other.machine, &other.text) || self.live.outcome().is_some() {
            return Ok(false);
        }
        self.by_hand(Request { seed: own.seed, bursts: own.bursts.clone(), ..request.clone() })
    }

    fn by_hand(&mut self, request: Request) -> Result<bool, Problem> {
        let (machine, overrides) = request.machine(&self.now.overrides)?;
        offered::check(&machine, &request.controller)?;
        let faults = self.scenario.sensor_faults.clone();
        let mut wanted = Scenario { sensor_faults: faults, ..request.scenario(&machine, &overrides, &self.pose)? };
        // Settings without a knob remain those of the replay.
        if let (Some(own), Some(choice)) = (&self.now.controller, &mut wanted.controller) {
            choice.model.clone_from(&own.model);
            choice.monitor = own.monitor.filter(|_| own.name == choice.name);
        }
        let Some(stage) = assembled_stages(&wanted, &request)?.pop() else { return Ok(false) };
        if stage.model.layout().names != self.now.model.layout().names {
            return Ok(false);
        }
        self.live.take_over();
        self.live.end_phase_at(f64::INFINITY);
        self.coming.clear();
        let Ok(from) = self.live.finish_sample(self.now.from) else { return Ok(false) };
        self.ticks = (self.live.time() / TICK).round() as u64;
        let setting = Setting { from, ..Setting::of(&wanted, &stage, request) };
        self.go_on(setting, stage.changes, stage.driver)?;
        Ok(true)
    }
}

fn assembled_stages(scenario: &Scenario, request: &Request) -> Result<Vec<AssembledStage>, Problem> {
    let mut machines = Machines { machine: &request.machine, text: request.text.as_deref() };
    stages(scenario, &mut machines).map_err(problem)
}

/// A fresh drive from rest.
pub fn begin(request: Request) -> Result<Drive, Problem> {
    let (machine, overrides) = request.machine(&[])?;
    let stated = request.pose(&machine)?;
    let middle: Vec<f64> = stated.iter().map(|q| q.unwrap_or(0.0)).collect();
    let wanted = request.scenario(&machine, &overrides, &middle)?;
    let Some(stage) = assembled_stages(&wanted, &request)?.pop() else {
        return Err(Problem::plain("there is no drive"));
    };
    let limits = stage.model.joint_limits();
    let pose: Vec<f64> = stated.iter().zip(limits).map(|(q, l)| q.unwrap_or(0.5 * (l.lower + l.upper))).collect();
    let payload = request.payload.unwrap_or(machine.payload.mass);
    let pose = clear_of_the_ground(&request, stage.model.as_ref(), pose, payload);
    let scenario = request.scenario(&machine, &overrides, &pose)?;
    let assembly = at_start(&scenario, SETTINGS, vec![stage]).map_err(problem)?;
    started(scenario, assembly, vec![request], false)
}

/// A drive that repeats a scenario, from stage to stage.
pub fn repeat(replay: Replay) -> Result<Drive, Problem> {
    started(replay.scenario, replay.assembly, replay.requests, true)
}

fn started(scenario: Scenario, assembly: Assembly, requests: Vec<Request>, replayed: bool) -> Result<Drive, Problem> {
    let Assembly { x0, doubts, options, stages, .. } = assembly;
    let mut coming: VecDeque<_> = stages.into_iter().zip(requests).collect();
    let Some((first, request)) = coming.pop_front() else { return Err(Problem::plain("there is no drive")) };
    let now = Setting::of(&scenario, &first, request);
    let doubts = [implausible(&now.model.machine().warnings), implausible(&scenario.warnings), doubts].concat();
    let pose = x0[..now.model.layout().joints()].to_vec();
    let pose = stated_pose(&scenario, &now, pose);
    let live = first.live(&x0, options).map_err(Problem::plain)?;
    let mut drive = Drive {
        now,
        earlier: Vec::new(),
        live,
        pose,
        scenario,
        replayed,
        coming,
        ticks: 0,
        loads_told: 0,
        changed: false,
        stuck: None,
        doubts,
    };
    drive.live.end_phase_at(drive.next_phase());
    Ok(drive)
}

/// The pose that the scenario states; `found`, where the crane stands, may rest on an end stop.
fn stated_pose(scenario: &Scenario, now: &Setting, found: Vec<f64>) -> Vec<f64> {
    let joints = now.model.machine().joints.iter().zip(found);
    let stated = |name: &str| scenario.initial.joints.iter().find(|(joint, _)| joint == name).map(|(_, q)| *q);
    joints.map(|(joint, found)| stated(&joint.name).unwrap_or(found)).collect()
}

/// If the request has no start pose, the first joint raises the default one until the load is clear of the ground.
fn clear_of_the_ground(request: &Request, model: &dyn Model, pose: Vec<f64>, payload: f64) -> Vec<f64> {
    const PARTS: u32 = 50;
    let stated = request.joints.contains_key(&model.machine().joints[0].name);
    if stated || model.ground_energy(&pose, payload) == 0.0 {
        return pose;
    }
    let limits = &model.joint_limits()[0];
    let raised = |end: f64, part: u32| {
        let first = pose[0] + (end - pose[0]) * f64::from(part) / f64::from(PARTS + 1);
        [&[first], &pose[1..]].concat()
    };
    let tries = (1..=PARTS).flat_map(|part| [limits.upper, limits.lower].map(|end| raised(end, part)));
    tries.into_iter().find(|q| model.ground_energy(q, payload) == 0.0).unwrap_or_else(|| pose.clone())
}
