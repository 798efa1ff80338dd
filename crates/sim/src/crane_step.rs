//! One step of a whole crane and how exact it is, over any number type: f64, or the lanes of a batch.

use hydrocrane_num::Real;
use hydrocrane_ode::grk4t::{end, error, GAMMA, STAGES, TABLEAU};
use hydrocrane_ode::rosenbrock::{stages, Linearised};
use hydrocrane_ode::rows::{all, Cell};
use hydrocrane_ode::BlockArrow;
use hydrocrane_ode::SchurFactors;
use hydrocrane_ode::FLUSH;
use hydrocrane_plant::layout::Layout;
use hydrocrane_plant::precision::Precision;
use hydrocrane_plant::rhs::Evaluator;

/// The laws of a crane and what drives it during a step.
pub struct Scene<'a, T, const N: usize> {
    pub evaluator: &'a Evaluator<T, T, N>,
    pub layout: &'a Layout,
    /// Spool commands, m, constant over the step.
    pub spools: &'a [T],
    /// At the tip, kg.
    pub payload: T,
}

/// Room for steps by GRK4T: without allocation, and the same work for every step.
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

    /// Tries a step of size `h` (s) from `x`; the new state is then in [`Self::reached`]. Gives the mean square of the
    /// estimated errors relative to their tolerances, which is not finite where a number of the new state is not.
    #[inline(always)]
    pub fn attempt<const N: usize>(&mut self, scene: &Scene<T, N>, h: T, x: &[T], precision: &Precision) -> T {
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
            reached,
            #[inline(always)]
            |i| error(&k, i),
        )
    }

    /// Where the last attempt led.
    #[inline(always)]
    pub fn reached(&self) -> &[T] {
        &self.reached
    }
}

/// The crane where a step starts.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::RunOptions;
    use crate::{EquilibriumMode, Model, Simulator, StateSpace};
    use hydrocrane_machine::{load, OverrideValue};
    use hydrocrane_num::Lanes;
    use hydrocrane_ode::{StepControl, Tolerances};
    use hydrocrane_plant::Crane;
    use std::sync::Arc;

    const SPOOLS: [f64; 3] = [0.02, 0.006, -0.01];

    /// The laboratory crane, its pistons with bristles or with the static map.
    fn crane(friction: &str) -> Crane<3> {
        let keys = ["lift", "jib", "extension"].map(|cylinder| format!("friction.{cylinder}.model"));
        let changes = keys.map(|key| (key, OverrideValue::Text(friction.to_string())));
        Crane::new(&load("rottne-f9-lab", &changes).expect("a valid machine")).expect("it can be built")
    }

    fn start(crane: &Crane<3>) -> Vec<f64> {
        let pose = [100f64.to_radians(), 100f64.to_radians(), 0.0];
        crane.equilibrium(&pose, EquilibriumMode::Hold, 0.0).expect("a pose inside the limits")
    }

    /// The state after `duration` (s) in equal steps.
    fn after<T: Real + Cell<Factor = T>>(crane: &Crane<3>, duration: f64, steps: usize) -> Vec<T> {
        let plant = crane.plant().map(&mut T::c);
        let layout = crane.layout();
        let evaluator = Evaluator::new(&plant, layout);
        let (spools, payload) = (SPOOLS.map(T::c), T::c(0.0));
        let scene = Scene { evaluator: &evaluator, layout, spools: &spools, payload };
        let mut x: Vec<T> = start(crane).into_iter().map(T::c).collect();
        let (mut stepping, precision) = (CraneStep::new(layout), Precision::new(layout, 1.0));
        for _ in 0..steps {
            stepping.attempt(&scene, T::c(duration / steps as f64), &x, &precision);
            x.copy_from_slice(stepping.reached());
        }
        x
    }

    #[test]
    fn a_lane_of_a_batch_takes_the_steps_of_one_crane_to_the_last_bit() {
        for friction in ["lugre", "static"] {
            let crane = crane(friction);
            let (alone, batch) = (after::<f64>(&crane, 0.25, 100), after::<Lanes<f64>>(&crane, 0.25, 100));
            for (alone, lanes) in alone.iter().zip(batch) {
                let mut numbers = [0.0; 1];
                lanes.store(&mut numbers);
                assert_eq!(numbers, [*alone], "{friction}");
            }
        }
    }

    /// Largest difference of two states, in units of the scales.
    fn difference(layout: &Layout, a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).zip(&layout.scales).map(|((a, b), scale)| ((a - b) / scale).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn steps_are_of_order_four_on_the_crane() {
        let crane = crane("lugre");
        let layout = crane.layout().clone();
        let exact = exact(&crane, 0.1);
        let error = |steps| difference(&layout, &after::<f64>(&crane, 0.1, steps), &exact);
        let (coarse, fine) = (error(200), error(400));
        assert!(coarse < 1e-3 && (10.0..24.0).contains(&(coarse / fine)), "{coarse} {fine}");
    }

    /// The state after `duration` by the adaptive method.
    fn exact(crane: &Crane<3>, duration: f64) -> Vec<f64> {
        let options = RunOptions {
            method: "rodas5p".to_string(),
            tolerances: Tolerances { relative: 1e-11, absolute: 1e-11, max_step: 1e-3 },
            control: StepControl::Adaptive,
            payload: 0.0,
            payload_changes: Vec::new(),
            ledger: false,
            max_steps: u64::MAX,
        };
        let start = start(crane);
        let crane: Arc<dyn Model> = Arc::new(self::crane("lugre"));
        let mut simulator = Simulator::new(crane, duration, options);
        simulator.reset(&start).expect("a good start");
        simulator.step(&SPOOLS);
        simulator.state().expect("a state").to_vec()
    }

    #[test]
    fn the_estimate_tells_by_how_much_a_step_errs_and_that_it_leads_nowhere() {
        let crane = crane("lugre");
        let layout = crane.layout();
        let evaluator = Evaluator::new(crane.plant(), layout);
        let scene = Scene { evaluator: &evaluator, layout, spools: &SPOOLS, payload: 0.0 };
        let (mut stepping, precision) = (CraneStep::new(layout), Precision::new(layout, 1e-3));
        let moving = after::<f64>(&crane, 0.2, 200);
        let mut estimate = |h: f64, x: &[f64]| stepping.attempt(&scene, h, x, &precision).sqrt();
        // The estimate's own order is three: its error grows with the fourth power of the step.
        let (one, two) = (estimate(1e-3, &moving), estimate(2e-3, &moving));
        assert!(one > 0.0 && (10.0..24.0).contains(&(two / one)), "{one} {two}");
        let mut wild = moving.clone();
        wild[layout.qd(0)] = 1e200;
        assert!(!estimate(1e-3, &wild).is_finite());
    }
}
