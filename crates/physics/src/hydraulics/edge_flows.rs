//! Pressures around a spool valve and the flows through its edges.

use super::hose_leak::Leaking;
use hydrocrane_num::Real;

/// Pressures around the valve, Pa.
#[derive(Debug, Clone, Copy, Default)]
pub struct PortPressures<T> {
    pub supply: T,
    /// Of the load-sensing line; counts behind a compensator of flow sharing only.
    pub load: T,
    pub tank: T,
    pub a: T,
    pub b: T,
    /// Opening of a compensator that follows late, from 0 to 1.
    pub opening: Option<T>,
}

/// Flow through each edge, m^3/s, in the direction its name reads.
#[derive(Debug, Clone, Copy, Default)]
pub struct EdgeFlows<T> {
    pub supply_to_a: T,
    pub a_to_tank: T,
    pub supply_to_b: T,
    pub b_to_tank: T,
}

/// Flows of a port, m^3/s.
#[derive(Debug, Clone, Copy)]
pub struct PortFlows<T> {
    /// From the supply and to the tank.
    pub fed: T,
    pub drained: T,
    /// Where the hose to the cylinder leaks.
    pub leaking: Option<Leaking<T>>,
}

impl<T: Real> EdgeFlows<T> {
    /// q_A: into the piston-side chamber.
    #[inline(always)]
    pub fn port_a(&self) -> T {
        self.supply_to_a - self.a_to_tank
    }
    /// q_B: out of the rod-side chamber.
    #[inline(always)]
    pub fn port_b(&self) -> T {
        self.b_to_tank - self.supply_to_b
    }
    /// Flow drawn from the pump.
    #[inline(always)]
    pub fn supply(&self) -> T {
        self.supply_to_a + self.supply_to_b
    }
    /// Flow returned to the tank.
    #[inline(always)]
    pub fn tank(&self) -> T {
        self.a_to_tank + self.b_to_tank
    }
}
