//! One fixed step of a whole crane, over any number type: f64, or the lanes of a batch.

use crate::bordered::Bordered;
use crate::elimination::Elimination;
use crate::integrator::ros3p::{end, stages, Linearised, GAMMA, STAGES};
use crate::integrator::FLUSH;
use crate::layout::Layout;
use crate::rhs::Evaluator;
use hydrocrane_num::Real;

/// The laws of a crane and what drives it during a step.
pub struct Scene<'a, T, const N: usize> {
    pub evaluator: &'a Evaluator<T, T, N>,
    pub layout: &'a Layout,
    /// Spool commands, m, constant over the step.
    pub spools: &'a [T],
    /// At the tip, kg.
    pub payload: T,
}

/// Room for steps by ROS3P: without allocation, and the same work for every step.
#[derive(Debug, Clone)]
pub struct CraneStep<T> {
    k: [Vec<T>; STAGES],
    argument: Vec<T>,
    slopes: Bordered<T>,
    elimination: Elimination<T>,
}

impl<T: Real> CraneStep<T> {
    pub fn new(layout: &Layout) -> Self {
        let room = vec![T::c(0.0); layout.len()];
        CraneStep {
            k: std::array::from_fn(|_| room.clone()),
            argument: room,
            slopes: Bordered::new(layout, 0),
            elimination: Elimination::default(),
        }
    }

    /// Moves `x` on by `h` (s). The mask tells where every number came out finite; the others are not to be used.
    #[inline(always)]
    pub fn step<const N: usize>(&mut self, scene: &Scene<T, N>, h: T, x: &mut [T]) -> T::Mask {
        let Scene { evaluator, layout, spools, payload } = *scene;
        let CraneStep { k, argument, slopes, elimination } = self;
        evaluator.linearise(layout, x, spools, payload, None, &mut k[0], slopes, |_, _, _| {});
        elimination.factor_sized::<N>(slopes, T::c(1.0 / GAMMA) / h);
        stages(&mut Here { scene, slopes, elimination }, h, x, None, k, argument);
        let mut size = T::c(0.0);
        for (i, x) in x.iter_mut().enumerate() {
            let new = end(*x, k, i);
            size += new.abs();
            *x = T::select(new.abs().lt(T::c(FLUSH)), T::c(0.0), new);
        }
        size.finite()
    }
}

/// The crane where a step starts.
struct Here<'a, T, const N: usize> {
    scene: &'a Scene<'a, T, N>,
    slopes: &'a Bordered<T>,
    elimination: &'a Elimination<T>,
}

impl<T: Real, const N: usize> Linearised<T> for Here<'_, T, N> {
    #[inline(always)]
    fn rate_at_end(&mut self, x: &[T], rate: &mut [T]) {
        let Scene { evaluator, layout, spools, payload, .. } = *self.scene;
        evaluator.derivative(layout, x, spools, payload, rate, |_, _, _| {});
    }

    #[inline(always)]
    fn solve(&self, r: &mut [T]) {
        self.elimination.solve_sized::<N>(self.slopes, r);
    }
}
