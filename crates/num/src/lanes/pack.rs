//! Several numbers in one.

use crate::lanes::register::{Register, WIDEST};
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

impl<R: Register> Pack<f64> for Lanes<R> {
    const WIDTH: usize = R::WIDTH;

    #[inline(always)]
    fn gather(mut f: impl FnMut(usize) -> f64) -> Self {
        let mut numbers = [0.0; WIDEST];
        for i in 0..R::WIDTH {
            numbers[i] = f(i);
        }
        Lanes::load(&numbers)
    }
    #[inline(always)]
    fn lane(self, i: usize) -> f64 {
        let mut numbers = [0.0; WIDEST];
        self.store(&mut numbers);
        numbers[i]
    }
}
