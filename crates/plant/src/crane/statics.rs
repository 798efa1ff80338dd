//! What the circuit holds at rest, and how fast it moves a load steadily.
//!
//! Slices of joints, cylinders and states have the lengths of the layout; SI units throughout.

use crate::crane::{array, Crane};
use crate::cylinders::hydraulic_axis::HydraulicAxis;
use crate::equations::plant::Plant;
use crate::resting::equilibrium::hold_pressures;
use crate::resting::shortfall::Shortfall;
use hydrocrane_num::{Real, Vec2};
use hydrocrane_physics::hydraulics::relief_valve::ReliefValve;

/// Pressure that is rounding, Pa.
const ROUNDING: f64 = 1e3;
/// Payload between two loads that show the slope of the static forces, kg.
const LOAD: f64 = 1000.0;

/// What ends the pressure at which a chamber can carry a load.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HeldBy {
    /// The highest pressure of the mains.
    Supply,
    /// A relief valve of the port, or one over to the other port.
    Relief,
}

/// A chamber that cannot hold its load: the piston side (0) or the rod side (1) of a cylinder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unheld {
    pub cylinder: usize,
    pub side: usize,
    /// Pressure that holds the load, and the highest one that there is, Pa.
    pub needed: f64,
    pub there_is: f64,
    pub held_by: HeldBy,
}

pub trait Statics {
    /// Lowest and highest steady piston speed per cylinder at full spool stroke under the load at rest, in pairs; the
    /// other spools are closed. Zero where the supply cannot move the load.
    fn piston_speeds(&self, q: &[f64], payload: f64, speeds: &mut [f64]);
    /// Highest pressure that piston side and rod side of each cylinder can be held at, Pa.
    fn holdable(&self) -> Vec<[f64; 2]>;
    /// The payload (kg, not above `ceiling`) at which the first cylinder reaches the pressure it can be held at, the other
    /// chamber at that of the tank, and which one; NaN if even the empty crane is not held. Without the ground.
    fn capacity(&self, q: &[f64], ceiling: f64) -> (f64, Option<usize>);
    /// Height of the underside of a `load` (kg) that the tip carries, or of the empty tip, above the ground, m; infinite without one.
    fn height_above_ground(&self, tip: [f64; 2], load: f64) -> f64;
    /// The chambers that cannot hold their loads in the state of rest `x`.
    fn unheld(&self, x: &[f64], payload: f64) -> Vec<Unheld>;
    /// The sections that get less than their spools ask for in the state `x`, while the pumps give all they will.
    fn shortfalls(&self, x: &[f64]) -> Vec<Shortfall>;
}

impl<const N: usize> Statics for Crane<N> {
    fn piston_speeds(&self, q: &[f64], payload: f64, speeds: &mut [f64]) {
        let loads = self.plant().static_force(&array::<N>(q), payload);
        for (i, speed) in speeds.iter_mut().enumerate() {
            let (c, mut spools) = (i / 2, [0.0; N]);
            spools[c] = if i % 2 == 0 { -1.0 } else { 1.0 } * self.machine.cylinders[c].valve.stroke;
            *speed = self.plant().steady(&spools, &loads).motions[c].speed;
        }
    }

    fn holdable(&self) -> Vec<[f64; 2]> {
        self.plant()
            .holdable(self.plant().supply_pressures.supply)
            .map(|sides| sides.map(|(pressure, _)| pressure))
            .to_vec()
    }

    fn capacity(&self, q: &[f64], ceiling: f64) -> (f64, Option<usize>) {
        let plant = self.plant();
        let most = plant.holdable(plant.supply_pressures.supply);
        let tank = plant.supply_pressures.tank;
        let [empty, loaded] = [0.0, LOAD].map(|payload| plant.resting_force(&array::<N>(q), payload, false));
        let mut first = (ceiling, None);
        for c in 0..N {
            let chambers = &plant.cylinders[c].chambers;
            let [(p1, _), (p2, _)] = most[c];
            let low = tank * chambers.area_1 - p2 * chambers.area_2;
            let high = p1 * chambers.area_1 - tank * chambers.area_2;
            if !(low..=high).contains(&empty[c]) {
                return (f64::NAN, Some(c));
            }
            let slope = (loaded[c] - empty[c]) / LOAD;
            let room = if slope > 0.0 { (high - empty[c]) / slope } else { (low - empty[c]) / slope };
            if slope != 0.0 && room < first.0 {
                first = (room, Some(c));
            }
        }
        first
    }

    fn height_above_ground(&self, [x, z]: [f64; 2], load: f64) -> f64 {
        let ground = self.plant().ground.as_ref();
        ground.map_or(f64::INFINITY, |ground| {
            let (x, drop) = ground.underside(Vec2::new(x, z), load);
            z - drop - ground.surface(x).0
        })
    }

    fn unheld(&self, x: &[f64], payload: f64) -> Vec<Unheld> {
        let plant = self.plant();
        let (tank, back) = (plant.supply_pressures.tank, self.machine.equilibrium.back_pressure);
        let q = hydrocrane_num::array::from_fn(|i| x[self.layout.q(i)]);
        let forces = plant.standing_force(&q, payload);
        let most = plant.holdable(plant.pressures_at(&self.layout, x).supply);
        let mut found = Vec::new();
        for (c, (unit, force)) in plant.cylinders.iter().zip(forces).enumerate() {
            let [least, held] = [tank, back].map(|back| hold_pressures(unit, force, back));
            for (side, (least, needed)) in [(least.0, held.0), (least.1, held.1)].into_iter().enumerate() {
                let (there_is, held_by) = most[c][side];
                if least > there_is + ROUNDING {
                    found.push(Unheld { cylinder: c, side, needed, there_is, held_by });
                }
            }
        }
        found
    }

    fn shortfalls(&self, x: &[f64]) -> Vec<Shortfall> {
        self.plant().shortfalls(&self.layout, x)
    }
}

impl<T: Real> HydraulicAxis<T> {
    /// Highest pressure of the piston side (0) or the rod side (1), Pa, at which no relief valve at its port lets oil pass, with the
    /// other side at the pressure `tank` (Pa).
    pub fn tight_to(&self, side: usize, tank: T) -> T {
        let own = if self.port_valves[side].kinds()[0] { self.port_valves[side].relief } else { None };
        let over = if self.crossover.kinds()[side] { self.crossover.from[side] } else { None };
        let boundless = T::c(f64::INFINITY);
        let at = |valve: Option<ReliefValve<T>>| valve.map_or(boundless, |valve| tank + valve.tight_to());
        at(own).min(at(over))
    }
}

impl<const N: usize> Plant<f64, N> {
    /// Highest pressure at which each chamber carries a load, Pa, and what ends it; without pumps the `supply` has that pressure, Pa.
    fn holdable(&self, supply: f64) -> [[(f64, HeldBy); 2]; N] {
        let tank = self.supply_pressures.tank;
        let mains = self.supply().map_or(supply, |supply| supply.reach(tank));
        hydrocrane_num::array::from_fn(|c| {
            [0, 1].map(|side| {
                let tight = self.cylinders[c].tight_to(side, tank);
                if tight < mains {
                    (tight, HeldBy::Relief)
                } else {
                    (mains, HeldBy::Supply)
                }
            })
        })
    }
}
