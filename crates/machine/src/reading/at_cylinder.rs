//! What stands at a cylinder beside its valve.

use crate::model::{Cylinder, PortValves};
use crate::number::Number;

impl<T> Cylinder<T> {
    /// Whether a line to it has a resistance.
    pub fn has_line_resistance(&self) -> bool {
        self.ports.lines.iter().flatten().any(|line| line.resistance.is_some())
    }

    /// Whether a hose to it may leak.
    pub fn has_hose_leak(&self) -> bool {
        self.ports.leaks.iter().any(Option::is_some)
    }

    /// Whether a relief valve leads from one of its ports to the other one.
    pub fn has_crossover_relief(&self) -> bool {
        self.ports.crossover.iter().any(Option::is_some)
    }

    /// Whether a relief or anti-cavitation valve stands at one of its ports.
    pub fn has_port_valves(&self) -> bool {
        !self.ports.valves.iter().all(PortValves::is_none)
    }
}

impl<T: Number> Cylinder<T> {
    /// Whether the walls of a line to it give way.
    pub fn has_elastic_line(&self) -> bool {
        self.ports.lines.iter().flatten().any(|line| !line.compliance.always(0.0))
    }
}
