//! The lane scheduler: cranes advance over one sample, each in steps of its own.
//!
//! A group has eight lanes. A lane steps one crane to the end of the sample and then loads the next waiting crane:
//! a crane that needs many steps delays no other crane, and no lane idles while cranes wait.

use super::command_path::{BatchCommandPath, Plan};
use super::kernel::{Group, StepKernel, StepResult, Trial, WIDTH};
use super::Status;
use crate::outcome::OutcomeKind;
use hydrocrane_plant::layout::MAX_JOINTS;

/// Share of a step by which what remains may be longer than whole steps: rounding must not add one.
const EVEN: f64 = 1e-6;
/// The finest and the shortest step, in units of the longest.
const FINEST: f64 = 1e-2;
const LEAST: f64 = 1e-3;
/// A step that led nowhere is tried again at most this long, in units of the one tried; from the finest on even shorter.
const AGAIN: f64 = 0.5;
const CLOSER: f64 = 0.25;
/// A crane whose steps are shorter than this, in units of the longest, is loaded first.
const SLOW: f64 = 0.3;

/// Sizes of steps, s.
#[derive(Debug, Clone, Copy)]
pub(super) struct Steps {
    pub longest: f64,
    /// Taken with whatever error, if they lead anywhere.
    pub finest: f64,
    /// Shorter ones are not tried.
    least: f64,
}

impl Steps {
    pub fn up_to(longest: f64) -> Self {
        Steps { longest, finest: FINEST * longest, least: LEAST * longest }
    }

    /// The equal step for what is `left`, at most `wanted`.
    fn portion(&self, left: f64, wanted: f64) -> f64 {
        left / (left / wanted.min(self.longest) - EVEN).ceil().max(1.0)
    }

    /// What to try after a step of size `h` that was not taken; `None` if nothing is left to try.
    fn again(&self, h: f64, growth: f64) -> Option<f64> {
        if h > self.finest {
            Some((h * growth.min(AGAIN)).max(self.finest))
        } else {
            (h > self.least).then_some(CLOSER * h)
        }
    }
}

/// Some groups of a batch.
pub(super) struct Block<'a> {
    /// Number of the first crane.
    pub first: usize,
    pub x: &'a mut [Group],
    pub payload: &'a [Group],
    /// Step sizes that the cranes want, s.
    pub wanted: &'a mut [Group],
    pub statuses: &'a mut [[Status; WIDTH]],
}

/// The crane that a lane steps.
#[derive(Debug, Clone, Copy)]
struct Lane {
    /// Counted within the block.
    crane: usize,
    stretch: usize,
    /// What remains of the stretch, s.
    left: f64,
    /// s
    wanted: f64,
}

/// The lanes of a group and what is needed to step them.
pub(super) struct LaneScheduler<'a> {
    step_kernel: Box<dyn StepKernel + 'a>,
    path: &'a BatchCommandPath,
    plan: &'a [Plan],
    steps: Steps,
    lanes: [Option<Lane>; WIDTH],
    trial: Trial,
    x: Vec<Group>,
}

impl<'a> LaneScheduler<'a> {
    pub fn new(
        step_kernel: Box<dyn StepKernel + 'a>,
        path: &'a BatchCommandPath,
        plan: &'a [Plan],
        steps: Steps,
        states: usize,
    ) -> Self {
        let trial = Trial { h: [steps.longest; WIDTH], spools: [[0.0; WIDTH]; MAX_JOINTS], payload: [0.0; WIDTH] };
        LaneScheduler { step_kernel, path, plan, steps, lanes: [None; WIDTH], trial, x: vec![[0.0; WIDTH]; states] }
    }

    /// Advances all running cranes of a block over the sample.
    pub fn advance(&mut self, block: &mut Block) {
        let mut waiting = block.in_order(self.steps.longest).into_iter();
        loop {
            let mut busy = false;
            for i in 0..WIDTH {
                if self.lanes[i].is_none() {
                    if let Some(crane) = waiting.next() {
                        self.load(block, i, crane);
                    }
                }
                busy |= self.set_step(i);
            }
            if !busy {
                return;
            }
            let result = self.step_kernel.attempt(&self.trial, &mut self.x);
            for i in 0..WIDTH {
                if let Some(lane) = self.lanes[i] {
                    self.lanes[i] = self.after_step(block, i, lane, &result);
                }
            }
        }
    }

    /// Loads a crane into lane `i`.
    fn load(&mut self, block: &Block, i: usize, crane: usize) {
        let (group, place) = (crane / WIDTH, crane % WIDTH);
        let states = self.x.len();
        for (x, from) in self.x.iter_mut().zip(&block.x[group * states..][..states]) {
            x[i] = from[place];
        }
        self.trial.payload[i] = block.payload[group][place];
        let lane = Lane { crane, stretch: 0, left: 0.0, wanted: block.wanted[group][place] };
        self.lanes[i] = Some(self.start_stretch(block, i, lane));
    }

    /// The lane at the start of a stretch: its spool commands are set.
    fn start_stretch(&mut self, block: &Block, i: usize, lane: Lane) -> Lane {
        let plan = &self.plan[lane.stretch];
        for c in 0..self.path.cylinders() {
            self.trial.spools[c][i] = self.path.at_spool(plan, block.first + lane.crane, c);
        }
        Lane { left: plan.length, ..lane }
    }

    /// Sets the size of the next step; whether there is one.
    fn set_step(&mut self, i: usize) -> bool {
        if let Some(lane) = self.lanes[i] {
            self.trial.h[i] = self.steps.portion(lane.left, lane.wanted);
        }
        self.lanes[i].is_some()
    }

    /// The lane after a trial; `None` where its crane has arrived or is lost.
    fn after_step(&mut self, block: &mut Block, i: usize, lane: Lane, result: &StepResult) -> Option<Lane> {
        let (h, growth) = (self.trial.h[i], result.growth[i]);
        let status = &mut block.statuses[lane.crane / WIDTH][lane.crane % WIDTH];
        if !result.taken[i] {
            if let Some(wanted) = self.steps.again(h, growth) {
                return Some(Lane { wanted, ..lane });
            }
            status.kind = if result.inside[i] { OutcomeKind::SolverFailed } else { OutcomeKind::StrokeLimit };
            self.store(block, i, lane);
            return None;
        }
        status.time += h;
        // A step cut short does not disprove the size that was wanted.
        let proven = if h < lane.wanted { lane.wanted } else { 0.0 };
        let wanted = (h * growth).max(proven).min(self.steps.longest);
        let lane = Lane { wanted, left: lane.left - h, ..lane };
        if lane.left > 0.0 {
            Some(lane)
        } else if lane.stretch + 1 < self.plan.len() {
            Some(self.start_stretch(block, i, Lane { stretch: lane.stretch + 1, ..lane }))
        } else {
            self.store(block, i, lane);
            None
        }
    }

    /// Stores the state of lane `i` back into its crane.
    fn store(&self, block: &mut Block, i: usize, lane: Lane) {
        let (group, place) = (lane.crane / WIDTH, lane.crane % WIDTH);
        let states = self.x.len();
        for (x, to) in self.x.iter().zip(&mut block.x[group * states..][..states]) {
            to[place] = x[i];
        }
        block.wanted[group][place] = lane.wanted;
    }
}

impl Block<'_> {
    /// The running cranes. Those that need many steps go first: otherwise the last of them would step in a group alone.
    fn in_order(&self, longest: f64) -> Vec<usize> {
        let (cranes, well) = (0..self.statuses.len() * WIDTH, OutcomeKind::Completed);
        let (mut order, mut quick) = (Vec::new(), Vec::new());
        for crane in cranes.filter(|c| self.statuses[c / WIDTH][c % WIDTH].kind == well) {
            let slow = self.wanted[crane / WIDTH][crane % WIDTH] < SLOW * longest;
            if slow { &mut order } else { &mut quick }.push(crane);
        }
        order.append(&mut quick);
        order
    }
}
