//! A controller whose sensors are monitored, with a safe state.  theory: docs/theory/control/plausibility.md
//!
//! A sensor that fails for a moment is left out, and control goes on without it. One that fails for longer leads to the safe state:
//! the crane stops as if the stick were released, then the valves close and hold the load. They stay closed until all sensors have
//! read plausibly for the recovery time and the sticks are released; then the controller restarts from where the crane stands.

use crate::controller::{Controller, Fault, Measurement, Stick};
use crate::plausibility::{Kind, Monitor, Returned};
use crate::signal::Signal;
use crate::valve_learning::LearntValve;
use std::sync::Arc;

/// Spool position (m) that a command (m) to the valve of a cylinder asks for.
pub type SpoolOf = Arc<dyn Fn(usize, f64) -> f64 + Send + Sync>;

/// Longest time that a controller takes to stop without a sensor, s; then the valves close.
const STOPPING: f64 = 1.5;
/// Time in which the valves close, s.
const CLOSING: f64 = 0.1;

/// Runs a controller while its sensors are plausible, without one that fails for a moment, and stops the crane beyond.
pub struct SafeState<const N: usize> {
    inner: Box<dyn Controller>,
    monitor: Monitor<N>,
    spool_of: SpoolOf,
    /// Commands at which the spools are centred, m.
    neutral: [f64; N],
    /// Names of joints and cylinders, and whether a joint turns.
    names: Names,
    phase: Phase,
    /// Time without a joint and without each of its pressures, less what good readings have made up for, s.
    missed: [[f64; 3]; N],
    /// Readings that could be used last.
    usable: Option<Usable<N>>,
    /// Last command, m.
    command: [f64; N],
    notices: Vec<String>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Phase {
    /// The controller has the spools.
    Driving,
    /// The controller stops the crane; since when, s.
    Stopping(f64),
    /// The spools close, or are closed; since when, s.
    Closing(f64),
}

#[derive(Debug, Clone, Copy)]
struct Usable<const N: usize> {
    t: f64,
    q: [f64; N],
    p: [[f64; 2]; N],
}

/// What the messages call things.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Names {
    pub joints: Vec<String>,
    pub revolute: Vec<bool>,
    pub cylinders: Vec<String>,
}

impl<const N: usize> SafeState<N> {
    pub fn new(
        inner: Box<dyn Controller>,
        monitor: Monitor<N>,
        spool_of: SpoolOf,
        neutral: [f64; N],
        names: Names,
    ) -> Self {
        SafeState {
            inner,
            monitor,
            spool_of,
            neutral,
            names,
            phase: Phase::Driving,
            missed: [[0.0; 3]; N],
            usable: None,
            command: [0.0; N],
            notices: Vec::new(),
        }
    }

    /// Tells of the sensors because of which the crane stops or stands.
    fn tell(&mut self, because: &[(Signal, Kind)]) {
        for &(signal, kind) in because {
            let (what, why) = self.names.fault(signal, kind);
            self.notices.push(format!(
                "{what} {why}; the crane stops and its spools go to neutral until its reading has been plausible for {} s and the \
                 stick is released: check the sensor and its cable",
                self.monitor.recovery_time()
            ));
        }
    }

    /// Counts the time without each sensor, `h` (s) after the last sample; whether one of `gaps` lasts too long.
    fn worn_out(&mut self, gaps: &[(Signal, Kind)], h: f64) -> bool {
        let most = self.monitor.ride_through();
        let regained = h * most / self.monitor.recovery_time().max(h);
        let mut worn_out = false;
        for (c, times) in self.missed.iter_mut().enumerate() {
            for (place, missed) in times.iter_mut().enumerate() {
                let gap = gaps.iter().find(|(signal, _)| (signal.cylinder(), signal.place()) == (c, place));
                *missed = gap.map_or((*missed - regained).max(0.0), |_| *missed + h);
                worn_out |= gap.is_some() && *missed > most + ROUNDING;
            }
        }
        worn_out
    }

    fn tell_of_return(&mut self, t: f64, back: &[Returned]) {
        for &Returned { signal, kind, from } in back {
            let (what, why) = self.names.fault(signal, kind);
            self.notices.push(format!(
                "{what} {why}; control continued without it for {:.0} ms from {from:.3} s on: check the sensor and its cable",
                1e3 * (t - from)
            ));
        }
    }

    /// The measurement with the last usable readings in the place of those of `gaps`; `None` where there are none.
    fn usable(&mut self, m: &Measurement, gaps: &[Signal]) -> Option<Usable<N>> {
        let read = Usable {
            t: m.t,
            q: hydrocrane_num::array::from_fn(|i| m.q.get(i).copied().unwrap_or(f64::NAN)),
            p: hydrocrane_num::array::from_fn(|c| m.p.get(c).copied().unwrap_or([f64::NAN; 2])),
        };
        let mut usable = read;
        for &gap in gaps {
            let last = self.usable.as_ref()?;
            match gap {
                Signal::Joint(i) => usable.q[i] = last.q[i],
                Signal::Pressure(c, side) => usable.p[c][side] = last.p[c][side],
            }
        }
        self.usable = Some(usable);
        self.usable
    }

    /// Tells the monitor which spool positions are commanded.
    fn note(&mut self, t: f64, command: [f64; N]) {
        self.command = command;
        self.monitor.sent(t, hydrocrane_num::array::from_fn(|c| (self.spool_of)(c, command[c])));
    }

    /// Closes the spools, or keeps them closed.
    fn close(&mut self, t: f64, since: f64, spool: &mut [f64]) {
        // What is left falls by the same share of the first command at each sample.
        let left = (since + CLOSING - t).max(0.0);
        let before = left + self.inner.period();
        let command =
            hydrocrane_num::array::from_fn(|c| self.neutral[c] + (self.command[c] - self.neutral[c]) * left / before);
        spool.iter_mut().zip(command).for_each(|(out, u)| *out = u);
        self.note(t, command);
    }
}

/// Rounding of sums of periods, s.
const ROUNDING: f64 = 1e-6;

impl<const N: usize> Controller for SafeState<N> {
    fn period(&self) -> f64 {
        self.inner.period()
    }

    fn copied(&self) -> Option<Box<dyn Controller>> {
        Some(Box::new(SafeState {
            inner: self.inner.copied()?,
            monitor: self.monitor.clone(),
            spool_of: self.spool_of.clone(),
            names: self.names.clone(),
            notices: self.notices.clone(),
            ..*self
        }))
    }

    fn reset(&mut self, first: &Measurement) {
        self.monitor.reset();
        (self.phase, self.notices) = (Phase::Driving, Vec::new());
        (self.missed, self.usable, self.command) = ([[0.0; 3]; N], None, [0.0; N]);
        self.inner.reset(first);
    }

    fn step(&mut self, measured: &Measurement, stick: Stick, spool: &mut [f64]) -> Result<(), Fault> {
        let t = measured.t;
        let found = self.monitor.check(measured);
        let gaps: Vec<(Signal, Kind)> = self.monitor.gaps().collect();
        let h = self.usable.map_or(0.0, |last| t - last.t).max(self.inner.period());
        let worn_out = self.worn_out(&gaps, h);
        if self.phase != Phase::Driving {
            self.tell(&found);
            if !self.monitor.has_suspects(t) && released(stick) {
                self.phase = Phase::Driving;
                self.missed = [[0.0; 3]; N];
                self.monitor.clear();
                self.inner.reset(measured);
                self.notices.push("all sensors read plausibly and the stick is released: control restarts".into());
            }
        } else if gaps.iter().any(|(_, kind)| matches!(kind, Kind::Frozen(_))) {
            // It has misled the controller since long before it was found.
            self.tell(&gaps);
            self.phase = Phase::Closing(t);
        } else if worn_out {
            self.tell(&gaps);
            self.phase = Phase::Stopping(t);
        } else {
            let back = self.monitor.trust_again();
            self.tell_of_return(t, &back);
        }
        let gaps: Vec<Signal> = gaps.into_iter().map(|(signal, _)| signal).collect();
        let Some(usable) = self.usable(measured, &gaps) else {
            // There never was a reading to go on from.
            if self.phase == Phase::Driving {
                self.tell(&found);
            }
            self.phase = Phase::Closing(t);
            self.close(t, t, spool);
            return Ok(());
        };
        let centred = [0.0; N];
        let stick = match (self.phase, stick) {
            (Phase::Driving, stick) => stick,
            (_, Stick::Tip(_) | Stick::Goal(_)) => Stick::Tip([0.0; 2]),
            (_, Stick::Lever(axes)) => Stick::Lever(&centred[..axes.len().min(N)]),
            (_, Stick::Height(axes)) => Stick::Height(&centred[..axes.len().min(N)]),
        };
        if let Phase::Stopping(since) = self.phase {
            if t >= since + STOPPING || self.inner.stands() {
                self.phase = Phase::Closing(t);
            }
        }
        if let Phase::Closing(since) = self.phase {
            self.close(t, since, spool);
            return Ok(());
        }
        let filled = Measurement { t, q: &usable.q, p: &usable.p };
        let answer = self.inner.step_without(&filled, &gaps, stick, spool);
        let usable = answer.is_ok() && spool.iter().all(|u| u.is_finite());
        let sent = |c: usize| spool.get(c).copied().filter(|_| usable).unwrap_or(0.0);
        self.note(t, hydrocrane_num::array::from_fn(sent));
        answer
    }

    fn reads_pressures(&self) -> bool {
        self.inner.reads_pressures()
    }

    fn refuses(&self, place: [f64; 2]) -> Option<String> {
        self.inner.refuses(place)
    }

    /// A goal that a sensor has interrupted is not gone on to: the crane would move when nobody expects it.
    fn heading(&self) -> bool {
        self.phase == Phase::Driving && self.inner.heading()
    }

    fn set_point(&self) -> Option<[f64; 2]> {
        self.inner.set_point()
    }

    fn learnt(&self) -> Vec<LearntValve> {
        self.inner.learnt()
    }

    fn notices(&mut self) -> Vec<String> {
        let mut notices = core::mem::take(&mut self.notices);
        notices.append(&mut self.inner.notices());
        notices
    }
}

fn released(stick: Stick) -> bool {
    match stick {
        Stick::Tip(axes) => axes == [0.0; 2],
        Stick::Lever(axes) | Stick::Height(axes) => axes.iter().all(|d| *d == 0.0),
        Stick::Goal(_) => false,
    }
}

impl Names {
    /// What a sensor is called, and what is wrong with it.
    fn fault(&self, signal: Signal, kind: Kind) -> (String, String) {
        let (name, size) = match signal {
            Signal::Joint(i) if self.revolute[i] => {
                (format!("`joint.{}.q`", self.joints[i]), (180.0 / core::f64::consts::PI, "deg"))
            }
            Signal::Joint(i) => (format!("`joint.{}.q`", self.joints[i]), (1e3, "mm")),
            Signal::Pressure(c, side) => (format!("`cylinder.{}.p{}`", self.cylinders[c], side + 1), (1e-5, "bar")),
        };
        let why = match kind {
            Kind::NoReading => "gives no reading".to_string(),
            Kind::OutOfRange => "is out of range: the machine cannot have this position".to_string(),
            Kind::Jump(by) => {
                format!("jumped by {:.3} {} in one sample, which no other reading confirms", by * size.0, size.1)
            }
            Kind::Frozen(missed) => {
                format!("is frozen: it has not changed while the piston moved by {:.1} mm", missed.abs() * 1e3)
            }
        };
        (name, why)
    }
}
