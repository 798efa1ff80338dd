//! Tests of the tape.

mod derivatives;
mod machines;
mod order;
