//! Pump, mains and relief valve: the laws of `physics`, from the state of the supply and what the valves draw to its rates.

use crate::hydraulic_axis::SupplyPressures;
use crate::layout::Layout;
use crate::plant::Plant;
use hydrocrane_num::{Dual, Real};
use hydrocrane_ode::SharedDerivatives;
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

impl<T: Real, const N: usize> Plant<T, N> {
    /// The pressures that the valves see in the state `x`.
    #[inline(always)]
    pub fn pressures_at(&self, layout: &Layout, x: &[T]) -> SupplyPressures<T> {
        let supply = self.mains(layout).map_or(self.supply_pressures.supply, |p| x[p]);
        SupplyPressures { supply, ..self.supply_pressures }
    }

    /// Index of the pressure of the mains. Programs for the smallest chains alone have no pumps.
    #[inline(always)]
    pub fn mains(&self, layout: &Layout) -> Option<usize> {
        if cfg!(feature = "chains") {
            layout.mains()
        } else {
            None
        }
    }

    /// The supply with its pressures and the share of its displacement in the state `x`; `None` where its pressure is constant.
    #[inline(always)]
    pub fn supply_at(&self, layout: &Layout, x: &[T]) -> Option<(&Supply<T>, SupplyPressures<T>, T)> {
        self.mains(layout)?;
        let e = layout.swivel().map_or(T::c(1.0), |e| x[e]);
        self.supply.as_ref().map(|supply| (supply, self.pressures_at(layout, x), e))
    }

    /// Writes the rates of the supply, from which the valves draw `drawn` (m^3/s).
    #[inline(always)]
    pub fn write_supply(&self, layout: &Layout, x: &[T], drawn: T, dx: &mut [T]) {
        let Some((supply, pressures, e)) = self.supply_at(layout, x) else { return };
        let rates = supply.rates(&self.fluid, &pressures, e, drawn);
        dx[layout.blocks().shared.first] = rates.pressure_rate;
        if let Some(swivel) = layout.swivel() {
            dx[swivel] = rates.swivel_rate;
        }
    }

    /// Writes the derivatives of the rates of the supply by its own states, and turns the derivatives of the `drawn` flows by the
    /// states of the cylinders into those of the rates. `by_supply` is the derivative of the drawn flow by the pressure.
    #[inline(always)]
    pub fn write_supply_derivatives(
        &self,
        layout: &Layout,
        x: &[T],
        drawn: T,
        by_supply: T,
        out: &mut SharedDerivatives<T>,
    ) {
        let Some((supply, pressures, e)) = self.supply_at(layout, x) else { return };
        let lift = &mut Dual::<T, 3>::constant;
        let pressures = SupplyPressures { supply: Dual::variable(pressures.supply, 0), tank: lift(pressures.tank) };
        let (supply, fluid) = (supply.map(lift), self.fluid.map(lift));
        let rates = supply.rates(&fluid, &pressures, Dual::variable(e, 1), Dual::variable(drawn, 2));
        let [by_p, by_e, by_drawn] = rates.pressure_rate.derivative;
        out.own[0] = [by_p + by_drawn * by_supply, by_e];
        out.own[1] = [rates.swivel_rate.derivative[0], rates.swivel_rate.derivative[1]];
        for row in &mut out.by_axes[0][..N] {
            *row = row.map(|derivative| derivative * by_drawn);
        }
    }
}
