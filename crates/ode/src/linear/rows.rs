//! State vectors in blocks of numbers or in lanes, and weighted sums of them in one pass.

#[cfg(target_arch = "x86_64")]
use hydrocrane_num::lanes::register_x86::Avx2;
use hydrocrane_num::{lanes::register::Register, Field, Lanes};

/// Numbers of a block.
const LANES: usize = 4;

/// A row consists of blocks; the last one is padded with zeros.
pub type Block = [f64; LANES];

/// Number of states of a row.
#[derive(Debug, Clone, Copy)]
pub struct Shape {
    states: usize,
}

impl Shape {
    pub fn new(states: usize) -> Self {
        Shape { states }
    }

    /// `count` rows of zeros, one behind the other.
    pub fn rows(&self, count: usize) -> Vec<Block> {
        vec![[0.0; LANES]; count * self.blocks()]
    }

    /// Blocks of a row.
    fn blocks(&self) -> usize {
        self.states.div_ceil(LANES)
    }

    #[inline(always)]
    pub fn states<'a>(&self, row: &'a [Block]) -> &'a [f64] {
        &row.as_flattened()[..self.states]
    }

    #[inline(always)]
    pub fn states_mut<'a>(&self, row: &'a mut [Block]) -> &'a mut [f64] {
        &mut row.as_flattened_mut()[..self.states]
    }

    /// The first `J` of `rows`, and the next one.
    #[inline(always)]
    pub fn split<'a, const J: usize>(&self, rows: &'a mut [Block]) -> ([&'a [Block]; J], &'a mut [Block]) {
        let (done, rest) = split(rows, self.blocks());
        (done, &mut rest[..self.blocks()])
    }

    /// All of `J` rows.
    #[inline(always)]
    pub fn all<'a, const J: usize>(&self, rows: &'a [Block]) -> [&'a [Block]; J] {
        all(rows, self.blocks())
    }
}

/// Writes the states of a row whose block `i` is `of(i)`.
#[inline(always)]
pub fn write(x: &mut [f64], of: impl Fn(usize) -> Block) {
    for (i, out) in x.chunks_mut(LANES).enumerate() {
        out.iter_mut().zip(of(i)).for_each(|(out, number)| *out = number);
    }
}

/// [`write`] compiled for AVX2: see [`with_avx2`].
#[inline(always)]
pub fn write_with_avx2(x: &mut [f64], of: impl Fn(usize) -> Block) {
    with_avx2(
        #[inline(always)]
        || write(x, &of),
    );
}

/// Numbers that are computed with at once.
pub trait Cell: Copy {
    /// What a whole row can be multiplied with.
    type Factor: Copy;
    fn zero() -> Self;
    fn plus(self, other: Self) -> Self;
    fn times(self, weight: f64) -> Self;
    fn scaled(self, factor: Self::Factor) -> Self;
}

impl Cell for Block {
    type Factor = f64;

    #[inline(always)]
    fn zero() -> Self {
        [0.0; LANES]
    }
    #[inline(always)]
    fn plus(mut self, other: Self) -> Self {
        for lane in 0..LANES {
            self[lane] += other[lane];
        }
        self
    }
    #[inline(always)]
    fn times(mut self, weight: f64) -> Self {
        for lane in 0..LANES {
            self[lane] *= weight;
        }
        self
    }
    #[inline(always)]
    fn scaled(self, factor: f64) -> Self {
        self.times(factor)
    }
}

impl Cell for f64 {
    type Factor = f64;

    #[inline(always)]
    fn zero() -> Self {
        0.0
    }
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self + other
    }
    #[inline(always)]
    fn times(self, weight: f64) -> Self {
        self * weight
    }
    #[inline(always)]
    fn scaled(self, factor: Self) -> Self {
        self * factor
    }
}

impl<R: Register> Cell for Lanes<R> {
    type Factor = Self;

    #[inline(always)]
    fn zero() -> Self {
        Self::c(0.0)
    }
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self + other
    }
    #[inline(always)]
    fn times(self, weight: f64) -> Self {
        self * weight
    }
    #[inline(always)]
    fn scaled(self, factor: Self) -> Self {
        self * factor
    }
}

/// The first `J` rows of `cells`, and the rows after them.
#[inline(always)]
pub fn split<E, const J: usize>(rows: &mut [E], cells: usize) -> ([&[E]; J], &mut [E]) {
    let (done, rest) = rows.split_at_mut(J * cells);
    let done: &[E] = done;
    (hydrocrane_num::array::from_fn(|j| &done[j * cells..][..cells]), rest)
}

/// All of `J` rows of `cells`.
#[inline(always)]
pub fn all<E, const J: usize>(rows: &[E], cells: usize) -> [&[E]; J] {
    hydrocrane_num::array::from_fn(|j| &rows[j * cells..][..cells])
}

/// The sum of cell `i` of `rows` with `weights`.
#[inline(always)]
pub fn sum<E: Cell, const J: usize>(weights: &[f64], rows: &[&[E]; J], i: usize) -> E {
    let mut sum = E::zero();
    for j in 0..J {
        sum = sum.plus(rows[j][i].times(weights[j]));
    }
    sum
}

/// row = base + sum_j weight_j row_j
#[inline(always)]
pub fn set_sum<E: Cell, const J: usize>(row: &mut [E], base: &[E], weights: &[f64], rows: [&[E]; J]) {
    for (i, (out, base)) in row.iter_mut().zip(base).enumerate() {
        *out = base.plus(sum(weights, &rows, i));
    }
}

/// row = base + scale sum_j weight_j row_j
#[inline(always)]
pub fn set_scaled_sum<E: Cell, const J: usize>(
    row: &mut [E],
    base: &[E],
    scale: E::Factor,
    weights: &[f64],
    rows: [&[E]; J],
) {
    for (i, (out, base)) in row.iter_mut().zip(base).enumerate() {
        *out = base.plus(sum(weights, &rows, i).scaled(scale));
    }
}

/// row += scale sum_j weight_j row_j
#[inline(always)]
pub fn add_sum<E: Cell, const J: usize>(row: &mut [E], scale: E::Factor, weights: &[f64], rows: [&[E]; J]) {
    for (i, out) in row.iter_mut().enumerate() {
        *out = out.plus(sum(weights, &rows, i).scaled(scale));
    }
}

/// Runs `f`, which must be inlined, compiled for AVX2 where the processor has it, so that a block is a register. The bits are the
/// same either way.
#[inline(always)]
pub fn with_avx2<O>(mut f: impl FnMut() -> O) -> O {
    #[cfg(target_arch = "x86_64")]
    if Avx2::is_available() {
        return Avx2::run(f);
    }
    f()
}
