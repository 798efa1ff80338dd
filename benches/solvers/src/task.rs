//! What every solver is given and what it hands back.

use hydrocrane_machine::load;
use hydrocrane_sim::{build, Model};
use std::cell::{Cell, RefCell};
use std::ffi::{c_char, CStr};
use std::slice::from_raw_parts;
use std::sync::Arc;

/// The task as it comes through C. Times in s, spools in m, row by row.
#[repr(C)]
pub struct RawTask {
    machine: *const c_char,
    payload: f64,
    states: usize,
    start: *const f64,
    sizes: *const f64,
    max_step: f64,
    commands: usize,
    times: *const f64,
    spools: *const f64,
    records: usize,
    record: *const f64,
    end: f64,
}

/// Calls of the laws and accepted steps.
#[repr(C)]
#[derive(Default)]
pub struct Effort {
    pub right_hand_sides: u64,
    pub jacobians: u64,
    pub steps: u64,
}

/// Recorded states row by row.
pub struct Answer {
    pub states: Vec<f64>,
    pub effort: Effort,
}

pub struct Task {
    pub model: Arc<dyn Model>,
    pub payload: f64,
    pub start: Vec<f64>,
    /// Absolute tolerance per unit of relative tolerance.
    pub sizes: Vec<f64>,
    pub max_step: f64,
    pub segments: Vec<Segment>,
    pub rows: usize,
}

impl Task {
    /// Absolute tolerances at a relative one.
    pub fn absolute(&self, relative: f64) -> Vec<f64> {
        self.sizes.iter().map(|size| relative * size).collect()
    }
}

/// A stretch of time with constant commands, and the record times in it, its begin left out.
pub struct Segment {
    pub begin: f64,
    pub end: f64,
    pub spools: Vec<f64>,
    pub record: Vec<f64>,
}

/// Record times are sums of steps; commands change at decimals.
const SAME_INSTANT: f64 = 1e-9;

impl Task {
    /// # Safety
    /// The pointers of `raw` are valid for the lengths it states.
    pub unsafe fn read(raw: &RawTask) -> Result<Task, String> {
        let name = CStr::from_ptr(raw.machine).to_str().map_err(|e| e.to_string())?;
        let model = build(&load(name, &[]).map_err(|e| e.to_string())?).map_err(|e| e.to_string())?;
        if model.layout().len() != raw.states {
            return Err(format!("{name} has {} states, not {}", model.layout().len(), raw.states));
        }
        let joints = model.layout().joints();
        let (times, record) = (from_raw_parts(raw.times, raw.commands), from_raw_parts(raw.record, raw.records));
        let spools = from_raw_parts(raw.spools, raw.commands * joints);
        let segment = |k: usize| {
            let (begin, end) = (times[k], times.get(k + 1).copied().unwrap_or(raw.end));
            let inside = |t: &&f64| **t > begin + SAME_INSTANT && **t <= end + SAME_INSTANT;
            Segment {
                begin,
                end,
                spools: spools[k * joints..][..joints].to_vec(),
                record: record.iter().filter(inside).map(|t| t.min(end)).collect(),
            }
        };
        Ok(Task {
            payload: raw.payload,
            start: from_raw_parts(raw.start, raw.states).to_vec(),
            sizes: from_raw_parts(raw.sizes, raw.states).to_vec(),
            max_step: raw.max_step,
            segments: (0..raw.commands).map(segment).collect(),
            rows: raw.records,
            model,
        })
    }
}

/// The laws at constant commands, and how often they were asked.
pub struct Laws<'a> {
    pub model: &'a dyn Model,
    pub payload: f64,
    pub spools: Vec<f64>,
    pub right_hand_sides: Cell<u64>,
    pub jacobians: Cell<u64>,
    rows: RefCell<Vec<f64>>,
}

impl<'a> Laws<'a> {
    pub fn new(task: &'a Task) -> Self {
        let n = task.start.len();
        Laws {
            model: task.model.as_ref(),
            payload: task.payload,
            spools: task.segments[0].spools.clone(),
            right_hand_sides: Cell::new(0),
            jacobians: Cell::new(0),
            rows: RefCell::new(vec![0.0; n * n]),
        }
    }

    /// Whether the state was one the laws hold for.
    pub fn derivative(&self, x: &[f64], dx: &mut [f64]) -> bool {
        self.right_hand_sides.set(self.right_hand_sides.get() + 1);
        self.model.derivative(x, &self.spools, self.payload, dx);
        dx.iter().all(|rate| rate.is_finite())
    }

    /// The exact Jacobian, column by column as these solvers want it.
    pub fn jacobian(&self, x: &[f64], columns: &mut [f64]) {
        self.jacobians.set(self.jacobians.get() + 1);
        let mut rows = self.rows.borrow_mut();
        self.model.jacobian(x, &self.spools, self.payload, &mut rows);
        let n = x.len();
        for (i, row) in rows.chunks_exact(n).enumerate() {
            for (j, slope) in row.iter().enumerate() {
                columns[j * n + i] = *slope;
            }
        }
    }

    pub fn effort(&self, steps: u64) -> Effort {
        let (right_hand_sides, jacobians) = (self.right_hand_sides.get(), self.jacobians.get());
        Effort { right_hand_sides, jacobians, steps }
    }
}
