//! What the operator asks `tip` for.

use crate::interface::controller::{Fault, Goal, Stick};
use crate::reference::slow_down::{checked_goal, checked_levers, checked_stick};

pub enum Wanted<const N: usize> {
    /// Of the tip forward, up and across the plane, m/s.
    Velocity([f64; 3]),
    /// Deflections of levers, while the height of the tip is held.
    Levers([f64; N]),
    Goal(Goal),
}

impl<const N: usize> Wanted<N> {
    /// By this stick, whose end asks for `full_speed` (m/s), of a crane that `slews` or not.
    pub fn by(stick: Stick, full_speed: f64, slews: bool) -> Result<Self, Fault> {
        Ok(match stick {
            Stick::Goal(goal) => Wanted::Goal(checked_goal(goal)?),
            Stick::Height(axes) => Wanted::Levers(checked_levers(axes)?),
            _ => Wanted::Velocity(checked_stick(stick, slews)?.map(|s| s * full_speed)),
        })
    }
}
