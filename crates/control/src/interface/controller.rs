//! What every controller is: something that, once per period, turns measurements and a stick into spool commands.
//!
//! A controller knows the crane's geometry and the parameters of its model, never the plant's state.

#[cfg(feature = "std")]
use crate::estimate::valve_learning::LearntValve;
use crate::interface::signal::Signal;
use crate::model::inverse_kinematics::TooFewRevolute;
use core::fmt;

/// Measurements at one sample, as the sensors deliver them. SI units; pressures gauge.
#[derive(Debug, Clone, Copy)]
pub struct Measurement<'a> {
    /// s
    pub t: f64,
    /// Joint coordinates, rad or m.
    pub q: &'a [f64],
    /// Chamber pressures (p1, p2) per cylinder, Pa.
    pub p: &'a [[f64; 2]],
}

/// A place that the tip shall go to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goal {
    /// (x, z), m
    pub place: [f64; 2],
    /// On the way, m/s; `None`: that of full stick.
    pub speed: Option<f64>,
    /// Share of the speed that counts now.
    pub share: f64,
    /// When it was given, s. The same place given later is another goal.
    pub given: f64,
    /// When it is dropped, s, if it is not reached before.
    pub until: f64,
}

impl Goal {
    /// In messages.
    pub fn name(&self) -> PlaceName {
        PlaceName(self.place)
    }
}

/// A place (x, z), m, in messages.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaceName(pub [f64; 2]);

impl fmt::Display for PlaceName {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [x, z] = self.0;
        write!(f, "({x:.3}, {z:.3}) m")
    }
}

/// A part of a measurement, in messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reading {
    Time,
    Joint(usize),
    /// Both pressures of a cylinder.
    Pressures(usize),
}

impl fmt::Display for Reading {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Reading::Time => write!(f, "t"),
            Reading::Joint(i) => write!(f, "q[{i}]"),
            Reading::Pressures(c) => write!(f, "p[{c}]"),
        }
    }
}

/// What the operator asks for: deflections of sticks, each axis in -1 to 1, or a goal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stick<'a> {
    /// One stick: the tip's velocity, forward and up, as a share of the full speed (thesis Figure 77). Of a crane that slews also across,
    /// positive with a growing angle of the slewing joint; without this third axis it does not slew.
    Tip(&'a [f64]),
    /// One axis per cylinder (thesis Figure 76).
    Lever(&'a [f64]),
    /// One axis per cylinder as well, for pistons at a speed, while one joint holds the tip's height.
    Height(&'a [f64]),
    /// Every stick is released, and the tip shall go to a place.
    Goal(Goal),
}

/// Why a controller gave no usable command. The loop closes the valves and records it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Fault {
    #[error("measurement `{0}` is not a finite number, or is beyond 1e12")]
    BadMeasurement(Reading),
    #[error("the stick is not a finite number between -1 and 1")]
    BadStick,
    #[error("the tip's stick has {0} axes; this crane takes {1}")]
    StickAxes(usize, &'static str),
    #[error("this controller supports the {0} stick mode only")]
    WrongStick(&'static str),
    #[error("the goal {} or its speed is not a valid number", .0.name())]
    BadGoal(Goal),
    #[error("the spool command is not a finite number; tip control restarts")]
    NoCommand,
    #[error(transparent)]
    TooFewRevolute(TooFewRevolute),
    #[cfg(feature = "std")]
    #[error("{0}")]
    Failed(String),
    /// Nothing better is to be expected of the next sample: the run ends.
    #[cfg(feature = "std")]
    #[error("{0}")]
    Fatal(String),
}

/// [`Controller::copied`] of a controller that can be cloned.
macro_rules! copied_by_clone {
    () => {
        #[cfg(feature = "std")]
        fn copied(&self) -> Option<Box<dyn Controller>> {
            Some(Box::new(self.clone()))
        }
    };
}
pub(crate) use copied_by_clone;

/// What a controller tells whoever runs the machine.
#[cfg(feature = "std")]
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    pub text: String,
    /// What the run is warned of.
    pub alarm: Option<Alarm>,
}

/// A reason for which a run with a controller may not show what was asked for.
#[cfg(feature = "std")]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Alarm {
    /// The crane stops because of a sensor.
    SensorStop,
    /// The controller's own loop oscillates.
    Oscillates,
    /// The tip leaves its path.
    Strays,
}

/// A sampled controller.
pub trait Controller: Send {
    /// Fixed time between samples, s.
    fn period(&self) -> f64;
    /// Starts anew from a first measurement.
    fn reset(&mut self, first: &Measurement);
    /// Writes one spool command per cylinder, m, positive extends.
    fn step(&mut self, measured: &Measurement, stick: Stick, spool: &mut [f64]) -> Result<(), Fault>;
    /// As [`Controller::step`], with the last usable readings in the place of those of `gaps`, which are missing.
    fn step_without(
        &mut self,
        measured: &Measurement,
        _gaps: &[Signal],
        stick: Stick,
        spool: &mut [f64],
    ) -> Result<(), Fault> {
        self.step(measured, stick, spool)
    }
    /// Another one in the same state, which goes on alike; `None` where it cannot be copied.
    #[cfg(feature = "std")]
    fn copied(&self) -> Option<Box<dyn Controller>> {
        None
    }
    /// Whether it needs the chamber pressures.
    fn reads_pressures(&self) -> bool {
        true
    }
    /// Whether there is nothing left to do for it after the stick was released.
    fn stands(&self) -> bool {
        true
    }
    /// Why it cannot take the tip to `place` (x, z), m, as far as that is known before; `None` where it can.
    #[cfg(feature = "std")]
    fn refuses(&self, _place: [f64; 2]) -> Option<String> {
        Some("only the controller `tip` goes to a goal".to_string())
    }
    /// Whether it is under way to a goal.
    fn heading(&self) -> bool {
        false
    }
    /// The set-point of the tip (x, z) after the last step, m, where the controller has one; of a crane that slews with the slewing
    /// joint turned back to zero.
    fn set_point(&self) -> Option<[f64; 2]>;
    /// The same where it is: (x, y, z).
    fn set_point_in_space(&self) -> Option<[f64; 3]> {
        self.set_point().map(|[x, z]| [x, 0.0, z])
    }
    /// What it has learnt of each valve; nothing where it does not learn.
    #[cfg(feature = "std")]
    fn learnt(&self) -> Vec<LearntValve> {
        Vec::new()
    }
    /// What has happened since the last call that whoever runs the machine should know.
    #[cfg(feature = "std")]
    fn notices(&mut self) -> Vec<Report> {
        Vec::new()
    }
}
