//! Eight cranes in the lanes of one vector, in the widest instruction set that the processor has.
//!
//! The laws are those of one crane. None of them contracts or reorders arithmetic, so that all instruction sets give the
//! same bits.

use crate::crane_step::{CraneStep, Scene};
use crate::layout::Layout;
use crate::plant::Plant;
use crate::rhs::Evaluator;
use hydrocrane_num::register::Register;
#[cfg(target_arch = "x86_64")]
use hydrocrane_num::register_x86::{Avx2, Avx512, Sse2};
use hydrocrane_num::{Lanes, Real, Vec2};

/// Cranes of a group: as many as the widest register has lanes; in narrower ones they go in several turns.
pub const WIDTH: usize = 8;
/// One number of each.
pub type Group = [f64; 8];

/// A stretch of equal steps under constant commands.
#[derive(Debug, Clone, Copy)]
pub struct Stretch<'a> {
    pub steps: usize,
    /// s
    pub h: f64,
    /// Spool commands, m.
    pub spools: &'a [Group],
    /// At the tips, kg.
    pub payload: Group,
}

/// The laws of a machine for whole groups.
pub trait Kernel: Send + Sync {
    /// Name of the instruction set.
    fn instruction_set(&self) -> &'static str;
    /// What one thread needs to move groups.
    fn mover(&self) -> Box<dyn Mover + '_>;
}

/// Moves groups of cranes.
pub trait Mover {
    /// Moves the states `x` of a group on.
    fn advance(&mut self, stretch: Stretch, x: &mut [Group]);
    /// Looks at a group.
    fn look(&mut self, x: &[Group]) -> Look;
}

/// What one sees of a group.
#[derive(Debug, Clone, Copy)]
pub struct Look {
    /// x and z of the tips, m.
    pub tip: [Group; 2],
    /// Whether all numbers are finite and every piston is in its cylinder.
    pub sensible: [bool; WIDTH],
}

/// A crane of `N` joints in the lanes of a register.
struct LaneCrane<R, const N: usize> {
    evaluator: Evaluator<Lanes<R>, Lanes<R>, N>,
    layout: Layout,
}

struct LaneMover<'a, R, const N: usize> {
    crane: &'a LaneCrane<R, N>,
    room: CraneStep<Lanes<R>>,
    x: Vec<Lanes<R>>,
    spools: [Lanes<R>; N],
}

/// The machine for groups, in the widest instruction set of this processor or the narrower one that is `wanted`.
#[cfg(target_arch = "x86_64")]
pub fn kernel<const N: usize>(plant: &Plant<f64, N>, layout: &Layout, wanted: Option<&str>) -> Box<dyn Kernel> {
    fn fits<R: Register>(wanted: Option<&str>) -> bool {
        R::is_available() && wanted.is_none_or(|name| name == R::NAME)
    }
    if fits::<Avx512>(wanted) {
        Box::new(LaneCrane::<Avx512, N>::new(plant, layout))
    } else if fits::<Avx2>(wanted) {
        Box::new(LaneCrane::<Avx2, N>::new(plant, layout))
    } else {
        Box::new(LaneCrane::<Sse2, N>::new(plant, layout))
    }
}

/// The machine for groups.
#[cfg(not(target_arch = "x86_64"))]
pub fn kernel<const N: usize>(plant: &Plant<f64, N>, layout: &Layout, _wanted: Option<&str>) -> Box<dyn Kernel> {
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

    fn mover(&self) -> Box<dyn Mover + '_> {
        Box::new(LaneMover {
            crane: self,
            room: CraneStep::new(&self.layout),
            x: vec![Lanes::default(); self.layout.len()],
            spools: [Lanes::default(); N],
        })
    }
}

impl<R: Register, const N: usize> Mover for LaneMover<'_, R, N> {
    fn advance(&mut self, stretch: Stretch, x: &mut [Group]) {
        R::run(
            #[inline(always)]
            || self.advance_here(stretch, x),
        );
    }

    fn look(&mut self, x: &[Group]) -> Look {
        R::run(
            #[inline(always)]
            || self.look_here(x),
        )
    }
}

impl<R: Register, const N: usize> LaneMover<'_, R, N> {
    #[inline(always)]
    fn advance_here(&mut self, stretch: Stretch, x: &mut [Group]) {
        let LaneMover { crane, room, x: states, spools } = self;
        let LaneCrane { evaluator, layout } = crane;
        for first in (0..WIDTH).step_by(R::WIDTH) {
            for i in 0..states.len() {
                states[i] = Lanes::load(&x[i][first..]);
            }
            for c in 0..N {
                spools[c] = Lanes::load(&stretch.spools[c][first..]);
            }
            let payload = Lanes::load(&stretch.payload[first..]);
            let scene = Scene { evaluator, layout, spools: &*spools, payload };
            for _ in 0..stretch.steps {
                room.step(&scene, Lanes::c(stretch.h), states);
            }
            for i in 0..states.len() {
                states[i].store(&mut x[i][first..]);
            }
        }
    }

    #[inline(always)]
    fn look_here(&self, x: &[Group]) -> Look {
        let mut look = Look { tip: [[0.0; WIDTH]; 2], sensible: [false; WIDTH] };
        let mut flags = [0.0; WIDTH];
        for first in (0..WIDTH).step_by(R::WIDTH) {
            let (tip, sensible) = self.look_at(x, first);
            tip.x.store(&mut look.tip[0][first..]);
            tip.z.store(&mut look.tip[1][first..]);
            Lanes::<R>::select(sensible, Lanes::c(1.0), Lanes::c(0.0)).store(&mut flags[first..]);
        }
        for lane in 0..WIDTH {
            look.sensible[lane] = flags[lane] == 1.0;
        }
        look
    }

    /// The tips of the cranes from `first` on, and where all is well.
    #[inline(always)]
    fn look_at(&self, x: &[Group], first: usize) -> (Vec2<Lanes<R>>, R::Mask) {
        let plant = &self.crane.evaluator.plant;
        let mut q = [Lanes::<R>::default(); N];
        let mut size = Lanes::<R>::default();
        for (i, lanes) in x.iter().enumerate() {
            let lanes = Lanes::load(&lanes[first..]);
            size += lanes.abs();
            if i < N {
                q[i] = lanes;
            }
        }
        let pose = plant.mechanics.pose(&q);
        (plant.mechanics.tip_position(&pose), size.finite() & plant.admissible(&pose))
    }
}
