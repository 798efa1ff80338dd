//! Eight cranes in the lanes of one vector, in the widest instruction set that the processor has.
//!
//! The laws are those of one crane. None of them contracts or reorders arithmetic, so that all instruction sets give the
//! same bits.

use crate::crane_step::{CraneStep, Scene};
use hydrocrane_num::register::Register;
#[cfg(target_arch = "x86_64")]
use hydrocrane_num::register_x86::{Avx2, Avx512, Sse2};
use hydrocrane_num::{Field, Lanes, Real};
use hydrocrane_plant::layout::Layout;
use hydrocrane_plant::layout::MAX_JOINTS;
use hydrocrane_plant::plant::Plant;
use hydrocrane_plant::precision::Precision;
use hydrocrane_plant::rhs::Evaluator;

/// Bounds of the change of step size from one step to the next.
const SHRINK: f64 = 0.2;
const GROW: f64 = 4.0;
const SAFETY: f64 = 0.85;

/// Number of cranes of a group, that of the lanes of the widest register; narrower registers are used several times.
pub const WIDTH: usize = 8;
/// One number per crane.
pub type Group = [f64; 8];

/// Trial steps of the cranes of a group, each with its own size.
#[derive(Debug, Clone, Copy)]
pub struct Trial {
    /// Its size, s.
    pub h: Group,
    /// Spool commands, m.
    pub spools: [Group; MAX_JOINTS],
    /// At the tips, kg.
    pub payload: Group,
}

/// Result of a trial, lane by lane.
#[derive(Debug, Clone, Copy)]
pub struct StepResult {
    /// Whether the step was accepted.
    pub taken: [bool; WIDTH],
    /// Whether the error met the tolerance.
    pub exact: [bool; WIDTH],
    /// Whether every piston is inside its cylinder.
    pub inside: [bool; WIDTH],
    /// Size of the step that just meets the tolerance, in units of the tried one.
    pub growth: Group,
}

/// Criterion for accepted steps.
#[derive(Debug, Clone)]
pub struct Demand {
    pub precision: Precision,
    /// Steps up to this size (s) are accepted with a larger error,
    pub finest: f64,
    /// up to this mean square of errors relative to their tolerances; infinite where laws jump.
    pub hopeless: f64,
}

/// The laws of a machine for whole groups.
pub trait Kernel: Send + Sync {
    /// Name of the instruction set.
    fn instruction_set(&self) -> &'static str;
    /// The step kernel of one thread.
    fn step_kernel<'a>(&'a self, demand: &'a Demand) -> Box<dyn StepKernel + 'a>;
}

/// Steps groups of cranes.
pub trait StepKernel {
    /// Tries a step of each crane from the states `x`, which are replaced by the new ones if the step is accurate
    /// enough.
    fn attempt(&mut self, trial: &Trial, x: &mut [Group]) -> StepResult;
    /// The tips of a group, x and z, m.
    fn tips(&mut self, x: &[Group]) -> [Group; 2];
}

/// A crane of `N` joints in the lanes of a register.
struct LaneCrane<R, const N: usize> {
    evaluator: Evaluator<Lanes<R>, Lanes<R>, N>,
    layout: Layout,
}

struct LaneStepKernel<'a, R, const N: usize> {
    crane: &'a LaneCrane<R, N>,
    demand: &'a Demand,
    room: CraneStep<Lanes<R>>,
    x: Vec<Lanes<R>>,
    spools: [Lanes<R>; N],
}

/// Plants of which there are kernels. Each length is named, so that its kernels are compiled here and not where they are
/// asked for.
pub trait InLanes {
    /// The machine for groups, in the widest instruction set of this processor or in the narrower one `wanted`.
    fn in_lanes(&self, layout: &Layout, wanted: Option<&str>) -> Box<dyn Kernel>;
}

macro_rules! sized {
    ($($joints:literal),*) => {
        $(impl InLanes for Plant<f64, $joints> {
            fn in_lanes(&self, layout: &Layout, wanted: Option<&str>) -> Box<dyn Kernel> {
                kernel(self, layout, wanted)
            }
        })*
    };
}

sized!(1, 2, 3, 4, 5, 6);

/// Whether chains of this length have kernels in the wide registers. Development builds have them for three joints only, those
/// of the tests that compare instruction sets: all of them would be a quarter of what the tests compile.
#[cfg(target_arch = "x86_64")]
const fn has_wide(joints: usize) -> bool {
    !cfg!(debug_assertions) || joints == 3
}

#[cfg(target_arch = "x86_64")]
fn kernel<const N: usize>(plant: &Plant<f64, N>, layout: &Layout, wanted: Option<&str>) -> Box<dyn Kernel> {
    fn fits<R: Register>(wanted: Option<&str>) -> bool {
        R::is_available() && wanted.is_none_or(|name| name == R::NAME)
    }
    if const { has_wide(N) } {
        if fits::<Avx512>(wanted) {
            return Box::new(LaneCrane::<Avx512, N>::new(plant, layout));
        }
        if fits::<Avx2>(wanted) {
            return Box::new(LaneCrane::<Avx2, N>::new(plant, layout));
        }
    }
    Box::new(LaneCrane::<Sse2, N>::new(plant, layout))
}

#[cfg(not(target_arch = "x86_64"))]
fn kernel<const N: usize>(plant: &Plant<f64, N>, layout: &Layout, _wanted: Option<&str>) -> Box<dyn Kernel> {
    Box::new(LaneCrane::<f64, N>::new(plant, layout))
}

impl<R: Register, const N: usize> LaneCrane<R, N> {
    fn new(plant: &Plant<f64, N>, layout: &Layout) -> Self {
        let plant = plant.map(&mut Lanes::c);
        LaneCrane { evaluator: Evaluator::new(&plant, layout), layout: layout.clone() }
    }
}

impl<R: Register, const N: usize> Kernel for LaneCrane<R, N> {
    fn instruction_set(&self) -> &'static str {
        R::NAME
    }

    fn step_kernel<'a>(&'a self, demand: &'a Demand) -> Box<dyn StepKernel + 'a> {
        Box::new(LaneStepKernel {
            crane: self,
            demand,
            room: CraneStep::new(&self.layout),
            x: vec![Lanes::default(); self.layout.len()],
            spools: [Lanes::default(); N],
        })
    }
}

impl<R: Register, const N: usize> StepKernel for LaneStepKernel<'_, R, N> {
    fn attempt(&mut self, trial: &Trial, x: &mut [Group]) -> StepResult {
        R::run(
            #[inline(always)]
            || self.attempt_here(trial, x),
        )
    }

    fn tips(&mut self, x: &[Group]) -> [Group; 2] {
        R::run(
            #[inline(always)]
            || self.tips_here(x),
        )
    }
}

impl<R: Register, const N: usize> LaneStepKernel<'_, R, N> {
    #[inline(always)]
    fn attempt_here(&mut self, trial: &Trial, x: &mut [Group]) -> StepResult {
        let LaneStepKernel { crane, demand, room, x: states, spools } = self;
        let LaneCrane { evaluator, layout } = crane;
        let [mut taken, mut exact, mut inside, mut growth] = [[0.0; WIDTH]; 4];
        for first in (0..WIDTH).step_by(R::WIDTH) {
            for i in 0..states.len() {
                states[i] = Lanes::load(&x[i][first..]);
            }
            for c in 0..N {
                spools[c] = Lanes::load(&trial.spools[c][first..]);
            }
            let (h, payload) = (Lanes::<R>::load(&trial.h[first..]), Lanes::load(&trial.payload[first..]));
            let scene = Scene { evaluator, layout, spools: &*spools, payload };
            let error = room.attempt(&scene, h, states, &demand.precision);
            let stays = stays(&evaluator.plant, room.reached());
            let met = error.le(Lanes::c(1.0));
            let good = met | (h.le(Lanes::c(demand.finest)) & error.le(Lanes::c(demand.hopeless)) & error.finite());
            for i in 0..states.len() {
                Lanes::select(good & stays, room.reached()[i], states[i]).store(&mut x[i][first..]);
            }
            let as_number = |mask| Lanes::<R>::select(mask, Lanes::c(1.0), Lanes::c(0.0));
            as_number(good & stays).store(&mut taken[first..]);
            as_number(met).store(&mut exact[first..]);
            as_number(stays).store(&mut inside[first..]);
            suggested(error).store(&mut growth[first..]);
        }
        let [taken, exact, inside] = [taken, exact, inside].map(|flags| flags.map(|flag| flag == 1.0));
        StepResult { taken, exact, inside, growth }
    }

    #[inline(always)]
    fn tips_here(&self, x: &[Group]) -> [Group; 2] {
        let mut tips = [[0.0; WIDTH]; 2];
        for first in (0..WIDTH).step_by(R::WIDTH) {
            let mechanics = &self.crane.evaluator.plant.mechanics;
            let q: [Lanes<R>; N] = hydrocrane_num::array::from_fn(|i| Lanes::load(&x[i][first..]));
            let tip = mechanics.tip_position(&mechanics.pose(&q));
            tip.x.store(&mut tips[0][first..]);
            tip.z.store(&mut tips[1][first..]);
        }
        tips
    }
}

/// Change of step size that a mean square of errors suggests for a method whose error grows with the fourth power.
#[inline(always)]
fn suggested<R: Register>(error: Lanes<R>) -> Lanes<R> {
    let growth = (error.ln() * (-1.0 / 8.0)).exp() * SAFETY;
    // NaN if the error is NaN; then both comparisons are false.
    let low = Lanes::select(Lanes::c(SHRINK).lt(growth), growth, Lanes::c(SHRINK));
    Lanes::select(error.lt(Lanes::c(1e-12)), Lanes::c(GROW), low.min(Lanes::c(GROW)))
}

/// Whether every piston is inside its cylinder in the state `x`.
#[inline(always)]
fn stays<R: Register, const N: usize>(plant: &Plant<Lanes<R>, N>, x: &[Lanes<R>]) -> R::Mask {
    let q: [Lanes<R>; N] = hydrocrane_num::array::from_fn(|i| x[i]);
    plant.admissible(&plant.mechanics.pose(&q))
}
