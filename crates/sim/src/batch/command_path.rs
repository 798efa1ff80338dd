//! The command path of a batch: signal chain, limits and delays from commands to spools.

use crate::command_path::{at_spool, delay, follow};
use hydrocrane_lanes::{Group, WIDTH};
use hydrocrane_machine::model::Valve;
use hydrocrane_machine::Machine;
use hydrocrane_plant::layout::MAX_JOINTS;
use std::collections::VecDeque;

/// Rounding tolerance between a time of arrival and the present time.
const ROUNDING: f64 = 1e-9;

/// Commands that were sent and are still needed.
pub struct BatchCommandPath {
    valves: Vec<Valve>,
    delays: Vec<f64>,
    groups: usize,
    /// Newest first: one entry per sample with the commands of all groups, cylinder by cylinder.
    sent: VecDeque<Vec<Group>>,
    /// Number of samples whose delayed commands may still arrive.
    memory: usize,
    sample_time: f64,
}

/// A part of a sample in which no command arrives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// s
    pub length: f64,
    /// Age of the command at each spool, in samples.
    pub age: [usize; MAX_JOINTS],
}

impl BatchCommandPath {
    pub fn new(machine: &Machine, groups: usize, sample_time: f64) -> Self {
        let valves: Vec<Valve> = machine.cylinders.iter().map(|c| c.valve.clone()).collect();
        let delays: Vec<f64> = valves.iter().map(delay).collect();
        let longest = delays.iter().copied().fold(0.0, f64::max);
        let memory = 1 + (longest / sample_time - ROUNDING).ceil().max(0.0) as usize;
        let none = vec![[0.0; WIDTH]; groups * valves.len()];
        BatchCommandPath { valves, delays, groups, sent: vec![none; memory].into(), memory, sample_time }
    }

    /// Sends one row of commands (m) per crane.
    pub fn send(&mut self, commands: &[f64]) {
        let cylinders = self.valves.len();
        let mut sent = self.sent.pop_back().unwrap_or_default();
        sent.resize(self.groups * cylinders, [0.0; WIDTH]);
        let newest = self.sent.front();
        for (crane, row) in commands.chunks_exact(cylinders).enumerate() {
            for (c, (valve, u)) in self.valves.iter().zip(row).enumerate() {
                let (place, lane) = (crane / WIDTH * cylinders + c, crane % WIDTH);
                let before = newest.map_or(sent[place][lane], |newest| newest[place][lane]);
                sent[place][lane] = follow(&valve.command, before, at_spool(&valve.command, valve.stroke, *u));
            }
        }
        self.sent.push_front(sent);
    }

    /// Removes all commands that have not arrived at this crane.
    pub fn forget(&mut self, group: usize, lane: usize) {
        let cylinders = self.valves.len();
        for sent in &mut self.sent {
            sent[group * cylinders..][..cylinders].iter_mut().for_each(|lanes| lanes[lane] = 0.0);
        }
    }

    /// The parts of a sample.
    pub fn plan(&self) -> Vec<Plan> {
        // A command arrives after the whole samples of its delay and the remainder.
        let whole = |delay: f64| (delay / self.sample_time + ROUNDING).floor();
        let rest = |delay: f64| (delay - whole(delay) * self.sample_time).max(0.0);
        let mut breaks: Vec<f64> = self.delays.iter().map(|d| rest(*d)).chain([0.0, self.sample_time]).collect();
        breaks.sort_by(f64::total_cmp);
        breaks.dedup_by(|a, b| *a - *b <= ROUNDING * self.sample_time);
        let stretch = |ends: &[f64]| {
            let length = ends[1] - ends[0];
            let mut age = [0; MAX_JOINTS];
            for (age, delay) in age.iter_mut().zip(&self.delays) {
                let arrived = rest(*delay) <= ends[0] + ROUNDING * self.sample_time;
                *age = whole(*delay) as usize + usize::from(!arrived);
            }
            Plan { length, age }
        };
        breaks.windows(2).map(stretch).collect()
    }

    /// The command at a spool of a crane.
    pub fn at_spool(&self, plan: &Plan, crane: usize, cylinder: usize) -> f64 {
        let sent = &self.sent[plan.age[cylinder].min(self.memory - 1)];
        sent[crane / WIDTH * self.cylinders() + cylinder][crane % WIDTH]
    }

    pub fn cylinders(&self) -> usize {
        self.valves.len()
    }
}
