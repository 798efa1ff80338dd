//! A system linearised at one state, and the linear systems of implicit steps there.

use crate::bordered::Bordered;
use crate::elimination::{Elimination, Over};
use crate::layout::Layout;
use hydrocrane_num::dense::Inverse;

/// What a [`System`](crate::system::System) says of itself at one state: rates, and their slopes either as a dense matrix
/// or in the blocks of a crane.
pub struct Linearisation {
    /// f
    pub rate: Vec<f64>,
    /// df/dx, then its derivative along each tangent, where the slopes are dense.
    dfdx: Vec<f64>,
    /// The same in blocks; empty where the slopes are dense.
    blocks: Vec<Bordered<f64>>,
    secants: bool,
}

impl Linearisation {
    /// For `n` states with all their tangents.
    pub fn new(n: usize) -> Self {
        Linearisation { rate: vec![0.0; n], dfdx: Vec::new(), blocks: Vec::new(), secants: false }
    }

    /// With static friction by its secant: see [`Bordered::secants`].
    pub fn with_secants(mut self) -> Self {
        self.secants = true;
        self
    }

    /// Room for df/dx, row-major `n x n`, followed by its derivative along each of the `tangents`.
    pub fn dense(&mut self, tangents: usize) -> &mut [f64] {
        let n = self.rate.len() / (1 + tangents);
        self.dfdx.resize(n * n * (1 + tangents), 0.0);
        &mut self.dfdx
    }

    /// The rates, and room for the slopes of a crane, followed by their derivatives along each of the `tangents`.
    pub fn bordered(&mut self, layout: &Layout, tangents: usize) -> (&mut [f64], &mut [Bordered<f64>]) {
        if self.blocks.is_empty() {
            let blocks = Bordered { secants: self.secants, ..Bordered::new(layout) };
            self.blocks = vec![blocks; 1 + tangents];
        }
        (&mut self.rate, &mut self.blocks)
    }

    /// Moves on by `d`: rates to first order, slopes as they are.
    pub fn shift(&mut self, d: &[f64]) {
        let Linearisation { rate, dfdx, blocks, .. } = self;
        match blocks.split_first() {
            Some((jacobian, slopes)) => {
                let n = d.len() / (1 + slopes.len());
                jacobian.add_whole_product(&d[..n], &mut rate[..n]);
                for (k, slope) in slopes.iter().enumerate() {
                    let tangent = n * (1 + k)..n * (2 + k);
                    jacobian.add_whole_product(&d[tangent.clone()], &mut rate[tangent.clone()]);
                    slope.add_product(&d[..n], &mut rate[tangent]);
                }
            }
            None => {
                let n = dfdx.len() / rate.len();
                for (k, slope) in dfdx.chunks_exact(n * n).enumerate() {
                    let block = n * k..n * (1 + k);
                    add_product(&dfdx[..n * n], &d[block.clone()], &mut rate[block.clone()]);
                    if k > 0 {
                        add_product(slope, &d[..n], &mut rate[block]);
                    }
                }
            }
        }
    }

    /// Number of states without tangents, of a dense system: `dfdx` has so many rows for each of them, and `rate` so many
    /// entries, that their quotient tells it.
    fn states(&self) -> usize {
        self.dfdx.len() / self.rate.len()
    }
}

/// `shift I - df/dx`, factored.
#[derive(Default)]
pub struct Factored<T> {
    elimination: Elimination<T>,
    inverse: Inverse<T>,
}

impl<T: Over<f64>> Factored<T> {
    /// Factors the matrix for a linearisation; the mask tells where that can be done.
    #[inline(always)]
    pub fn factor(&mut self, at: &Linearisation, shift: T) -> T::Mask {
        if let Some(jacobian) = at.blocks.first() {
            return self.elimination.factor(jacobian, shift);
        }
        let n = at.states();
        let mut matrix: Vec<T> = at.dfdx[..n * n].iter().map(|slope| T::c(-slope)).collect();
        matrix.iter_mut().step_by(n + 1).for_each(|entry| *entry += shift);
        self.inverse.of(n, &matrix)
    }

    /// Replaces the right-hand side `k` by the solution: that of the state first, which enters the right-hand sides of its
    /// tangents.
    #[inline(always)]
    pub fn solve(&self, at: &Linearisation, k: &mut [T]) {
        let Some((jacobian, slopes)) = at.blocks.split_first() else { return self.solve_dense(at, k) };
        let (state, tangents) = k.split_at_mut(k.len() / at.blocks.len());
        self.elimination.solve(jacobian, state);
        for (tangent, slope) in tangents.chunks_exact_mut(state.len()).zip(slopes) {
            slope.add_product(state, tangent);
            self.elimination.solve(jacobian, tangent);
        }
    }

    #[inline(always)]
    fn solve_dense(&self, at: &Linearisation, k: &mut [T]) {
        let n = at.states();
        let (state, tangents) = k.split_at_mut(n);
        self.inverse.solve(state);
        let along = at.dfdx.chunks_exact(n * n).skip(1);
        for (tangent, slope) in tangents.chunks_exact_mut(n).zip(along) {
            add_product(slope, state, tangent);
            self.inverse.solve(tangent);
        }
    }
}

/// y += a x with a row-major `a`.
#[inline(always)]
fn add_product<T: Over<f64>>(a: &[f64], x: &[T], y: &mut [T]) {
    for (y, row) in y.iter_mut().zip(a.chunks_exact(x.len())) {
        row.iter().zip(x).for_each(|(a, x)| *y += *x * *a);
    }
}
