//! Notices a tip that stands though the stick is out, and why.             theory: docs/theory/control/tip.md
//!
//! The set-point may slow down, not turn, so that a straight path can end where the tip could well go on another way. Whoever
//! holds the stick gets one notice, and another one only after the tip has moved.

/// Share of the speed asked for below which the tip counts as standing.
const STANDING: f64 = 0.1;
/// Time for which it stands before a notice, s.
const PATIENCE: f64 = 0.9;

/// Since when the tip has stood under a deflected stick.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Standstill {
    /// s
    lasted: f64,
}

impl Standstill {
    /// Takes in the speed asked for and that of the set-point (m/s) over one `period` (s); whether to tell now.
    pub fn watch(&mut self, asked: f64, given: f64, period: f64) -> bool {
        if given >= STANDING * asked {
            self.lasted = 0.0;
            return false;
        }
        let before = self.lasted;
        self.lasted += period;
        before < PATIENCE && self.lasted >= PATIENCE
    }
}

/// Cylinders that sink at rest and that the supply pressure cannot lift.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sinking {
    /// For how long, s.
    time: f64,
    /// Whether that was reported since the last motion.
    pub reported: bool,
}

impl Sinking {
    /// Whether cylinders, if not `none`, have been sinking for `most` (s) with this further `period` (s); it then counts anew.
    pub fn lasted(&mut self, none: bool, period: f64, most: f64) -> bool {
        self.time = if none { 0.0 } else { self.time + period };
        let lasted = self.time >= most;
        self.time = if lasted { 0.0 } else { self.time };
        lasted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tells_once_and_again_only_after_the_tip_has_moved() {
        let mut still = Standstill::default();
        let mut notices =
            |asked: f64, given: f64, samples: usize| (0..samples).filter(|_| still.watch(asked, given, 0.25)).count();
        assert_eq!(notices(0.2, 0.0, 3), 0, "too early");
        assert_eq!(notices(0.2, 0.0, 50), 1);
        assert_eq!(notices(0.2, 0.1, 1) + notices(0.2, 0.005, 3), 0);
        assert_eq!(notices(0.2, 0.005, 1), 1);
        // Nobody asks for anything.
        assert_eq!(notices(0.0, 0.0, 50), 0);
    }
}
