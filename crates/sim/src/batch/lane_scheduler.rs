//! The lane scheduler: cranes advance over one sample, each with its own step sizes.
//!
//! A register has up to eight lanes. A lane steps one crane to the end of the sample and then loads the next waiting crane:
//! a crane that needs many steps delays no other crane, and no lane idles while cranes wait.

use super::command_path::BatchCommandPath;
use super::own_numbers::OwnNumbers;
use super::Status;
use crate::outcome::OutcomeKind;
use hydrocrane_lanes::{Demand, Group, Needed, StepKernel, StepResult, Trial, WIDTH};
use hydrocrane_ode::step_size::{equal_part, longest_part};
use hydrocrane_plant::layout::MAX_JOINTS;
use hydrocrane_plant::precision::Precision;

/// The finest step, in units of the longest, and the same where laws jump: there no step is short enough.
const FINEST: f64 = 1e-4;
const FINEST_WITH_JUMPS: f64 = 1e-2;
/// The shortest step, in units of the finest.
const LEAST: f64 = 0.1;
/// Error of a finest step, relative to its tolerance, above which the crane is lost.
const HOPELESS: f64 = 100.0;
/// Number of trials per longest step after which a crane is lost, so that a sample takes some milliseconds at most.
const MOST_TRIALS: f64 = 4096.0;
/// Largest size of the next trial after a failed step, in units of that step; below the finest size even smaller.
const AGAIN: f64 = 0.5;
const CLOSER: f64 = 0.25;
/// A crane whose steps are shorter than this, in units of the longest, is loaded first.
const SLOW: f64 = 0.3;

/// Sizes of steps, s.
#[derive(Debug, Clone, Copy)]
pub(super) struct Steps {
    pub longest: f64,
    finest: f64,
    /// Shorter steps are not tried.
    least: f64,
    /// Whether laws jump.
    jumps: bool,
}

impl Steps {
    pub fn up_to(longest: f64, jumps: bool) -> Self {
        let finest = longest * if jumps { FINEST_WITH_JUMPS } else { FINEST };
        Steps { longest, finest, least: LEAST * finest, jumps }
    }

    /// When a step is accepted.
    pub fn demand(&self, precision: Precision) -> Demand {
        let hopeless = if self.jumps { f64::INFINITY } else { HOPELESS * HOPELESS };
        Demand { precision, finest: self.accepted(), hopeless }
    }

    /// Steps up to this size are accepted with a larger error, if the new state is admissible, s.
    fn accepted(&self) -> f64 {
        longest_part(self.finest)
    }

    /// Size of the next trial after a rejected step of size `h`; `None` if there is none.
    fn again(&self, h: f64, growth: f64) -> Option<f64> {
        if h > self.accepted() {
            Some((h * growth.min(AGAIN)).max(self.finest))
        } else {
            (h > self.least).then_some(CLOSER * h)
        }
    }

    /// Size wanted after an accepted step of size `h`. A step that was cut short gives no reason to reduce the `wanted`
    /// size, and one that was accepted with any error gives none to go below the finest.
    fn next(&self, h: f64, growth: f64, wanted: f64) -> f64 {
        let proven = if h < wanted { wanted } else { self.finest };
        (h * growth).max(proven).min(self.longest)
    }

    /// Number of trials within `span` (s) after which a crane is lost.
    fn budget(&self, span: f64) -> u32 {
        (MOST_TRIALS * (span / self.longest).ceil()).min(f64::from(u32::MAX)) as u32
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
    /// Remainder of this part of the sample, s.
    left: f64,
    /// s
    wanted: f64,
    /// Number of trials that are left within the sample.
    trials: u32,
}

/// The lanes of a group with their work space.
pub(super) struct LaneScheduler<'a> {
    step_kernel: &'a mut dyn StepKernel,
    path: &'a BatchCommandPath,
    own: &'a OwnNumbers,
    steps: Steps,
    lanes: [Option<Lane>; WIDTH],
    trial: Trial,
    x: Vec<Group>,
}

impl<'a> LaneScheduler<'a> {
    pub fn new(
        step_kernel: &'a mut dyn StepKernel,
        path: &'a BatchCommandPath,
        own: &'a OwnNumbers,
        steps: Steps,
        states: usize,
    ) -> Self {
        let trial = Trial { h: [steps.longest; WIDTH], spools: [[0.0; WIDTH]; MAX_JOINTS], payload: [0.0; WIDTH] };
        LaneScheduler { step_kernel, path, own, steps, lanes: [None; WIDTH], trial, x: vec![[0.0; WIDTH]; states] }
    }

    /// Advances all running cranes of a block over the sample.
    pub fn advance(&mut self, block: &mut Block) {
        let mut waiting = block.in_order(self.steps.longest).into_iter();
        loop {
            let mut busy = false;
            let together = self.load_together(block, waiting.as_slice());
            for i in 0..self.step_kernel.lanes() {
                if self.lanes[i].is_none() {
                    if let Some(crane) = waiting.next() {
                        if !together {
                            self.step_kernel.load(i, self.own.of(block.first + crane), crane % WIDTH);
                        }
                        self.load(block, i, crane);
                    }
                }
                busy |= self.set_step(i);
            }
            if !busy {
                return;
            }
            let result = self.step_kernel.attempt(&self.trial, &mut self.x);
            for i in 0..self.step_kernel.lanes() {
                if let Some(lane) = self.lanes[i] {
                    self.lanes[i] = self.after_step(block, i, lane, &result);
                }
            }
        }
    }

    /// If no lane is busy and the next cranes stand side by side, gives their own numbers to all lanes at once.
    fn load_together(&mut self, block: &Block, waiting: &[usize]) -> bool {
        let count = self.step_kernel.lanes();
        let Some(next) = waiting.get(..count) else { return false };
        let side_by_side = next[0] % count == 0 && next.iter().zip(next[0]..).all(|(crane, place)| *crane == place);
        if !side_by_side || self.lanes.iter().any(Option::is_some) {
            return false;
        }
        self.step_kernel.load_all(self.own.of(block.first + next[0]), next[0] % WIDTH, Needed::All);
        true
    }

    /// Loads a crane but for its own numbers into lane `i`.
    fn load(&mut self, block: &Block, i: usize, crane: usize) {
        let (group, place) = (crane / WIDTH, crane % WIDTH);
        let states = self.x.len();
        for (x, from) in self.x.iter_mut().zip(&block.x[group * states..][..states]) {
            x[i] = from[place];
        }
        self.trial.payload[i] = block.payload[group][place];
        let sample: f64 = self.path.plan(block.first + crane).iter().map(|plan| plan.length).sum();
        let trials = self.steps.budget(sample);
        let lane = Lane { crane, stretch: 0, left: 0.0, wanted: block.wanted[group][place], trials };
        self.lanes[i] = Some(self.start_stretch(block, i, lane));
    }

    /// Sets the spool commands of a lane at the start of a part of a sample.
    fn start_stretch(&mut self, block: &Block, i: usize, lane: Lane) -> Lane {
        let plan = &self.path.plan(block.first + lane.crane)[lane.stretch];
        for c in 0..self.path.cylinders() {
            self.trial.spools[c][i] = self.path.at_spool(plan, block.first + lane.crane, c);
        }
        Lane { left: plan.length, ..lane }
    }

    /// Sets the size of the next step; whether there is one.
    fn set_step(&mut self, i: usize) -> bool {
        if let Some(lane) = self.lanes[i] {
            self.trial.h[i] = equal_part(lane.left, lane.wanted.min(self.steps.longest));
        }
        self.lanes[i].is_some()
    }

    /// The lane after a trial; `None` if its crane has finished or is lost.
    fn after_step(&mut self, block: &mut Block, i: usize, lane: Lane, result: &StepResult) -> Option<Lane> {
        let (h, growth) = (self.trial.h[i], result.growth[i]);
        let lane = Lane { trials: lane.trials.saturating_sub(1), ..lane };
        if !result.taken[i] {
            let again = self.steps.again(h, growth).filter(|_| lane.trials > 0);
            return match again {
                Some(wanted) => Some(Lane { wanted, ..lane }),
                None if result.inside[i] => self.lose(block, i, lane, OutcomeKind::SolverFailed),
                None => self.lose(block, i, lane, OutcomeKind::StrokeLimit),
            };
        }
        let status = &mut block.statuses[lane.crane / WIDTH][lane.crane % WIDTH];
        status.time += h;
        status.inexact |= !(result.exact[i] || self.steps.jumps);
        let lane = Lane { wanted: self.steps.next(h, growth, lane.wanted), left: lane.left - h, ..lane };
        if lane.left > 0.0 && lane.trials == 0 {
            self.lose(block, i, lane, OutcomeKind::SolverFailed)
        } else if lane.left > 0.0 {
            Some(lane)
        } else if lane.stretch + 1 < self.path.plan(block.first + lane.crane).len() {
            Some(self.start_stretch(block, i, Lane { stretch: lane.stretch + 1, ..lane }))
        } else {
            self.store(block, i, lane);
            None
        }
    }

    /// Ends the crane of lane `i` in its last state.
    fn lose(&self, block: &mut Block, i: usize, lane: Lane, kind: OutcomeKind) -> Option<Lane> {
        block.statuses[lane.crane / WIDTH][lane.crane % WIDTH].kind = kind;
        self.store(block, i, lane);
        None
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
