//! The states that all cylinders share, those of the supply: what the valves see of them, their rates and derivatives.

use crate::hydraulic_axis::SupplyPressures;
use crate::layout::Layout;
use crate::plant::Plant;
use crate::supply::Supply;
use hydrocrane_num::{Dual, Real};
use hydrocrane_ode::SharedDerivatives;

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
        let Some((supply, pressures, e)) = self.supply_at(layout, x) else {
            // A measured pressure changes as the run prescribes, by nothing here.
            self.mains(layout).into_iter().for_each(|p| dx[p] = T::c(0.0));
            return;
        };
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
        let Some((supply, pressures, e)) = self.supply_at(layout, x) else {
            *out = SharedDerivatives { on_axes: out.on_axes, ..SharedDerivatives::new(out.at) };
            return;
        };
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
