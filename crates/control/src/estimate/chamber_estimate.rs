//! Chamber pressures and force of a cylinder that nothing measures.   theory: docs/theory/control/estimate.md
//!
//! The load that the controller knows gives A_1 p_1 - A_2 p_2 = F_ref; what the spool lets in and out moves both pressures along that
//! line, (dp_1, dp_2) = (A_2, A_1) dz. What the piston is off the place x^ to which the flow takes it is oil that gives way:
//!
//!   F = F_ref - k (x - x^)

use crate::estimate::observer::{Gains, Observer};
use crate::model::controller_model::CylinderModel;
use crate::model::feed_forward::{Moment, SupplyPressures, MOST};
use hydrocrane_num::portable;
use hydrocrane_physics::hydraulics::fluid::Fluid;

/// Where the chamber pressures come from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pressures {
    Measured,
    /// From the model, with this pressure (Pa) in the chamber that carries less at rest.
    Estimated(f64),
}

hydrocrane_num::stored!([] enum Pressures { 0: Measured {}, 1: Estimated { 0: f64 } });

/// Halvings of the interval in which the level is looked for.
const HALVINGS: usize = 10;

/// Rest bands by which a piston goes farther off at rest before its valve closes.
const YIELDS: f64 = 5.0;

/// Oil and supply around a cylinder.
#[derive(Debug, Clone, Copy)]
pub struct Surroundings {
    pub fluid: Fluid<f64>,
    pub supply_pressures: SupplyPressures,
    /// s
    pub period: f64,
}

/// What the last command asked for.
#[derive(Debug, Clone, Copy)]
pub struct Sent {
    /// Spool position, m, and the speed of the piston (m/s) that its flow gives while the force stays the same.
    pub spool: f64,
    pub speed: f64,
    /// F_ref, N
    pub planned: f64,
}

/// What the speed of a piston tells of its load.
#[derive(Debug, Clone, Copy)]
pub struct Evidence {
    /// d, m/s
    pub missing: f64,
    /// How surely it tells anything, 0 to 1.
    pub share: f64,
    /// Speed that the resolution of the joint sensor hides, m/s.
    pub uncertainty: f64,
    /// dv/dF, m/(s N)
    pub per_force: f64,
    /// Speed at full opening, m/s.
    pub full: f64,
    /// From full pressure on the one side to full pressure on the other, N.
    pub span: f64,
}

#[derive(Debug, Clone, Copy)]
pub struct ChamberEstimate {
    /// p_1 and p_2, Pa
    pub p: [f64; 2],
    /// N
    pub force: f64,
    pub sent: Sent,
    /// Where the flow takes the piston, as observed.
    carried: Observer,
    /// Spool position as it follows the commands, m.
    spool: f64,
    /// Resolution of the piston's position at the last sample, and how near to its place it has been at rest, m.
    count: f64,
    nearest: f64,
    /// Whether the load pushes the piston back at rest though the valve opens against it.
    pub yields: bool,
}

impl ChamberEstimate {
    /// At rest under `force` (N), with the pressure `back` (Pa) in the chamber that carries nothing.
    pub fn at(cylinder: &CylinderModel, stroke: f64, force: f64, back: f64) -> Self {
        let [a1, a2] = [cylinder.chambers.area_1, cylinder.chambers.area_2];
        let pushed = (force + a2 * back) / a1;
        let p = if pushed > back { [pushed, back] } else { [back, (a1 * back - force) / a2] };
        let sent = Sent { spool: 0.0, speed: 0.0, planned: force };
        let carried = Observer::at(stroke);
        ChamberEstimate { p, force, sent, carried, spool: 0.0, count: 0.0, nearest: f64::INFINITY, yields: false }
    }

    /// Has the model explain `speed` (m/s) of what was missing.
    pub fn explain(&mut self, speed: f64) {
        self.carried.explain(speed);
    }

    /// Takes note of a piston that is `off` (m) its place, of which `band` (m) is left alone at rest; `rest`: it is held there.
    pub fn hold(&mut self, rest: bool, off: f64, band: f64) {
        self.nearest = if rest { self.nearest.min(off) } else { f64::INFINITY };
        self.yields = rest && (self.yields || off > self.nearest + YIELDS * band + self.count);
    }

    /// After a period, with the piston at `stroke` (m), which is known to a `count` (m), on oil of this `stiffness` (N/m).
    pub fn advance(
        &mut self,
        cylinder: &CylinderModel,
        around: &Surroundings,
        gains: &Gains,
        (stroke, count): (f64, f64),
        stiffness: f64,
    ) {
        let Sent { spool, speed, planned } = self.sent;
        self.count = count;
        self.carried.update(stroke, speed, gains, 1.0, count);
        let behind = self.spool;
        self.spool = spool + (behind - spool) * portable::exp(-around.period / cylinder.dynamics.lag().max(1e-6));
        self.settle(cylinder, around, stroke, planned, 0.5 * (behind + self.spool));
        let given = stroke - self.carried.position;
        self.force = planned - stiffness * (given - given.clamp(-0.25 * count, 0.25 * count));
    }

    /// Takes the pressures over a period in which the force becomes `planned` (N), with the spool at `spool` (m).
    fn settle(&mut self, cylinder: &CylinderModel, around: &Surroundings, stroke: f64, planned: f64, spool: f64) {
        let Surroundings { fluid, supply_pressures, period } = around;
        let [a1, a2] = [cylinder.chambers.area_1, cylinder.chambers.area_2];
        let most = MOST * supply_pressures.supply;
        let bounded = |p: [f64; 2]| p.map(|p| p.clamp(fluid.vacuum, most));
        let more = planned - cylinder.chambers.force(self.p[0], self.p[1]);
        let share = cylinder.pressures_per_force(fluid, &Moment { stroke, p: self.p });
        self.p = bounded(hydrocrane_num::array::from_fn(|i| self.p[i] + more * share[i]));

        // Implicit step, z = T z'(z): chambers that fill within a period come to their steady level. z' falls with z.
        let at = |z: f64| [self.p[0] + a2 * z, self.p[1] + a1 * z];
        let rate = |z: f64| cylinder.level_rate(fluid, supply_pressures, &Moment { stroke, p: at(z) }, spool);
        let (mut short, mut beyond) = (0.0, period * rate(0.0));
        for _ in 0..HALVINGS {
            let z = 0.5 * (short + beyond);
            if (period * rate(z) - z) * beyond > 0.0 {
                short = z;
            } else {
                beyond = z;
            }
        }
        self.p = bounded(at(0.5 * (short + beyond)));
    }
}
