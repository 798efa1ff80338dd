//! How fast a motion may be so that the cylinders can end it.            theory: docs/theory/control/reference.md
//!
//! low <= (tau(q, q', -n w/e q')/g)_c <= high    at every stage of a stop,    h_i(q + 3 q'/w) >= 0.9
//!
//! | symbol    | meaning                                                                                  | unit  |
//! | tau       | torques of the joints at a stage: load, Coriolis and inertia                             | N m or N |
//! | w         | bandwidth of the stick's two lags, which decelerate by w/e of the speed at most          | rad/s |
//! | n         | forces of a stop in those without swings                                                 | -     |
//! | low, high | forces of nearly the supply pressure on either side, or of that at which a relief valve opens | N     |
//! | h         | share of `holding`: how the oil holds a joint                                            | -     |
//!
//! Near a dead centre the lever arm g vanishes, and with it what a cylinder can do against the mass that it moves.

use crate::model::controller_model::{At, ControllerModel, CylinderModel};
use crate::reference::set_point::Means;
use core::cell::LazyCell;
use hydrocrane_num::bisect;

/// Pressure that a stop may plan with, in supply pressures: where the piston draws from the supply, and where a closing edge stops
/// oil that the load pushes out, which no supply limits. Cylinders without a rating are rated for 1.5.
const DRAWN: f64 = 0.95;
const HELD_BACK: f64 = 1.3;
/// n: the oil swings beyond the force of a stop behind lags near its lowest mode.
const SWING: f64 = 2.2;
/// Share of the forces from full pressure on the one side to full pressure on the other that a stop may always take: where a load
/// leaves nothing, the tip still creeps.
const LEAST: f64 = 0.02;
/// Share h that every joint has at the end of its travel, unless it is no worse than here, and that travel, in v/w.
const HELD: f64 = 0.9;
const WAY_HELD: f64 = 3.0;
/// Travel of a stop, in v/w.
const STOPPED: f64 = 2.0;
/// Halvings that find the share.
const HALVINGS: usize = 10;

/// A stage of a stop behind two lags: travel since the stick was released, in v/w, and share of the speed that is left.
struct Stage {
    travel: f64,
    speed: f64,
}

/// The beginning, the steepest deceleration (1/w after it, at 2/e of the speed) and the end.
const STAGES: [Stage; 3] =
    [Stage { travel: 0.0, speed: 1.0 }, Stage { travel: 0.9, speed: 0.736 }, Stage { travel: 2.0, speed: 0.0 }];

/// Largest share of these rates that is borne.
fn most_borne<const N: usize>(rates: &[f64; N], borne: impl Fn(&[f64; N]) -> bool) -> f64 {
    if rates.iter().all(|rate| *rate == 0.0) || borne(rates) {
        return 1.0;
    }
    bisect(0.0, 1.0, HALVINGS, |share| borne(&rates.map(|rate| share * rate)))
}

impl CylinderModel {
    /// Lowest and highest force that a stop from this `speed` (m/s) may plan with, N.
    fn braking_forces(&self, supply: f64, tank: f64, speed: f64) -> [f64; 2] {
        let highest = |held_back: bool| supply * if held_back { HELD_BACK } else { DRAWN };
        self.forces_up_to([highest(speed < 0.0), highest(speed > 0.0)], tank)
    }

    /// Lowest and highest force with these pressures (Pa) in either chamber at most and the other one at that of the tank, N.
    fn forces_up_to(&self, most: [f64; 2], tank: f64) -> [f64; 2] {
        let [p_1, p_2] = [0, 1].map(|side| most[side].min(self.tight_to[side]));
        [self.chambers.force(tank, p_2), self.chambers.force(p_1, tank)]
    }
}

impl<const N: usize> ControllerModel<N> {
    /// Share of the joint `rates` (rad/s or m/s) of a reference that is `at` a place that the cylinders can bring to rest behind two lags of this
    /// `bandwidth` (rad/s). `lifting`: and end where the supply pressure lifts the load.
    pub fn braking_share(&self, at: &At<N>, rates: &[f64; N], bandwidth: f64, now: &Means<N>, lifting: bool) -> f64 {
        let here = LazyCell::new(|| self.cylinder_force_at(at, &[0.0; N], now.payload));
        most_borne(rates, |rates| {
            STAGES.iter().all(|stage| self.brakes(at, rates, now.payload, bandwidth, stage))
                && (!lifting || self.ends_lifted(at, rates, bandwidth, now, &here))
        })
    }

    /// Share of the joint `rates` (rad/s or m/s) with which the crane comes to rest where closed valves hold it.
    pub fn held_share(&self, rates: &[f64; N], bandwidth: f64, now: &Means<N>) -> f64 {
        most_borne(rates, |rates| self.ends_held(rates, bandwidth, now))
    }

    /// Whether the cylinders bear the deceleration of a motion that is `at` a place at one of its stages.
    fn brakes(&self, at: &At<N>, rates: &[f64; N], payload: f64, bandwidth: f64, stage: &Stage) -> bool {
        let ahead: At<N>;
        let there = if stage.travel == 0.0 {
            at
        } else {
            ahead = self.at(&hydrocrane_num::array::from_fn(|i| {
                let [low, high] = self.joint_limits[i];
                (at.q[i] + stage.travel / bandwidth * rates[i]).clamp(low.min(at.q[i]), high.max(at.q[i]))
            }));
            &ahead
        };
        let steepest = SWING * bandwidth / core::f64::consts::E;
        let (speed, acceleration) = (rates.map(|rate| stage.speed * rate), rates.map(|rate| -steepest * rate));
        // Hardly ever asked for: usual motions are borne in full.
        let still = LazyCell::new(|| self.inverse_dynamics(&there.pose, &[0.0; N], None, payload));
        let stopping = self.inverse_dynamics(&there.pose, &speed, Some(&acceleration), payload);
        (0..N).all(|c| {
            let lever_arm = there.lever_arm[c];
            let [low, high] = self.cylinders[c].braking_forces(self.supply, self.tank, lever_arm * rates[c]);
            let least = LEAST * (high - low);
            let force = stopping[c] / lever_arm;
            let more = || (stopping[c] - still[c]) / lever_arm;
            // At a dead centre itself the quotients are not numbers: no motion ends there.
            (force <= high || more() <= least) && (force >= low || more() >= -least)
        })
    }

    /// Whether the supply pressure lifts the load where a motion that is `at` a place ends, or the load is no worse than `here`, N.
    fn ends_lifted(&self, at: &At<N>, rates: &[f64; N], bandwidth: f64, now: &Means<N>, here: &[f64; N]) -> bool {
        let time = STOPPED / bandwidth;
        let end = hydrocrane_num::array::from_fn(|i| at.q[i] + time * rates[i]);
        let there = self.cylinder_force(&end, &[0.0; N], now.payload);
        (0..N).all(|c| {
            let [low, high] = self.cylinders[c].forces_up_to([DRAWN * self.supply; 2], self.tank);
            (there[c] <= high || there[c] <= here[c]) && (there[c] >= low || there[c] >= here[c])
        })
    }

    /// Whether closed valves hold the joints where a motion of the crane ends.
    fn ends_held(&self, rates: &[f64; N], bandwidth: f64, now: &Means<N>) -> bool {
        let time = WAY_HELD / bandwidth;
        let end = self.at(&hydrocrane_num::array::from_fn(|i| now.observed[i] + time * rates[i]));
        let there = self.held(&end, now.payload, &now.stiffness);
        (0..N).all(|i| there[i] >= HELD.min(now.held[i]))
    }
}
