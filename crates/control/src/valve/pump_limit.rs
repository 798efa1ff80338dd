//! How much of a motion the pump can feed.                      theory: docs/theory/control/reference.md
//!
//! s = min(1, r Q / sum a_i |v_i|),    Q = e D w - k dp,    e = min(1, M_max/(D dp) - c)
//!
//! | symbol | meaning | unit |
//! | a_i | area through which the section draws: A_1 out, A_2 in; A_1 - A_2 out with a regenerative valve | m^2 |
//! | v_i | piston speed that the motion asks for                                      | m/s   |
//! | r   | share of the flow that a motion may plan with: the rest is for corrections | -     |
//! | Q   | largest flow at the pressure rise dp, by the laws of the pump              | m^3/s |
//!
//! All joints slow down by the same share, so that the tip stays on its path. dp is what the pump is set to; with load sensing
//! the highest pressure of the chambers that are fed, and the margin.

use crate::model::controller_model::{ControllerModel, CylinderModel, PumpModel};

/// r: share of the pump's flow that a motion may plan with.
const PLANNED: f64 = 0.9;

impl PumpModel {
    /// Largest flow while the pressure of the mains is `p` (Pa), m^3/s.
    pub fn most(&self, p: f64, tank: f64) -> f64 {
        let rise = (p - tank).max(0.0);
        // Without any rise the quotient is infinite or no number: min takes full displacement.
        let by_torque = self.torque_limit / (self.pump.displacement * rise) - self.pump.mechanical_loss;
        self.pump.flow(1.0_f64.min(by_torque).max(0.0), rise).max(0.0)
    }
}

impl CylinderModel {
    /// Area through which the section draws from the supply while the piston moves at `v` (m/s), m^2.
    pub fn drawing_area(&self, v: f64) -> f64 {
        match v > 0.0 {
            true => self.chambers.area_1 - self.valve.regenerative * self.chambers.area_2,
            false => self.chambers.area_2,
        }
    }
}

impl<const N: usize> ControllerModel<N> {
    /// Share of the piston speeds `v` (m/s) that the pump can feed at the chamber pressures `p` (Pa); 1 without a pump.
    pub fn pump_share(&self, v: &[f64; N], p: &[[f64; 2]; N]) -> f64 {
        let Some(pump) = &self.pump else { return 1.0 };
        let drawn: f64 = (0..N).map(|c| self.cylinders[c].drawing_area(v[c]) * v[c].abs()).sum();
        let load = (0..N).filter(|&c| v[c] != 0.0).map(|c| p[c][usize::from(v[c] < 0.0)]).fold(self.tank, f64::max);
        let pressure = pump.margin.map_or(pump.highest, |margin| pump.highest.min(load + margin));
        let most = PLANNED * pump.most(pressure, self.tank);
        if drawn <= most {
            1.0
        } else {
            most / drawn
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hydrocrane_physics::hydraulics::pump::Pump;

    fn pump() -> PumpModel {
        // 20 cm^3 per radian at 100 rad/s: 2 l/s, of which 5 % leak at 200 bar.
        let pump =
            Pump { displacement: 20e-6, speed: 100.0, droop: 0.0, leakage: 0.05 * 2e-3 / 200e5, mechanical_loss: 0.1 };
        PumpModel { pump, torque_limit: f64::INFINITY, highest: 200e5, margin: None }
    }

    #[test]
    fn the_largest_flow_is_what_leakage_leaves_and_torque_allows() {
        assert!((pump().most(200e5, 0.0) - 0.95 * 2e-3).abs() < 1e-15);
        assert_eq!(pump().most(0.0, 0.0), 2e-3);
        // 300 N m at 200 bar turn the swivel to 300/400 - 0.1 of its range.
        let weak = PumpModel { torque_limit: 300.0, ..pump() };
        assert!((weak.most(200e5, 0.0) - (0.65 - 0.05) * 2e-3).abs() < 1e-15);
        assert_eq!(weak.most(100e5, 0.0), pump().most(100e5, 0.0));
        assert_eq!(weak.most(0.0, 0.0), 2e-3);
        assert_eq!(PumpModel { torque_limit: 1.0, ..pump() }.most(200e5, 0.0), 0.0);
    }
}
