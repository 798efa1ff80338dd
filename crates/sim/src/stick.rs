//! The operator's sticks against time: dead zone, interpolation, ramp.

use hydrocrane_control::controller::Stick;
pub use hydrocrane_machine::scenario::StickMode as StickKind;

/// How far beyond its end rounding may take a deflection; it counts as the end.
pub const ROUNDING: f64 = 1e-9;

/// What the operator does.
#[derive(Debug, Clone, PartialEq)]
pub struct Sticks {
    pub kind: StickKind,
    /// Ascending, s. Before the first, every stick is centred.
    pub times: Vec<f64>,
    /// Row-major, `times.len() x axes`, -1 to 1.
    pub deflections: Vec<f64>,
    pub axes: usize,
    /// Straight between the rows instead of held.
    pub linear: bool,
    /// Deflections up to this size do nothing; beyond it the rest of the way counts from zero to one.
    pub dead_zone: f64,
    /// Time that a stick takes from its centre to its end, s; zero: it jumps.
    pub ramp: f64,
}

impl Sticks {
    /// All sticks centred, for ever.
    pub fn centred(kind: StickKind, cylinders: usize) -> Self {
        let axes = if kind == StickKind::Tip { 2 } else { cylinders };
        Sticks { kind, times: Vec::new(), deflections: Vec::new(), axes, linear: false, dead_zone: 0.0, ramp: 0.0 }
    }

    /// Where one axis is held at time `t`.
    fn raw(&self, axis: usize, t: f64) -> f64 {
        let next = self.times.partition_point(|&time| time <= t + 1e-12);
        if next == 0 {
            return 0.0;
        }
        let value = |row: usize| self.deflections[row * self.axes + axis];
        match (self.linear, self.times.get(next)) {
            (true, Some(&end)) => {
                let begin = self.times[next - 1];
                value(next - 1) + (value(next) - value(next - 1)) * (t - begin) / (end - begin)
            }
            _ => value(next - 1),
        }
    }

    /// Where the operator wants one axis at time `t`, after its dead zone.
    fn wanted(&self, axis: usize, t: f64) -> f64 {
        let raw = self.raw(axis, t).clamp(-1.0, 1.0);
        let beyond = raw - raw.clamp(-self.dead_zone, self.dead_zone);
        beyond / (1.0 - self.dead_zone)
    }
}

/// The sticks on their way through time.
pub(crate) struct Hand {
    sticks: Sticks,
    at: Vec<f64>,
    since: f64,
}

impl Hand {
    /// Centred at time `now` (s).
    pub fn new(sticks: Sticks, now: f64) -> Self {
        Hand { at: vec![0.0; sticks.axes], sticks, since: now }
    }

    /// From time `t` on the operator does what `sticks` say; levers in another hand begin centred.
    pub fn take(&mut self, sticks: Sticks, t: f64) {
        let same = sticks.kind == self.sticks.kind && sticks.axes == self.sticks.axes;
        if !same {
            (self.at, self.since) = (vec![0.0; sticks.axes], t);
        }
        self.sticks = sticks;
    }

    /// What the operator has done so far.
    pub fn sticks(&self) -> &Sticks {
        &self.sticks
    }

    /// Forgets what the operator would have done after the last of `samples` (s). Sticks that go straight between rows are
    /// held where they were at each sample from then on: a controller that samples there sees no difference.
    pub fn forget_after(&mut self, samples: impl Iterator<Item = f64>) {
        if self.sticks.linear {
            let straight = self.sticks.clone();
            self.sticks = Sticks { times: Vec::new(), deflections: Vec::new(), linear: false, ..straight };
            for t in samples {
                let there: Vec<f64> = (0..straight.axes).map(|axis| straight.raw(axis, t)).collect();
                self.hold(t, &there);
            }
        } else {
            let last = samples.last().unwrap_or(f64::NEG_INFINITY);
            let kept = self.sticks.times.partition_point(|&time| time <= last);
            self.sticks.times.truncate(kept);
            self.sticks.deflections.truncate(kept * self.sticks.axes);
        }
    }

    /// From time `t` on the operator holds `deflections`. Times must grow.
    pub fn hold(&mut self, t: f64, deflections: &[f64]) {
        let axes = self.sticks.axes;
        let last = self.sticks.deflections.len().saturating_sub(axes);
        if self.sticks.deflections[last..] != *deflections {
            self.sticks.times.push(t);
            self.sticks.deflections.extend_from_slice(deflections);
        }
    }

    /// Goes on to time `t` and tells the deflections there.
    pub fn move_to(&mut self, t: f64) -> &[f64] {
        let most = if self.sticks.ramp > 0.0 { (t - self.since) / self.sticks.ramp } else { f64::INFINITY };
        for (axis, at) in self.at.iter_mut().enumerate() {
            // The sum of where it is and what it lacks may miss the end of a stick's way by rounding.
            *at = (*at + (self.sticks.wanted(axis, t) - *at).clamp(-most, most)).clamp(-1.0, 1.0);
        }
        self.since = t;
        &self.at
    }

    /// The deflections at hand.
    pub fn at(&self) -> &[f64] {
        &self.at
    }

    /// The deflections as a controller takes them.
    pub fn stick(&self) -> Stick<'_> {
        match (self.sticks.kind, self.at.as_slice()) {
            (StickKind::Tip, &[x, z]) => Stick::Tip([x, z]),
            _ => Stick::Lever(&self.at),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sticks(linear: bool, dead_zone: f64, ramp: f64) -> Sticks {
        let (times, deflections) = (vec![1.0, 2.0], vec![0.0, 1.0, 1.0, -1.0]);
        Sticks { kind: StickKind::Tip, times, deflections, axes: 2, linear, dead_zone, ramp }
    }

    #[test]
    fn held_and_straight_between_the_rows() {
        let at = |linear, t| Hand::new(sticks(linear, 0.0, 0.0), 0.0).move_to(t).to_vec();
        assert_eq!(at(false, 0.5), [0.0, 0.0]);
        assert_eq!(at(false, 1.5), [0.0, 1.0]);
        assert_eq!(at(true, 1.5), [0.5, 0.0]);
        assert_eq!(at(true, 9.0), [1.0, -1.0]);
    }

    #[test]
    fn rounding_does_not_lead_past_the_end_of_a_stick() {
        // The row begins a rounding error after the sample that it is meant for.
        let begin = 0.1 + 0.2;
        for (end, dead_zone, ramp) in [(1.0, 0.0, 0.0), (1.0, 0.1, 0.05), (1.0 + 0.5 * ROUNDING, 0.0, 0.0)] {
            let (times, deflections) = (vec![0.2, begin, 0.31], vec![end, -end, end, -end, -end, end]);
            let mut hand = Hand::new(Sticks { times, deflections, ..sticks(true, dead_zone, ramp) }, 0.0);
            for t in [0.0, 0.2, 0.25, 0.3, begin, 0.305, 0.31] {
                let at = hand.move_to(t);
                assert!(at.iter().all(|d| d.abs() <= 1.0), "{at:?} at {t} s");
            }
        }
    }

    #[test]
    fn the_dead_zone_leaves_full_deflection_full() {
        let zoned = sticks(true, 0.2, 0.0);
        assert_eq!(Hand::new(zoned.clone(), 0.0).move_to(2.0), [1.0, -1.0]);
        assert!((Hand::new(zoned.clone(), 0.0).move_to(1.6)[0] - 0.5).abs() < 1e-12);
        assert_eq!(Hand::new(zoned.clone(), 0.0).move_to(1.58)[1], 0.0, "0.16 backwards is inside the zone");
    }

    #[test]
    fn a_ramp_limits_the_speed_of_the_stick() {
        let ramped = sticks(false, 0.0, 0.2);
        let mut hand = Hand::new(ramped, 0.0);
        hand.move_to(0.99);
        assert!((hand.move_to(1.04)[1] - 0.25).abs() < 1e-12);
        assert_eq!(hand.move_to(1.5)[1], 1.0);
    }

    #[test]
    fn straight_sticks_taken_over_are_held_as_the_samples_saw_them() {
        let samples = || (0..=3).map(|k| 0.9 + 0.3 * f64::from(k));
        let mut hand = Hand::new(sticks(true, 0.2, 0.0), 0.0);
        let before: Vec<_> = samples().map(|t| hand.move_to(t).to_vec()).collect();
        hand.forget_after(samples());
        assert!(!hand.sticks().linear && hand.sticks().times.len() == 4, "{:?}", hand.sticks());
        let after: Vec<_> = samples().map(|t| hand.move_to(t).to_vec()).collect();
        assert_eq!(before, after);
        assert_eq!(hand.move_to(9.0), before[3], "what was to come is forgotten");
    }

    #[test]
    fn what_a_hand_holds_is_written_down_where_it_changes() {
        let mut hand = Hand::new(Sticks::centred(StickKind::Tip, 3), 0.0);
        for (t, z) in [(0.0, 0.5), (0.1, 0.5), (0.2, -0.5)] {
            hand.hold(t, &[0.0, z]);
            assert_eq!(hand.move_to(t), [0.0, z]);
        }
        assert_eq!(hand.sticks().times, [0.0, 0.2]);
    }
}
