//! Ordinary differential equations x' = f(t, x) with quadratures, for stiff systems of some ten states.
//!
//! A [`System`] gives its right-hand side and its Jacobian, either dense or as a [`BlockArrow`]. A [`Method`] tries one
//! step. The [`Stepper`] chooses the step sizes. This crate does not depend on cranes.

mod axis;
mod block_arrow;
pub mod exponential4;
pub mod grk4t;
mod linear;
mod method;
mod methods;
mod opening;
mod poles;
mod quadratures;
pub mod rodas5p;
pub mod rosenbrock;
pub mod rosenbrock3;
pub mod rows;
mod schur;
mod shared;
pub mod step_size;
mod stepper;
mod system;
pub mod tableau;
pub mod tsit5;

pub use axis::{AxisDerivatives, AxisStates, Row, ScalarOver, MAX_ACTING, MAX_BORDER, MAX_SHARED};
pub use block_arrow::{BlockArrow, ForceAlong, StateBlocks};
pub use linear::{Factored, Linearisation};
pub use method::{Effort, Method, Restart, Target, FLUSH};
pub use methods::{method, METHODS};
pub use opening::AxisOpening;
pub use schur::SchurFactors;
pub use shared::{SharedDerivatives, SharedStates};
pub use stepper::{least_step, StepControl, StepFailure, Stepper, Tolerances, CRAWL_ATTEMPTS};
pub use system::System;
