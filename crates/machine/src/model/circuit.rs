//! Parts of the [model](crate::model) in the hydraulic circuit besides cylinders, valves and pump.

use crate::text::document::Place;

/// A load-holding valve between a chamber and its port of the spool valve.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadHolding<T = f64> {
    /// Flow when fully open, m^3/s, at a pressure drop, Pa.
    pub nominal_flow: T,
    pub nominal_pressure_drop: T,
    pub kind: HoldingKind<T>,
}

#[derive(Debug, Clone, PartialEq)]
pub enum HoldingKind<T = f64> {
    Counterbalance(Counterbalance<T>),
    PilotCheck(PilotCheck<T>),
    HoseBurst(HoseBurst<T>),
}

/// Counterbalance valve, vented.
#[derive(Debug, Clone, PartialEq)]
pub struct Counterbalance<T = f64> {
    /// Dotted path of its setting, and its place in the file.
    pub key: String,
    pub place: Place,
    /// Pressure of the chamber that opens it without a pilot, Pa.
    pub setting: T,
    pub pilot_ratio: T,
    /// Rise beyond that which opens it fully, Pa.
    pub opening_pressure: T,
}

/// Pilot-operated check valve.
#[derive(Debug, Clone, PartialEq)]
pub struct PilotCheck<T = f64> {
    pub pilot_ratio: T,
    /// Spring force over seat area, Pa, and the pressure rise beyond it that opens the valve fully.
    pub spring_pressure: T,
    pub opening_pressure: T,
}

/// Hose-burst valve.
#[derive(Debug, Clone, PartialEq)]
pub struct HoseBurst<T = f64> {
    /// Flow at which it begins to close, m^3/s.
    pub closing_flow: T,
    /// Remaining share of the opening.
    pub bleed: T,
}

/// Hose or pipe between a side of a cylinder and its port of the valve.
#[derive(Debug, Clone, PartialEq)]
pub struct Line<T = f64> {
    /// Without pressure, m^3, and its growth with pressure, m^3/Pa.
    pub volume: T,
    pub compliance: T,
    pub resistance: Option<Resistance<T>>,
}

/// A hole in the hose to a side of a cylinder.
#[derive(Debug, Clone, PartialEq)]
pub struct HoseLeak<T = f64> {
    /// Area, m^2; zero while the hose is tight.
    pub opening: T,
    pub discharge_coefficient: T,
}

/// Pressure drop over a line: R q + K q |q|.
#[derive(Debug, Clone, PartialEq)]
pub struct Resistance<T = f64> {
    /// R, Pa s/m^3
    pub laminar: T,
    /// K, Pa s^2/m^6
    pub turbulent: T,
}

/// Valves between a side of a cylinder and the tank.
#[derive(Debug, Clone, PartialEq)]
pub struct PortValves<T = f64> {
    pub relief: Option<PortRelief<T>>,
    pub anti_cavitation: Option<AntiCavitation<T>>,
}

impl<T> PortValves<T> {
    pub fn is_none(&self) -> bool {
        self.relief.is_none() && self.anti_cavitation.is_none()
    }
}

/// Relief (shock) valve of a port, to the tank or, as a cross-over valve, to the other port.
#[derive(Debug, Clone, PartialEq)]
pub struct PortRelief<T = f64> {
    /// Pressure over the tank, or over the other port, at which it opens, Pa.
    pub setting: T,
    /// Flow, m^3/s, at a pressure beyond the setting, Pa.
    pub nominal_flow: T,
    pub overpressure: T,
}

/// Check valve from the tank to a port.
#[derive(Debug, Clone, PartialEq)]
pub struct AntiCavitation<T = f64> {
    /// Flow, m^3/s, at a pressure drop from the tank to the port, Pa.
    pub nominal_flow: T,
    pub nominal_pressure_drop: T,
    /// Pressure drop that opens it, Pa.
    pub opening_pressure: T,
}

/// The line through which oil returns to the tank.
#[derive(Debug, Clone, PartialEq)]
pub struct TankLine<T = f64> {
    /// Without pressure, m^3, and its growth with pressure, m^3/Pa.
    pub volume: T,
    pub compliance: T,
    /// `None`: only the filter resists.
    pub resistance: Option<Resistance<T>>,
    pub filter: Option<ReturnFilter<T>>,
}

/// Filter between the tank line and the tank.
#[derive(Debug, Clone, PartialEq)]
pub struct ReturnFilter<T = f64> {
    /// Flow, m^3/s, at a pressure drop, Pa.
    pub nominal_flow: T,
    pub nominal_pressure_drop: T,
    pub bypass: Option<FilterBypass<T>>,
}

/// Bypass valve of a filter.
#[derive(Debug, Clone, PartialEq)]
pub struct FilterBypass<T = f64> {
    /// Drop over the filter that opens it, Pa, and the rise beyond it at which the nominal flow of the filter passes.
    pub pressure: T,
    pub overpressure: T,
}

/// The load-sensing line, which transmits the highest load pressure to the pump.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadSensing<T = f64> {
    /// Least margin of the pumps above that pressure, Pa.
    pub margin: T,
    /// Of the line, s.
    pub time_constant: T,
}

/// Pressure compensator of a valve section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Compensator<T = f64> {
    None,
    /// Before the spool, with the pressure drop that it holds over the metering edge, Pa.
    Before(T),
    /// Behind the spool: all sections have the drop that remains from the pump.
    Behind,
}

impl<T> Compensator<T> {
    pub fn is_none(&self) -> bool {
        matches!(self, Compensator::None)
    }
}

/// An edge to the tank that holds the pressure of its port.
#[derive(Debug, Clone, PartialEq)]
pub struct MeterOut<T = f64> {
    /// Pa
    pub pressure: T,
    /// Rise beyond that which opens the edge fully, Pa.
    pub range: T,
}

/// Largest number of pumps that feed the mains.
pub const MOST_PUMPS: usize = 3;

/// The section that is served first.
#[derive(Debug, Clone, PartialEq)]
pub struct Priority<T = f64> {
    /// Index of its cylinder.
    pub cylinder: usize,
    /// Pressure over the load-sensing line at which the other sections are shut, Pa, and the rise beyond it that frees them.
    pub margin: T,
    pub range: T,
}

/// Gas behind a bladder or a piston, joined to the mains.
#[derive(Debug, Clone, PartialEq)]
pub struct Accumulator<T = f64> {
    /// Of the gas without oil, m^3.
    pub volume: T,
    /// Gauge pressure of the gas without oil, Pa.
    pub precharge: T,
    pub polytropic_exponent: T,
}
