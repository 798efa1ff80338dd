//! One fixed step of a whole crane, over any number type: f64, or the lanes of a batch.

use crate::bordered::Bordered;
use crate::elimination::Elimination;
use crate::integrator::rodas3::{self, GAMMA, STAGES};
use crate::integrator::ros3p::Linearised;
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

/// Which steps are good enough.
#[derive(Debug, Clone)]
pub struct Demand {
    /// Inverse tolerances of the states.
    pub weights: Vec<f64>,
    /// Inverse tolerance of the oil's relative density.
    pub dilation: f64,
    /// Steps no longer than this are taken with whatever error, s.
    pub finest: f64,
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
            slopes: Bordered { secants: true, ..Bordered::new(layout, 0) },
            elimination: Elimination::default(),
        }
    }

    /// Tries a step of size `h` (s) from `x`; the new state is then in [`Self::reached`]. Gives the mean square of the
    /// error estimate, each state's in units of its tolerance: `weights` are the inverse tolerances.
    #[inline(always)]
    pub fn attempt<const N: usize>(&mut self, scene: &Scene<T, N>, h: T, x: &[T], demand: &Demand) -> T {
        let Scene { evaluator, layout, spools, payload } = *scene;
        let CraneStep { k, argument, slopes, elimination } = self;
        T::apart(
            #[inline(always)]
            || evaluator.linearise(layout, x, spools, payload, None, &mut k[0], slopes, |_, _, _| {}),
        );
        T::apart(
            #[inline(always)]
            || elimination.factor_sized::<N>(slopes, T::c(1.0 / GAMMA) / h),
        );
        rodas3::step(&mut Here { scene, slopes, elimination }, h, x, k, argument);
        let mut sum = T::c(0.0);
        for ((error, weight), reached) in k[STAGES - 1].iter().zip(&demand.weights).zip(&mut *argument) {
            sum += (*error * *weight).square();
            *reached = T::select(reached.abs().lt(T::c(FLUSH)), T::c(0.0), *reached);
        }
        for c in 0..N {
            for i in [layout.p1(c), layout.p2(c)] {
                let dilation = k[STAGES - 1][i] / evaluator.plant.fluid.bulk_modulus(argument[i]);
                sum += (dilation * demand.dilation).square();
            }
        }
        sum / layout.len() as f64
    }

    /// Where the last attempt led.
    #[inline(always)]
    pub fn reached(&self) -> &[T] {
        &self.argument
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
        T::apart(
            #[inline(always)]
            || evaluator.derivative(layout, x, spools, payload, rate, |_, _, _| {}),
        );
    }

    #[inline(always)]
    fn solve(&self, r: &mut [T]) {
        T::apart(
            #[inline(always)]
            || self.elimination.solve_sized::<N>(self.slopes, r),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crane::Crane;
    use crate::integrator::Tolerances;
    use crate::run::RunOptions;
    use crate::{EquilibriumMode, Model, Simulator};
    use hydrocrane_machine::{load, OverrideValue};
    use hydrocrane_num::Lanes;
    use std::sync::Arc;

    const STEP: f64 = 2.5e-3;
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

    fn after<T: Real>(crane: &Crane<3>, steps: usize) -> Vec<T> {
        let plant = crane.plant().map(&mut T::c);
        let layout = crane.layout();
        let evaluator = Evaluator::new(&plant, layout);
        let (spools, payload) = (SPOOLS.map(T::c), T::c(0.0));
        let scene = Scene { evaluator: &evaluator, layout, spools: &spools, payload };
        let mut x: Vec<T> = start(crane).into_iter().map(T::c).collect();
        let mut stepping = CraneStep::new(layout);
        for _ in 0..steps {
            stepping.attempt(&scene, T::c(STEP), &x, &Demand { weights: layout.scales.clone(), dilation: 0.0, finest: 0.0 });
            x.copy_from_slice(stepping.reached());
        }
        x
    }

    #[test]
    fn a_lane_of_a_batch_takes_the_steps_of_one_crane_to_the_last_bit() {
        for friction in ["lugre", "static"] {
            let crane = crane(friction);
            let (alone, batch) = (after::<f64>(&crane, 100), after::<Lanes<f64>>(&crane, 100));
            for (alone, lanes) in alone.iter().zip(batch) {
                let mut numbers = [0.0; 1];
                lanes.store(&mut numbers);
                assert_eq!(numbers, [*alone], "{friction}");
            }
        }
    }

    #[test]
    fn takes_the_steps_of_the_method_for_any_system() {
        for friction in ["lugre", "static"] {
            let own = after::<f64>(&crane(friction), 200);
            let tolerances = Tolerances { relative: 1e-4, absolute: 1e-4, max_step: STEP };
            let options = RunOptions {
                method: "ros3p".to_string(),
                tolerances,
                payload: 0.0,
                payload_changes: Vec::new(),
                ledger: false,
                max_steps: 1000,
            };
            let crane = Arc::new(crane(friction));
            let mut simulator = Simulator::new(crane.clone(), 200.0 * STEP, options);
            simulator.reset(&start(&crane)).expect("a good start");
            simulator.step(&SPOOLS);
            let state = simulator.state().expect("a state");
            for ((a, b), scale) in own.iter().zip(state).zip(&crane.layout().scales) {
                assert!((a - b).abs() < 1e-9 * scale, "{friction}: {a} {b}");
            }
        }
    }
}
