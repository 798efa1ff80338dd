//! One step of a whole crane with its error estimate, over any number type: f64, or the lanes of a batch.

use hydrocrane_num::Real;
use hydrocrane_ode::linear::rows::{all, Cell};
use hydrocrane_ode::methods::grk4t::{end, error, GAMMA, STAGES, TABLEAU};
use hydrocrane_ode::methods::rosenbrock::{stages, Linearised};
use hydrocrane_ode::BlockArrow;
use hydrocrane_ode::SchurFactors;
use hydrocrane_ode::FLUSH;
use hydrocrane_plant::equations::rhs::Evaluator;
use hydrocrane_plant::layout::Layout;
use hydrocrane_plant::precision::Precision;

/// The laws of a crane and its inputs during a step.
pub struct Scene<'a, T, const N: usize> {
    pub evaluator: &'a Evaluator<T, T, N>,
    pub layout: &'a Layout,
    /// Spool commands, m, constant over the step.
    pub spools: &'a [T],
    /// At the tip, kg.
    pub payload: T,
}

/// Work space for steps by GRK4T: no allocation, constant work per step.
#[derive(Debug, Clone)]
pub struct CraneStep<T> {
    /// Increments, stage by stage.
    k: Vec<T>,
    reached: Vec<T>,
    jacobian: BlockArrow<T>,
    schur: SchurFactors<T>,
}

impl<T: Real + Cell<Factor = T>> CraneStep<T> {
    pub fn new(layout: &Layout) -> Self {
        let room = vec![T::c(0.0); layout.len()];
        CraneStep {
            k: vec![T::c(0.0); STAGES * layout.len()],
            reached: room,
            jacobian: BlockArrow { secants: true, ..BlockArrow::new(layout.blocks()) },
            schur: SchurFactors::default(),
        }
    }

    /// Tries a step of size `h` (s) from `x`; the new state is then in [`Self::reached`]. Returns the mean square of
    /// the estimated errors relative to their tolerances, which is not finite if a number of the new state is not.
    #[inline(always)]
    pub fn attempt<const N: usize>(&mut self, scene: &Scene<T, N>, h: T, x: &[T], precision: &Precision<T>) -> T {
        let Scene { evaluator, layout, spools, payload } = *scene;
        let CraneStep { k, reached, jacobian, schur } = self;
        T::outlined(
            #[inline(always)]
            || evaluator.linearise(layout, x, spools, payload, &mut k[..x.len()], jacobian),
        );
        T::outlined(
            #[inline(always)]
            || schur.factor_sized::<N, _>(jacobian, T::c(1.0 / GAMMA) / h),
        );
        stages(&TABLEAU, &mut Here { scene, jacobian, schur }, T::c(1.0) / h, x, k, reached);
        let k = all(k, x.len());
        for (i, reached) in reached.iter_mut().enumerate() {
            let new = end(x[i], &k, i);
            *reached = T::select(new.abs().lt(T::c(FLUSH)), T::c(0.0), new);
        }
        let fluid = &evaluator.plant.fluid;
        precision.mean_square(
            fluid,
            layout,
            x,
            reached,
            #[inline(always)]
            |i| error(&k, i),
        )
    }

    /// The state after the last attempt.
    #[inline(always)]
    pub fn reached(&self) -> &[T] {
        &self.reached
    }
}

/// The crane at the start of a step.
struct Here<'a, T, const N: usize> {
    scene: &'a Scene<'a, T, N>,
    jacobian: &'a BlockArrow<T>,
    schur: &'a SchurFactors<T>,
}

impl<T: Real, const N: usize> Linearised<T> for Here<'_, T, N> {
    #[inline(always)]
    fn rate(&mut self, _stage: usize, x: &[T], rate: &mut [T]) {
        let Scene { evaluator, layout, spools, payload, .. } = *self.scene;
        T::outlined(
            #[inline(always)]
            || evaluator.derivative(layout, x, spools, payload, rate),
        );
    }

    #[inline(always)]
    fn solve(&self, r: &mut [T]) {
        T::outlined(
            #[inline(always)]
            || self.schur.solve_sized::<N, _>(self.jacobian, r),
        );
    }
}
