//! Where a piston can be, whatever is read now.                       theory: docs/theory/control/plausibility.md
//!
//! From where a piston was read last it gets no further than its valve lets oil out of the chamber before it, at any pressure that the
//! machine can have, and than that oil can be compressed.

use crate::model::controller_model::CylinderModel;
use crate::model::feed_forward::Moment;
use crate::model::oil_displacement::{compressed, outflow, Interval, Trust};
use hydrocrane_physics::hydraulics::fluid::Fluid;

/// Share of the load that accelerations may add.
pub(crate) const DYNAMIC: f64 = 0.25;

/// A piston since its joint was trusted last.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Whereabouts {
    /// The last readings: of the joint (rad or m), and what they make.
    pub q: f64,
    pub moment: Moment,
    /// How far the oil that has left can have moved the piston, m, until the time `t` (s).
    t: f64,
    moved: Interval,
}

impl Whereabouts {
    /// Of a piston that is read at time `t` (s).
    pub fn at(t: f64, q: f64, moment: Moment) -> Self {
        Whereabouts { q, moment, t, moved: Interval::ZERO }
    }

    /// The time until which it is known, s.
    pub fn t(&self) -> f64 {
        self.t
    }

    /// Until time `t` (s), with the spool asked for positions within `asked` (m).
    pub fn until(self, t: f64, c: &CylinderModel, trust: &Trust, asked: Interval, highest: f64) -> Self {
        let moved = self.moved.plus(outflow(c, trust, asked, highest).times(t - self.t));
        Whereabouts { t, moved, ..self }
    }

    /// Whether the piston can be at `stroke` (m), read within `scatter` (m); its pressures can rise to `highest` (Pa).
    pub fn reach(&self, stroke: f64, scatter: f64, c: &CylinderModel, fluid: &Fluid<f64>, highest: f64) -> bool {
        let (travel, by_flow) = (Interval::at(stroke - self.moment.stroke), self.moved.widened(scatter, 0.0));
        // Motion in order never needs what the oil gives way.
        by_flow.gap(&travel) == 0.0 || {
            let p = self.moment.p.map(|p| if p.is_finite() { p } else { 0.0 });
            by_flow.plus(compressed(c, fluid, self.moment.stroke, p, highest)).gap(&travel) == 0.0
        }
    }
}
