//! The states of the supply, common to all cylinders: pressures at the valves, rates and derivatives.

use crate::cylinders::hydraulic_axis::SupplyPressures;
use crate::cylinders::in_chains::in_chains;
use crate::cylinders::supply::{Demand, Shares, Supply, MAX_PUMPS};
use crate::equations::plant::Plant;
use crate::layout::Layout;
use hydrocrane_num::{Dual, Real};
use hydrocrane_ode::{AxisOpening, Row, SharedDerivatives, MAX_ACTING, MAX_SHARED};

/// Rows of the derivatives by the cylinders until they become those of rates: of the drawn flow, of the signal and of what returns.
pub const DRAWN: usize = 0;
pub const SIGNAL: usize = 1;
pub const RETURNED: usize = 2;
/// Place of the tank line after mains and load-sensing line.
pub const TANK: usize = 2;

/// Derivatives of what the valves ask for by the pressures of mains, load-sensing line and tank line.
#[derive(Debug, Clone, Copy)]
pub struct AskedByPressures<T> {
    pub drawn: [T; MAX_ACTING],
    pub signal: [T; MAX_ACTING],
    pub returned: [T; MAX_ACTING],
}

impl<T: Real> Default for AskedByPressures<T> {
    fn default() -> Self {
        let none = [T::c(0.0); MAX_ACTING];
        AskedByPressures { drawn: none, signal: none, returned: none }
    }
}

impl<T: Real, const N: usize> Plant<T, N> {
    /// The supply pressures at the valves in the state `x`.
    #[inline(always)]
    pub fn pressures_at(&self, layout: &Layout, x: &[T]) -> SupplyPressures<T> {
        let Some(p) = self.mains(layout) else { return self.supply_pressures };
        let load = layout.load().map_or(self.supply_pressures.load, |load| x[load]);
        let tank = layout.tank().map_or(self.supply_pressures.tank, |tank| x[tank]);
        SupplyPressures { supply: x[p], load, tank }
    }

    /// Index of the pressure of the tank line, likewise.
    #[inline(always)]
    pub fn tank_line(&self, layout: &Layout) -> Option<usize> {
        in_chains(layout.tank())
    }

    /// Index of the pressure of the mains. Builds for the smallest chains only have no pumps.
    #[inline(always)]
    pub fn mains(&self, layout: &Layout) -> Option<usize> {
        in_chains(layout.mains())
    }

    /// The supply with its pressures and the shares of its displacements in the state `x`; `None` if its pressure is
    /// constant.
    #[inline(always)]
    pub fn supply_at(&self, layout: &Layout, x: &[T]) -> Option<(&Supply<T>, SupplyPressures<T>, Shares<T>)> {
        self.mains(layout)?;
        let mut e = [T::c(1.0); MAX_PUMPS];
        e.iter_mut().zip(layout.swivels()).for_each(|(e, at)| *e = x[at]);
        self.supply().map(|supply| (supply, self.pressures_at(layout, x), e))
    }

    /// Zero demand of the valves, where what returns is at the pressure `tank` (Pa).
    #[inline(always)]
    pub fn no_demand(&self, tank: T) -> Demand<T> {
        Demand { drawn: T::c(0.0), signal: tank, returned: T::c(0.0) }
    }

    /// Writes the rates of the supply.
    #[inline(always)]
    pub fn write_supply(&self, layout: &Layout, x: &[T], demand: Demand<T>, dx: &mut [T]) {
        let Some((supply, pressures, e)) = self.supply_at(layout, x) else {
            // The run prescribes a measured pressure, so its rate is zero here.
            self.mains(layout).into_iter().for_each(|p| dx[p] = T::c(0.0));
            return;
        };
        let rates = supply.rates(&self.fluid, &pressures, &e, demand);
        dx[layout.blocks().shared.first] = rates.pressure_rate;
        if let Some(load) = layout.load() {
            dx[load] = rates.load_rate;
        }
        if let Some(tank) = layout.tank() {
            dx[tank] = rates.tank_rate;
        }
        layout.swivels().zip(rates.swivel_rates).for_each(|(at, rate)| dx[at] = rate);
    }

    /// Writes the derivatives of the rates of the supply. `out.by_axes` holds those of the drawn flow ([`DRAWN`]), of the
    /// signal ([`SIGNAL`]) and of what returns ([`RETURNED`]) by the local states of the cylinders, `openings` likewise those by the openings
    /// of compensators, `by_pressures` those by the pressures of mains, load-sensing line and tank line.
    #[inline(always)]
    pub fn write_supply_derivatives(
        &self,
        layout: &Layout,
        x: &[T],
        demand: Demand<T>,
        by_pressures: AskedByPressures<T>,
        openings: Option<&mut [AxisOpening<T>]>,
        out: &mut SharedDerivatives<T>,
    ) {
        let openings = openings.into_iter().flatten();
        let Some((supply, pressures, e)) = self.supply_at(layout, x) else {
            openings.for_each(|own| own.on_shared = AxisOpening::default().on_shared);
            *out = SharedDerivatives { on_axes: out.on_axes, ..SharedDerivatives::new(out.at) };
            return;
        };
        let by_tank_line = self.tank_line(layout).map(
            #[inline(always)]
            |_| {
                T::outlined(
                    #[inline(always)]
                    || self.by_tank_line(supply, &pressures, &e, demand),
                )
            },
        );
        for k in 1..layout.swivels().len() {
            T::outlined(
                #[inline(always)]
                || self.write_further_pump(layout, x, demand, k, out),
            );
        }
        let lift = &mut |number: &T| Dual::<T, 5>::constant(*number);
        let pressures = SupplyPressures {
            supply: Dual::variable(pressures.supply, 0),
            load: Dual::variable(pressures.load, 1),
            tank: lift(&pressures.tank),
        };
        let (supply, fluid) = (supply.map(lift), self.fluid.map(lift));
        let demand = Demand {
            drawn: Dual::variable(demand.drawn, 3),
            signal: Dual::variable(demand.signal, 4),
            returned: Dual::constant(demand.returned),
        };
        let mut shares = e.map(Dual::constant);
        shares[0] = Dual::variable(e[0], 2);
        let rates = supply.rates(&fluid, &pressures, &shares, demand);
        let first = layout.blocks().shared.first;
        let kinds = [layout.mains(), layout.load(), layout.tank(), layout.swivel()];
        let of = [rates.pressure_rate, rates.load_rate, rates.tank_rate, rates.swivel_rates[0]];
        let rows = out.by_axes;
        for own in openings {
            let asked = std::mem::replace(&mut own.on_shared, [T::c(0.0); MAX_SHARED]);
            for (k, (rate, at)) in of.iter().zip(kinds).enumerate() {
                let Some(i) = at.map(|at| at - first) else { continue };
                let [.., by_drawn, by_signal] = rate.derivative;
                own.on_shared[i] = by_drawn * asked[DRAWN] + by_signal * asked[SIGNAL];
                if let Some(by_tank_line) = &by_tank_line {
                    own.on_shared[i] += by_tank_line[k][1] * asked[RETURNED];
                }
            }
        }
        for (k, (rate, at)) in of.iter().zip(kinds).enumerate() {
            let Some(i) = at.map(|at| at - first) else { continue };
            let [by_supply, by_load, by_swivel, by_drawn, by_signal] = rate.derivative;
            let asked = |j: usize| by_drawn * by_pressures.drawn[j] + by_signal * by_pressures.signal[j];
            let mut own = [by_supply + asked(0), by_load + asked(1), T::c(0.0), by_swivel];
            if let Some(by_tank_line) = &by_tank_line {
                let [by_tank, by_returned] = by_tank_line[k];
                own[TANK] = by_tank + asked(TANK);
                (0..=TANK).for_each(|j| own[j] += by_returned * by_pressures.returned[j]);
            }
            for (derivative, at) in own.iter().zip(kinds) {
                if let Some(j) = at.map(|at| at - first) {
                    out.own[i][j] = *derivative;
                }
            }
            for c in 0..N {
                out.by_axes[i][c] = rows[DRAWN][c].map(|d| d * by_drawn).plus(&rows[SIGNAL][c].map(|d| d * by_signal));
                if let Some(by_tank_line) = &by_tank_line {
                    let [_, by_returned] = by_tank_line[k];
                    out.by_axes[i][c] = out.by_axes[i][c].plus(&rows[RETURNED][c].map(|d| d * by_returned));
                }
            }
        }
    }

    /// Writes the derivatives of and by the share of displacement of pump `k`, beside the first one. It acts on the mains, and depends
    /// on the pressures of mains and load-sensing line.
    #[inline(always)]
    fn write_further_pump(
        &self,
        layout: &Layout,
        x: &[T],
        demand: Demand<T>,
        k: usize,
        out: &mut SharedDerivatives<T>,
    ) {
        let Some((supply, pressures, e)) = self.supply_at(layout, x) else { return };
        let lift = &mut |number: &T| Dual::<T, 3>::constant(*number);
        let pressures = SupplyPressures {
            supply: Dual::variable(pressures.supply, 0),
            load: Dual::variable(pressures.load, 1),
            tank: lift(&pressures.tank),
        };
        let demand =
            Demand { drawn: lift(&demand.drawn), signal: lift(&demand.signal), returned: lift(&demand.returned) };
        let mut shares = e.map(Dual::constant);
        shares[k] = Dual::variable(e[k], 2);
        let rates = supply.map(lift).rates(&self.fluid.map(lift), &pressures, &shares, demand);
        let first = layout.blocks().shared.first;
        let (own, mains) = (layout.swivels().start + k - first, layout.mains().map_or(0, |p| p - first));
        let [by_mains, by_load, by_own] = rates.swivel_rates[k].derivative;
        out.by_axes[own] = [Row::default(); hydrocrane_ode::MAX_BORDER];
        out.own[mains][own] = rates.pressure_rate.derivative[2];
        out.own[own] = [T::c(0.0); hydrocrane_ode::MAX_SHARED];
        out.own[own][mains] = by_mains;
        out.own[own][own] = by_own;
        if let Some(load) = layout.load() {
            out.own[own][load - first] = by_load;
        }
    }

    /// Derivatives of the rates of mains, load-sensing line, tank line and swivel by the pressure of the tank line and by what returns.
    #[inline(always)]
    fn by_tank_line(
        &self,
        supply: &Supply<T>,
        pressures: &SupplyPressures<T>,
        e: &Shares<T>,
        demand: Demand<T>,
    ) -> [[T; 2]; 4] {
        let lift = &mut |number: &T| Dual::<T, 2>::constant(*number);
        let pressures = SupplyPressures { tank: Dual::variable(pressures.tank, 0), ..pressures.map(lift) };
        let demand = Demand {
            drawn: lift(&demand.drawn),
            signal: lift(&demand.signal),
            returned: Dual::variable(demand.returned, 1),
        };
        let rates = supply.map(lift).rates(&self.fluid.map(lift), &pressures, &e.map(Dual::constant), demand);
        [rates.pressure_rate, rates.load_rate, rates.tank_rate, rates.swivel_rates[0]].map(|rate| rate.derivative)
    }
}
