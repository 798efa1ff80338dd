//! Numbers of all kinds against independent ones. One binary: linking takes longer than compiling.

mod dual;
mod elementary;
mod lanes;
