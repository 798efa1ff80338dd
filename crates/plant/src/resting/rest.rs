//! Equilibrium states: with closed spools, or with spools that feed the leakage.

use crate::cylinders::hydraulic_axis::{HydraulicAxis, SupplyPressures};
use crate::cylinders::local::LocalState;
use crate::equations::plant::Plant;
use crate::errors::PoseError;
use crate::layout::Layout;
use crate::resting::equilibrium::SUPPLY_ROUNDS;
use crate::resting::steady::{Section, PRESSURE};
use hydrocrane_machine::Machine;
use hydrocrane_num::{portable, root};
use hydrocrane_physics::hydraulics::fluid::Fluid;
use hydrocrane_physics::hydraulics::parts::AnyParts;
use std::f64::consts::PI;

/// Kind of equilibrium.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EquilibriumMode {
    /// Valves closed; pressures balance the load and then change slowly by leakage.
    Hold,
    /// Spools opened just enough to feed the leakage; pressures are constant.
    Steady,
}

impl<const N: usize> Plant<f64, N> {
    /// q' = xs' = 0, friction 0, pressures in balance with gravity and end stops at the joint coordinates `q`.
    pub fn rest(
        &self,
        machine: &Machine,
        layout: &Layout,
        q: &[f64; N],
        mode: EquilibriumMode,
        payload: f64,
    ) -> Result<Vec<f64>, PoseError> {
        let strokes = self.strokes(&self.mechanics.pose(q));
        for c in 0..N {
            require_inside(machine, &self.cylinders[c], c, q[c], strokes[c].0)?;
        }
        let x = self.held(layout, q, machine.equilibrium.back_pressure, payload);
        if mode == EquilibriumMode::Hold {
            return Ok(x);
        }
        let forces = self.standing_force(q, payload);
        let loads = hydrocrane_num::array::from_fn(|c| (strokes[c].0, forces[c]));
        if layout.load().is_none() {
            return self.fed(machine, layout, x, &loads, None);
        }
        // What the sections signal falls with the pressure that they are given. Where it feeds them by no opening, they lack all of it.
        let (tank, highest) = (self.supply_pressures.tank, self.supply().map_or(0.0, |supply| supply.highest));
        let fed = |load: f64| self.fed(machine, layout, x.clone(), &loads, Some(load));
        fed(root(tank, highest, PRESSURE, |load| fed(load).map_or(highest, |x| self.signal(layout, &x) - load)))
    }

    /// The state of rest `x` with pistons at positions (m) under pressure forces (N), with spools that feed the leakage; `load`: as of [`Plant::settle_supply`].
    fn fed(
        &self,
        machine: &Machine,
        layout: &Layout,
        mut x: Vec<f64>,
        loads: &[(f64, f64); N],
        load: Option<f64>,
    ) -> Result<Vec<f64>, PoseError> {
        self.settle_supply(layout, &mut x, load);
        // The small flow of the open spools changes the pressure of the mains, which changes this flow far less.
        for _ in 0..if self.supply().is_some() { SUPPLY_ROUNDS } else { 1 } {
            let supply_pressures = self.pressures_at(layout, &x);
            for (c, &(position, force)) in loads.iter().enumerate() {
                // At rest the compensator has settled.
                let unit = &HydraulicAxis { compensator_lag: None, ..self.cylinders[c] };
                let balance =
                    Balance { unit, fluid: &self.fluid, supply_pressures: &supply_pressures, position, force };
                if balance.rates(x[layout.p1(c)], x[layout.p2(c)], 0.0) != (0.0, 0.0) {
                    let cylinder = machine.cylinders[c].name.clone();
                    let (p1, p2, spool) = balance.solve().ok_or(PoseError::NotSteady { cylinder, force })?;
                    x[layout.p1(c)] = p1;
                    x[layout.p2(c)] = p2;
                    x[layout.xs(c)] = spool;
                }
            }
            self.settle_supply(layout, &mut x, load);
            self.settle_openings(layout, &mut x);
        }
        Ok(x)
    }

    /// Highest pressure that the sections give to the load-sensing line in the state of rest `x`, Pa.
    fn signal(&self, layout: &Layout, x: &[f64]) -> f64 {
        let at = self.pressures_at(layout, x);
        let signals = self.cylinders.iter().enumerate().map(|(c, unit)| {
            let section = Section { unit, vacuum: self.fluid.vacuum, spool: x[layout.xs(c)], load: 0.0 };
            section.flows(&at, [x[layout.p1(c)], x[layout.p2(c)]]).1.signal
        });
        signals.fold(at.tank, f64::max)
    }
}

fn require_inside(
    machine: &Machine,
    unit: &HydraulicAxis<f64>,
    c: usize,
    coordinate: f64,
    position: f64,
) -> Result<(), PoseError> {
    let (lower, upper) = (unit.end_stop.lower, unit.end_stop.upper);
    if position > lower && position < upper {
        return Ok(());
    }
    let (joint, cylinder) = (machine.joints[c].name.clone(), machine.cylinders[c].name.clone());
    Err(PoseError::OutsideStroke { joint, coordinate, cylinder, position, lower, upper })
}

/// One cylinder at rest under a force: a slightly open spool keeps both pressures constant.
struct Balance<'a> {
    unit: &'a HydraulicAxis<f64>,
    fluid: &'a Fluid<f64>,
    supply_pressures: &'a SupplyPressures<f64>,
    position: f64,
    force: f64,
}

impl Balance<'_> {
    /// (p1, p2, spool), or `None` where no opening balances the leakage.
    fn solve(&self) -> Option<(f64, f64, f64)> {
        const SAMPLES: usize = 400;
        let (low, high) = (self.supply_pressures.tank, self.supply_pressures.supply);
        // Denser at both ends: light loads balance within a fraction of a bar of the tank.
        let at = |i: usize| {
            let share = 0.5 - 0.5 * portable::cos(PI * (i as f64 + 0.5) / SAMPLES as f64);
            low + (high - low) * share
        };
        let mut previous: Option<(f64, f64)> = None;
        for i in 0..SAMPLES {
            let p2 = at(i);
            let here = self.rod_side_rate(p2).map(|rate| (p2, rate));
            if let (Some((a, ra)), Some((b, rb))) = (previous, here) {
                if ra * rb <= 0.0 && (ra != 0.0 || rb != 0.0) {
                    let p2 = self.bisect(a, b, ra);
                    let (p1, spool) = self.piston_side(p2)?;
                    return Some((p1, p2, spool));
                }
            }
            previous = here;
        }
        None
    }

    fn bisect(&self, mut a: f64, mut b: f64, rate_a: f64) -> f64 {
        for _ in 0..200 {
            let middle = 0.5 * (a + b);
            if middle == a || middle == b {
                break;
            }
            match self.rod_side_rate(middle) {
                Some(rate) if rate * rate_a > 0.0 => a = middle,
                _ => b = middle,
            }
        }
        0.5 * (a + b)
    }

    /// p1 from the force balance, and the spool that keeps it constant: that flow grows with the spool.
    fn piston_side(&self, p2: f64) -> Option<(f64, f64)> {
        let c = &self.unit.chambers;
        let p1 = (self.force + p2 * c.area_2) / c.area_1;
        let limit = 1.0 + self.unit.valve.overlap;
        let (mut low, mut high) = (-limit, limit);
        if self.rates(p1, p2, low).0 > 0.0 || self.rates(p1, p2, high).0 < 0.0 {
            return None;
        }
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if middle == low || middle == high {
                break;
            }
            if self.rates(p1, p2, middle).0 < 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        Some((p1, 0.5 * (low + high)))
    }

    fn rod_side_rate(&self, p2: f64) -> Option<f64> {
        let (p1, spool) = self.piston_side(p2)?;
        Some(self.rates(p1, p2, spool).1)
    }

    fn at(&self, p1: f64, p2: f64, spool: f64) -> LocalState<f64> {
        LocalState { x: self.position, v: 0.0, p1, p2, spool, z: 0.0, opening: None }
    }

    fn rates(&self, p1: f64, p2: f64, spool: f64) -> (f64, f64) {
        let rates = self.unit.rates::<AnyParts>(self.fluid, self.supply_pressures, &self.at(p1, p2, spool));
        (rates.p1_rate, rates.p2_rate)
    }
}
