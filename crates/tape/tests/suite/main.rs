//! Tests of the tape.

mod machines;
