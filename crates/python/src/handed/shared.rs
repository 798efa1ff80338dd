//! What several threads of Python may ask: one after the other.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::{self, ThreadId};

/// A simulator that answers when the step of another thread is done.
pub struct Shared<T> {
    inner: Mutex<T>,
    /// The thread that has it.
    holder: Mutex<Option<ThreadId>>,
}

/// It, until dropped.
struct Held<'a, T> {
    inner: MutexGuard<'a, T>,
    holder: &'a Mutex<Option<ThreadId>>,
}

impl<T> Drop for Held<'_, T> {
    fn drop(&mut self) {
        *locked(self.holder) = None;
    }
}

fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<T: Send> Shared<T> {
    pub fn new(inner: T) -> Self {
        Shared { inner: Mutex::new(inner), holder: Mutex::new(None) }
    }

    /// What `ask` makes of it. Python goes on meanwhile, since the step of another thread, for which it may wait, may call Python.
    pub fn ask<R: Send>(&self, py: Python<'_>, ask: impl FnOnce(&mut T) -> R + Send) -> PyResult<R> {
        // A controller of one's own is within the step of this thread: it would wait for itself.
        if *locked(&self.holder) == Some(thread::current().id()) {
            return Err(PyRuntimeError::new_err(
                "the simulation is asked from within its own step, by a controller or what it calls: keep what is needed from \
                 `step(measured, stick)`, or ask after the step",
            ));
        }
        Ok(py.detach(|| {
            let mut held = Held { inner: locked(&self.inner), holder: &self.holder };
            *locked(&self.holder) = Some(thread::current().id());
            ask(&mut held.inner)
        }))
    }
}
