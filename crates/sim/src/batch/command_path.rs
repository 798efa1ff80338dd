//! The command path of a batch: signal chain, limits and delays from commands to spools.

use crate::command_path::{at_spool, delay, follow};
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
    /// Of each crane; cranes with the same valves share them.
    sections: Vec<Arc<Sections>>,
    cylinders: usize,
    groups: usize,
    /// Newest first: one entry per sample with the commands of all groups, cylinder by cylinder.
    sent: VecDeque<Vec<Group>>,
    sample_time: f64,
}

/// The valves of a crane.
#[derive(Debug, PartialEq)]
struct Sections {
    /// Signal chain and spool stroke (m) by cylinder.
    valves: Vec<(SignalChain, f64)>,
    /// The parts of a sample.
    plan: Vec<Plan>,
    /// Number of samples whose delayed commands may still arrive.
    memory: usize,
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
    /// Of cranes that all are `machine`.
    pub fn new(machine: &Machine, cranes: usize, sample_time: f64) -> Self {
        let sections = Arc::new(Sections::new(machine, sample_time));
        let (cylinders, groups) = (sections.valves.len(), cranes.div_ceil(WIDTH));
        let mut path = BatchCommandPath { sections: Vec::new(), cylinders, groups, sent: VecDeque::new(), sample_time };
        path.remember(sections.memory);
        path.sections = vec![sections; cranes];
        path
    }

    /// Keeps the commands of at least so many samples.
    fn remember(&mut self, samples: usize) {
        let none = vec![[0.0; WIDTH]; self.groups * self.cylinders];
        self.sent.resize(self.sent.len().max(samples), none);
    }

    /// Gives a crane the valves of `machine`, with no command on its way.
    pub fn begin(&mut self, crane: usize, machine: &Machine) {
        let sections = Sections::new(machine, self.sample_time);
        self.remember(sections.memory);
        if *self.sections[crane] != sections {
            self.sections[crane] = Arc::new(sections);
        }
        let (first, lane) = (crane / WIDTH * self.cylinders, crane % WIDTH);
        for sent in &mut self.sent {
            sent[first..][..self.cylinders].iter_mut().for_each(|lanes| lanes[lane] = 0.0);
        }
    }

    /// Sends one row of commands (m) per crane.
    pub fn send(&mut self, commands: &[f64]) {
        let cylinders = self.cylinders;
        let mut sent = self.sent.pop_back().unwrap_or_default();
        sent.resize(self.groups * cylinders, [0.0; WIDTH]);
        let newest = self.sent.front();
        for (crane, (row, sections)) in commands.chunks_exact(cylinders).zip(&self.sections).enumerate() {
            for (c, ((chain, stroke), u)) in sections.valves.iter().zip(row).enumerate() {
                let (place, lane) = (crane / WIDTH * cylinders + c, crane % WIDTH);
                let before = newest.map_or(sent[place][lane], |newest| newest[place][lane]);
                sent[place][lane] = follow(chain, before, at_spool(chain, *stroke, *u));
            }
        }
        self.sent.push_front(sent);
    }

    /// The parts of a sample of a crane.
    pub fn plan(&self, crane: usize) -> &[Plan] {
        &self.sections[crane].plan
    }

    /// The command at a spool of a crane.
    pub fn at_spool(&self, plan: &Plan, crane: usize, cylinder: usize) -> f64 {
        let sent = &self.sent[plan.age[cylinder].min(self.sections[crane].memory - 1)];
        sent[crane / WIDTH * self.cylinders + cylinder][crane % WIDTH]
    }

    pub fn cylinders(&self) -> usize {
        self.cylinders
    }
}

impl Sections {
    fn new(machine: &Machine, sample_time: f64) -> Self {
        let valves = || machine.cylinders.iter().map(|c| &c.valve);
        let delays: Vec<f64> = valves().map(delay).collect();
        let longest = delays.iter().copied().fold(0.0, f64::max);
        let memory = 1 + (longest / sample_time - ROUNDING).ceil().max(0.0) as usize;
        let valves = valves().map(|valve| (valve.command, valve.stroke)).collect();
        Sections { valves, plan: plan(&delays, sample_time), memory }
    }
}

/// The parts of a sample, divided where delayed commands arrive.
fn plan(delays: &[f64], sample_time: f64) -> Vec<Plan> {
    // A command arrives after the whole samples of its delay and the remainder.
    let whole = |delay: f64| (delay / sample_time + ROUNDING).floor();
    let rest = |delay: f64| (delay - whole(delay) * sample_time).max(0.0);
    let mut breaks: Vec<f64> = delays.iter().map(|d| rest(*d)).chain([0.0, sample_time]).collect();
    breaks.sort_by(f64::total_cmp);
    breaks.dedup_by(|a, b| *a - *b <= ROUNDING * sample_time);
    let stretch = |ends: &[f64]| {
        let length = ends[1] - ends[0];
        let mut age = [0; MAX_JOINTS];
        for (age, delay) in age.iter_mut().zip(delays) {
            let arrived = rest(*delay) <= ends[0] + ROUNDING * sample_time;
            *age = whole(*delay) as usize + usize::from(!arrived);
        }
        Plan { length, age }
    };
    breaks.windows(2).map(stretch).collect()
}
