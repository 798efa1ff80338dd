//! A controller whose sensors are monitored, with a safe state.  theory: docs/theory/control/plausibility.md
//!
//! A sensor that fails for a moment is left out, and control goes on without it. One that fails for longer leads to the safe state:
//! the crane stops as if the stick were released, then the valves close and hold the load. They stay closed until all sensors have
//! read plausibly for the recovery time and the sticks are released; then the controller restarts from where the crane stands.

use crate::interface::controller::{Controller, Fault, Measurement, Reading, Stick};
#[cfg(feature = "std")]
use crate::interface::notice::Names;
use crate::interface::notice::News;
use crate::interface::signal::{OfSignals, Signal, MOST};
use crate::model::controller_model::ControllerModel;
use crate::monitor::plausibility::{Kind, Monitor, Returned};

/// Longest time that a controller takes to stop without a sensor, s; then the valves close.
const STOPPING: f64 = 1.5;
/// Time in which the valves close, s.
const CLOSING: f64 = 0.1;

/// A controller with the model of its crane, by which its sensors are judged.
pub trait Guarded<const N: usize> {
    type Controller: Controller + ?Sized;
    fn controller(&mut self) -> &mut Self::Controller;
    fn model(&self) -> &ControllerModel<N>;
}

/// What the monitor of the sensors tells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SensorNotice {
    /// The crane stops, or stays stopped, because of this sensor.
    Stops(Signal, Kind),
    /// Control went on without this sensor from one time until another, s.
    Continued { signal: Signal, kind: Kind, from: f64, until: f64 },
    /// All sensors read plausibly again, and the controller restarts.
    Restarts,
}

/// Whatever happens in one sample has room: each signal, and a restart.
pub type SensorNews = News<SensorNotice, { MOST + 1 }>;

/// Runs a controller while its sensors are plausible, without one that fails for a moment, and stops the crane beyond.
///
/// The controller is handed in at each call: without a heap it lies beside this, and both share one model.
#[derive(Clone)]
pub struct SafeState<const N: usize> {
    monitor: Monitor<N>,
    phase: Phase,
    /// Time without a joint and without each of its pressures, less what good readings have made up for, s.
    missed: [[f64; 3]; N],
    /// Readings that could be used last.
    usable: Option<Usable<N>>,
    /// Last command, m.
    command: [f64; N],
    news: SensorNews,
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

impl<const N: usize> SafeState<N> {
    pub fn new(monitor: Monitor<N>) -> Self {
        SafeState {
            monitor,
            phase: Phase::Driving,
            missed: [[0.0; 3]; N],
            usable: None,
            command: [0.0; N],
            news: SensorNews::default(),
        }
    }

    /// The monitor, which knows the suspect sensors.
    pub fn monitor(&self) -> &Monitor<N> {
        &self.monitor
    }

    /// Whether the controller has the spools.
    pub fn drives(&self) -> bool {
        self.phase == Phase::Driving
    }

    /// What has happened since the last call.
    pub fn take_news(&mut self) -> SensorNews {
        core::mem::take(&mut self.news)
    }

    /// Tells of the sensors because of which the crane stops or stands.
    fn tell(&mut self, because: &[(Signal, Kind)]) {
        let own = because.iter().filter(|(_, kind)| *kind != Kind::InBadSample);
        own.for_each(|&(signal, kind)| self.news.tell(SensorNotice::Stops(signal, kind)));
    }

    /// Counts the time without each sensor, `h` (s) after the last sample; whether one of `gaps` lasts too long. Nothing is said of those in
    /// doubt.
    fn worn_out(&mut self, gaps: &[(Signal, Kind)], doubted: &[Signal], h: f64) -> bool {
        let most = self.monitor.ride_through();
        let regained = h * most / self.monitor.recovery_time().max(h);
        let mut worn_out = false;
        for (c, times) in self.missed.iter_mut().enumerate() {
            for (place, missed) in times.iter_mut().enumerate() {
                let signal = Signal::of_cylinder(c, place);
                let gap = gaps.iter().any(|(of, _)| *of == signal);
                let left_out = gap || doubted.contains(&signal);
                *missed = if left_out { *missed + h } else { (*missed - regained).max(0.0) };
                worn_out |= gap && *missed > most + ROUNDING;
            }
        }
        worn_out
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

    /// Tells the monitor of the commands (m).
    fn note(&mut self, model: &ControllerModel<N>, t: f64, command: [f64; N]) {
        self.command = command;
        self.monitor.sent(model, t, &command);
    }

    /// Closes the spools, or keeps them closed.
    fn close(&mut self, guarded: &mut impl Guarded<N>, t: f64, since: f64, spool: &mut [f64]) {
        // What is left falls by the same share of the first command at each sample.
        let left = (since + CLOSING - t).max(0.0);
        let before = left + guarded.controller().period();
        // The commands that centre the spools.
        let neutral = guarded.model().cylinders.map(|cylinder| cylinder.chain.command(0.0));
        let command = hydrocrane_num::array::from_fn(|c| neutral[c] + (self.command[c] - neutral[c]) * left / before);
        spool.iter_mut().zip(command).for_each(|(out, u)| *out = u);
        self.note(guarded.model(), t, command);
    }

    /// Starts anew from a first measurement.
    pub fn reset(&mut self, guarded: &mut impl Guarded<N>, first: &Measurement) {
        self.monitor.reset();
        (self.phase, self.news) = (Phase::Driving, SensorNews::default());
        (self.missed, self.usable, self.command) = ([[0.0; 3]; N], None, [0.0; N]);
        guarded.controller().reset(first);
    }

    /// [`Controller::step`] behind the monitor.
    pub fn step(
        &mut self,
        guarded: &mut impl Guarded<N>,
        measured: &Measurement,
        stick: Stick,
        spool: &mut [f64],
    ) -> Result<(), Fault> {
        let t = measured.t;
        if !t.is_finite() {
            // The monitor would compare all later samples with it.
            return Err(Fault::BadMeasurement(Reading::Time));
        }
        let found = self.monitor.check(guarded.model(), measured);
        let gaps: OfSignals<(Signal, Kind)> = self.monitor.gaps().collect();
        let doubted: OfSignals<Signal> = self.monitor.doubted().collect();
        let h = self.usable.map_or(0.0, |last| t - last.t).max(guarded.controller().period());
        let worn_out = self.worn_out(&gaps, &doubted, h);
        if self.phase != Phase::Driving {
            self.tell(&found);
            if !self.monitor.has_suspects(t) && released(stick) {
                self.phase = Phase::Driving;
                self.missed = [[0.0; 3]; N];
                self.monitor.clear();
                guarded.controller().reset(measured);
                self.news.tell(SensorNotice::Restarts);
            }
        } else if gaps.iter().any(|(_, kind)| matches!(kind, Kind::Frozen(_))) {
            // It has misled the controller since long before it was found.
            self.tell(&gaps);
            self.phase = Phase::Closing(t);
        } else if worn_out {
            self.tell(&gaps);
            self.phase = Phase::Stopping(t);
        } else {
            for Returned { signal, kind, from } in self.monitor.trust_again() {
                self.news.tell(SensorNotice::Continued { signal, kind, from, until: t });
            }
        }
        // A crane that stops goes on without a sensor even if it reads plausibly again.
        let mut left_out: OfSignals<Signal> = match self.phase {
            Phase::Stopping(_) => self.monitor.suspects().map(|(signal, _)| signal).collect(),
            _ => gaps.into_iter().map(|(signal, _)| signal).collect(),
        };
        left_out.extend(doubted);
        let Some(usable) = self.usable(measured, &left_out) else {
            // There never was a reading to go on from.
            if self.phase == Phase::Driving {
                self.tell(&found);
            }
            self.phase = Phase::Closing(t);
            self.close(guarded, t, t, spool);
            return Ok(());
        };
        let centred = [0.0; N];
        let stick = match (self.phase, stick) {
            (Phase::Driving, stick) => stick,
            (_, Stick::Tip(_) | Stick::Goal(_)) => Stick::Tip(&[0.0; 2]),
            (_, Stick::Lever(axes)) => Stick::Lever(&centred[..axes.len().min(N)]),
            (_, Stick::Height(axes)) => Stick::Height(&centred[..axes.len().min(N)]),
        };
        if let Phase::Stopping(since) = self.phase {
            if t >= since + STOPPING || guarded.controller().stands() {
                self.phase = Phase::Closing(t);
            }
        }
        if let Phase::Closing(since) = self.phase {
            self.close(guarded, t, since, spool);
            return Ok(());
        }
        let filled = Measurement { t, q: &usable.q, p: &usable.p };
        let answer = guarded.controller().step_without(&filled, &left_out, stick, spool);
        let usable = answer.is_ok() && spool.iter().all(|u| u.is_finite());
        let sent = |c: usize| spool.get(c).copied().filter(|_| usable).unwrap_or(0.0);
        self.note(guarded.model(), t, hydrocrane_num::array::from_fn(sent));
        answer
    }
}

/// Rounding of sums of periods, s.
const ROUNDING: f64 = 1e-6;

fn released(stick: Stick) -> bool {
    match stick {
        Stick::Tip(axes) | Stick::Lever(axes) | Stick::Height(axes) => axes.iter().all(|d| *d == 0.0),
        Stick::Goal(_) => false,
    }
}

#[cfg(feature = "std")]
impl SensorNotice {
    /// In words; sensors are to read plausibly for the `recovery` time (s) before they are trusted again.
    pub fn text(&self, names: &Names, recovery: f64) -> String {
        let fault = |signal: &Signal, kind: &Kind| {
            let (what, why) = names.fault(*signal, *kind);
            format!("{what} {why}")
        };
        match self {
            SensorNotice::Stops(signal, kind) => format!(
                "{}; the crane stops and its spools go to neutral until its reading has been plausible for {recovery} s and the \
                 stick is released: check the sensor and its cable",
                fault(signal, kind)
            ),
            SensorNotice::Continued { signal, kind, from, until } => format!(
                "{}; control continued without it for {:.0} ms from {from:.3} s on: check the sensor and its cable",
                fault(signal, kind),
                1e3 * (until - from)
            ),
            SensorNotice::Restarts => "all sensors read plausibly and the stick is released: control restarts".to_string(),
        }
    }
}

#[cfg(feature = "std")]
impl Names {
    /// What a sensor is called, and what is wrong with it.
    fn fault(&self, signal: Signal, kind: Kind) -> (String, String) {
        let joint = |i: usize| format!("`joint.{}.q`", self.joints[i]);
        let (name, quantity, size) = match signal {
            Signal::Joint(i) if self.revolute[i] => (joint(i), "position", (180.0 / core::f64::consts::PI, "deg")),
            Signal::Joint(i) => (joint(i), "position", (1e3, "mm")),
            Signal::Pressure(c, side) => {
                (format!("`cylinder.{}.p{}`", self.cylinders[c], side + 1), "pressure", (1e-5, "bar"))
            }
        };
        let why = match kind {
            Kind::NoReading => "gives no reading".to_string(),
            Kind::OutOfRange => format!("is out of range: the machine cannot have this {quantity}"),
            Kind::Jump(by) => {
                format!("jumped by {:.3} {} in one sample, which no other reading confirms", by * size.0, size.1)
            }
            Kind::Frozen(missed) => {
                format!("is frozen: it has not changed while the piston moved by {:.1} mm", missed.abs() * 1e3)
            }
            Kind::Vanished => "reads nothing, as does the other chamber, where oil carried a load before".to_string(),
            Kind::InBadSample => "came with other readings that cannot be right".to_string(),
        };
        (name, why)
    }
}
