//! On which side of its overlap a spool stands.                      theory: docs/theory/control/regulate.md
//!
//! A spool with an overlap stays on the side that the motion needs, and damps by the half waves that open it farther. It waits at the edge
//! during the others, where no edge passes oil: there and back it would pass nothing but what it overshoots.

use crate::model::controller_model::CylinderModel;

#[derive(Debug, Clone, Copy)]
pub struct Overlap {
    /// Where the spool stands or waits: at the edges of the overlap at -1 and 1, in its middle at 0.
    side: f64,
    /// How far the spool swings beyond a step, as a share of it.
    overshoot: f64,
    /// Largest displacement of the spool, m.
    stroke: f64,
    /// Part of the travel from the middle to an edge in a period, on a ramp across the overlap that lasts as long as a swing of the spool: it
    /// leaves hardly any.
    ramp: f64,
}

impl Overlap {
    /// Of a valve that has not been opened yet.
    pub fn of(cylinder: &CylinderModel, period: f64) -> Self {
        let dynamics = &cylinder.dynamics;
        let ramp = period * dynamics.natural_frequency / core::f64::consts::PI;
        Overlap { side: 0.0, overshoot: dynamics.overshoot(), stroke: cylinder.stroke, ramp: ramp.min(2.0) }
    }

    /// Spool position (m) for an `opening`, of which the motion has `needed` a part; `spool_of` gives the one of an opening, and `begin` (m) is
    /// where the piston begins to move, retracting and extending.
    ///
    /// In motion it crosses at once for what is no less than it overshoots; at `rest`, where that would be a kick, on a ramp.
    pub fn spool(
        &mut self,
        opening: f64,
        needed: f64,
        rest: bool,
        begin: [f64; 2],
        spool_of: impl Fn(f64) -> f64,
    ) -> f64 {
        // Beyond this the spool swings after it has passed half of its overlap: less would be drowned by that.
        let half = 0.5 * (begin[0] + begin[1]);
        let least = self.overshoot * (half / (self.stroke - half));
        if least <= 0.0 {
            return spool_of(opening);
        }
        let sense = if needed == 0.0 { 0.0 } else { needed.signum() };
        if rest {
            self.side += (sense - self.side).clamp(-self.ramp, self.ramp);
        } else if sense != 0.0 && (self.side.abs() < 1.0 || needed.abs() >= least) {
            self.side = sense;
        }
        if self.side.abs() == 1.0 && opening * self.side > 0.0 {
            return spool_of(opening);
        }
        let low = spool_of(-f64::MIN_POSITIVE);
        let high = spool_of(f64::MIN_POSITIVE);
        0.5 * (low + high + self.side * (high - low))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EDGE: f64 = 1e-3;

    fn of(opening: f64) -> f64 {
        (EDGE + 0.1 * opening.abs()).copysign(opening)
    }

    fn overlap(ramp: f64) -> Overlap {
        // The least opening to cross for is 0.01.
        Overlap { side: 0.0, overshoot: 0.01, stroke: 2.0 * EDGE, ramp }
    }

    #[test]
    fn in_motion_the_spool_crosses_for_what_the_motion_needs() {
        let mut overlap = overlap(0.25);
        let mut spool = |opening, needed| overlap.spool(opening, needed, false, [EDGE; 2], of);
        assert_eq!(spool(0.02, 0.001), of(0.02));
        assert_eq!(spool(-0.02, 0.001), EDGE);
        assert_eq!(spool(-0.02, -0.009), EDGE);
        assert_eq!(spool(-0.02, -0.01), of(-0.02));
        assert_eq!(spool(0.02, -0.01), -EDGE);
    }

    #[test]
    fn at_rest_it_crosses_on_a_ramp_and_noise_does_not_send_it_across() {
        let mut overlap = overlap(0.25);
        let places: Vec<f64> =
            (0..10).map(|k| overlap.spool(1e-4, if k < 5 { 1e-4 } else { -1e-4 }, true, [EDGE; 2], of)).collect();
        let ramp = [0.25, 0.5, 0.75].map(|share| share * EDGE);
        assert_eq!(places[..3], ramp);
        assert_eq!(places[3..5], [of(1e-4); 2]);
        assert_eq!(places[5..8], [ramp[2], ramp[1], ramp[0]]);
        let noisy =
            (0..100).map(|k| overlap.spool(1e-4, if k % 2 == 0 { 1e-4 } else { -1e-4 }, true, [EDGE; 2], of).abs());
        assert!(noisy.fold(0.0, f64::max) <= 0.5 * EDGE);
    }

    #[test]
    fn a_ramp_across_leaves_less_swing_than_a_step() {
        let (omega, ratio, period) = (50.0, 0.3, 0.01);
        let beyond = |ramp: f64| {
            let (mut overlap, [mut x, mut v]) = (Overlap { side: -1.0, ..overlap(ramp) }, [-EDGE, 0.0]);
            let mut most = 0.0f64;
            for _ in 0..100 {
                let asked = overlap.spool(0.0, 1e-4, true, [EDGE; 2], of);
                for _ in 0..100 {
                    v += 0.01 * period * (omega * omega * (asked - x) - 2.0 * ratio * omega * v);
                    x += 0.01 * period * v;
                    most = most.max(x - EDGE);
                }
            }
            most
        };
        let (step, ramp) = (beyond(2.0), beyond(period * omega / core::f64::consts::PI));
        assert!(step > 0.7 * EDGE && ramp < 0.25 * step, "{step} {ramp}");
    }

    #[test]
    fn valves_without_overlap_pass_everything() {
        assert_eq!(overlap(2.0).spool(-1e-5, 1.0, true, [0.0; 2], of), of(-1e-5));
    }
}
