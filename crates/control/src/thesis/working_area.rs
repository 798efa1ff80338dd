//! Where the thesis's controller may put its set-point (Table 6, step 6).   theory: docs/theory/control/heinze_pid.md
//!
//! A set-point that moves at every sample slows down before the regions to keep out of and before the limits of the
//! joints; one that leaps is accepted or not.

use crate::model::controller_model::ControllerModel;
use crate::reference::keep_out::{Caution, KeepOut};
use crate::reference::redundancy::{resolve, Preference, Task};
use crate::reference::slow_down::joint_rates;

#[derive(Debug, Clone, PartialEq)]
pub struct WorkingArea {
    pub keep_out: KeepOut,
    /// Rate of the slow-down before limits, 1/s.
    pub limit_rate: f64,
}

hydrocrane_num::stored!([] WorkingArea { keep_out: KeepOut, limit_rate: f64 });

/// Deeper by less than this is rounding, m.
const ROUNDING: f64 = 1e-9;

impl WorkingArea {
    /// `velocity` of a set-point at `place` with the joint targets `q`, slowed down before borders. `moves`: the joints
    /// that the controller chooses freely.
    pub fn slowed<const N: usize>(
        &self,
        model: &ControllerModel<N>,
        q: &[f64; N],
        moves: &[bool; N],
        place: [f64; 2],
        velocity: [f64; 2],
    ) -> [f64; 2] {
        let velocity = self.keep_out.slowed(place, velocity, &Caution::NONE);
        let posture = model.posture(q);
        let any_speed = [[f64::NEG_INFINITY, f64::INFINITY]; N];
        let mut bounds = joint_rates(model, &posture, q, &any_speed, self.limit_rate);
        for i in (0..N).filter(|&i| !moves[i]) {
            bounds[i] = [0.0; 2];
        }
        let prefer = Preference { weights: [1.0; N], rates: [0.0; N], bounds };
        let share = resolve(&posture.jacobian, &Task { velocity, correction: [0.0; 2] }, &prefer).scale;
        velocity.map(|v| share * v)
    }

    /// Whether a set-point may go from `from` to `to` as far as regions matter: out of every margin, or at least no deeper.
    pub fn accepts(&self, from: [f64; 2], to: [f64; 2]) -> bool {
        let (before, after) = (self.keep_out.distance(from), self.keep_out.distance(to));
        after >= self.keep_out.margin.min(before) - ROUNDING
    }

    /// Joint limits, widened to a target that lies beyond them already, so that there is a way back.
    pub fn limits<const N: usize>(&self, model: &ControllerModel<N>, q: &[f64; N]) -> [[f64; 2]; N] {
        hydrocrane_num::array::from_fn(|i| {
            let [low, high] = model.joint_limits[i];
            [low.min(q[i]), high.max(q[i])]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::keep_out::Region;

    #[test]
    fn a_set_point_may_leave_a_region_but_not_go_deeper() {
        let region = Region::new(vec![[-1.0, -1.0], [1.0, -1.0], [1.0, 0.0], [-1.0, 0.0]]);
        let area = WorkingArea { keep_out: KeepOut { regions: vec![region], margin: 0.1, rate: 2.0 }, limit_rate: 2.0 };
        assert!(area.accepts([0.0, 1.0], [0.0, 0.1]));
        assert!(!area.accepts([0.0, 1.0], [0.0, 0.05]));
        assert!(area.accepts([0.0, -0.3], [0.0, -0.2]) && !area.accepts([0.0, -0.2], [0.0, -0.3]));
        let nowhere = WorkingArea { keep_out: KeepOut::default(), limit_rate: 2.0 };
        assert!(nowhere.accepts([0.0, 1.0], [9.0, -9.0]));
    }
}
