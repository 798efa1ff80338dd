//! A cylinder from one sample to the next.                           theory: docs/theory/control/plausibility.md

use crate::interface::signal::Kind;
use crate::model::feed_forward::Moment;
use crate::model::oil_displacement::{Interval, OilDisplacement};

/// Least time between two samples that are compared, s: faster ones would drown in scatter.
pub const INTERVAL: f64 = 0.01;

/// One cylinder at its last sample, and what has happened since each of its readings last changed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Track {
    pub t: f64,
    pub moment: Moment,
    /// Force of the planned load, N.
    pub load: f64,
    pub reading: f64,
    /// Displacement by the oil while the position reading stayed the same.
    pub missed: [OilDisplacement; 2],
    /// The cylinder where each pressure reading last changed.
    pub changed: [Standing; 2],
    /// The sample before, s.
    pub earlier: Option<(f64, Moment)>,
    /// Bits that readings speak against each pressure sensor since, and the piston position at the last of them, m.
    pub against: [f64; 2],
    pub stirred: [f64; 2],
}

/// What a cylinder was like: piston position (m), pressures (Pa), and force of the planned load (N; not a number if unknown).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Standing {
    pub moment: Moment,
    pub load: f64,
}

/// One cylinder between two samples.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Passage {
    pub before: Track,
    pub now: Track,
    /// Displacements by the position sensor and by the oil of the chambers, m.
    pub measured: Interval,
    pub oil: [Interval; 2],
    /// By the oil since the position reading last changed or was there, m.
    pub total: [Interval; 2],
}

impl Passage {
    /// Whether both chambers agree that the piston is not where it reads, since its reading last changed or was there.
    pub fn contradicted(&self, jump: f64) -> bool {
        let [one, two] = &self.total;
        one.gap(two) <= jump && one.between(two).gap(&self.measured) > jump
    }

    /// The jump of the position reading.
    pub fn jumped(&self) -> Kind {
        Kind::Jump(self.now.reading - self.before.reading)
    }

    /// Where the oil says that the piston is, since its reading last changed or was there, m.
    pub fn expected(&self) -> f64 {
        self.before.moment.stroke + self.total[0].between(&self.total[1]).middle()
    }

    /// Displacement that both chambers share, m; none where they differ by more than a `jump`.
    pub fn agreed(&self, jump: f64) -> f64 {
        let [one, two] = &self.oil;
        if one.gap(two) <= jump {
            one.between(two).middle()
        } else {
            0.0
        }
    }

    /// Middle of what both chambers say, where they know better than `within` (m).
    pub fn narrow(&self, within: f64) -> f64 {
        let oil = self.oil[0].between(&self.oil[1]);
        if oil.high - oil.low < within {
            oil.middle()
        } else {
            0.0
        }
    }
}
