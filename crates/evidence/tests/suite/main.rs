//! The tools in their short forms. One binary: linking takes longer than compiling.

mod fuzz;
mod random_drives;
