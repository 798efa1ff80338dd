//! Arrays built by index, with little to compile: the standard library's own function takes ten generic functions for each closure.

use core::mem::MaybeUninit;

/// The array of `f(0)`, `f(1)`, ..., called in this order.
///
/// ```
/// assert_eq!(hydrocrane_num::array::from_fn(|i| 2 * i), [0, 2, 4]);
/// ```
#[inline(always)]
pub fn from_fn<T, const N: usize>(mut f: impl FnMut(usize) -> T) -> [T; N] {
    let mut out = [const { MaybeUninit::uninit() }; N];
    for i in 0..N {
        out[i] = MaybeUninit::new(f(i));
    }
    // SAFETY: every place has been written.
    unsafe { (&raw const out).cast::<[T; N]>().read() }
}
