//! Steady motion of the whole circuit.                          theory: docs/theory/hydraulics/steady_circuit.md
//!
//! Every section moves its piston at constant speed under a constant load, with its spool held, on the pressures of a supply whose
//! pumps give just what the sections draw:
//!     A_f v = q_f(p_f),   A_o v = q_o(p_o, p_f),   p_f A_f - p_o A_o = s (F + F_f(v))     f: the fed chamber, o: the other one
//!     Q_pumps(p_S) - q_relief(p_S) = sum of what the sections draw at p_S,   p_LS = max of what they signal at p_S
//! The laws are those of the right-hand side. A higher pressure brings every balance out of its zero in one sense, so each is one
//! bracketed [`root`] inside the other; [`root`] has the budget. Where a load drives its piston faster than the supply
//! fills the fed chamber, p_f is that of vacuum.
//!
//! Limits of validity: the dynamic pressure in the connectors is left out, compensators have settled, no
//! chamber is at its end. Friction counts from [`CREEP`] on.

use crate::cylinders::hydraulic_axis::{HydraulicAxis, SupplyPressures};
use crate::cylinders::supply::{Demand, Supply};
use crate::equations::plant::Plant;
use crate::resting::equilibrium::hold_pressures;
use hydrocrane_num::{array, root};
use hydrocrane_physics::hydraulics::parts::AnyParts;

/// Least speed at which friction is evaluated, m/s: a piston that moves has broken away.
const CREEP: f64 = 1e-3;
/// Pressure to which balances are solved, Pa, and speed, m/s.
pub(crate) const PRESSURE: f64 = 1e-3;
const SPEED: f64 = 1e-12;
/// Most rounds for the leakage between both chambers, which hardly changes with the speed.
const ROUNDS: usize = 30;

/// A cylinder with its valve, the spool at `spool` (m), under `load` (N, positive where the piston pushes outward).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Section<'a> {
    pub unit: &'a HydraulicAxis<f64>,
    pub vacuum: f64,
    pub spool: f64,
    pub load: f64,
}

/// A section in steady motion.
#[derive(Debug, Clone, Copy)]
pub struct Motion {
    /// m/s
    pub speed: f64,
    /// Of the piston side and of the rod side, Pa.
    pub pressures: [f64; 2],
    pub demand: Demand<f64>,
}

/// The circuit in steady motion.
#[derive(Debug, Clone, Copy)]
pub struct Circuit<const N: usize> {
    pub motions: [Motion; N],
    pub pressures: SupplyPressures<f64>,
}

impl Section<'_> {
    fn motion(&self, at: &SupplyPressures<f64>) -> Motion {
        let held = hold_pressures(self.unit, self.load, at.tank);
        let open = self.unit.valve.edge_openings(self.spool).iter().any(|opening| *opening > 0.0);
        if !open {
            let pressures = [held.0, held.1];
            return Motion { speed: 0.0, pressures, demand: self.flows(at, pressures).1 };
        }
        let Some((speed, pressures)) = self.moving(at) else {
            // The fed chamber has the pressure of the supply, or what holds the load, and draws nothing.
            let pressures =
                if self.spool < 0.0 { [held.0, held.1.max(at.supply)] } else { [held.0.max(at.supply), held.1] };
            let demand = Demand { drawn: 0.0, ..self.flows(at, pressures).1 };
            return Motion { speed: 0.0, pressures, demand };
        };
        Motion { speed, pressures, demand: self.flows(at, pressures).1 }
    }

    /// Speed (m/s) and pressures (Pa); `None` where the supply does not move the load.
    fn moving(&self, at: &SupplyPressures<f64>) -> Option<(f64, [f64; 2])> {
        let sense = self.spool.signum();
        let fed = usize::from(sense < 0.0);
        let chambers = &self.unit.chambers;
        let areas = [chambers.area_1, chambers.area_2];
        let (own, other) = (areas[fed], areas[1 - fed]);
        let in_order = |own: f64, other: f64| if fed == 0 { [own, other] } else { [other, own] };
        let behind = |p: f64, w: f64| {
            let friction = self.unit.friction.steady(sense * w.max(CREEP));
            (p * own - sense * (self.load + friction)) / other
        };
        let filling = |p: f64, behind: f64| self.flows(at, in_order(p, behind)).0[fed] / own;
        let emptying = |p: f64, behind: f64| -self.flows(at, in_order(p, behind)).0[1 - fed] / other;
        // The speed at which the fed chamber keeps its pressure.
        let kept = |p: f64| {
            let mut w = filling(p, behind(p, 0.0));
            for _ in 0..ROUNDS {
                let next = filling(p, behind(p, w));
                let done = (next - w).abs() < SPEED;
                w = next;
                if done {
                    break;
                }
            }
            w
        };
        let gap = |p: f64| {
            let w = kept(p);
            emptying(p, behind(p, w)) - w
        };
        if gap(at.supply) <= 0.0 {
            return None;
        }
        let (p, w) = if gap(self.vacuum) >= 0.0 {
            let p = self.vacuum;
            let most = emptying(p, behind(p, 0.0));
            (p, root(0.0, most.max(0.0), SPEED, |w| emptying(p, behind(p, w)) - w))
        } else {
            let p = root(self.vacuum, at.supply, PRESSURE, gap);
            (p, kept(p))
        };
        Some((sense * w.max(0.0), in_order(p, behind(p, w))))
    }

    /// Flows into both chambers, m^3/s, and what the section asks of the supply, at the pressures `p` of the chambers (Pa).
    pub fn flows(&self, at: &SupplyPressures<f64>, p: [f64; 2]) -> ([f64; 2], Demand<f64>) {
        let (unit, spool) = (self.unit, self.spool);
        let ports = unit.ports(at, 0.0, p, None);
        let (a, b) = (unit.port_a::<AnyParts>(&ports, spool), unit.port_b::<AnyParts>(&ports, spool));
        let leakage = unit.leakage.flows(p[0], p[1], at.tank);
        let inflows = unit.inflows::<AnyParts>([&a, &b], unit.crossed::<AnyParts>(&ports), leakage);
        let [p_a, p_b] = [a.at_valve(), b.at_valve()];
        let demand = Demand {
            drawn: a.fed + b.fed,
            signal: unit.valve.connection.signal(spool, [p_a, p_b], at.tank),
            returned: a.drained + b.drained + a.relieved + b.relieved + leakage.1,
        };
        ([inflows.0, inflows.1], demand)
    }
}

impl<const N: usize> Circuit<N> {
    fn sum(&self, of: impl Fn(&Demand<f64>) -> f64) -> f64 {
        self.motions.iter().map(|motion| of(&motion.demand)).sum()
    }

    fn signal(&self) -> f64 {
        self.motions.iter().fold(self.pressures.tank, |most, motion| most.max(motion.demand.signal))
    }
}

impl<const N: usize> Plant<f64, N> {
    /// With the spools at `spools` (m) under the `loads` (N).
    pub fn steady(&self, spools: &[f64; N], loads: &[f64; N]) -> Circuit<N> {
        let vacuum = self.fluid.vacuum;
        let sections: [Section; N] =
            array::from_fn(|c| Section { unit: &self.cylinders[c], vacuum, spool: spools[c], load: loads[c] });
        let Some(supply) = self.supply() else {
            let pressures = self.supply_pressures;
            return Circuit { motions: sections.map(|section| section.motion(&pressures)), pressures };
        };
        let tank = match &supply.tank_line {
            None => self.supply_pressures.tank,
            Some(line) => {
                let backed_up = |tank: f64| {
                    let found = balanced(supply, &sections, tank);
                    line.at_rest(found.sum(|demand| demand.returned) + supply.given(&found.pressures).1)
                };
                root(line.tank, backed_up(line.tank), PRESSURE, |tank| backed_up(tank) - tank)
            }
        };
        balanced(supply, &sections, tank)
    }
}

/// With the pumps giving what the sections draw.
fn balanced<const N: usize>(supply: &Supply<f64>, sections: &[Section; N], tank: f64) -> Circuit<N> {
    let lacking = |p: f64| {
        let found = sensed(supply, sections, p, tank);
        let (given, relieved) = supply.given(&found.pressures);
        found.sum(|demand| demand.drawn) + relieved - given
    };
    sensed(supply, sections, root(tank, supply.ceiling(), PRESSURE, lacking), tank)
}

/// With the highest signal on the load-sensing line: what the sections signal falls where they are given less of the drop.
fn sensed<const N: usize>(supply: &Supply<f64>, sections: &[Section; N], p: f64, tank: f64) -> Circuit<N> {
    let at = |load: f64| {
        let pressures = SupplyPressures { supply: p, load, tank };
        Circuit { motions: array::from_fn(|c| sections[c].motion(&pressures)), pressures }
    };
    let unloaded = at(tank);
    let highest = unloaded.signal();
    if supply.sensing.is_none() || highest <= tank {
        return unloaded;
    }
    let loaded = at(highest);
    if (loaded.signal() - highest).abs() <= PRESSURE {
        return loaded;
    }
    at(root(tank, highest, PRESSURE, |load| at(load).signal() - load))
}
