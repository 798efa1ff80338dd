//! The step kernels of a batch, one per thread, made when the thread first has work.

use crate::model::Model;
use hydrocrane_lanes::{Demand, StepKernel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The step kernel of a thread, once it is made.
type Made = Option<Box<dyn StepKernel>>;

pub struct Kernels {
    model: Arc<dyn Model>,
    demand: Demand,
    /// Numbers in which cranes differ.
    own: Vec<usize>,
    wanted_set: Option<String>,
    made: Vec<Mutex<Made>>,
}

impl Kernels {
    /// Of so many `threads`, in the widest instruction set of this processor or the one `wanted`.
    pub fn new(model: Arc<dyn Model>, demand: Demand, wanted: Option<String>, threads: usize) -> Self {
        let made = (0..threads).map(|_| Mutex::default()).collect();
        Kernels { model, demand, own: Vec::new(), wanted_set: wanted, made }
    }

    /// Lets cranes differ in these numbers.
    pub fn differ_in(&mut self, own: &[usize]) {
        self.own = own.to_vec();
        self.made.iter_mut().for_each(|made| *made = Mutex::default());
    }

    /// Does `work` with the kernel of the present thread, which is one of a pool or the caller's.
    pub fn with<O>(&self, work: impl FnOnce(&mut dyn StepKernel) -> O) -> O {
        let mut made = self.lock();
        let kernel =
            made.get_or_insert_with(|| self.model.step_kernel(&self.demand, &self.own, self.wanted_set.as_deref()));
        work(kernel.as_mut())
    }

    /// Another pool may have more threads; two of them then take turns.
    fn lock(&self) -> MutexGuard<'_, Made> {
        let thread = rayon::current_thread_index().unwrap_or(0) % self.made.len();
        self.made[thread].lock().unwrap_or_else(PoisonError::into_inner)
    }
}
