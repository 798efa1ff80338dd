//! The operator's sticks against time: dead zone, interpolation, precision, ramp; and the goals of the tip.

use hydrocrane_control::controller::{Goal, Stick};
pub use hydrocrane_machine::scenario::StickMode as StickKind;

/// Rounding error by which a deflection may exceed its end; it counts as the end.
pub const ROUNDING: f64 = 1e-9;

/// The operator's input.
#[derive(Debug, Clone, PartialEq)]
pub struct Sticks {
    pub kind: StickKind,
    /// Ascending, s. Before the first, every stick is centred.
    pub times: Vec<f64>,
    /// Row-major, `times.len() x axes`, -1 to 1.
    pub deflections: Vec<f64>,
    pub axes: usize,
    /// Whether deflections are interpolated linearly instead of held.
    pub linear: bool,
    /// Dead zone: smaller deflections have no effect; the rest counts from zero to one.
    pub dead_zone: f64,
    /// Time of a stick from its centre to its end, s; zero: it jumps.
    pub ramp: f64,
    /// Share of the full speed from each of the times on, 0 to 1; empty: full speed.
    pub precision: Vec<f64>,
    /// Goals of the tip in order of time; moving a stick cancels a goal.
    pub goals: Vec<Goal>,
}

impl Sticks {
    /// All sticks permanently centred.
    pub fn centred(kind: StickKind, cylinders: usize) -> Self {
        let axes = if kind == StickKind::Tip { 2 } else { cylinders };
        Sticks {
            kind,
            times: Vec::new(),
            deflections: Vec::new(),
            axes,
            linear: false,
            dead_zone: 0.0,
            ramp: 0.0,
            precision: Vec::new(),
            goals: Vec::new(),
        }
    }

    /// Whether a stick moves or there is a goal.
    pub fn idle(&self) -> bool {
        self.times.is_empty() && self.goals.is_empty()
    }

    /// Deflection of one axis at time `t`.
    fn raw(&self, axis: usize, t: f64) -> f64 {
        self.between(t, |row| self.deflections[row * self.axes + axis]).unwrap_or(0.0)
    }

    /// Share of the full speed at time `t`.
    fn share(&self, t: f64) -> f64 {
        if self.precision.is_empty() {
            return 1.0;
        }
        self.between(t, |row| self.precision[row]).unwrap_or(1.0).clamp(0.0, 1.0)
    }

    /// A value of the rows at time `t`; none before the first.
    fn between(&self, t: f64, value: impl Fn(usize) -> f64) -> Option<f64> {
        let next = self.times.partition_point(|&time| time <= t + 1e-12);
        if next == 0 {
            return None;
        }
        Some(match (self.linear, self.times.get(next)) {
            (true, Some(&end)) => {
                let begin = self.times[next - 1];
                value(next - 1) + (value(next) - value(next - 1)) * (t - begin) / (end - begin)
            }
            _ => value(next - 1),
        })
    }

    /// Target of one axis at time `t`, after its dead zone.
    fn wanted(&self, axis: usize, t: f64) -> f64 {
        let raw = self.raw(axis, t).clamp(-1.0, 1.0);
        let beyond = raw - raw.clamp(-self.dead_zone, self.dead_zone);
        self.share(t) * (beyond / (1.0 - self.dead_zone))
    }

    /// Goals given until time `t`.
    fn given(&self, t: f64) -> usize {
        self.goals.partition_point(|goal| goal.given <= t + 1e-12)
    }
}

/// The sticks as they advance in time.
pub(crate) struct Hand {
    sticks: Sticks,
    at: Vec<f64>,
    since: f64,
    /// Number of goals that are no longer active, counted from the first.
    past: usize,
    /// A goal that was given while a stick was deflected.
    refused: Option<Goal>,
}

impl Hand {
    /// Centred at time `now` (s).
    pub fn new(sticks: Sticks, now: f64) -> Self {
        Hand { at: vec![0.0; sticks.axes], sticks, since: now, past: 0, refused: None }
    }

    /// Uses `sticks` from time `t` on; sticks of another mode begin centred. Earlier goals remain.
    pub fn take(&mut self, mut sticks: Sticks, t: f64) {
        let (mut earlier, before) = (self.sticks.goals.clone(), sticks.given(t));
        earlier.truncate(self.sticks.given(t));
        earlier.extend(sticks.goals.drain(..).skip(before));
        sticks.goals = earlier;
        let same = sticks.kind == self.sticks.kind && sticks.axes == self.sticks.axes;
        if !same {
            (self.at, self.since) = (vec![0.0; sticks.axes], t);
            self.past = sticks.given(t);
        }
        self.sticks = sticks;
    }

    /// Record of the operator's input so far.
    pub fn sticks(&self) -> &Sticks {
        &self.sticks
    }

    /// Removes the planned input after the last of `samples` (s). Linearly interpolated sticks are replaced by held
    /// values at each sample, which makes no difference for a controller that samples there.
    pub fn forget_after(&mut self, samples: impl Iterator<Item = f64>) {
        let mut last = f64::NEG_INFINITY;
        if self.sticks.linear {
            let straight = self.sticks.clone();
            let (times, deflections, precision) = (Vec::new(), Vec::new(), Vec::new());
            self.sticks = Sticks { times, deflections, precision, linear: false, ..straight.clone() };
            for t in samples {
                let there: Vec<f64> = (0..straight.axes).map(|axis| straight.raw(axis, t)).collect();
                self.hold(t, &there, straight.share(t));
                last = t;
            }
        } else {
            last = samples.last().unwrap_or(last);
            let kept = self.sticks.times.partition_point(|&time| time <= last);
            self.sticks.times.truncate(kept);
            self.sticks.deflections.truncate(kept * self.sticks.axes);
            self.sticks.precision.truncate(kept);
        }
        let given = self.sticks.given(last);
        self.sticks.goals.truncate(given);
        for goal in self.sticks.goals.iter_mut().filter(|goal| goal.until > last) {
            goal.until = f64::INFINITY;
        }
    }

    /// Holds `deflections` with this `share` of the full speed from time `t` on. Times must increase.
    pub fn hold(&mut self, t: f64, deflections: &[f64], share: f64) {
        let axes = self.sticks.axes;
        let last = self.sticks.deflections.len().saturating_sub(axes);
        let before = self.sticks.precision.last().copied().unwrap_or(1.0);
        if self.sticks.deflections[last..] != *deflections || before != share {
            if share != 1.0 || !self.sticks.precision.is_empty() {
                self.sticks.precision.resize(self.sticks.times.len(), 1.0);
                self.sticks.precision.push(share);
            }
            self.sticks.times.push(t);
            self.sticks.deflections.extend_from_slice(deflections);
        }
    }

    /// Adds `goal`, which is active from its time on. Times must increase.
    pub fn go_to(&mut self, goal: Goal) {
        self.sticks.goals.push(goal);
    }

    /// A goal that was given while a stick was deflected; returned once.
    pub fn refused(&mut self) -> Option<Goal> {
        self.refused.take()
    }

    /// Cancels the present goal at time `t`.
    pub fn drop_goal(&mut self, t: f64) {
        if let Some(goal) = self.sticks.goals.get_mut(self.past..).and_then(|ahead| ahead.last_mut()) {
            goal.until = t;
        }
    }

    /// The active goal.
    pub fn goal(&self) -> Option<Goal> {
        let given = self.sticks.given(self.since);
        (self.past < given).then(|| self.sticks.goals[given - 1])
    }

    /// The controller has reached or left its goal.
    pub fn arrive(&mut self) {
        self.past = self.sticks.given(self.since);
    }

    /// Advances to time `t` and returns the deflections there.
    pub fn move_to(&mut self, t: f64) -> &[f64] {
        let most = if self.sticks.ramp > 0.0 { (t - self.since) / self.sticks.ramp } else { f64::INFINITY };
        for (axis, at) in self.at.iter_mut().enumerate() {
            // The sum of the position and the missing part may miss the target by rounding.
            *at = (*at + (self.sticks.wanted(axis, t) - *at).clamp(-most, most)).clamp(-1.0, 1.0);
        }
        let given = self.sticks.given(t);
        if self.past < given && self.sticks.goals[given - 1].until <= t + 1e-12 {
            self.past = given;
        }
        if self.past < given && (0..self.at.len()).any(|axis| self.sticks.wanted(axis, t) != 0.0) {
            let goal = self.sticks.goals[given - 1];
            self.refused = (goal.given > self.since || self.since == t).then_some(goal);
            self.past = given;
        }
        self.since = t;
        &self.at
    }

    /// The present deflections.
    pub fn at(&self) -> &[f64] {
        &self.at
    }

    /// The deflections in the form for a controller.
    pub fn stick(&self) -> Stick<'_> {
        if let Some(goal) = self.goal() {
            return Stick::Goal(Goal { share: self.sticks.share(self.since), ..goal });
        }
        match (self.sticks.kind, self.at.as_slice()) {
            (StickKind::Tip, &[x, z]) => Stick::Tip([x, z]),
            (StickKind::Height, _) => Stick::Height(&self.at),
            _ => Stick::Lever(&self.at),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sticks(linear: bool, dead_zone: f64, ramp: f64) -> Sticks {
        let (times, deflections) = (vec![1.0, 2.0], vec![0.0, 1.0, 1.0, -1.0]);
        Sticks { times, deflections, linear, dead_zone, ramp, ..Sticks::centred(StickKind::Tip, 0) }
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
            hand.hold(t, &[0.0, z], 1.0);
            assert_eq!(hand.move_to(t), [0.0, z]);
        }
        assert_eq!(hand.sticks().times, [0.0, 0.2]);
        assert!(hand.sticks().precision.is_empty(), "nothing was said of it");
        hand.hold(0.3, &[0.0, -0.5], 0.25);
        hand.hold(0.4, &[0.0, -0.5], 1.0);
        assert_eq!(
            (&hand.sticks().times[2..], &hand.sticks().precision[..]),
            (&[0.3, 0.4][..], &[1.0, 1.0, 0.25, 1.0][..])
        );
        assert_eq!((hand.move_to(0.35)[1], hand.move_to(0.45)[1]), (-0.125, -0.5));
    }

    #[test]
    fn precision_slows_the_stick_through_its_ramp() {
        let slower = Sticks { precision: vec![1.0, 0.25], ..sticks(false, 0.2, 0.5) };
        let mut hand = Hand::new(slower, 0.0);
        assert_eq!(hand.move_to(1.9)[1], 1.0);
        assert!((hand.move_to(2.1)[0] - 0.25).abs() < 1e-12);
        assert!((hand.at()[1] - 0.6).abs() < 1e-12, "on the way from 1 to -0.25");
    }

    fn goal(given: f64, x: f64) -> Goal {
        Goal { place: [x, 0.0], speed: None, share: 1.0, given, until: f64::INFINITY }
    }

    /// To where the controller is sent at each time.
    fn sent(hand: &mut Hand, times: &[f64]) -> Vec<Option<f64>> {
        let at = |t: &f64| {
            hand.move_to(*t);
            match hand.stick() {
                Stick::Goal(goal) => Some(goal.place[0]),
                _ => None,
            }
        };
        times.iter().map(at).collect()
    }

    #[test]
    fn a_goal_holds_until_the_next_one_or_until_a_stick_is_moved() {
        // The sticks are centred until 1 s and from 2 s on.
        let (times, deflections) = (vec![1.0, 2.0], vec![0.5, 0.0, 0.0, 0.0]);
        let goals = vec![goal(0.1, 1.0), goal(0.5, 2.0), goal(1.5, 3.0), goal(3.0, 4.0)];
        let plan = Sticks { times, deflections, goals, ..sticks(false, 0.0, 0.5) };
        let mut hand = Hand::new(plan.clone(), 0.0);
        assert_eq!(sent(&mut hand, &[0.0, 0.1, 0.4, 0.5, 0.9]), [None, Some(1.0), Some(1.0), Some(2.0), Some(2.0)]);
        assert_eq!((sent(&mut hand, &[1.0, 1.4]), hand.refused()), (vec![None; 2], None));
        assert_eq!((sent(&mut hand, &[1.5]), hand.refused()), (vec![None], Some(goal(1.5, 3.0))));
        assert_eq!(sent(&mut hand, &[2.5, 3.0]), [None, Some(4.0)], "a stick that is released starts nothing");
        hand.arrive();
        assert_eq!(sent(&mut hand, &[3.1]), [None]);
        // Another phase with the same goals starts none of them again; another operator's plan has its own.
        hand.take(plan.clone(), 3.2);
        assert_eq!(sent(&mut hand, &[3.3]), [None]);
        hand.take(Sticks { goals: vec![goal(4.0, 5.0)], ..plan }, 3.5);
        assert_eq!(sent(&mut hand, &[3.6, 4.0]), [None, Some(5.0)]);
        assert_eq!(hand.sticks().goals.len(), 5);
        hand.forget_after([3.9].into_iter());
        assert_eq!((sent(&mut hand, &[4.1]), hand.sticks().goals.len()), (vec![None], 4));
    }

    #[test]
    fn a_goal_that_is_dropped_is_past_from_then_on_and_again_when_repeated() {
        let mut hand = Hand::new(Sticks::centred(StickKind::Tip, 0), 0.0);
        hand.drop_goal(0.0);
        assert!(hand.sticks().idle(), "there is none to drop");
        hand.go_to(goal(0.1, 1.0));
        assert_eq!(sent(&mut hand, &[0.1, 0.2]), [Some(1.0); 2]);
        hand.drop_goal(0.3);
        assert_eq!(sent(&mut hand, &[0.3, 0.4]), [None; 2]);
        let mut again = Hand::new(hand.sticks().clone(), 0.0);
        assert_eq!(sent(&mut again, &[0.1, 0.2, 0.3]), [Some(1.0), Some(1.0), None]);
        again.go_to(goal(0.5, 2.0));
        assert_eq!(sent(&mut again, &[0.5]), [Some(2.0)]);
        // Somebody who takes over a replay has not dropped the goal yet.
        let mut taken = Hand::new(hand.sticks().clone(), 0.0);
        assert_eq!(sent(&mut taken, &[0.2]), [Some(1.0)]);
        taken.forget_after([0.2].into_iter());
        assert_eq!(sent(&mut taken, &[0.3]), [Some(1.0)]);
    }
}
