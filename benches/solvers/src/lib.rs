//! Other people's solvers on the laws of hydrocrane-sim, behind one C function that `benches/competitors/compiled.py`
//! calls. Right-hand side and exact Jacobian are the product's own, compiled into this library with its settings.

mod cvode;
mod diffsol_methods;
mod task;

use hydrocrane_ode::BlockArrow;
use std::ffi::{c_char, CStr};
use std::hint::black_box;
use std::panic::{catch_unwind, AssertUnwindSafe};
use task::{Answer, Effort, RawTask, Task};

/// A text that the caller has room for.
#[repr(C)]
pub struct Message {
    text: *mut c_char,
    room: usize,
}

impl Message {
    unsafe fn write(&self, text: &str) {
        let length = text.len().min(self.room - 1);
        std::ptr::copy_nonoverlapping(text.as_ptr(), self.text.cast(), length);
        *self.text.add(length) = 0;
    }
}

/// What `work` returns, or `None` after its error has been written down; nothing unwinds into the caller.
unsafe fn guarded<T>(message: &Message, work: impl FnOnce() -> Result<T, String>) -> Option<T> {
    let done = catch_unwind(AssertUnwindSafe(work)).unwrap_or(Err("the solver panicked".into()));
    done.map_err(|text| message.write(&text)).ok()
}

/// Reads a task once, its machine included; null if that fails.
///
/// # Safety
/// All pointers are valid for the lengths that the task states.
#[no_mangle]
pub unsafe extern "C" fn prepare(raw: *const RawTask, message: *const Message) -> *mut Task {
    guarded(&*message, || Task::read(&*raw)).map_or(std::ptr::null_mut(), |task| Box::into_raw(Box::new(task)))
}

/// # Safety
/// `task` comes from [`prepare`] and is not used again.
#[no_mangle]
pub unsafe extern "C" fn release(task: *mut Task) {
    drop(Box::from_raw(task));
}

/// Solves `task` at the relative tolerance by the method named `solver`, with the shared library of SUNDIALS at `library`
/// for those that need it. Writes one row of states per record time and what it took; returns zero, or one on failure.
///
/// # Safety
/// `task` comes from [`prepare`], the texts end with zero, `states` has room for all rows.
#[no_mangle]
pub unsafe extern "C" fn solve(
    task: *const Task,
    solver: *const c_char,
    library: *const c_char,
    relative: f64,
    states: *mut f64,
    effort: *mut Effort,
    message: *const Message,
) -> i32 {
    let (task, name) = (&*task, |text: *const c_char| CStr::from_ptr(text).to_str().map_err(|e| e.to_string()));
    let answer: Option<Answer> = guarded(&*message, || match name(solver)? {
        "cvode-bdf" => cvode::solve(task, relative, name(library)?, cvode::BDF),
        "cvode-adams" => cvode::solve(task, relative, name(library)?, cvode::ADAMS),
        other => diffsol_methods::solve(task, relative, other),
    });
    let Some(answer) = answer else { return 1 };
    std::ptr::copy_nonoverlapping(answer.states.as_ptr(), states, answer.states.len());
    *effort = answer.effort;
    0
}

/// Evaluates the laws once at each of the states, at closed valves: the right-hand side, with its structured Jacobian where
/// `structured`.
///
/// # Safety
/// `task` comes from [`prepare`], `states` holds `rows` states.
#[no_mangle]
pub unsafe extern "C" fn evaluate(task: *const Task, states: *const f64, rows: usize, structured: bool) {
    let (model, n) = ((*task).model.as_ref(), (*task).start.len());
    let (spools, mut rates) = (vec![0.0; model.layout().joints()], vec![0.0; n]);
    let mut slopes = BlockArrow::new(model.layout().blocks());
    for x in std::slice::from_raw_parts(states, rows * n).chunks_exact(n) {
        if structured {
            model.linearise(x, &spools, (*task).payload, &mut rates, &mut slopes);
            black_box(&slopes);
        } else {
            model.derivative(x, &spools, (*task).payload, &mut rates);
        }
        black_box(&rates);
    }
}
