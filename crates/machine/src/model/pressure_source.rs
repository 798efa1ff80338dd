//! Where the pressure of the circuit comes from: supply, mains, pumps and their engines.

use crate::model::circuit::{Accumulator, LoadSensing, Priority, TankLine};

#[derive(Debug, Clone, PartialEq)]
pub struct Supply<T = f64> {
    /// Constant pressure, set pressure of the pump, or typical value of a prescribed pressure, Pa.
    pub pressure: T,
    /// What the file states of it, whatever it is set to: by this the machine is built and its sensors are chosen, Pa.
    pub rated: f64,
    pub tank_pressure: T,
    /// The pressure is a measured one, which a run prescribes.
    pub measured: bool,
    /// `None`: the pressure is constant or prescribed.
    pub mains: Option<Mains<T>>,
}

/// The mains (pressure line between pump and valves), whose pressure follows from its flows.
#[derive(Debug, Clone, PartialEq)]
pub struct Mains<T = f64> {
    /// Volume of the lines between pump and valves without pressure, m^3, and its growth with pressure, m^3/Pa.
    pub volume: T,
    pub compliance: T,
    /// Pressure at which the main relief valve opens, Pa, and its flow per pressure beyond that, m^3/(s Pa).
    pub relief_pressure: T,
    pub relief_gradient: T,
    pub pump: Pump<T>,
    /// Pumps beside it, of the same type.
    pub further: Vec<Pump<T>>,
    /// `None`: the pumps do not follow the load.
    pub load_sensing: Option<LoadSensing<T>>,
    pub accumulator: Option<Accumulator<T>>,
    /// `None`: what returns is at the pressure of the tank.
    pub tank_line: Option<TankLine<T>>,
    pub priority: Option<Priority<T>>,
}

impl<T> Mains<T> {
    pub fn pumps(&self) -> impl Iterator<Item = &Pump<T>> {
        std::iter::once(&self.pump).chain(&self.further)
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct Pump<T = f64> {
    pub name: String,
    /// m^3 per revolution
    pub displacement: T,
    /// Without a load, rad/s.
    pub speed: T,
    /// Of its volumetric efficiency, rad/s.
    pub rated_speed: T,
    /// `None`: the speed is constant.
    pub engine: Option<Engine<T>>,
    /// At full displacement and the supply pressure.
    pub volumetric_efficiency: T,
    pub hydromechanical_efficiency: T,
    /// `None`: the displacement is fixed.
    pub control: Option<PressureControl<T>>,
    /// Above the pressure of the load-sensing line, Pa; `None`: the pump does not follow the load.
    pub margin: Option<T>,
}

/// An engine that slows down under its load.
#[derive(Debug, Clone, PartialEq)]
pub struct Engine<T = f64> {
    /// Share of the speed that is lost at the rated torque.
    pub droop: T,
    /// N m
    pub rated_torque: T,
}

/// A pump that controls the supply pressure by its displacement.
#[derive(Debug, Clone, PartialEq)]
pub struct PressureControl<T = f64> {
    /// Fall of pressure that brings full displacement, Pa.
    pub range: T,
    /// s
    pub time_constant: T,
    /// N m; `None`: no limit.
    pub torque_limit: Option<T>,
}
