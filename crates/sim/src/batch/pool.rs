//! Threads of a batch, which a process that was forked does not have.

use std::mem::forget;
use std::process;

pub struct Pool {
    threads: Option<rayon::ThreadPool>,
    /// Zero: the number of cores.
    wanted: usize,
    process: u32,
}

impl Pool {
    /// `None` if the threads cannot be started.
    pub fn new(wanted: usize) -> Option<Self> {
        let threads = rayon::ThreadPoolBuilder::new().num_threads(wanted).build().ok()?;
        Some(Pool { threads: Some(threads), wanted, process: process::id() })
    }

    /// The number of threads; one if there are none.
    pub fn count(&self) -> usize {
        self.threads.as_ref().map_or(1, rayon::ThreadPool::current_num_threads)
    }

    /// The threads, unless they are those of another process.
    pub fn here(&self) -> Option<&rayon::ThreadPool> {
        self.threads.as_ref().filter(|_| process::id() == self.process)
    }

    /// Starts the threads anew in a forked process, if they can be started.
    pub fn renew(&mut self) {
        if process::id() != self.process {
            self.leave();
            self.threads = Pool::new(self.wanted).and_then(|mut pool| pool.threads.take());
            self.process = process::id();
        }
    }

    /// Forgets threads of another process: to end them would wait for ever.
    fn leave(&mut self) {
        if let Some(threads) = self.threads.take_if(|_| process::id() != self.process) {
            forget(threads);
        }
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        self.leave();
    }
}
