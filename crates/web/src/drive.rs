//! A running drive: its settings, its replay, and changes of settings.

use crate::offered;
use crate::problem::{problem, Problem};
use crate::replay::{own_overrides, Replay};
use crate::request::Request;
use crate::scenario::SETTINGS;
use hydrocrane_machine::scenario::Scenario;
use hydrocrane_machine::Machine;
use hydrocrane_sim::assembly::{at_start, stages, AssembledStage, Assembly, Machines};
use hydrocrane_sim::{implausible, Model, Playback};
use std::collections::VecDeque;

pub use crate::scenario::TICK;

/// A running drive.
pub struct Drive {
    /// What the request asks for now.
    pub request: Request,
    pub playback: Playback,
    /// Start pose, rad or m.
    pub pose: Vec<f64>,
    /// The scenario of the start: its start, commands, sensor faults and seed apply throughout.
    pub scenario: Scenario,
    /// Whether it is the replay of a scenario.
    pub replayed: bool,
    /// Requests that are equivalent to the remaining stages of the replay.
    coming: VecDeque<Request>,
    pub ticks: u64,
    pub loads_sent: usize,
    /// Whether a phase of a replay has begun since the last call of [`crate::Cockpit::events`].
    pub changed: bool,
}

impl Drive {
    /// The machine at the begin of the present stage.
    pub fn model(&self) -> &dyn Model {
        self.playback.now().model.as_ref()
    }

    pub fn continued(&self) -> bool {
        self.playback.ended_stages() > 0
    }

    /// Ends a replay when the operator moves a stick, a load or a knob. After repeated spool commands the levers are
    /// active.
    pub fn take_over(&mut self) {
        self.coming.clear();
        self.changed |= self.playback.live.follows_commands();
        self.playback.take_over();
    }

    /// Advances to time `until` (s) through the phases of a replay; returns whether it continues.
    pub fn advance(&mut self, until: f64) -> bool {
        let before = self.playback.ended_stages();
        let goes_on = self.playback.advance(until);
        let begun = self.playback.ended_stages() - before;
        if let Some(request) = self.coming.drain(..begun.min(self.coming.len())).next_back() {
            (self.request, self.changed) = (request, true);
        }
        goes_on
    }

    /// Applies other settings at the next sample; returns whether that was possible.
    pub fn change(&mut self, request: &Request) -> Result<bool, Problem> {
        let (own, other) = (&self.request, request);
        if (&own.machine, &own.text) != (&other.machine, &other.text) || self.playback.live.outcome().is_some() {
            return Ok(false);
        }
        self.by_hand(Request { seed: own.seed, bursts: own.bursts.clone(), ..request.clone() })
    }

    fn by_hand(&mut self, request: Request) -> Result<bool, Problem> {
        let now = &self.playback.now().stage;
        let (machine, overrides) = request.machine(&own_overrides(&self.scenario, now))?;
        offered::check(&machine, &request.controller)?;
        let mut wanted = request.scenario(&machine, &overrides, &self.pose)?;
        wanted.faults.sensors.clone_from(&self.scenario.faults.sensors);
        // Settings without a knob remain those of the replay.
        if let (Some(own), Some(choice)) = (&now.controller, &mut wanted.controller) {
            choice.model.clone_from(&own.model);
            choice.monitor = own.monitor.filter(|_| own.name == choice.name);
        }
        let Some(stage) = assembled_stages(&wanted, &request)?.pop() else { return Ok(false) };
        if stage.model.layout().names != self.model().layout().names {
            return Ok(false);
        }
        self.coming.clear();
        let goes_on = self.playback.change(stage).map_err(Problem::plain)?;
        if goes_on {
            self.ticks = (self.playback.live.time() / TICK).round() as u64;
            self.request = request;
        }
        Ok(goes_on)
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
    let payload = request.payload.unwrap_or(machine.payload.mass).max(DRAWN_LOG);
    let pose = clear_of_the_ground(&request, stage.model.as_ref(), pose, payload);
    let scenario = request.scenario(&machine, &overrides, &pose)?;
    let assembly = at_start(&scenario, SETTINGS, vec![stage]).map_err(problem)?;
    started(scenario, assembly, VecDeque::from([request]), false)
}

/// A drive that repeats a scenario, from stage to stage.
pub fn repeat(replay: Replay) -> Result<Drive, Problem> {
    started(replay.scenario, replay.assembly, replay.requests, true)
}

fn started(
    scenario: Scenario,
    mut assembly: Assembly,
    mut coming: VecDeque<Request>,
    replayed: bool,
) -> Result<Drive, Problem> {
    let Some((first, request)) = assembly.stages.first().zip(coming.pop_front()) else {
        return Err(Problem::plain("there is no drive"));
    };
    let machine = first.model.machine();
    let pose = stated_pose(&scenario, machine, &assembly.x0);
    assembly.doubts = [implausible(&machine.warnings), implausible(&scenario.warnings), assembly.doubts].concat();
    let playback = Playback::new(assembly).map_err(Problem::plain)?;
    Ok(Drive { request, playback, pose, scenario, replayed, coming, ticks: 0, loads_sent: 0, changed: false })
}

/// The pose that the scenario states; `found`, where the crane stands, may rest on an end stop.
fn stated_pose(scenario: &Scenario, machine: &Machine, found: &[f64]) -> Vec<f64> {
    let joints = machine.joints.iter().zip(found);
    let stated = |name: &str| scenario.initial.joints.iter().find(|(joint, _)| joint == name).map(|(_, q)| *q);
    joints.map(|(joint, found)| stated(&joint.name).unwrap_or(*found)).collect()
}

/// kg; a tool that carries nothing is drawn as long as with this load, `LOG` in `cockpit/src/logs.ts`.
const DRAWN_LOG: f64 = 40.0;

/// If the request has no start pose, the first joint raises the default one until load and tool are clear of the ground.
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
