//! The command path of a batch: signal chain, limits and delays from commands to spools.

use crate::inputs::command_path::{astray, at_spool, delay, follow, longest_delay};
use crate::warning::Warning;
use hydrocrane_lanes::{Group, WIDTH};
use hydrocrane_machine::model::SignalChain;
use hydrocrane_machine::Machine;
use hydrocrane_plant::layout::MAX_JOINTS;
use std::collections::VecDeque;
use std::sync::Arc;

/// Rounding tolerance between a time of arrival and the present time.
const ROUNDING: f64 = 1e-9;

/// Commands that were sent and are still needed.
pub struct BatchCommandPath {
    /// Signal chain and spool stroke (m) by cylinder: one while all cranes have the same, else one for each crane.
    valves: Vec<Vec<(SignalChain, f64)>>,
    /// The parts of a sample of each crane; cranes with the same delays share them.
    plans: Vec<Arc<[Plan]>>,
    groups: usize,
    /// Newest first: one entry per sample with the commands of all groups, cylinder by cylinder.
    sent: VecDeque<Vec<Group>>,
    sample_time: f64,
    /// Of the cylinders.
    names: Vec<String>,
    /// The first crane, since its reset, that got a command far beyond the stroke of a spool.
    astray: Option<(usize, Warning)>,
}

/// A part of a sample in which no command arrives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// s
    pub length: f64,
    /// Age of the command at each spool, in samples.
    pub age: [u32; MAX_JOINTS],
}

impl BatchCommandPath {
    /// Of cranes that all are `machine`.
    pub fn new(machine: &Machine, cranes: usize, sample_time: f64) -> Self {
        let valves = machine.cylinders.iter().map(|c| vec![(c.valve.command, c.valve.stroke)]).collect();
        let plans = vec![plan(machine, sample_time).into(); cranes];
        let groups = cranes.div_ceil(WIDTH);
        let names = machine.cylinders.iter().map(|c| c.name.clone()).collect();
        let mut path =
            BatchCommandPath { valves, plans, groups, sent: VecDeque::new(), sample_time, names, astray: None };
        path.remember(machine);
        path
    }

    /// Keeps the commands of as many samples as may still arrive at the spools of `machine`.
    fn remember(&mut self, machine: &Machine) {
        let none = vec![[0.0; WIDTH]; self.groups * self.cylinders()];
        self.sent.resize(self.sent.len().max(memory(machine, self.sample_time)), none);
    }

    /// Gives a crane the valves of `machine`, with no command on its way.
    pub fn begin(&mut self, crane: usize, machine: &Machine) {
        self.remember(machine);
        for (valves, cylinder) in self.valves.iter_mut().zip(&machine.cylinders) {
            let own = (cylinder.valve.command, cylinder.valve.stroke);
            if valves[own_or_common(valves, crane)] != own {
                if valves.len() == 1 {
                    *valves = vec![valves[0]; self.plans.len()];
                }
                valves[crane] = own;
            }
        }
        let plan = plan(machine, self.sample_time);
        if *self.plans[crane] != plan {
            let beside = &self.plans[crane.saturating_sub(1)];
            self.plans[crane] = if **beside == plan { beside.clone() } else { plan.into() };
        }
        self.astray.take_if(|(astray, _)| *astray == crane);
        let (first, lane) = (crane / WIDTH * self.cylinders(), crane % WIDTH);
        for sent in &mut self.sent {
            sent[first..][..self.valves.len()].iter_mut().for_each(|lanes| lanes[lane] = 0.0);
        }
    }

    /// Sends one row of commands (m) per crane.
    pub fn send(&mut self, commands: &[f64]) {
        let cylinders = self.cylinders();
        let mut sent = self.sent.pop_back().unwrap_or_default();
        sent.resize(self.groups * cylinders, [0.0; WIDTH]);
        let newest = self.sent.front();
        for (crane, row) in commands.chunks_exact(cylinders).enumerate() {
            for (c, (valves, u)) in self.valves.iter().zip(row).enumerate() {
                let (chain, stroke) = &valves[own_or_common(valves, crane)];
                if self.astray.is_none() {
                    self.astray = astray(0.0, &self.names[c], *stroke, *u).map(|warning| (crane, warning));
                }
                let (place, lane) = (crane / WIDTH * cylinders + c, crane % WIDTH);
                let before = newest.map_or(sent[place][lane], |newest| newest[place][lane]);
                sent[place][lane] = follow(chain, before, at_spool(chain, *stroke, *u));
            }
        }
        self.sent.push_front(sent);
    }

    /// The first crane that got a command far beyond the stroke of a spool since its reset, and its warning.
    pub fn astray(&self) -> Option<&(usize, Warning)> {
        self.astray.as_ref()
    }

    /// The parts of a sample of a crane.
    pub fn plan(&self, crane: usize) -> &[Plan] {
        &self.plans[crane]
    }

    /// The command at a spool of a crane.
    pub fn at_spool(&self, plan: &Plan, crane: usize, cylinder: usize) -> f64 {
        self.sent[plan.age[cylinder] as usize][crane / WIDTH * self.cylinders() + cylinder][crane % WIDTH]
    }

    pub fn cylinders(&self) -> usize {
        self.valves.len()
    }
}

/// Where a crane's entry stands among those of all, or the one that they have in common.
fn own_or_common<T>(entries: &[T], crane: usize) -> usize {
    if entries.len() == 1 {
        0
    } else {
        crane
    }
}

/// Number of samples whose delayed commands may still arrive.
fn memory(machine: &Machine, sample_time: f64) -> usize {
    1 + (longest_delay(machine) / sample_time - ROUNDING).ceil().max(0.0) as usize
}

/// The parts of a sample, divided where delayed commands arrive.
fn plan(machine: &Machine, sample_time: f64) -> Vec<Plan> {
    let (delays, oldest) = (machine.cylinders.iter().map(|c| delay(&c.valve)), memory(machine, sample_time) - 1);
    let delays: Vec<f64> = delays.collect();
    // A command arrives after the whole samples of its delay and the remainder.
    let whole = |delay: f64| (delay / sample_time + ROUNDING).floor();
    let rest = |delay: f64| (delay - whole(delay) * sample_time).max(0.0);
    let mut breaks: Vec<f64> = delays.iter().map(|d| rest(*d)).chain([0.0, sample_time]).collect();
    breaks.sort_by(f64::total_cmp);
    breaks.dedup_by(|a, b| *a - *b <= ROUNDING * sample_time);
    let stretch = |ends: &[f64]| {
        let length = ends[1] - ends[0];
        let mut age = [0; MAX_JOINTS];
        for (age, delay) in age.iter_mut().zip(&delays) {
            let arrived = rest(*delay) <= ends[0] + ROUNDING * sample_time;
            *age = (whole(*delay) as usize + usize::from(!arrived)).min(oldest) as u32;
        }
        Plan { length, age }
    };
    breaks.windows(2).map(stretch).collect()
}
