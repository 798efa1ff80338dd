//! Cranes on their way through one sample, each in steps of its own.
//!
//! A group is eight seats. Whoever sits in one tries steps until the sample is over, then the next crane takes the seat:
//! a crane that needs many steps holds up no other one, and no lane idles while cranes wait.

use super::kernel::{Group, Mover, Trial, Verdict, WIDTH};
use super::line::{CommandLine, Plan};
use super::Fate;
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
/// Whose steps are shorter than this, in units of the longest, goes first.
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
    /// Steps that the cranes want, s.
    pub wanted: &'a mut [Group],
    pub fates: &'a mut [[Fate; WIDTH]],
}

/// One who is under way.
#[derive(Debug, Clone, Copy)]
struct Rider {
    /// Counted within the block.
    crane: usize,
    stretch: usize,
    /// What remains of the stretch, s.
    left: f64,
    /// s
    wanted: f64,
}

/// The seats of a group and what is needed to move them.
pub(super) struct Ride<'a> {
    mover: Box<dyn Mover + 'a>,
    line: &'a CommandLine,
    plan: &'a [Plan],
    steps: Steps,
    riders: [Option<Rider>; WIDTH],
    trial: Trial,
    x: Vec<Group>,
}

impl<'a> Ride<'a> {
    pub fn new(
        mover: Box<dyn Mover + 'a>,
        line: &'a CommandLine,
        plan: &'a [Plan],
        steps: Steps,
        states: usize,
    ) -> Self {
        let trial = Trial { h: [steps.longest; WIDTH], spools: [[0.0; WIDTH]; MAX_JOINTS], payload: [0.0; WIDTH] };
        Ride { mover, line, plan, steps, riders: [None; WIDTH], trial, x: vec![[0.0; WIDTH]; states] }
    }

    /// Moves all cranes of a block that are well through the sample.
    pub fn advance(&mut self, block: &mut Block) {
        let mut waiting = block.in_order(self.steps.longest).into_iter();
        loop {
            let mut under_way = false;
            for seat in 0..WIDTH {
                if self.riders[seat].is_none() {
                    if let Some(crane) = waiting.next() {
                        self.board(block, seat, crane);
                    }
                }
                under_way |= self.set_step(seat);
            }
            if !under_way {
                return;
            }
            let verdict = self.mover.attempt(&self.trial, &mut self.x);
            for seat in 0..WIDTH {
                if let Some(rider) = self.riders[seat] {
                    self.riders[seat] = self.judge(block, seat, rider, &verdict);
                }
            }
        }
    }

    /// A crane takes a seat.
    fn board(&mut self, block: &Block, seat: usize, crane: usize) {
        let (group, lane) = (crane / WIDTH, crane % WIDTH);
        let states = self.x.len();
        for (x, from) in self.x.iter_mut().zip(&block.x[group * states..][..states]) {
            x[seat] = from[lane];
        }
        self.trial.payload[seat] = block.payload[group][lane];
        let rider = Rider { crane, stretch: 0, left: 0.0, wanted: block.wanted[group][lane] };
        self.riders[seat] = Some(self.enter(block, seat, rider));
    }

    /// The rider at the start of a stretch.
    fn enter(&mut self, block: &Block, seat: usize, rider: Rider) -> Rider {
        let plan = &self.plan[rider.stretch];
        for c in 0..self.line.cylinders() {
            self.trial.spools[c][seat] = self.line.at_spool(plan, block.first + rider.crane, c);
        }
        Rider { left: plan.length, ..rider }
    }

    /// Sets the size of the next step; whether there is one.
    fn set_step(&mut self, seat: usize) -> bool {
        if let Some(rider) = self.riders[seat] {
            self.trial.h[seat] = self.steps.portion(rider.left, rider.wanted);
        }
        self.riders[seat].is_some()
    }

    /// What becomes of a rider after a trial; `None` leaves the seat.
    fn judge(&mut self, block: &mut Block, seat: usize, rider: Rider, verdict: &Verdict) -> Option<Rider> {
        let (h, growth) = (self.trial.h[seat], verdict.growth[seat]);
        let fate = &mut block.fates[rider.crane / WIDTH][rider.crane % WIDTH];
        if !verdict.taken[seat] {
            if let Some(wanted) = self.steps.again(h, growth) {
                return Some(Rider { wanted, ..rider });
            }
            fate.kind = if verdict.inside[seat] { OutcomeKind::SolverFailed } else { OutcomeKind::StrokeLimit };
            self.alight(block, seat, rider);
            return None;
        }
        fate.time += h;
        // A step cut short does not disprove the size that was wanted.
        let proven = if h < rider.wanted { rider.wanted } else { 0.0 };
        let wanted = (h * growth).max(proven).min(self.steps.longest);
        let rider = Rider { wanted, left: rider.left - h, ..rider };
        if rider.left > 0.0 {
            Some(rider)
        } else if rider.stretch + 1 < self.plan.len() {
            Some(self.enter(block, seat, Rider { stretch: rider.stretch + 1, ..rider }))
        } else {
            self.alight(block, seat, rider);
            None
        }
    }

    /// The crane's state back into its place.
    fn alight(&self, block: &mut Block, seat: usize, rider: Rider) {
        let (group, lane) = (rider.crane / WIDTH, rider.crane % WIDTH);
        let states = self.x.len();
        for (x, to) in self.x.iter().zip(&mut block.x[group * states..][..states]) {
            to[lane] = x[seat];
        }
        block.wanted[group][lane] = rider.wanted;
    }
}

impl Block<'_> {
    /// The cranes that are well, those first that need many steps: else the last of them would ride alone.
    fn in_order(&self, longest: f64) -> Vec<usize> {
        let (cranes, well) = (0..self.fates.len() * WIDTH, OutcomeKind::Completed);
        let (mut order, mut quick) = (Vec::new(), Vec::new());
        for crane in cranes.filter(|c| self.fates[c / WIDTH][c % WIDTH].kind == well) {
            let slow = self.wanted[crane / WIDTH][crane % WIDTH] < SLOW * longest;
            if slow { &mut order } else { &mut quick }.push(crane);
        }
        order.append(&mut quick);
        order
    }
}
