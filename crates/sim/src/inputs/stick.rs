//! The operator's sticks against time: dead zone, interpolation, precision, ramp; and the goals of the tip.

use hydrocrane_control::interface::controller::{Goal, Stick};
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
    /// All sticks permanently centred, with so many `axes`.
    pub fn centred(kind: StickKind, axes: usize) -> Self {
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
pub struct Hand {
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
        match self.sticks.kind {
            StickKind::Tip => Stick::Tip(&self.at),
            StickKind::Height => Stick::Height(&self.at),
            StickKind::Lever => Stick::Lever(&self.at),
        }
    }
}
