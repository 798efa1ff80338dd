//! The payload that the speeds of the pistons tell where no pressure is measured.
//!                                                          theory: docs/theory/control/estimate.md
//!
//! A heavier payload makes a piston lift slower and lower faster than the valve's law expects, by s = dv/dF dF/dm for each kilogram.
//! The speeds d that the observers find missing, with the deviation sigma, give the payload by recursive least squares:
//!
//!   I <- I + T/T_e sum (s/sigma)^2 - T/T_m I,     m <- m + T/T_e sum s d/sigma^2 / (I + 1/sigma_m^2)

use crate::estimate::chamber_estimate::Evidence;
use crate::model::controller_model::ControllerModel;
use crate::regulate::drive::Drive;
use hydrocrane_num::Real;

/// Standard deviation by which a piston's speed differs from the law, share of its full speed, and the time over which it stays so, s.
const ERROR: f64 = 0.01;
const ERROR_TIME: f64 = 0.2;
/// Standard deviation of the force by friction and the like, share of the span.
const FORCE_ERROR: f64 = 0.05;
/// Standard deviation of the payload before anything has moved, share of the crane's own mass.
const BELIEF: f64 = 0.3;
/// Time of motion that is remembered, s.
const MEMORY: f64 = 5.0;

#[derive(Debug, Clone, Copy)]
pub struct Weighing {
    /// I and 1/sigma_m^2, 1/kg^2
    information: f64,
    belief: f64,
    /// T/T_m and T/T_e
    forgetting: f64,
    weight: f64,
}

impl Weighing {
    /// Nothing known of the load of a crane whose links have the mass `own`, kg; `period` in s.
    pub fn new(own: f64, period: f64) -> Self {
        Weighing {
            information: 0.0,
            belief: 1.0 / (BELIEF * own).square(),
            forgetting: (period / MEMORY).min(1.0),
            weight: (period / ERROR_TIME).min(1.0),
        }
    }

    /// Takes in a sample of pistons whose positions have the resolutions `counts` (m); the payload, kg, which was taken to be `before`.
    /// The drives then carry it.
    pub fn payload<const N: usize>(
        &mut self,
        model: &ControllerModel<N>,
        drives: &mut [Drive; N],
        q: &[f64; N],
        counts: &[f64; N],
        before: f64,
    ) -> f64 {
        let at = model.at(q);
        let [planned, laden] = [0.0, 1.0].map(|more| model.cylinder_force_at(&at, &[0.0; N], model.payload + more));
        let per_kilogram: [f64; N] = hydrocrane_num::array::from_fn(|c| laden[c] - planned[c]);
        let evidence: [Evidence; N] = hydrocrane_num::array::from_fn(|c| drives[c].evidence(counts[c]));
        // More than the supply pressure can move is no payload that moves.
        let most = (0..N).fold(f64::INFINITY, |most, c| {
            let [low, high] = drives[c].movable();
            let limit = if per_kilogram[c] > 0.0 { high } else { low };
            most.min(((limit - planned[c]) / per_kilogram[c]).max(0.0))
        });
        let after = (before + self.more(&evidence, &per_kilogram)).min(model.payload + most).max(0.0);
        for (c, drive) in drives.iter_mut().enumerate() {
            // At a dead centre no force carries anything.
            let force = if per_kilogram[c].is_finite() { per_kilogram[c] } else { 0.0 };
            drive.carry((after - model.payload) * force, (after - before) * force * evidence[c].per_force);
        }
        after
    }

    /// By how much the payload is more than was thought, kg. `per_kilogram`: dF/dm, m/s^2.
    fn more<const N: usize>(&mut self, evidence: &[Evidence; N], per_kilogram: &[f64; N]) -> f64 {
        let (mut square, mut product) = (0.0, 0.0);
        for (e, force) in evidence.iter().zip(per_kilogram) {
            let noise =
                (ERROR * e.full).square() + e.uncertainty.square() + (FORCE_ERROR * e.span * e.per_force).square();
            let s = e.per_force * force;
            square += e.share * s * s / noise;
            product += e.share * s * e.missing / noise;
        }
        if !(square > 0.0 && square.is_finite() && product.is_finite()) {
            return 0.0;
        }
        self.information += self.weight * square - self.forgetting * self.information;
        self.weight * product / (self.information + self.belief)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A piston at a tenth of its full speed which lifts 50 N for each kilogram, with this speed missing.
    fn lifting(missing: f64) -> Evidence {
        Evidence { missing, share: 1.0, uncertainty: 0.0, per_force: -1e-7, full: 0.1, span: 1e5 }
    }

    /// The payload that a piston tells that has `true_payload` to lift, after `seconds`.
    fn found(true_payload: f64, seconds: f64, share: f64) -> f64 {
        let (mut weighing, mut payload) = (Weighing::new(500.0, 0.01), 0.0);
        for _ in 0..(seconds / 0.01) as usize {
            let missing = -1e-7 * 50.0 * (true_payload - payload);
            let evidence = Evidence { share, ..lifting(missing) };
            payload += weighing.more(&[evidence], &[50.0]);
        }
        payload
    }

    #[test]
    fn a_piston_that_lifts_slower_carries_more() {
        assert!((found(80.0, 20.0, 1.0) - 80.0).abs() < 8.0, "{}", found(80.0, 20.0, 1.0));
        let soon = found(80.0, 0.5, 1.0);
        assert!(soon > 0.0 && soon < 80.0, "{soon}");
    }

    #[test]
    fn a_piston_that_stands_tells_nothing() {
        assert_eq!(found(80.0, 20.0, 0.0), 0.0);
    }

    #[test]
    fn what_is_no_number_is_left_out() {
        let mut weighing = Weighing::new(500.0, 0.01);
        for bad in [f64::NAN, f64::INFINITY] {
            assert_eq!(weighing.more(&[lifting(bad)], &[50.0]), 0.0);
            assert_eq!(weighing.more(&[lifting(-1e-5)], &[bad]), 0.0);
        }
        assert!(weighing.more(&[lifting(-1e-5)], &[50.0]) > 0.0);
    }
}
