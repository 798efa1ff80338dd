//! Ordinary differential equations x' = f(t, x) with quadratures, for stiff systems of some ten states.
//!
//! A [`System`] gives its right-hand side and its Jacobian, either dense or as a [`BlockArrow`]. A [`Method`] tries one
//! step. The [`Stepper`] chooses the step sizes. This crate does not depend on cranes.

pub mod linear;
pub mod methods;
mod quadratures;
pub mod step_size;
mod stepper;

pub use linear::axis::{AxisDerivatives, AxisStates, Row, ScalarOver, MAX_ACTING, MAX_BORDER, MAX_SHARED};
pub use linear::block_arrow::{BlockArrow, ForceAlong, StateBlocks};
pub use linear::opening::AxisOpening;
pub use linear::schur::SchurFactors;
pub use linear::shared::{SharedDerivatives, SharedStates};
pub use linear::system::System;
pub use linear::{Factored, Linearisation};
pub use methods::method::{Effort, Method, Restart, Target, FLUSH};
pub use methods::{method, METHODS};
pub use stepper::{least_step, StepControl, StepFailure, Stepper, Tolerances, CRAWL_ATTEMPTS};
