//! Speed of the tip at full stick, where nobody states one.   theory: docs/theory/control/reference.md
//!
//! v = min(v_1, e l w_1^2/w),     w = min(w_0, w_1)
//!
//! | symbol | meaning                                                                        | unit  |
//! | v_1    | speed in the crane's plane with the fastest joint alone, unloaded              | m/s   |
//! | l      | distance of the tip from the set-point at which the set-point waits            | m     |
//! | w_0    | bandwidth of each of the stick's two lags                                      | rad/s |
//! | w_1    | lowest natural frequency of the crane on its oil, with the stated load         | rad/s |
//!
//! All in the middle of the joints' ranges. Behind two lags a motion starts and stops with v w/e, under which the oil gives way by that
//! over w_1^2.

use crate::model::controller_model::ControllerModel;
use crate::model::feed_forward::{steady_speed, Moment};
use core::f64::consts::E;

/// 31 mm of the laboratory crane's 4.1 m.
const LAG_PER_REACH: f64 = 0.0075;

impl<const N: usize> ControllerModel<N> {
    /// Speed of the tip at full stick (m/s) with lags of this `bandwidth` (rad/s), where the set-point waits at the distance `lag_limit`, m.
    pub fn full_speed(&self, bandwidth: f64, lag_limit: f64) -> f64 {
        let q = self.joint_limits.map(|[low, high]| 0.5 * (low + high));
        let (posture, at) = self.posture_at(&q);
        let fastest = (usize::from(self.slews())..N)
            .map(|i| posture.tip_per_joint(i) * (self.unloaded_speed(i, 1.0) / posture.lever_arm[i]).abs());
        let supply_pressures = self.supply_pressures();
        let stiffness = hydrocrane_num::array::from_fn(|c| {
            let moment = Moment { stroke: posture.stroke[c], p: [0.5 * (self.supply + self.tank); 2] };
            self.cylinders[c].capacity(&self.fluid, &supply_pressures, &moment).stiffness
        });
        let mass = self.mass_matrix(&at.pose, self.payload);
        let slowest = self.oil_modes(&mass, &posture.lever_arm, &stiffness).slowest();
        let followed = E * lag_limit * slowest * slowest / bandwidth.min(slowest);
        // At a dead centre the crane can have no modes.
        fastest.fold(0.0, f64::max).min(if followed > 0.0 { followed } else { f64::INFINITY })
    }

    /// Distance of the tip at which the set-point waits, where nobody states one, m: a share of the longest line from a joint that turns to the
    /// tip, with all joints at their limits; of one that slides, of its range.
    pub fn lag_limit(&self) -> f64 {
        let corner = |k: usize| hydrocrane_num::array::from_fn(|i| self.joint_limits[i][k >> i & 1]);
        let reach = |k: usize| {
            let posture = self.posture(&corner(k));
            let arm = |i: usize| {
                let [low, high] = self.joint_limits[i];
                if self.mechanics.joints[i].revolute {
                    posture.tip_per_joint(i)
                } else {
                    high - low
                }
            };
            (0..N).map(arm).fold(0.0, f64::max)
        };
        LAG_PER_REACH * (0..1 << N).map(reach).fold(0.0, f64::max)
    }

    /// Steady speed of a piston at full stroke of its spool without load, in either direction, m/s.
    pub fn unloaded_speed(&self, cylinder: usize, sense: f64) -> f64 {
        sense * steady_speed(&self.cylinders[cylinder], &self.supply_pressures(), 0.0, sense)
    }

    /// The faster of both directions, no faster than the oil of the pump, m/s.
    pub fn fastest(&self, cylinder: usize) -> f64 {
        let fed = |sense: f64| {
            self.pump.map_or(f64::INFINITY, |pump| {
                pump.most(self.tank, self.tank) / self.cylinders[cylinder].drawing_area(sense)
            })
        };
        [-1.0, 1.0].map(|sense| self.unloaded_speed(cylinder, sense).min(fed(sense))).into_iter().fold(0.0, f64::max)
    }
}
