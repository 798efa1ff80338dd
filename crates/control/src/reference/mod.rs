//! Where the tip may go, and how fast.

pub(crate) mod braking;
pub mod holding;
pub mod keep_out;
#[cfg(feature = "std")]
pub mod reach;
pub mod redundancy;
pub(crate) mod request;
pub mod set_point;
pub mod slow_down;
pub(crate) mod wanted;
