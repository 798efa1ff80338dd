//! Choice of a posture by penalties.                             theory: docs/theory/control/heinze_pid.md
//!
//! p = sum_i w_move,i (q_d,i - q_i)^2 + w_mid,i (q_d,i - mid_i)^2                           thesis (131)
//!
//! over candidates that put the tip on its set-point with the other joints held at values from their lower limit past
//! where they are to their upper limit.
//! Candidates outside the limits do not enter, which is the thesis's first term with an infinite w_0. Departs from
//! the source: (131) measures the distance to mid-range from the actual coordinate, which no candidate changes (E36).

use crate::model::controller_model::ControllerModel;
use crate::model::inverse_kinematics::{branches, Printed, TooFewRevolute};
use hydrocrane_num::Real;

/// Weights per joint, 1/rad^2 or 1/m^2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights<const N: usize> {
    /// w_1 to w_3: against large motions.
    pub motion: [f64; N],
    /// w_4 to w_6: towards the middle of the range.
    pub middle: [f64; N],
}

hydrocrane_num::stored!([const N: usize] Weights<N> { motion: [f64; N], middle: [f64; N] });

impl<const N: usize> Weights<N> {
    pub fn penalty(&self, limits: &[[f64; 2]; N], now: &[f64; N], candidate: &[f64; N]) -> f64 {
        (0..N)
            .map(|i| {
                let middle = 0.5 * (limits[i][0] + limits[i][1]);
                self.motion[i] * (candidate[i] - now[i]).square() + self.middle[i] * (candidate[i] - middle).square()
            })
            .sum()
    }
}

/// The posture of least penalty, where anything reaches: among `samples` values of the prismatic joints to each side of
/// their present ones, then between the neighbours of the best. The present ones are among them, so that the telescope stands
/// still where moving does not pay, and the target moves with the set-point rather than from sample to sample.
pub fn search<const N: usize>(
    model: &ControllerModel<N>,
    weights: &Weights<N>,
    target: [f64; 2],
    now: &[f64; N],
    samples: usize,
) -> Result<Option<[f64; N]>, TooFewRevolute> {
    let mut best: Option<Candidate<N>> = None;
    let mut consider = |share: f64| {
        let limits = &model.joint_limits;
        let held = held_at(limits, now, share);
        for q in branches(&model.mechanics, limits, target, &held, Printed::default())?.into_iter().flatten() {
            let penalty = weights.penalty(limits, now, &q);
            if best.is_none_or(|least| penalty < least.penalty) {
                best = Some(Candidate { penalty, q, share });
            }
        }
        Ok(best.map(|least| least.share))
    };
    let mut at = consider(0.0)?;
    let mut step = 1.0 / samples.max(1) as f64;
    for sample in 1..=samples.max(1) {
        consider(step * sample as f64)?;
        at = consider(-step * sample as f64)?;
    }
    for _ in 0..HALVINGS {
        step *= 0.5;
        let Some(centre) = at else { break };
        consider((centre - step).max(-1.0))?;
        at = consider((centre + step).min(1.0))?;
    }
    Ok(best.map(|least| least.q))
}

#[derive(Clone, Copy)]
struct Candidate<const N: usize> {
    penalty: f64,
    q: [f64; N],
    share: f64,
}

/// Halvings of the distance between candidates: to a thousandth.
const HALVINGS: usize = 10;

/// All joints `share` of the way from where they are to their lower (negative) or upper limit.
fn held_at<const N: usize>(limits: &[[f64; 2]; N], now: &[f64; N], share: f64) -> [f64; N] {
    hydrocrane_num::array::from_fn(|i| {
        let [low, high] = limits[i];
        let here = now[i].max(low).min(high);
        let end = if share < 0.0 { low } else { high };
        here + share.abs() * (end - here)
    })
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

    #[test]
    fn candidates_run_from_limit_to_limit_past_the_present_posture() {
        let limits = [[-1.0, 3.0], [0.0, 1.0]];
        let at = |share| held_at(&limits, &[2.0, 0.5], share);
        assert_eq!([at(-1.0), at(0.0), at(0.5), at(1.0)], [[-1.0, 0.0], [2.0, 0.5], [2.5, 0.75], [3.0, 1.0]]);
        assert_eq!(held_at(&limits, &[9.0, -9.0], 0.0), [3.0, 0.0]);
    }
}
