//! Values of the machine that change while the driver goes on: hoses that burst.

use crate::model::Model;

/// From `time` (s) on the machine is `model`, whose states are the same.
#[derive(Clone, Copy)]
pub struct ModelChange<'a> {
    pub time: f64,
    pub model: &'a dyn Model,
}

/// The changes of a phase.
#[derive(Clone, Default)]
pub(crate) struct ModelChanges<'a> {
    /// Ascending; entries before `next` are done.
    changes: Vec<ModelChange<'a>>,
    next: usize,
}

/// Rounding tolerance between the time of a change and the present time, s.
const ROUNDING: f64 = 1e-12;

impl<'a> ModelChanges<'a> {
    pub fn new(changes: Vec<ModelChange<'a>>) -> Self {
        ModelChanges { changes, next: 0 }
    }

    /// Time of the next change, s.
    pub fn next_time(&self) -> Option<f64> {
        self.changes.get(self.next).map(|change| change.time)
    }

    /// The machine of the last change that is due at `now` (s), if one is. Builds for the smallest chains only have none.
    pub fn due(&mut self, now: f64) -> Option<&'a dyn Model> {
        if !cfg!(feature = "chains") {
            return None;
        }
        let due = self.changes[self.next..].iter().take_while(|change| change.time <= now + ROUNDING).count();
        self.next += due;
        (due > 0).then(|| self.changes[self.next - 1].model)
    }
}
