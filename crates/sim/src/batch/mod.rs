//! Many cranes of one machine at once.

mod kernel;

pub use kernel::*;
