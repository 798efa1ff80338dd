//! What a controller measures, by name: a joint and two pressures per cylinder; and what can be wrong with it.

use arrayvec::ArrayVec;

/// A measured signal of a crane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Signal {
    Joint(usize),
    /// Cylinder, and 0 for its piston side or 1 for its rod side.
    Pressure(usize, usize),
}

/// What is wrong with a reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    NoReading,
    OutOfRange,
    /// By this much (rad, m or Pa) from one sample to the next, which nothing explains.
    Jump(f64),
    /// Unchanged while the piston must have moved this far, m.
    Frozen(f64),
    /// Nothing in both chambers, where oil has carried a load the sample before.
    Vanished,
    /// It came with others that cannot be right.
    InBadSample,
}

/// Signals of one cylinder, and of the largest crane.
pub const PER_CYLINDER: usize = 3;
pub const MOST: usize = 6 * PER_CYLINDER;

/// One thing for each of some signals of a crane.
pub type OfSignals<T> = ArrayVec<T, MOST>;

impl Signal {
    /// The one at this `place` among the three of a cylinder.
    pub fn of_cylinder(cylinder: usize, place: usize) -> Self {
        match place {
            0 => Signal::Joint(cylinder),
            place => Signal::Pressure(cylinder, place - 1),
        }
    }

    /// Of the cylinder that the sensor belongs to.
    pub fn cylinder(self) -> usize {
        match self {
            Signal::Joint(c) | Signal::Pressure(c, _) => c,
        }
    }

    /// Its place among the three signals of the cylinder: the joint, then the pressures.
    pub fn place(self) -> usize {
        match self {
            Signal::Joint(_) => 0,
            Signal::Pressure(_, side) => 1 + side,
        }
    }
}
