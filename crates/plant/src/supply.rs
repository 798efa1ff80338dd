//! Pump, mains and relief valve: the laws of `physics`, from the state of the supply and what the valves draw to its rates.

use crate::hydraulic_axis::SupplyPressures;
use hydrocrane_num::Real;
use hydrocrane_physics::hydraulics::fluid::Fluid;
use hydrocrane_physics::hydraulics::mains::Mains;
use hydrocrane_physics::hydraulics::pump::{PressureControl, Pump};
use hydrocrane_physics::hydraulics::relief_valve::ReliefValve;

/// A supply whose pressure follows from what flows in and out.
#[derive(Debug, Clone, Copy)]
pub struct Supply<T> {
    pub pump: Pump<T>,
    /// `None`: the displacement is fixed.
    pub control: Option<PressureControl<T>>,
    pub mains: Mains<T>,
    pub relief: ReliefValve<T>,
}

/// What happens in the supply at one state.
#[derive(Debug, Clone, Copy)]
pub struct SupplyRates<T> {
    /// Of the pressure of the mains, Pa/s, and of the share of the displacement, 1/s.
    pub pressure_rate: T,
    pub swivel_rate: T,
    /// Flows of the pump into the mains and of the relief valve out of them, m^3/s.
    pub pump_flow: T,
    pub relief_flow: T,
}

impl<T: Copy> Supply<T> {
    /// The same with `f` of every number.
    pub fn map<U>(&self, f: &mut impl FnMut(T) -> U) -> Supply<U> {
        Supply {
            pump: self.pump.map(f),
            control: self.control.map(|control| control.map(f)),
            mains: self.mains.map(f),
            relief: self.relief.map(f),
        }
    }
}

impl<T: Real> Supply<T> {
    /// At the `pressures`, with the share `e` of the displacement, while the valves draw `drawn` (m^3/s).
    #[inline(always)]
    pub fn rates(&self, fluid: &Fluid<T>, pressures: &SupplyPressures<T>, e: T, drawn: T) -> SupplyRates<T> {
        let SupplyPressures { supply, tank } = *pressures;
        let (pump_flow, relief_flow) = (self.pump.flow(e, supply - tank), self.relief.flow(supply));
        let stiffness = self.mains.stiffness(fluid.bulk_modulus(supply), supply);
        let swivel_rate =
            self.control.as_ref().map_or(T::c(0.0), |control| control.swivel_rate(&self.pump, e, supply, tank));
        SupplyRates {
            pressure_rate: stiffness * (pump_flow - relief_flow - drawn),
            swivel_rate,
            pump_flow,
            relief_flow,
        }
    }

    /// Pressure of the mains and share of the displacement at rest, where the valves draw `leakage` per pressure of the mains
    /// (m^3/(s Pa)) less `returned` (m^3/s), which their ports give. All laws are linear there.
    pub fn at_rest(&self, tank: T, leakage: T, returned: T) -> (T, T) {
        let full = self.pump.full_flow();
        let given = self.pump.leakage * tank + returned;
        let taken = self.pump.leakage + leakage;
        match &self.control {
            Some(control) => {
                let steepness = full / control.range;
                let p = (steepness * control.pressure + given) / (taken + steepness);
                (p, (control.pressure - p) / control.range)
            }
            None => {
                let ReliefValve { pressure, gradient } = self.relief;
                ((full + gradient * pressure + given) / (taken + gradient), T::c(1.0))
            }
        }
    }
}
