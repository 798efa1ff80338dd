//! Evidence: random drives and damaged files, as tools. `make drives` and `make fuzz` run them; short forms are tests.
//!
//! [`drives`] drives every bundled machine with random sticks and judges what came out. [`fuzz`] feeds damaged files and
//! links to the core and finds panics, hangs, memory and numbers that are not finite.

pub mod arguments;
pub mod bound;
pub mod case;
pub mod clock;
pub mod core;
pub mod course;
pub mod drives;
pub mod energy;
pub mod fuzz;
pub mod lowering;
pub mod reference;
pub mod sticks;
