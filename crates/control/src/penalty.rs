//! Choice of a posture by penalties.                             theory: docs/theory/control/penalty.md
//!
//! p = sum_i w_move,i (q_d,i - q_i)^2 + w_mid,i (q_d,i - mid_i)^2                           thesis (131)
//!
//! over candidates that put the tip on its set-point with the other joints held at values spread over their range.
//! Candidates outside the limits do not enter, which is the thesis's first term with an infinite w_0. Departs from
//! the source: (131) measures the distance to mid-range from the actual coordinate, which no candidate changes (E36).

use crate::inverse_kinematics::{branches, Printed, TooFewRevolute};
use crate::nominal::Nominal;

/// Weights per joint, 1/rad^2 or 1/m^2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights<const N: usize> {
    /// w_1 to w_3: against large motions.
    pub motion: [f64; N],
    /// w_4 to w_6: towards the middle of the range.
    pub middle: [f64; N],
}

impl<const N: usize> Weights<N> {
    pub fn penalty(&self, limits: &[[f64; 2]; N], now: &[f64; N], candidate: &[f64; N]) -> f64 {
        (0..N)
            .map(|i| {
                let middle = 0.5 * (limits[i][0] + limits[i][1]);
                self.motion[i] * (candidate[i] - now[i]).powi(2) + self.middle[i] * (candidate[i] - middle).powi(2)
            })
            .sum()
    }
}

/// The posture of least penalty among `samples` values of the prismatic joints; `None` where nothing reaches.
pub fn search<const N: usize>(
    nominal: &Nominal<N>,
    weights: &Weights<N>,
    target: [f64; 2],
    now: &[f64; N],
    samples: usize,
) -> Result<Option<[f64; N]>, TooFewRevolute> {
    let limits = &nominal.joint_limits;
    let mut best: Option<(f64, [f64; N])> = None;
    for sample in 0..samples.max(1) {
        let share = if samples > 1 { sample as f64 / (samples - 1) as f64 } else { 0.5 };
        let held = std::array::from_fn(|i| limits[i][0] + share * (limits[i][1] - limits[i][0]));
        for candidate in branches(&nominal.mechanics, limits, target, &held, Printed::default())?.into_iter().flatten()
        {
            let penalty = weights.penalty(limits, now, &candidate);
            if best.is_none_or(|(least, _)| penalty < least) {
                best = Some((penalty, candidate));
            }
        }
    }
    Ok(best.map(|(_, q)| q))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weighs_motion_and_the_distance_of_the_candidate_from_the_middle() {
        let weights = Weights { motion: [1.0, 0.0], middle: [0.0, 2.0] };
        let limits = [[0.0, 2.0], [-1.0, 3.0]];
        assert_eq!(weights.penalty(&limits, &[0.5, 9.0], &[1.5, 4.0]), 1.0 + 2.0 * 9.0);
    }
}
