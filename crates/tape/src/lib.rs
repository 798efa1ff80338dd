//! A law as a list of operations.                                           theory: docs/theory/tape.md
//!
//! [`Traced`] is a number that records what is done to it. A law that is generic over `Real` and free of branches is run once with
//! such numbers, and what is recorded is the same law for every state: the [`Tape`]. [`derivatives`] adds the operations of exact
//! derivatives, [`program`] puts what is needed in a stable order under names, for writers of other languages, and [`crane`]
//! traces a machine.

pub mod crane;
pub mod derivatives;
mod error;
mod laws;
mod operation;
mod parameters;
pub mod program;
mod recorder;
mod traced;

pub use crane::{export, Exported, Request};
pub use error::TapeError;
pub use operation::{Kind, Operand, Operation};
pub use program::{Function, Program, Step};
pub use recorder::{record, Tape};
pub use traced::{command, parameter, state, Traced, TracedMask};
