//! A sensor that is left out, and when it reads plausibly again.      theory: docs/theory/control/plausibility.md

use crate::interface::signal::{Kind, Signal};
use crate::model::feed_forward::Moment;
use crate::monitor::passage::Passage;

/// A suspect sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Suspect {
    pub signal: Signal,
    pub kind: Kind,
    /// s
    pub from: f64,
    /// Expected piston position (m), or the pressure that does not change (Pa).
    pub expected: f64,
    /// Since when it reads plausibly again, s.
    pub plausible: Option<f64>,
}

/// A sensor that reads plausibly again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Returned {
    pub signal: Signal,
    pub kind: Kind,
    /// Since when its readings were not used, s.
    pub from: f64,
}

/// What a suspect sensor of a cylinder is judged by.
pub(crate) struct Judged<'a> {
    /// Piston and pressures as they read now.
    pub now: &'a Moment,
    /// Where the piston was read last while its joint was trusted, m.
    pub known: f64,
    pub passage: Option<&'a Passage>,
    /// Whether a short gap ends at this sample with nothing to hold it against.
    pub unjudged: bool,
    /// Whether its gap was short.
    pub short: bool,
    /// Change of each reading since the sample before: of the joint (rad or m) and of its pressures (Pa).
    pub change: [f64; 3],
    /// Displacement that counts as a jump, and that within which a position is where it is expected, m.
    pub jump: f64,
    pub near: f64,
}

impl Suspect {
    /// Whether it reads plausibly again; `wrong`: what its reading is by itself.
    pub fn fits(&mut self, wrong: Option<Kind>, by: &Judged) -> bool {
        let missing = matches!(self.kind, Kind::NoReading | Kind::OutOfRange | Kind::InBadSample);
        if let Some(kind) = wrong {
            if let (true, Kind::Jump(_)) = (missing, kind) {
                (self.kind, self.expected) = (kind, by.known);
            }
            return false;
        }
        let back = |size: f64| returned(by.change[self.signal.place()], size);
        match (self.kind, self.signal) {
            // After a short gap the piston cannot be but where the oil says.
            (_, Signal::Joint(_)) if missing && by.short => match by.passage {
                Some(p) if p.contradicted(by.jump) => {
                    (self.kind, self.expected) = (p.jumped(), p.expected());
                    false
                }
                Some(_) => true,
                None => by.unjudged,
            },
            (Kind::Jump(size), Signal::Joint(_)) if back(size) => {
                self.expected = by.now.stroke;
                true
            }
            (Kind::Jump(_) | Kind::Frozen(_), Signal::Joint(_)) => {
                self.expected += by.passage.map_or(0.0, |p| p.narrow(by.near));
                (by.now.stroke - self.expected).abs() <= by.near
            }
            (Kind::Jump(size), Signal::Pressure(..)) => self.plausible.is_some() || back(size),
            (Kind::Frozen(_), Signal::Pressure(_, side)) => by.now.p[side] != self.expected,
            _ => true,
        }
    }
}

/// Whether a reading has taken back a jump of `size`.
pub(crate) fn returned(change: f64, size: f64) -> bool {
    (0.5..1.5).contains(&(-change / size))
}
