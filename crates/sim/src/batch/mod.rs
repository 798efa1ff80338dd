//! Many cranes at once, of one machine or of machines that differ in numbers: lanes times threads.
//!
//! Up to eight cranes step side by side, each with its own step sizes. Contract: the result of a crane depends, bit for bit,
//! only on its own machine, start, commands and payload, and not on its place, the number of cranes, the number of
//! threads or the instruction set.                                             theory: docs/theory/batch.md

pub mod command_path;
mod kernels;
mod lane_scheduler;
mod own_numbers;
mod pool;

use crate::model::method_choice::jumps;
use crate::model::payload::picks_up;
use crate::model::Model;
use crate::outcome::OutcomeKind;
use crate::warning::Warning;
use command_path::BatchCommandPath;
use hydrocrane_lanes::{Group, Needed, WIDTH};
use hydrocrane_plant::precision::Precision;
use kernels::Kernels;
use lane_scheduler::{Block, LaneScheduler, Steps};
use own_numbers::OwnNumbers;
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
    pool: Pool,
    kernels: Kernels,
    cranes: usize,
    /// States, group by group, one entry per state.
    x: Vec<Group>,
    /// kg at the tips, one entry per group.
    payload: Vec<Group>,
    statuses: Vec<[Status; WIDTH]>,
    /// Wanted step sizes of the cranes, s, one entry per group.
    wanted: Vec<Group>,
    path: BatchCommandPath,
    own: OwnNumbers,
    /// What decides the laws besides these.
    structure: String,
    tolerance: f64,
    steps: Steps,
}

impl Batch {
    /// `None` if the threads cannot be started. No crane runs before its reset.
    pub fn new(model: Arc<dyn Model>, cranes: usize, options: &BatchOptions) -> Option<Self> {
        let groups = cranes.div_ceil(WIDTH);
        let steps = Steps::up_to(options.step.min(options.sample_time), jumps(model.machine()));
        let precision = Precision::new(model.layout(), options.tolerance);
        let lost = Status { kind: OutcomeKind::BadState, time: 0.0, inexact: false };
        let (pool, demand) = (Pool::new(options.threads)?, steps.demand(precision));
        Some(Batch {
            kernels: Kernels::new(model.clone(), demand, options.instruction_set.clone(), pool.count()),
            pool,
            cranes,
            x: vec![[0.0; WIDTH]; groups * model.layout().len()],
            payload: vec![[0.0; WIDTH]; groups],
            statuses: vec![[lost; WIDTH]; groups],
            path: BatchCommandPath::new(model.machine(), cranes, options.sample_time),
            wanted: vec![[0.0; WIDTH]; groups],
            own: OwnNumbers::new(numbers(model.as_ref(), options.tolerance), groups),
            structure: model.structure(),
            tolerance: options.tolerance,
            steps,
            model,
        })
    }

    pub fn cranes(&self) -> usize {
        self.cranes
    }
    pub fn instruction_set(&self) -> &'static str {
        self.kernels.with(|kernel| kernel.instruction_set())
    }
    pub fn threads(&self) -> usize {
        self.pool.count()
    }

    /// Makes a crane the machine `model` and puts it at time zero into `state` with `payload` (kg). The error says why it cannot start
    /// there, or that the machine differs from the others in more than numbers.
    pub fn reset(&mut self, crane: usize, model: &dyn Model, state: &[f64], payload: f64) -> Result<(), String> {
        if !self.takes(model) {
            return Err("this machine differs from those of the batch in more than numbers".to_string());
        }
        if let Some(fault) = crate::inputs::faults::state_fault(model, state) {
            return Err(fault);
        }
        if self.own.set(crane, &numbers(model, self.tolerance)) {
            self.kernels.differ_in(self.own.differing());
        }
        let (group, lane) = (crane / WIDTH, crane % WIDTH);
        self.write_state(crane, state);
        self.payload[group][lane] = payload;
        self.statuses[group][lane] = Status { kind: OutcomeKind::Completed, time: 0.0, inexact: false };
        self.wanted[group][lane] = self.steps.longest;
        self.path.begin(crane, model.machine());
        Ok(())
    }

    /// Whether a crane of the batch can be this machine: it has the same joints, parts, laws and curves.
    pub fn takes(&self, model: &dyn Model) -> bool {
        std::ptr::addr_eq(model, self.model.as_ref()) || model.structure() == self.structure
    }

    /// `f` of each item, by all threads.
    pub fn each<I: Sync, O: Send>(&mut self, items: &[I], f: impl Fn(&I) -> O + Sync + Send) -> Vec<O> {
        self.pool.renew();
        match self.pool.here() {
            Some(threads) => threads.install(|| items.par_iter().map(f).collect()),
            None => items.iter().map(f).collect(),
        }
    }

    /// Sets the mass at the tip of a crane to `mass` (kg): it picks up a load at rest, or releases one.
    pub fn set_payload(&mut self, crane: usize, mass: f64) {
        let payload = &mut self.payload[crane / WIDTH][crane % WIDTH];
        let change = [*payload, mass];
        *payload = mass;
        if picks_up(change) {
            let (mut x, n) = (self.state(crane), self.model.layout().joints());
            let rates = self.model.picked_up(&self.own.all(crane), &x[..n], &x[n..2 * n], change);
            x[n..2 * n].copy_from_slice(&rates);
            self.write_state(crane, &x);
        }
    }

    /// The first crane that got a command far beyond the stroke of a spool since its reset, and its warning.
    pub fn astray(&self) -> Option<&(usize, Warning)> {
        self.path.astray()
    }

    /// Holds the spool commands (m, one row per crane) for one sample time. Lost cranes keep their last state.
    pub fn step(&mut self, commands: &[f64]) {
        self.pool.renew();
        self.path.send(commands);
        let states = self.model.layout().len();
        let (alone, block) = (self.runs_alone(), BLOCK.min(self.statuses.len().div_ceil(self.threads())));
        let Batch { kernels, pool, x, payload, wanted, statuses, path, own, steps, .. } = self;
        let (kernels, path, own) = (&*kernels, &*path, &*own);
        let advance = |block: &mut Block| {
            kernels.with(|kernel| LaneScheduler::new(kernel, path, own, *steps, states).advance(block));
        };
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
            Some(threads) => threads.install(|| blocks.par_iter_mut().for_each(advance)),
            None => blocks.iter_mut().for_each(advance),
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
        let work = |(group, (rows, x)): (usize, (&mut [f64], &[Group]))| {
            let mut tip = [[0.0; WIDTH]; 3];
            self.kernels.with(|kernel| {
                for first in (0..WIDTH).step_by(kernel.lanes()) {
                    kernel.load_all(self.own.of(group * WIDTH), first, Needed::Tip);
                    kernel.tips(x, first, &mut tip);
                }
            });
            for (lane, row) in rows.chunks_exact_mut(width).enumerate() {
                for i in 0..2 * n {
                    row[i] = x[i][lane];
                }
                for c in 0..n {
                    row[2 * n + 2 * c] = x[layout.p1(c)][lane];
                    row[2 * n + 2 * c + 1] = x[layout.p2(c)][lane];
                }
                for (out, axis) in row[4 * n..].iter_mut().zip(self.model.tip_axes()) {
                    *out = tip[*axis][lane];
                }
            }
        };
        match self.pool.here().filter(|_| !self.runs_alone()) {
            Some(threads) => {
                let groups = rows.par_chunks_exact_mut(width * WIDTH).zip(self.x.par_chunks_exact(states));
                threads.install(|| groups.enumerate().with_min_len(LEAST_GROUPS).for_each(work));
            }
            None => rows.chunks_exact_mut(width * WIDTH).zip(self.x.chunks_exact(states)).enumerate().for_each(work),
        }
        rows.truncate(self.cranes * width);
        rows
    }

    /// Length of a row of [`Self::observe`].
    pub fn observed(&self) -> usize {
        4 * self.model.layout().joints() + self.model.tip_axes().len()
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

/// All numbers on which the steps of a crane depend: those of its laws and the weights of its errors.
fn numbers(model: &dyn Model, tolerance: f64) -> Vec<f64> {
    [model.numbers(), Precision::new(model.layout(), tolerance).weights].concat()
}
