//! A controller whose sensors are monitored, with a safe state.  theory: docs/theory/control/plausibility.md
//!
//! A suspect sensor leads to the safe state: the valves close and hold the load. They stay closed until all sensors have read
//! plausibly for the recovery time and the sticks are released; then the controller restarts from where the crane stands.

use crate::controller::{Controller, Fault, Measurement, Stick};
use crate::plausibility::{Kind, Monitor, Signal};

/// Spool position (m) that a command (m) to the valve of a cylinder asks for.
pub type SpoolOf = Box<dyn Fn(usize, f64) -> f64 + Send>;

/// Runs a controller while its sensors are plausible, and closes the valves while they are not.
pub struct SafeState<const N: usize> {
    inner: Box<dyn Controller>,
    monitor: Monitor<N>,
    spool_of: SpoolOf,
    /// Names of joints and cylinders, and whether a joint turns.
    names: Names,
    recovery_time: f64,
    holding: bool,
    notices: Vec<String>,
}

/// What the messages call things.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Names {
    pub joints: Vec<String>,
    pub revolute: Vec<bool>,
    pub cylinders: Vec<String>,
}

impl<const N: usize> SafeState<N> {
    pub fn new(inner: Box<dyn Controller>, monitor: Monitor<N>, spool_of: SpoolOf, names: Names) -> Self {
        let recovery_time = monitor.recovery_time();
        SafeState { inner, monitor, spool_of, names, recovery_time, holding: false, notices: Vec::new() }
    }

    fn hold(&mut self, found: &[(Signal, Kind)]) {
        for &(signal, kind) in found {
            let what = self.names.message(signal, kind);
            self.notices.push(format!(
                "{what}; the spools go to neutral until it has read plausibly for {} s and the stick is released: \
                 check the sensor and its cable",
                self.recovery_time
            ));
        }
        self.holding |= !found.is_empty();
    }

    /// Tells the monitor which spool positions are commanded.
    fn note(&mut self, t: f64, command: [f64; N]) {
        self.monitor.sent(t, std::array::from_fn(|c| (self.spool_of)(c, command[c])));
    }
}

impl<const N: usize> Controller for SafeState<N> {
    fn period(&self) -> f64 {
        self.inner.period()
    }

    fn reset(&mut self, first: &Measurement) {
        self.monitor.reset();
        (self.holding, self.notices) = (false, Vec::new());
        self.inner.reset(first);
    }

    fn step(&mut self, measured: &Measurement, stick: Stick, spool: &mut [f64]) -> Result<(), Fault> {
        let found = self.monitor.check(measured);
        self.hold(&found);
        if self.holding && !self.monitor.has_suspects(measured.t) && released(stick) {
            self.holding = false;
            self.monitor.clear();
            self.inner.reset(measured);
            self.notices.push("all sensors read plausibly and the stick is released: control starts anew".into());
        }
        if self.holding {
            spool.fill(0.0);
            self.note(measured.t, [0.0; N]);
            return Ok(());
        }
        let answer = self.inner.step(measured, stick, spool);
        let usable = answer.is_ok() && spool.iter().all(|u| u.is_finite());
        let sent = |c: usize| spool.get(c).copied().filter(|_| usable).unwrap_or(0.0);
        self.note(measured.t, std::array::from_fn(sent));
        answer
    }

    fn set_point(&self) -> Option<[f64; 2]> {
        self.inner.set_point()
    }

    fn notices(&mut self) -> Vec<String> {
        let mut notices = std::mem::take(&mut self.notices);
        notices.append(&mut self.inner.notices());
        notices
    }
}

fn released(stick: Stick) -> bool {
    match stick {
        Stick::Tip(axes) => axes == [0.0; 2],
        Stick::Lever(axes) => axes.iter().all(|d| *d == 0.0),
    }
}

impl Names {
    fn message(&self, signal: Signal, kind: Kind) -> String {
        let (name, size) = match signal {
            Signal::Joint(i) if self.revolute[i] => {
                (format!("joint.{}.q", self.joints[i]), (180.0 / std::f64::consts::PI, "deg"))
            }
            Signal::Joint(i) => (format!("joint.{}.q", self.joints[i]), (1e3, "mm")),
            Signal::Pressure(c, side) => (format!("cylinder.{}.p{}", self.cylinders[c], side + 1), (1e-5, "bar")),
        };
        match kind {
            Kind::NoReading => format!("`{name}` gives no reading"),
            Kind::OutOfRange => format!("`{name}` is out of range: the machine cannot be where it reads"),
            Kind::Jump(by) => {
                format!("`{name}` jumped by {:.3} {} in one sample, which nothing else confirms", by * size.0, size.1)
            }
            Kind::Frozen(missed) => {
                format!("`{name}` is frozen: it has not changed while the piston moved by {:.1} mm", missed.abs() * 1e3)
            }
        }
    }
}
