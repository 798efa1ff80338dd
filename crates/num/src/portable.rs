//! Elementary functions of one `f64`, with the same bits on every platform.
//!
//! The methods of `f64` call the platform's own library, whose last bit differs from one platform to the next. A controller
//! that saturates amplifies such a bit, so that the same drive would end elsewhere in a browser. What the laws evaluate in lanes
//! stands in [`elementary`](crate::lanes::elementary); the rest is taken from `libm`, a Rust port of musl's library.

pub use libm::{acos, atan2, cos, erf, exp, hypot, log10, log2, pow, sin};
pub use libm::{log as ln, sincos as sin_cos};

/// The nearest whole number, halves away from zero, and the square root: both exact to the last bit, so that the processor's own serve.
#[cfg(feature = "std")]
#[inline(always)]
pub fn sqrt(x: f64) -> f64 {
    x.sqrt()
}
#[cfg(feature = "std")]
#[inline(always)]
pub fn round(x: f64) -> f64 {
    x.round()
}
#[cfg(not(feature = "std"))]
pub use libm::{round, sqrt};
