//! A system linearised at one state, and the linear systems of implicit steps there.

use crate::bordered::Bordered;
use crate::elimination::Elimination;
use crate::layout::Layout;
use hydrocrane_num::dense::Lu;

/// What a [`System`](crate::system::System) says of itself at one state: rates, and their slopes either as a dense matrix
/// or in the blocks of a crane.
pub struct Linearisation {
    /// f
    pub rate: Vec<f64>,
    dense: Dense,
    /// df/dx, then its derivative along each tangent; empty where the slopes are dense.
    blocks: Vec<Bordered<f64>>,
    elimination: Elimination<f64>,
    secants: bool,
}

#[derive(Default)]
struct Dense {
    /// Number of states without tangents.
    n: usize,
    /// df/dx, then its derivative along each tangent.
    dfdx: Vec<f64>,
    matrix: Vec<f64>,
    lu: Lu,
}

impl Linearisation {
    /// For `n` states with all their tangents.
    pub fn new(n: usize) -> Self {
        Linearisation {
            rate: vec![0.0; n],
            dense: Dense::default(),
            blocks: Vec::new(),
            elimination: Elimination::default(),
            secants: false,
        }
    }

    /// With static friction by its secant: see [`Bordered::secants`].
    pub fn with_secants(mut self) -> Self {
        self.secants = true;
        self
    }

    /// Room for df/dx, row-major `n x n`, followed by its derivative along each of the `tangents`.
    pub fn dense(&mut self, tangents: usize) -> &mut [f64] {
        let dense = &mut self.dense;
        dense.n = self.rate.len() / (1 + tangents);
        dense.dfdx.resize(dense.n * dense.n * (1 + tangents), 0.0);
        dense.matrix.resize(dense.n * dense.n, 0.0);
        &mut dense.dfdx
    }

    /// The rates, and room for the slopes of a crane, followed by their derivatives along each of the `tangents`.
    pub fn bordered(&mut self, layout: &Layout, tangents: usize) -> (&mut [f64], &mut [Bordered<f64>]) {
        if self.blocks.is_empty() {
            let blocks = Bordered { secants: self.secants, ..Bordered::new(layout) };
            self.blocks = vec![blocks; 1 + tangents];
        }
        (&mut self.rate, &mut self.blocks)
    }

    /// Factors `I/time - df/dx`; `false` where that cannot be done.
    pub fn factor(&mut self, time: f64) -> bool {
        let shift = 1.0 / time;
        match self.blocks.first() {
            Some(jacobian) => self.elimination.factor(jacobian, shift),
            None => self.dense.factor(shift),
        }
    }

    /// Replaces the right-hand side `k` by the solution: that of the state first, which enters the right-hand sides of its
    /// tangents.
    #[inline(always)]
    pub fn solve(&self, k: &mut [f64]) {
        let Some((jacobian, slopes)) = self.blocks.split_first() else { return self.dense.solve(k) };
        let (state, tangents) = k.split_at_mut(k.len() / self.blocks.len());
        self.elimination.solve(jacobian, state);
        for (tangent, slope) in tangents.chunks_exact_mut(state.len()).zip(slopes) {
            slope.add_product(state, tangent);
            self.elimination.solve(jacobian, tangent);
        }
    }
}

impl Dense {
    fn factor(&mut self, shift: f64) -> bool {
        self.matrix.iter_mut().zip(&self.dfdx).for_each(|(w, j)| *w = -j);
        self.matrix.iter_mut().step_by(self.n + 1).for_each(|w| *w += shift);
        self.lu.factor(self.n, &self.matrix)
    }

    fn solve(&self, k: &mut [f64]) {
        let (state, tangents) = k.split_at_mut(self.n);
        self.lu.solve(state);
        let along = self.dfdx.chunks_exact(self.n * self.n).skip(1);
        for (tangent, slope) in tangents.chunks_exact_mut(self.n).zip(along) {
            add_product(slope, state, tangent);
            self.lu.solve(tangent);
        }
    }
}

/// y += a x with a row-major `a`.
fn add_product(a: &[f64], x: &[f64], y: &mut [f64]) {
    for (y, row) in y.iter_mut().zip(a.chunks_exact(x.len())) {
        *y += row.iter().zip(x).map(|(a, x)| a * x).sum::<f64>();
    }
}
