//! Eight cranes in the lanes of one vector, in the widest instruction set that the processor has.
//!
//! The laws are those of one crane. None of them contracts or reorders arithmetic, so that all instruction sets give the
//! same bits.

use crate::crane_step::{CraneStep, Scene};
use crate::own_numbers::{Bank, Group, Needed, Places, WIDTH};
use hydrocrane_num::lanes::register::Register;
#[cfg(target_arch = "x86_64")]
use hydrocrane_num::lanes::register_x86::{Avx2, Avx512, Sse2};
use hydrocrane_num::{Field, Lanes, Real};
use hydrocrane_plant::equations::plant::Plant;
use hydrocrane_plant::layout::Layout;
use hydrocrane_plant::layout::MAX_JOINTS;
use hydrocrane_plant::precision::Precision;

/// Bounds of the change of step size from one step to the next.
const SHRINK: f64 = 0.2;
const GROW: f64 = 4.0;
const SAFETY: f64 = 0.85;

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

/// Steps groups of cranes of one machine, in one thread.
pub trait StepKernel: Send {
    /// Name of the instruction set.
    fn instruction_set(&self) -> &'static str;
    /// Number of lanes, at most [`WIDTH`].
    fn lanes(&self) -> usize;
    /// Gives a lane to the crane at `place` of a group with these values of its own numbers.
    fn load(&mut self, lane: usize, own: &[Group], place: usize);
    /// Gives all lanes to the cranes of a group from `first` on; what is `needed` of their own numbers.
    fn load_all(&mut self, own: &[Group], first: usize, needed: Needed);
    /// Tries a step of each crane from the states `x`, which are replaced by the new ones if the step is accurate
    /// enough.
    fn attempt(&mut self, trial: &Trial, x: &mut [Group]) -> StepResult;
    /// Writes the tips, x, y and z (m), of the cranes of the group `x` from `first` on, one per lane.
    fn tips(&mut self, x: &[Group], first: usize, tips: &mut [Group; 3]);
}

/// Cranes of `N` joints in the lanes of a register.
struct LaneStepKernel<R, const N: usize> {
    bank: Bank<R, N>,
    /// Where the own numbers stand in it.
    places: Places,
    layout: Layout,
    demand: Demand,
    room: CraneStep<Lanes<R>>,
    x: Vec<Lanes<R>>,
    spools: [Lanes<R>; N],
}

/// Plants of which there are kernels. Each length is named, so that its kernels are compiled here and not where they are
/// asked for.
pub trait InLanes {
    /// The machine for groups, in the widest instruction set of this processor or in the narrower one `wanted`. `own`: in which of
    /// its numbers cranes may differ, counted by [`Plant::numbers`] and on by the weights of the demanded precision.
    fn in_lanes(&self, layout: &Layout, demand: &Demand, own: &[usize], wanted: Option<&str>) -> Box<dyn StepKernel>;
}

macro_rules! sized {
    ($($joints:literal),*) => {
        $(impl InLanes for Plant<f64, $joints> {
            fn in_lanes(&self, layout: &Layout, demand: &Demand, own: &[usize], wanted: Option<&str>) -> Box<dyn StepKernel> {
                kernel(self, layout, demand, own, wanted)
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
fn kernel<const N: usize>(
    plant: &Plant<f64, N>,
    layout: &Layout,
    demand: &Demand,
    own: &[usize],
    wanted: Option<&str>,
) -> Box<dyn StepKernel> {
    fn fits<R: Register>(wanted: Option<&str>) -> bool {
        R::is_available() && wanted.is_none_or(|name| name == R::NAME)
    }
    if const { has_wide(N) } {
        if fits::<Avx512>(wanted) {
            return Box::new(LaneStepKernel::<Avx512, N>::new(plant, layout, demand, own));
        }
        if fits::<Avx2>(wanted) {
            return Box::new(LaneStepKernel::<Avx2, N>::new(plant, layout, demand, own));
        }
    }
    Box::new(LaneStepKernel::<Sse2, N>::new(plant, layout, demand, own))
}

#[cfg(not(target_arch = "x86_64"))]
fn kernel<const N: usize>(
    plant: &Plant<f64, N>,
    layout: &Layout,
    demand: &Demand,
    own: &[usize],
    _wanted: Option<&str>,
) -> Box<dyn StepKernel> {
    Box::new(LaneStepKernel::<f64, N>::new(plant, layout, demand, own))
}

impl<R: Register, const N: usize> LaneStepKernel<R, N> {
    fn new(plant: &Plant<f64, N>, layout: &Layout, demand: &Demand, own: &[usize]) -> Self {
        let bank = Bank::new(plant, layout, &demand.precision);
        LaneStepKernel {
            places: Places::new(plant, layout, &bank, own),
            bank,
            layout: layout.clone(),
            demand: demand.clone(),
            room: CraneStep::new(layout),
            x: vec![Lanes::default(); layout.len()],
            spools: [Lanes::default(); N],
        }
    }
}

impl<R: Register, const N: usize> StepKernel for LaneStepKernel<R, N> {
    fn instruction_set(&self) -> &'static str {
        R::NAME
    }

    fn lanes(&self) -> usize {
        R::WIDTH
    }

    fn load(&mut self, lane: usize, own: &[Group], place: usize) {
        self.bank.put(&self.places, Needed::All, own, place, [lane, 1]);
    }

    fn load_all(&mut self, own: &[Group], first: usize, needed: Needed) {
        R::run(
            #[inline(always)]
            || self.bank.put(&self.places, needed, own, first, [0, R::WIDTH]),
        );
    }

    fn attempt(&mut self, trial: &Trial, x: &mut [Group]) -> StepResult {
        R::run(
            #[inline(always)]
            || self.attempt_here(trial, x),
        )
    }

    fn tips(&mut self, x: &[Group], first: usize, tips: &mut [Group; 3]) {
        R::run(
            #[inline(always)]
            || self.tips_here(x, first, tips),
        );
    }
}

impl<R: Register, const N: usize> LaneStepKernel<R, N> {
    #[inline(always)]
    fn attempt_here(&mut self, trial: &Trial, x: &mut [Group]) -> StepResult {
        let LaneStepKernel { bank: Bank { evaluator, precision }, layout, demand, room, x: states, spools, .. } = self;
        for i in 0..states.len() {
            states[i] = Lanes::load(&x[i]);
        }
        for c in 0..N {
            spools[c] = Lanes::load(&trial.spools[c]);
        }
        let (h, payload) = (Lanes::<R>::load(&trial.h), Lanes::load(&trial.payload));
        let scene = Scene { evaluator, layout, spools: &*spools, payload };
        let error = room.attempt(&scene, h, states, precision);
        let stays = stays(&evaluator.plant, room.reached());
        let met = error.le(Lanes::c(1.0));
        let good = met | (h.le(Lanes::c(demand.finest)) & error.le(Lanes::c(demand.hopeless)) & error.finite());
        for i in 0..states.len() {
            Lanes::select(good & stays, room.reached()[i], states[i]).store(&mut x[i]);
        }
        let numbers = |number: Lanes<R>| {
            let mut numbers = [0.0; WIDTH];
            number.store(&mut numbers);
            numbers
        };
        let flags = |mask| numbers(Lanes::select(mask, Lanes::c(1.0), Lanes::c(0.0))).map(|flag| flag == 1.0);
        let growth = numbers(suggested(error));
        StepResult { taken: flags(good & stays), exact: flags(met), inside: flags(stays), growth }
    }

    #[inline(always)]
    fn tips_here(&mut self, x: &[Group], first: usize, tips: &mut [Group; 3]) {
        let plant = &self.bank.evaluator.plant;
        let q: [Lanes<R>; N] = hydrocrane_num::array::from_fn(|i| Lanes::load(&x[i][first..]));
        let tip = plant.tip_position(&plant.mechanics.pose(&q));
        tip.x.store(&mut tips[0][first..]);
        tip.y.store(&mut tips[1][first..]);
        tip.z.store(&mut tips[2][first..]);
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
