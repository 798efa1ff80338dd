//! Values of the machine that change while the driver goes on: hoses that burst. Builds for the smallest chains only have none.

use crate::model::Model;
use crate::CHAINS;
use std::sync::Arc;

/// From `time` (s) on the machine is `model`, whose states are the same.
#[derive(Clone, Copy)]
pub struct ModelChange<'a> {
    pub time: f64,
    pub model: &'a dyn Model,
}

/// Times (s) in order, each with the machine from then on.
pub type OwnedChanges = Vec<(f64, Arc<dyn Model>)>;

/// Takes the first `count` changes away: the machine of the last of them.
pub(crate) fn take(changes: &mut OwnedChanges, count: usize) -> Option<Arc<dyn Model>> {
    if !CHAINS {
        return None;
    }
    changes.drain(..count).next_back().map(|(_, model)| model)
}

/// Number of changes at these times (s, ascending) that are due at `now` (s).
pub(crate) fn count_due(times: impl Iterator<Item = f64>, now: f64) -> usize {
    if CHAINS {
        times.take_while(|time| *time <= now + ROUNDING).count()
    } else {
        0
    }
}

impl<'a> ModelChange<'a> {
    pub fn all(owned: &'a [(f64, Arc<dyn Model>)]) -> Vec<Self> {
        let owned = if CHAINS { owned } else { &[] };
        owned.iter().map(|(time, model)| ModelChange { time: *time, model: model.as_ref() }).collect()
    }
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

    /// Number of changes that have happened.
    pub fn done(&self) -> usize {
        if CHAINS {
            self.next
        } else {
            0
        }
    }

    /// The machine of the last change that is due at `now` (s), if one is.
    pub fn due(&mut self, now: f64) -> Option<&'a dyn Model> {
        if !CHAINS {
            return None;
        }
        let due = count_due(self.changes[self.next..].iter().map(|change| change.time), now);
        self.next += due;
        (due > 0).then(|| self.changes[self.next - 1].model)
    }
}
