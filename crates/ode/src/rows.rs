//! States in whole blocks of numbers, and sums of them in one pass.

#[cfg(target_arch = "x86_64")]
use hydrocrane_num::{register::Register, register_x86::Avx2};

/// Numbers that sums take at once.
const LANES: usize = 4;

/// A row is made of these, the last one filled up with zeros.
pub type Block = [f64; LANES];

/// How many states a row holds.
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

    /// The first `J` of `rows`, and the one behind them.
    #[inline(always)]
    pub fn split<'a, const J: usize>(&self, rows: &'a mut [Block]) -> ([&'a [Block]; J], &'a mut [Block]) {
        let blocks = self.blocks();
        let (done, rest) = rows.split_at_mut(J * blocks);
        let done: &[Block] = done;
        (std::array::from_fn(|j| &done[j * blocks..][..blocks]), &mut rest[..blocks])
    }

    /// All of `J` rows.
    #[inline(always)]
    pub fn all<'a, const J: usize>(&self, rows: &'a [Block]) -> [&'a [Block]; J] {
        let blocks = self.blocks();
        std::array::from_fn(|j| &rows[j * blocks..][..blocks])
    }
}

/// Writes the row whose blocks are `of` their numbers to where its states are wanted.
#[inline(always)]
pub fn write(x: &mut [f64], of: impl Fn(usize) -> Block) {
    for (i, out) in x.chunks_mut(LANES).enumerate() {
        out.iter_mut().zip(of(i)).for_each(|(out, number)| *out = number);
    }
}

/// [`write`] with a register for each block: see [`with_avx2`].
#[inline(always)]
pub fn write_with_avx2(x: &mut [f64], of: impl Fn(usize) -> Block) {
    with_avx2(
        #[inline(always)]
        || write(x, &of),
    );
}

/// The sum of block `i` of `rows` with `weights`.
#[inline(always)]
pub fn sum<const J: usize>(weights: &[f64], rows: &[&[Block]; J], i: usize) -> Block {
    let mut sum = [0.0; LANES];
    for j in 0..J {
        let term = &rows[j][i];
        for lane in 0..LANES {
            sum[lane] += weights[j] * term[lane];
        }
    }
    sum
}

/// row = base + scale sum_j weight_j row_j
#[inline(always)]
pub fn set_sum<const J: usize>(row: &mut [Block], base: &[Block], scale: f64, weights: &[f64], rows: [&[Block]; J]) {
    for (i, (out, base)) in row.iter_mut().zip(base).enumerate() {
        let sum = sum(weights, &rows, i);
        for lane in 0..LANES {
            out[lane] = base[lane] + scale * sum[lane];
        }
    }
}

/// row += scale sum_j weight_j row_j
#[inline(always)]
pub fn add_sum<const J: usize>(row: &mut [Block], scale: f64, weights: &[f64], rows: [&[Block]; J]) {
    for (i, out) in row.iter_mut().enumerate() {
        let sum = sum(weights, &rows, i);
        for lane in 0..LANES {
            out[lane] += scale * sum[lane];
        }
    }
}

/// Runs `f`, which is to be inlined, with a register for each block where the processor has such. The bits are the same
/// either way.
#[inline(always)]
pub fn with_avx2<O>(mut f: impl FnMut() -> O) -> O {
    #[cfg(target_arch = "x86_64")]
    if Avx2::is_available() {
        return Avx2::run(f);
    }
    f()
}
