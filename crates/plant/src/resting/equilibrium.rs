//! The load at rest on its cylinders, with closed spools.

use crate::cylinders::hydraulic_axis::{HydraulicAxis, SupplyPressures};
use crate::equations::plant::Plant;
use crate::layout::Layout;
use hydrocrane_num::Real;
use hydrocrane_physics::hydraulics::edge_flows::PortPressures;

/// Number of iterations until the pressure of the mains is exact to rounding.
pub(crate) const SUPPLY_ROUNDS: usize = 4;

impl<T: Real, const N: usize> Plant<T, N> {
    /// The state at rest with closed spools at any piston positions; `back`: pressure of the less loaded chamber, Pa. It is lower
    /// where relief valves at the ports hold the load then, and would not with all of it.
    pub fn held(&self, layout: &Layout, q: &[T; N], back: T, payload: T) -> Vec<T> {
        let mut x = vec![T::c(0.0); layout.len()];
        let forces = self.standing_force(q, payload);
        for c in 0..N {
            x[layout.q(c)] = q[c];
            let back = self.affordable(c, forces[c], back);
            (x[layout.p1(c)], x[layout.p2(c)]) = hold_pressures(&self.cylinders[c], forces[c], back);
        }
        for _ in 0..SUPPLY_ROUNDS {
            self.settle_openings(layout, &mut x);
            self.settle_supply(layout, &mut x, None);
        }
        self.settle_openings(layout, &mut x);
        x
    }

    /// The pressure of the less loaded chamber, Pa: `back`, or less where relief valves at the ports stay closed then.
    fn affordable(&self, c: usize, force: T, back: T) -> T {
        let (unit, tank) = (&self.cylinders[c], self.supply_pressures.tank);
        let (a1, a2) = (unit.chambers.area_1, unit.chambers.area_2);
        let most = |side: usize| unit.tight_to(side, tank);
        let pushed = (back * (a1 - a2)).le(force);
        let room = T::select(pushed, (most(0) * a1 - force) / a2, (most(1) * a2 + force) / a1);
        T::select(tank.le(room), back.min(room), back)
    }

    /// Writes the settled openings of compensators that follow late.
    pub(crate) fn settle_openings(&self, layout: &Layout, x: &mut [T]) {
        let SupplyPressures { supply, load, tank } = self.pressures_at(layout, x);
        for (c, unit) in self.cylinders.iter().enumerate() {
            let Some(at) = layout.opening(c) else { continue };
            let (a, b) = (x[layout.p1(c)], x[layout.p2(c)]);
            let ports = PortPressures { supply, load, tank, a, b, opening: None };
            x[at] = unit.valve.settled_opening(x[layout.xs(c)], &ports);
        }
    }

    /// Writes the steady state of the supply for the flow that the valves draw at its present state: an iteration that
    /// begins with closed valves and ends when nothing changes. The load-sensing line has the pressure `sensed` (Pa), or that of the tank.
    pub(crate) fn settle_supply(&self, layout: &Layout, x: &mut [T], sensed: Option<T>) {
        let Some(p) = self.mains(layout) else { return };
        let Some(supply) = self.supply() else {
            x[p] = self.supply_pressures.supply;
            return;
        };
        let SupplyPressures { supply: mains, load, tank } = self.pressures_at(layout, x);
        let (mut drawn, mut returned) = (T::c(0.0), T::c(0.0));
        for (c, unit) in self.cylinders.iter().enumerate() {
            let (a, b) = (x[layout.p1(c)], x[layout.p2(c)]);
            let opening = layout.opening(c).map(|at| x[at]);
            let ports = PortPressures { supply: mains, load, tank, a, b, opening };
            let edges = unit.edge_flows(x[layout.xs(c)], &ports);
            drawn += edges.supply();
            if layout.tank().is_some() {
                let relieved = unit.port_valves[0].flow(a, tank) + unit.port_valves[1].flow(b, tank);
                returned += edges.tank() + relieved + unit.leakage.flows(a, b, tank).1;
            }
        }
        let sensed = sensed.unwrap_or(tank);
        let (pressure, shares) = supply.at_rest(tank, sensed, drawn);
        x[p] = pressure;
        if let Some(load) = layout.load() {
            x[load] = sensed;
        }
        layout.swivels().zip(shares).for_each(|(at, share)| x[at] = share);
        let settled = SupplyPressures { supply: pressure, load: sensed, tank };
        if let (Some(at), Some(p)) = (layout.tank(), supply.tank_line_at_rest(&settled, returned)) {
            x[at] = p;
        }
    }

    /// Pressure forces that hold the crane at rest, N: the static forces less those of the end stops.
    pub fn standing_force(&self, q: &[T; N], payload: T) -> [T; N] {
        let strokes = self.strokes(&self.mechanics.pose(q));
        let load = self.static_force(q, payload);
        hydrocrane_num::array::from_fn(|c| load[c] - self.cylinders[c].end_stop.force(strokes[c].0, T::c(0.0)).0)
    }
}

/// Number of bisections until a position is exact to rounding.
const HALVINGS: usize = 80;

/// Position of rest of a piston that is placed at `position` (m) under `load` (N, to be held by its force). This is
/// `position`, unless more than the `supply` pressure is needed to press it so far into an end stop. Then the piston
/// rests on the stop, with both chambers at the pressure `back`, or at the begin of the stop if the load pulls it away.
pub fn resting_position(unit: &HydraulicAxis<f64>, position: f64, load: f64, back: f64, supply: f64) -> f64 {
    let stop = |x: f64| unit.end_stop.force(x, 0.0).0;
    let (p1, p2) = hold_pressures(unit, load - stop(position), back);
    if stop(position) == 0.0 || p1.max(p2) <= supply {
        return position;
    }
    let leaning = load - back * (unit.chambers.area_1 - unit.chambers.area_2);
    let outward = stop(position).signum();
    let begins =
        if outward > 0.0 { unit.end_stop.lower + unit.end_stop.zone } else { unit.end_stop.upper - unit.end_stop.zone };
    let (mut deep, mut free) = (position, begins);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (deep + free);
        if stop(middle) * outward > leaning * outward {
            deep = middle;
        } else {
            free = middle;
        }
    }
    free
}

/// p1 A1 - p2 A2 = force with the less loaded chamber at the back pressure.
pub(crate) fn hold_pressures<T: Real>(unit: &HydraulicAxis<T>, force: T, back: T) -> (T, T) {
    let (a1, a2) = (unit.chambers.area_1, unit.chambers.area_2);
    let pushed = (back * (a1 - a2)).le(force);
    (T::select(pushed, (force + back * a2) / a1, back), T::select(pushed, back, (back * a1 - force) / a2))
}
