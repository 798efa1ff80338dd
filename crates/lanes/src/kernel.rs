//! Eight cranes in the lanes of one vector, in the widest instruction set that the processor has.
//!
//! The laws are those of one crane. None of them contracts or reorders arithmetic, so that all instruction sets give the
//! same bits.

use crate::crane_step::{CraneStep, Scene};
use crate::own_numbers::{Bank, Needed, Places};
use hydrocrane_num::register::Register;
#[cfg(target_arch = "x86_64")]
use hydrocrane_num::register_x86::{Avx2, Avx512, Sse2};
use hydrocrane_num::{Field, Lanes, Real};
use hydrocrane_plant::layout::Layout;
use hydrocrane_plant::layout::MAX_JOINTS;
use hydrocrane_plant::plant::Plant;
use hydrocrane_plant::precision::Precision;

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

/// Steps groups of cranes of one machine, in one thread.
pub trait StepKernel: Send {
    /// Name of the instruction set.
    fn instruction_set(&self) -> &'static str;
    /// Gives a lane to a crane with these values of its own numbers.
    fn load(&mut self, lane: usize, own: &[f64]);
    /// Tries a step of each crane from the states `x`, which are replaced by the new ones if the step is accurate
    /// enough.
    fn attempt(&mut self, trial: &Trial, x: &mut [Group]) -> StepResult;
    /// The tips of a group, x and z, m.
    fn tips(&mut self, x: &[Group]) -> [Group; 2];
}

/// Cranes of `N` joints in the lanes of a register.
struct LaneStepKernel<R, const N: usize> {
    /// One for all lanes if cranes have no numbers of their own, else one for each register of a group.
    banks: Vec<Bank<R, N>>,
    places: Places,
    /// The own numbers of the cranes in the lanes.
    own: Vec<Group>,
    /// Whether they are other ones than in the bank of a register.
    stale: [bool; WIDTH],
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
        let numbers = [plant.numbers(), demand.precision.weights.clone()].concat();
        LaneStepKernel {
            places: Places::new(plant, layout, &bank, own),
            banks: vec![bank; if own.is_empty() { 1 } else { WIDTH / R::WIDTH }],
            own: own.iter().map(|i| [numbers[*i]; WIDTH]).collect(),
            stale: [false; WIDTH],
            layout: layout.clone(),
            demand: demand.clone(),
            room: CraneStep::new(layout),
            x: vec![Lanes::default(); layout.len()],
            spools: [Lanes::default(); N],
        }
    }

    /// The bank of the register whose lanes begin at `first`, with what is `needed` of the numbers of its cranes.
    #[inline(always)]
    fn bank(&mut self, first: usize, needed: Needed) -> usize {
        let bank = (first / R::WIDTH).min(self.banks.len() - 1);
        if self.stale[bank] {
            self.banks[bank].put(&self.places, needed, &self.own, first);
            self.stale[bank] = needed != Needed::All;
        }
        bank
    }
}

impl<R: Register, const N: usize> StepKernel for LaneStepKernel<R, N> {
    fn instruction_set(&self) -> &'static str {
        R::NAME
    }

    fn load(&mut self, lane: usize, own: &[f64]) {
        let mut changed = false;
        for (numbers, number) in self.own.iter_mut().zip(own) {
            changed |= numbers[lane].to_bits() != number.to_bits();
            numbers[lane] = *number;
        }
        self.stale[lane / R::WIDTH] |= changed;
    }

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

impl<R: Register, const N: usize> LaneStepKernel<R, N> {
    #[inline(always)]
    fn attempt_here(&mut self, trial: &Trial, x: &mut [Group]) -> StepResult {
        let [mut taken, mut exact, mut inside, mut growth] = [[0.0; WIDTH]; 4];
        for first in (0..WIDTH).step_by(R::WIDTH) {
            let bank = self.bank(first, Needed::All);
            let LaneStepKernel { banks, layout, demand, room, x: states, spools, .. } = self;
            let Bank { evaluator, precision } = &banks[bank];
            for i in 0..states.len() {
                states[i] = Lanes::load(&x[i][first..]);
            }
            for c in 0..N {
                spools[c] = Lanes::load(&trial.spools[c][first..]);
            }
            let (h, payload) = (Lanes::<R>::load(&trial.h[first..]), Lanes::load(&trial.payload[first..]));
            let scene = Scene { evaluator, layout, spools: &*spools, payload };
            let error = room.attempt(&scene, h, states, precision);
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
    fn tips_here(&mut self, x: &[Group]) -> [Group; 2] {
        let mut tips = [[0.0; WIDTH]; 2];
        for first in (0..WIDTH).step_by(R::WIDTH) {
            let bank = self.bank(first, Needed::Mechanics);
            let mechanics = &self.banks[bank].evaluator.plant.mechanics;
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
