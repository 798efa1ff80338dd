//! Many cranes of one machine at once: lanes times threads.
//!
//! Eight cranes step side by side, each with its own step sizes. Contract: the result of a crane depends, bit for bit,
//! only on its own start, commands and payload, and not on its place, the number of cranes, the number of threads or
//! the instruction set.                                                        theory: docs/theory/batch.md

pub mod command_path;
mod lane_scheduler;
mod pool;

use crate::method_choice::jumps;
use crate::model::Model;
use crate::outcome::OutcomeKind;
use crate::payload::change_payload;
use command_path::BatchCommandPath;
use hydrocrane_lanes::{Demand, Group, Kernel, StepKernel, WIDTH};
use hydrocrane_plant::precision::Precision;
use lane_scheduler::{Block, LaneScheduler, Steps};
use pool::Pool;
use rayon::prelude::*;
use std::sync::Arc;

/// Most groups per block of a thread: enough that the last cranes beside empty lanes do not matter, and few enough for
/// its cache.
const BLOCK: usize = 64;
/// Least groups per thread, so that its work exceeds the overhead.
const LEAST_GROUPS: usize = 4;

/// Status of a crane of a batch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Status {
    pub kind: OutcomeKind,
    /// Time since its reset, s; at the loss it stops.
    pub time: f64,
    /// Whether a finest step had an error beyond the tolerance.
    pub inexact: bool,
}

/// Settings of a batch.
#[derive(Debug, Clone, Default)]
pub struct BatchOptions {
    /// s
    pub sample_time: f64,
    /// Longest step, s.
    pub step: f64,
    /// Tolerance of the errors of a step, root mean square, in units of the states' scales.
    pub tolerance: f64,
    /// Zero: the number of cores.
    pub threads: usize,
    /// An instruction set narrower than the widest of this processor.
    pub instruction_set: Option<String>,
}

/// Cranes that advance together by one sample per step.
pub struct Batch {
    model: Arc<dyn Model>,
    kernel: Box<dyn Kernel>,
    pool: Pool,
    cranes: usize,
    /// States, group by group, one entry per state.
    x: Vec<Group>,
    /// kg at the tips, one entry per group.
    payload: Vec<Group>,
    statuses: Vec<[Status; WIDTH]>,
    /// Wanted step sizes of the cranes, s, one entry per group.
    wanted: Vec<Group>,
    path: BatchCommandPath,
    demand: Demand,
    steps: Steps,
}

impl Batch {
    /// `None` if the threads cannot be started. No crane runs before its reset.
    pub fn new(model: Arc<dyn Model>, cranes: usize, options: &BatchOptions) -> Option<Self> {
        let groups = cranes.div_ceil(WIDTH);
        let steps = Steps::up_to(options.step.min(options.sample_time), jumps(model.machine()));
        let precision = Precision::new(model.layout(), options.tolerance);
        let lost = Status { kind: OutcomeKind::BadState, time: 0.0, inexact: false };
        Some(Batch {
            kernel: model.kernel(options.instruction_set.as_deref()),
            pool: Pool::new(options.threads)?,
            cranes,
            x: vec![[0.0; WIDTH]; groups * model.layout().len()],
            payload: vec![[0.0; WIDTH]; groups],
            statuses: vec![[lost; WIDTH]; groups],
            path: BatchCommandPath::new(model.machine(), groups, options.sample_time),
            wanted: vec![[0.0; WIDTH]; groups],
            demand: steps.demand(precision),
            steps,
            model,
        })
    }

    pub fn cranes(&self) -> usize {
        self.cranes
    }
    pub fn instruction_set(&self) -> &'static str {
        self.kernel.instruction_set()
    }
    pub fn threads(&self) -> usize {
        self.pool.count()
    }

    /// Puts a crane at time zero into `state` with `payload` (kg). The error says why it cannot start there.
    pub fn reset(&mut self, crane: usize, state: &[f64], payload: f64) -> Result<(), String> {
        if let Some(fault) = crate::faults::state_fault(self.model.as_ref(), state) {
            return Err(fault);
        }
        let (group, lane) = (crane / WIDTH, crane % WIDTH);
        self.write_state(crane, state);
        self.payload[group][lane] = payload;
        self.statuses[group][lane] = Status { kind: OutcomeKind::Completed, time: 0.0, inexact: false };
        self.wanted[group][lane] = self.steps.longest;
        self.path.forget(group, lane);
        Ok(())
    }

    /// Sets the mass at the tip of a crane to `mass` (kg): it picks up a load at rest, or releases one.
    pub fn set_payload(&mut self, crane: usize, mass: f64) {
        let mut x = self.state(crane);
        let payload = &mut self.payload[crane / WIDTH][crane % WIDTH];
        let change = [*payload, mass];
        *payload = mass;
        if change[0] != change[1] {
            let time = self.statuses[crane / WIDTH][crane % WIDTH].time;
            change_payload(self.model.as_ref(), time, &mut x, change);
            self.write_state(crane, &x);
        }
    }

    /// Holds the spool commands (m, one row per crane) for one sample time. Lost cranes keep their last state.
    pub fn step(&mut self, commands: &[f64]) {
        self.pool.renew();
        self.path.send(commands);
        let plan = self.path.plan();
        let states = self.model.layout().len();
        let (alone, block) = (self.runs_alone(), BLOCK.min(self.statuses.len().div_ceil(self.threads())));
        let Batch { kernel, pool, x, payload, wanted, statuses, path, demand, steps, .. } = self;
        let (kernel, path) = (&*kernel, &*path);
        let scheduler = || LaneScheduler::new(kernel.step_kernel(demand), path, &plan, *steps, states);
        let parts = x.chunks_mut(block * states).zip(payload.chunks(block));
        let parts = parts.zip(wanted.chunks_mut(block).zip(statuses.chunks_mut(block))).enumerate();
        let mut blocks: Vec<Block> = parts
            .map(|(i, ((x, payload), (wanted, statuses)))| Block {
                first: i * block * WIDTH,
                x,
                payload,
                wanted,
                statuses,
            })
            .collect();
        match pool.here().filter(|_| !alone) {
            Some(threads) => threads.install(|| blocks.par_iter_mut().for_each_init(scheduler, LaneScheduler::advance)),
            None => {
                let mut scheduler = scheduler();
                blocks.iter_mut().for_each(|block| scheduler.advance(block));
            }
        }
    }

    /// Whether the calling thread does the work, because distribution would take longer.
    fn runs_alone(&self) -> bool {
        self.threads() == 1 || self.statuses.len() <= LEAST_GROUPS
    }

    /// Per crane its joint coordinates, rates, pressures p1 and p2 by cylinder, and tip: rows of [`Self::observed`] numbers.
    pub fn observe(&self) -> Vec<f64> {
        let layout = self.model.layout();
        let (n, states, width) = (layout.joints(), layout.len(), self.observed());
        let mut rows = vec![0.0; self.statuses.len() * WIDTH * width];
        let work = |step_kernel: &mut Box<dyn StepKernel + '_>, (rows, x): (&mut [f64], &[Group])| {
            let tip = step_kernel.tips(x);
            for (lane, row) in rows.chunks_exact_mut(width).enumerate() {
                for i in 0..2 * n {
                    row[i] = x[i][lane];
                }
                for c in 0..n {
                    row[2 * n + 2 * c] = x[layout.p1(c)][lane];
                    row[2 * n + 2 * c + 1] = x[layout.p2(c)][lane];
                }
                row[4 * n..].copy_from_slice(&[tip[0][lane], tip[1][lane]]);
            }
        };
        match self.pool.here().filter(|_| !self.runs_alone()) {
            Some(threads) => {
                let groups = rows.par_chunks_exact_mut(width * WIDTH).zip(self.x.par_chunks_exact(states));
                let begin = || self.kernel.step_kernel(&self.demand);
                threads.install(|| groups.with_min_len(LEAST_GROUPS).for_each_init(begin, work));
            }
            None => {
                let mut step_kernel = self.kernel.step_kernel(&self.demand);
                let groups = rows.chunks_exact_mut(width * WIDTH).zip(self.x.chunks_exact(states));
                groups.for_each(|item| work(&mut step_kernel, item));
            }
        }
        rows.truncate(self.cranes * width);
        rows
    }

    /// Length of a row of [`Self::observe`].
    pub fn observed(&self) -> usize {
        4 * self.model.layout().joints() + 2
    }

    pub fn state(&self, crane: usize) -> Vec<f64> {
        let states = self.model.layout().len();
        let group = &self.x[crane / WIDTH * states..][..states];
        group.iter().map(|lanes| lanes[crane % WIDTH]).collect()
    }

    fn write_state(&mut self, crane: usize, state: &[f64]) {
        let states = state.len();
        let group = &mut self.x[crane / WIDTH * states..][..states];
        group.iter_mut().zip(state).for_each(|(lanes, value)| lanes[crane % WIDTH] = *value);
    }

    pub fn status(&self, crane: usize) -> Status {
        self.statuses[crane / WIDTH][crane % WIDTH]
    }

    /// At the tip, kg.
    pub fn payload(&self, crane: usize) -> f64 {
        self.payload[crane / WIDTH][crane % WIDTH]
    }
}
