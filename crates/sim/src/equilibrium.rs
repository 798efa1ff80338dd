//! Equilibrium states: the load at rest on its cylinders.

use crate::crane::Crane;
use crate::cylinder_unit::{CylinderUnit, LocalState, Mains};
use crate::model::{EquilibriumMode, Model};
use hydrocrane_physics::hydraulics::fluid::Fluid;

/// A pose in which the crane cannot rest.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "joint `{joint}` at {coordinate:.6}: the piston of `{cylinder}` would be at {position:.4} m, \
     its ends are at {lower:.4} and {upper:.4} m; choose a pose inside the joint limits"
)]
pub struct PoseError {
    pub joint: String,
    pub coordinate: f64,
    pub cylinder: String,
    pub position: f64,
    pub lower: f64,
    pub upper: f64,
}

/// q' = xs' = 0, friction 0, pressures in balance with gravity and end stops at the joint coordinates `q`.
pub fn state<const N: usize>(
    crane: &Crane<N>,
    q: &[f64; N],
    mode: EquilibriumMode,
    payload: f64,
) -> Result<Vec<f64>, PoseError> {
    let layout = crane.layout();
    let mut x = vec![0.0; layout.len()];
    let (mut position, mut gain, mut force) = ([0.0; N], [0.0; N], [0.0; N]);
    crane.strokes(q, &mut position, &mut gain);
    crane.static_force(q, payload, &mut force);
    let back = crane.machine().equilibrium.back_pressure;
    for c in 0..N {
        let unit = &crane.plant.cylinders[c];
        let (lower, upper) = (unit.end_stop.lower, unit.end_stop.upper);
        if !(position[c] > lower && position[c] < upper) {
            let machine = crane.machine();
            return Err(PoseError {
                joint: machine.joints[c].name.clone(),
                coordinate: q[c],
                cylinder: machine.cylinders[c].name.clone(),
                position: position[c],
                lower,
                upper,
            });
        }
        let (stop, _) = unit.end_stop.force(position[c], 0.0);
        let hold = hold_pressures(unit, force[c] - stop, back);
        let balance = Balance {
            unit,
            fluid: &crane.plant.fluid,
            mains: &crane.plant.mains,
            position: position[c],
            force: force[c] - stop,
        };
        let (p1, p2, spool) = match mode {
            EquilibriumMode::Hold => (hold.0, hold.1, 0.0),
            EquilibriumMode::Steady => balance.solve().unwrap_or((hold.0, hold.1, 0.0)),
        };
        x[layout.q(c)] = q[c];
        x[layout.p1(c)] = p1;
        x[layout.p2(c)] = p2;
        x[layout.xs(c)] = spool;
    }
    Ok(x)
}

/// p1 A1 - p2 A2 = force with the chamber that carries less at the back pressure.
fn hold_pressures(unit: &CylinderUnit<f64>, force: f64, back: f64) -> (f64, f64) {
    let (a1, a2) = (unit.chambers.area_1, unit.chambers.area_2);
    if force >= back * (a1 - a2) {
        ((force + back * a2) / a1, back)
    } else {
        (back, (back * a1 - force) / a2)
    }
}

/// One cylinder standing still under a force: both pressures constant through a slightly open spool.
struct Balance<'a> {
    unit: &'a CylinderUnit<f64>,
    fluid: &'a Fluid<f64>,
    mains: &'a Mains<f64>,
    position: f64,
    force: f64,
}

impl Balance<'_> {
    /// (p1, p2, spool), or `None` where no opening balances the leakage (as without any leakage).
    fn solve(&self) -> Option<(f64, f64, f64)> {
        const SAMPLES: usize = 400;
        let (low, high) = (self.mains.tank, self.mains.supply);
        let at = |i: usize| low + (high - low) * (i as f64 + 0.5) / SAMPLES as f64;
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

    fn rates(&self, p1: f64, p2: f64, spool: f64) -> (f64, f64) {
        let s = LocalState { x: self.position, v: 0.0, p1, p2, spool, z: 0.0 };
        let rates = self.unit.rates(self.fluid, self.mains, &s);
        (rates.p1_rate, rates.p2_rate)
    }
}
