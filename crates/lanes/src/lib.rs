//! Steps of many cranes side by side: one step of a whole crane over any number type, and groups of cranes in the lanes of
//! vector registers. A crate of its own, because it is compiled once for each instruction set and length of chain, as long
//! as all that simulates one crane, and needs none of that.                       theory: docs/theory/batch.md

mod crane_step;
mod kernel;
mod own_numbers;

pub use crane_step::{CraneStep, Scene};
pub use kernel::{Demand, InLanes, StepKernel, StepResult, Trial};
pub use own_numbers::{Group, Needed, WIDTH};
