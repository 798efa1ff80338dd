//! What a controller measures, by name: a joint and two pressures per cylinder.

/// A measured signal of a crane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Signal {
    Joint(usize),
    /// Cylinder, and 0 for its piston side or 1 for its rod side.
    Pressure(usize, usize),
}

impl Signal {
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
