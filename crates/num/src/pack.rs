//! Several numbers in one.

use crate::{Lanes, Real};

/// A number type that holds [`WIDTH`](Pack::WIDTH) numbers of type `T` side by side. Every type packs itself, one by one.
pub trait Pack<T>: Real {
    const WIDTH: usize;

    /// The numbers that `f` gives for the lanes.
    fn gather(f: impl FnMut(usize) -> T) -> Self;
    fn lane(self, i: usize) -> T;
}

impl<T: Real> Pack<T> for T {
    const WIDTH: usize = 1;

    #[inline(always)]
    fn gather(mut f: impl FnMut(usize) -> T) -> T {
        f(0)
    }
    #[inline(always)]
    fn lane(self, _: usize) -> T {
        self
    }
}

impl<const W: usize> Pack<f64> for Lanes<W> {
    const WIDTH: usize = W;

    #[inline(always)]
    fn gather(mut f: impl FnMut(usize) -> f64) -> Self {
        let mut lanes = [0.0; W];
        for i in 0..W {
            lanes[i] = f(i);
        }
        Lanes(lanes)
    }
    #[inline(always)]
    fn lane(self, i: usize) -> f64 {
        self.0[i]
    }
}
