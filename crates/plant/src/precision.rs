//! Required accuracy of a step: errors relative to the scales of the states and to the density of the oil.

use crate::layout::Layout;
use hydrocrane_num::Real;
use hydrocrane_physics::hydraulics::fluid::Fluid;

/// Required accuracy of a step.
#[derive(Debug, Clone)]
pub struct Precision<T = f64> {
    /// Inverse tolerances of the states.
    pub weights: Vec<T>,
    /// Inverse tolerance of the relative density of the oil in the chambers.
    density: f64,
}

/// Relative density of the oil that counts as much as a state's scale.
const DENSITY_SCALE: f64 = 1e-3;
/// Time of a fast full stroke of a piston, s: what a spool that is wrong for its own time constant lets in, as a share of
/// the oil in a chamber, is its error times this constant over this time.
const STROKE_TIME: f64 = 1.0;

/// Modulus of the softer end of a step, Pa.
#[inline(always)]
fn softer<T: Real>(fluid: &Fluid<T>, from: T, to: T) -> T {
    fluid.bulk_modulus(from).min(fluid.bulk_modulus(to))
}

/// Share of its stiffness without pressure that the oil has at the softer end of a step, at most one. Where free gas
/// makes oil soft, a small error of its pressure is a large one of its volume, and of the time at which it is stiff again.
#[inline(always)]
pub fn stiffness<T: Real>(fluid: &Fluid<T>, from: T, to: T) -> T {
    (softer(fluid, from, to) / fluid.bulk_modulus(T::c(0.0))).min(T::c(1.0))
}

impl Precision {
    /// Errors up to `tolerance` times the scales of the states. A spool counts by the oil that its error lets in before it
    /// has faded, which no other state shows within the step.
    pub fn new(layout: &Layout, tolerance: f64) -> Self {
        let mut weights: Vec<f64> = layout.scales.iter().map(|scale| 1.0 / (tolerance * scale)).collect();
        for c in 0..layout.joints() {
            let (xs, vs) = (layout.xs(c), layout.vs(c));
            let fades = layout.scales[xs] / layout.scales[vs];
            weights[xs] *= fades / (STROKE_TIME * DENSITY_SCALE);
            weights[vs] = 0.0;
        }
        Precision { weights, density: 1.0 / (tolerance * DENSITY_SCALE) }
    }

    /// The same in another number type.
    pub fn lift<T: Real>(&self) -> Precision<T> {
        Precision { weights: self.weights.iter().map(|weight| T::c(*weight)).collect(), density: self.density }
    }
}

impl<T: Real> Precision<T> {
    /// Sum over the cylinders of the mean squares of the errors of a step `from` one state `to` another, relative to their tolerances.
    #[inline(always)]
    pub fn mean_square(
        &self,
        fluid: &Fluid<T>,
        layout: &Layout,
        from: &[T],
        to: &[T],
        error: impl Fn(usize) -> T,
    ) -> T {
        let mut sum = T::c(0.0);
        for (i, weight) in self.weights.iter().enumerate() {
            sum += (error(i) * *weight).square();
        }
        for c in 0..layout.joints() {
            for i in [layout.p1(c), layout.p2(c)] {
                let density = error(i) / softer(fluid, from[i], to[i]);
                sum += (density * self.density).square();
            }
        }
        sum * (layout.joints() as f64 / layout.len() as f64)
    }
}
