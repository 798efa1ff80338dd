//! CVODE of SUNDIALS with its own dense linear solver, called through its C interface; nothing of Python is in the way.
//!
//! The shared library is the one that scikit-sundae brings; SUNDIALS 6 and later have this interface.

use crate::task::{Answer, Laws, Task};
use libloading::{Library, Symbol};
use std::ffi::{c_int, c_long, c_void};
use std::ptr::null_mut;
use std::slice::{from_raw_parts, from_raw_parts_mut};

/// CVODE's numbers of its two families of methods.
pub const ADAMS: c_int = 1;
pub const BDF: c_int = 2;

const TO_TIME: c_int = 1;
const MAX_STEPS: c_long = 10_000_000;
const RECOVERABLE: c_int = 1;

type Object = *mut c_void;
type Data = unsafe extern "C" fn(Object) -> *mut f64;
type Make = unsafe extern "C" fn(i64, *const f64, Object) -> Object;
type Free = unsafe extern "C" fn(Object);
type RightHandSide = unsafe extern "C" fn(f64, Object, Object, Object) -> c_int;
type Jacobian = unsafe extern "C" fn(f64, Object, Object, Object, Object, Object, Object, Object) -> c_int;

/// What the callbacks get: the laws and how to reach the numbers of a vector and a matrix.
struct Callbacks<'a> {
    laws: Laws<'a>,
    states: usize,
    vector: Data,
    matrix: Data,
}

unsafe extern "C" fn right_hand_side(_t: f64, x: Object, dx: Object, user: Object) -> c_int {
    let c = &*user.cast::<Callbacks>();
    let (x, dx) = (from_raw_parts((c.vector)(x), c.states), from_raw_parts_mut((c.vector)(dx), c.states));
    if c.laws.derivative(x, dx) {
        0
    } else {
        RECOVERABLE
    }
}

#[rustfmt::skip]
unsafe extern "C" fn jacobian(_t: f64, x: Object, _dx: Object, j: Object, user: Object, _: Object, _: Object, _: Object) -> c_int {
    let c = &*user.cast::<Callbacks>();
    let x = from_raw_parts((c.vector)(x), c.states);
    c.laws.jacobian(x, from_raw_parts_mut((c.matrix)(j), c.states * c.states));
    0
}

/// A function of the library by its name.
unsafe fn function<'l, F>(library: &'l Library, name: &str) -> Result<Symbol<'l, F>, String> {
    library.get(name.as_bytes()).map_err(|e| format!("{name}: {e}"))
}

fn check(flag: c_int, what: &str) -> Result<(), String> {
    if flag < 0 {
        Err(format!("{what} returned {flag}"))
    } else {
        Ok(())
    }
}

/// Solves the task by `method`, started anew at every change of the commands.
pub fn solve(task: &Task, relative: f64, library: &str, method: c_int) -> Result<Answer, String> {
    // SAFETY: the signatures are those of the SUNDIALS headers; indices fit both its widths of integers.
    unsafe {
        let library = Library::new(library).map_err(|e| e.to_string())?;
        let n = task.start.len();
        let callbacks = Callbacks {
            laws: Laws::new(task),
            states: n,
            vector: *function::<Data>(&library, "N_VGetArrayPointer")?,
            matrix: *function::<Data>(&library, "SUNDenseMatrix_Data")?,
        };
        let mut solver = Solver::new(&library, task, relative, method, callbacks)?;
        let states = solver.run(task)?;
        Ok(Answer { states, effort: solver.callbacks.laws.effort(solver.steps) })
    }
}

/// A solver with what it owns.
struct Solver<'a> {
    library: &'a Library,
    callbacks: Box<Callbacks<'a>>,
    x: Vec<f64>,
    vector: Object,
    matrix: Object,
    linear: Object,
    memory: Object,
    context: Object,
    steps: u64,
}

impl<'a> Solver<'a> {
    unsafe fn new(
        library: &'a Library,
        task: &Task,
        relative: f64,
        method: c_int,
        callbacks: Callbacks<'a>,
    ) -> Result<Self, String> {
        let n = callbacks.states as i64;
        let mut context = null_mut();
        let create = function::<unsafe extern "C" fn(c_int, *mut Object) -> c_int>(library, "SUNContext_Create")?;
        check(create(0, &mut context), "SUNContext_Create")?;
        let make = function::<Make>(library, "N_VMake_Serial")?;
        let dense = function::<unsafe extern "C" fn(i64, i64, Object) -> Object>(library, "SUNDenseMatrix")?;
        let lu = function::<unsafe extern "C" fn(Object, Object, Object) -> Object>(library, "SUNLinSol_Dense")?;
        let memory = function::<unsafe extern "C" fn(c_int, Object) -> Object>(library, "CVodeCreate")?;
        let x = task.start.clone();
        let vector = make(n, x.as_ptr(), context);
        let matrix = dense(n, n, context);
        let solver = Solver {
            callbacks: Box::new(callbacks),
            linear: lu(vector, matrix, context),
            memory: memory(method, context),
            steps: 0,
            library,
            x,
            vector,
            matrix,
            context,
        };
        solver.configure(task, relative)?;
        Ok(solver)
    }

    unsafe fn configure(&self, task: &Task, relative: f64) -> Result<(), String> {
        type Init = unsafe extern "C" fn(Object, RightHandSide, f64, Object) -> c_int;
        type Three = unsafe extern "C" fn(Object, Object, Object) -> c_int;
        let (library, memory) = (self.library, self.memory);
        check(function::<Init>(library, "CVodeInit")?(memory, right_hand_side, 0.0, self.vector), "CVodeInit")?;
        self.set_tolerances(relative, &task.absolute(relative))?;
        let user = (&raw const *self.callbacks).cast_mut().cast();
        check(
            function::<unsafe extern "C" fn(Object, Object) -> c_int>(library, "CVodeSetUserData")?(memory, user),
            "",
        )?;
        check(function::<Three>(library, "CVodeSetLinearSolver")?(memory, self.linear, self.matrix), "linear solver")?;
        check(
            function::<unsafe extern "C" fn(Object, Jacobian) -> c_int>(library, "CVodeSetJacFn")?(memory, jacobian),
            "",
        )?;
        let limit = function::<unsafe extern "C" fn(Object, f64) -> c_int>(library, "CVodeSetMaxStep")?;
        check(limit(memory, task.max_step), "CVodeSetMaxStep")?;
        let most = function::<unsafe extern "C" fn(Object, c_long) -> c_int>(library, "CVodeSetMaxNumSteps")?;
        check(most(memory, MAX_STEPS), "CVodeSetMaxNumSteps")
    }

    /// CVODE keeps a copy of the absolute ones.
    unsafe fn set_tolerances(&self, relative: f64, absolute: &[f64]) -> Result<(), String> {
        type Set = unsafe extern "C" fn(Object, f64, Object) -> c_int;
        let make = function::<Make>(self.library, "N_VMake_Serial")?;
        let vector = make(absolute.len() as i64, absolute.as_ptr(), self.context);
        let flag = function::<Set>(self.library, "CVodeSVtolerances")?(self.memory, relative, vector);
        function::<Free>(self.library, "N_VDestroy")?(vector);
        check(flag, "CVodeSVtolerances")
    }

    unsafe fn run(&mut self, task: &Task) -> Result<Vec<f64>, String> {
        type Advance = unsafe extern "C" fn(Object, f64, Object, *mut f64, c_int) -> c_int;
        let advance = function::<Advance>(self.library, "CVode")?;
        let restart = function::<unsafe extern "C" fn(Object, f64, Object) -> c_int>(self.library, "CVodeReInit")?;
        let stop = function::<unsafe extern "C" fn(Object, f64) -> c_int>(self.library, "CVodeSetStopTime")?;
        let count = function::<unsafe extern "C" fn(Object, *mut c_long) -> c_int>(self.library, "CVodeGetNumSteps")?;
        let mut states = Vec::with_capacity(task.rows * self.x.len());
        states.extend_from_slice(&task.start);
        for segment in &task.segments {
            self.callbacks.laws.spools.copy_from_slice(&segment.spools);
            check(restart(self.memory, segment.begin, self.vector), "CVodeReInit")?;
            check(stop(self.memory, segment.end), "CVodeSetStopTime")?;
            let mut reached = segment.begin;
            for &t in &segment.record {
                check(advance(self.memory, t, self.vector, &mut reached, TO_TIME), "CVode")?;
                states.extend_from_slice(&self.x);
            }
            if reached < segment.end {
                check(advance(self.memory, segment.end, self.vector, &mut reached, TO_TIME), "CVode")?;
            }
            let mut steps = 0;
            check(count(self.memory, &mut steps), "CVodeGetNumSteps")?;
            self.steps += steps as u64;
        }
        Ok(states)
    }

    unsafe fn release(&mut self) -> Result<(), String> {
        function::<unsafe extern "C" fn(*mut Object)>(self.library, "CVodeFree")?(&mut self.memory);
        function::<unsafe extern "C" fn(Object) -> c_int>(self.library, "SUNLinSolFree")?(self.linear);
        function::<Free>(self.library, "SUNMatDestroy")?(self.matrix);
        function::<Free>(self.library, "N_VDestroy")?(self.vector);
        function::<unsafe extern "C" fn(*mut Object) -> c_int>(self.library, "SUNContext_Free")?(&mut self.context);
        Ok(())
    }
}

impl Drop for Solver<'_> {
    fn drop(&mut self) {
        // SAFETY: every object was made by this library and is freed once.
        let _ = unsafe { self.release() };
    }
}
