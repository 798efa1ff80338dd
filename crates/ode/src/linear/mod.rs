//! A system linearised at one state, and the linear systems of implicit steps there.

pub(crate) mod axis;
pub(crate) mod block_arrow;
pub(crate) mod opening;
pub mod rows;
pub(crate) mod schur;
pub(crate) mod shared;
pub(crate) mod system;

use crate::linear::axis::ScalarOver;
use crate::linear::block_arrow::{BlockArrow, StateBlocks};
use crate::linear::rows::with_avx2;
use crate::linear::schur::SchurFactors;
use hydrocrane_num::linear::dense::Inverse;

/// A [`System`](crate::linear::system::System) linearised at one state: rates, and the Jacobian as a dense matrix or as a block arrow.
pub struct Linearisation {
    /// f
    pub rate: Vec<f64>,
    /// Without tangents.
    states: usize,
    /// df/dx, then its derivative along each tangent, if the Jacobian is dense.
    dfdx: Vec<f64>,
    /// The same in blocks; empty if the Jacobian is dense.
    blocks: Vec<BlockArrow<f64>>,
    secants: bool,
}

impl Linearisation {
    /// For `n` states with all their tangents.
    pub fn new(n: usize) -> Self {
        Linearisation { rate: vec![0.0; n], states: n, dfdx: Vec::new(), blocks: Vec::new(), secants: false }
    }

    /// With the secant of static friction: see [`BlockArrow::secants`].
    pub fn with_secants(mut self) -> Self {
        self.secants = true;
        self
    }

    /// Room for df/dx, row-major `n x n`, followed by its derivative along each of the `tangents`.
    pub fn dense(&mut self, tangents: usize) -> &mut [f64] {
        self.states = self.rate.len() / (1 + tangents);
        self.dfdx.resize(self.states * self.rate.len(), 0.0);
        &mut self.dfdx
    }

    /// The rates, and room for a block arrow of these states, followed by its derivatives along each of the `tangents`.
    pub fn block_arrow(&mut self, states: &StateBlocks, tangents: usize) -> (&mut [f64], &mut [BlockArrow<f64>]) {
        if self.blocks.is_empty() {
            self.states = self.rate.len() / (1 + tangents);
            let blocks = BlockArrow { secants: self.secants, ..BlockArrow::new(states) };
            self.blocks = vec![blocks; 1 + tangents];
        }
        (&mut self.rate, &mut self.blocks)
    }

    /// Shifts the point of linearisation by `d` (state, then tangents): rates to first order, Jacobian unchanged.
    pub fn shift(&mut self, d: &[f64]) {
        let n = self.states;
        let mut rate = std::mem::take(&mut self.rate);
        for (k, (rate, along)) in rate.chunks_exact_mut(n).zip(d.chunks_exact(n)).enumerate() {
            self.add_product(0, along, rate);
            if k > 0 {
                self.add_product(k, &d[..n], rate);
            }
        }
        self.rate = rate;
    }

    /// y += df/dx x for `k` = 0; for `k` >= 1 with the derivative of df/dx along tangent `k`.
    #[inline(always)]
    fn add_product<T: ScalarOver<f64>>(&self, k: usize, x: &[T], y: &mut [T]) {
        let n = self.states;
        match self.blocks.get(k) {
            Some(derivatives) => {
                derivatives.add_product(x, y);
                // The rows of q' are not stored in the blocks; their derivative is constant.
                if k == 0 {
                    for j in 0..derivatives.joints {
                        y[j] += x[derivatives.joints + j];
                    }
                }
            }
            None => {
                for (y, row) in y.iter_mut().zip(self.dfdx[k * n * n..].chunks_exact(n)) {
                    row.iter().zip(x).for_each(|(derivative, x)| *y += *x * *derivative);
                }
            }
        }
    }
}

/// `shift I - df/dx`, factored.
#[derive(Default)]
pub struct Factored<T> {
    schur: SchurFactors<T>,
    inverse: Inverse<T>,
}

impl<T: ScalarOver<f64>> Factored<T> {
    /// Factors the matrix of a linearisation; the mask is true where this succeeds.
    #[inline(always)]
    pub fn factor(&mut self, at: &Linearisation, shift: T) -> T::Mask {
        if let Some(jacobian) = at.blocks.first() {
            return self.schur.factor(jacobian, shift);
        }
        let n = at.states;
        let mut matrix: Vec<T> = at.dfdx[..n * n].iter().map(|derivative| T::c(-derivative)).collect();
        for i in 0..n {
            matrix[i * (n + 1)] += shift;
        }
        self.inverse.of(n, &matrix)
    }

    /// Replaces the right-hand side `k` by the solution. The solution of the state comes first and enters the right-hand sides of
    /// the tangents.
    #[inline(always)]
    pub fn solve(&self, at: &Linearisation, k: &mut [T]) {
        let (state, tangents) = k.split_at_mut(at.states);
        self.solve_one(at, state);
        for (i, tangent) in tangents.chunks_exact_mut(at.states).enumerate() {
            at.add_product(1 + i, state, tangent);
            self.solve_one(at, tangent);
        }
    }

    #[inline(always)]
    fn solve_one(&self, at: &Linearisation, k: &mut [T]) {
        match at.blocks.first() {
            Some(jacobian) => self.schur.solve(jacobian, k),
            None => self.inverse.solve(k),
        }
    }
}

// Long code, a part for each size of the border: one function for all stages of all methods.
impl Factored<f64> {
    /// [`Self::factor`]
    #[inline(never)]
    pub fn factor_outlined(&mut self, at: &Linearisation, shift: f64) -> bool {
        self.factor(at, shift)
    }

    /// [`Self::solve`]
    #[inline(never)]
    pub fn solve_outlined(&self, at: &Linearisation, k: &mut [f64]) {
        with_avx2(
            #[inline(always)]
            || self.solve(at, k),
        );
    }
}
