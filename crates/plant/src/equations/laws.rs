//! The laws of a crane, with its cylinders in lanes where the processor has registers for them. The bits are the same either way.

use crate::equations::plant::Plant;
use crate::equations::rhs::{Evaluated, Evaluator};
use crate::layout::Layout;
#[cfg(target_arch = "x86_64")]
use hydrocrane_num::lanes::register::Register;
use hydrocrane_num::{lanes::native::NativeSimd, Lanes, Pack};
use hydrocrane_ode::BlockArrow;
use hydrocrane_physics::hydraulics::fluid::OilTables;

/// How the cylinders are arranged.
pub enum Laws<const N: usize> {
    /// Side by side, one per lane of the native register.
    Simd(Evaluator<f64, Lanes<NativeSimd>, N>),
    /// One after the other.
    #[cfg(target_arch = "x86_64")]
    Single(Evaluator<f64, f64, N>),
}

/// A state with its inputs.
#[derive(Clone, Copy)]
pub struct Moment<'a> {
    pub layout: &'a Layout,
    pub x: &'a [f64],
    /// Spool commands, m.
    pub u: &'a [f64],
    /// At the tip, kg.
    pub payload: f64,
}

impl<const N: usize> Laws<N> {
    pub fn new(plant: &Plant<f64, N>, layout: &Layout) -> Self {
        #[cfg(target_arch = "x86_64")]
        if !NativeSimd::is_available() {
            return Laws::Single(Evaluator::new(plant, layout));
        }
        Laws::Simd(Evaluator::new(plant, layout))
    }

    pub fn plant(&self) -> &Plant<f64, N> {
        match self {
            Laws::Simd(evaluator) => &evaluator.plant,
            #[cfg(target_arch = "x86_64")]
            Laws::Single(evaluator) => &evaluator.plant,
        }
    }

    /// Writes the state derivative.
    pub fn derivative(&self, at: Moment, dx: &mut [f64]) {
        match self {
            Laws::Simd(evaluator) => derivative(evaluator, at, dx),
            #[cfg(target_arch = "x86_64")]
            Laws::Single(evaluator) => derivative(evaluator, at, dx),
        }
    }

    /// Writes the state derivative with its Jacobian.
    pub fn linearise(&self, at: Moment, dx: &mut [f64], jacobian: &mut BlockArrow<f64>) {
        match self {
            Laws::Simd(evaluator) => linearise(evaluator, at, dx, jacobian),
            #[cfg(target_arch = "x86_64")]
            Laws::Single(evaluator) => linearise(evaluator, at, dx, jacobian),
        }
    }

    /// Updates the state derivative and its Jacobian to other spool commands.
    pub fn update_input(&self, x: &[f64], u: &[f64], dx: &mut [f64], jacobian: &mut BlockArrow<f64>) {
        match self {
            Laws::Simd(evaluator) => update_input(evaluator, x, u, dx, jacobian),
            #[cfg(target_arch = "x86_64")]
            Laws::Single(evaluator) => update_input(evaluator, x, u, dx, jacobian),
        }
    }

    /// Positions and laws at the state `x`.
    pub fn evaluated<'a>(&self, layout: &'a Layout, x: &'a [f64], payload: f64) -> Evaluated<'a, f64, N> {
        match self {
            Laws::Simd(evaluator) => evaluated(evaluator, layout, x, payload),
            #[cfg(target_arch = "x86_64")]
            Laws::Single(evaluator) => evaluated(evaluator, layout, x, payload),
        }
    }

    /// Writes the powers of the ledger at the state `x`.
    pub fn powers(&self, layout: &Layout, oil: &OilTables, x: &[f64], payload: f64, out: &mut [f64]) {
        match self {
            Laws::Simd(evaluator) => powers(evaluator, layout, oil, x, payload, out),
            #[cfg(target_arch = "x86_64")]
            Laws::Single(evaluator) => powers(evaluator, layout, oil, x, payload, out),
        }
    }
}

fn derivative<L: Pack<f64>, const N: usize>(evaluator: &Evaluator<f64, L, N>, at: Moment, dx: &mut [f64]) {
    L::outlined(
        #[inline(always)]
        || evaluator.derivative(at.layout, at.x, at.u, at.payload, dx),
    );
}

fn linearise<L: Pack<f64>, const N: usize>(
    evaluator: &Evaluator<f64, L, N>,
    at: Moment,
    dx: &mut [f64],
    jacobian: &mut BlockArrow<f64>,
) {
    L::outlined(
        #[inline(always)]
        || evaluator.linearise(at.layout, at.x, at.u, at.payload, dx, jacobian),
    );
}

fn update_input<L: Pack<f64>, const N: usize>(
    evaluator: &Evaluator<f64, L, N>,
    x: &[f64],
    u: &[f64],
    dx: &mut [f64],
    jacobian: &mut BlockArrow<f64>,
) {
    L::outlined(
        #[inline(always)]
        || evaluator.update_input(x, u, dx, jacobian),
    );
}

fn evaluated<'a, L: Pack<f64>, const N: usize>(
    evaluator: &Evaluator<f64, L, N>,
    layout: &'a Layout,
    x: &'a [f64],
    payload: f64,
) -> Evaluated<'a, f64, N> {
    L::outlined(
        #[inline(always)]
        || evaluator.evaluated(layout, x, payload),
    )
}

fn powers<L: Pack<f64>, const N: usize>(
    evaluator: &Evaluator<f64, L, N>,
    layout: &Layout,
    oil: &OilTables,
    x: &[f64],
    payload: f64,
    out: &mut [f64],
) {
    L::outlined(
        #[inline(always)]
        || evaluator.powers(layout, oil, x, payload, out),
    );
}
