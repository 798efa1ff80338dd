//! The cockpit's core: a crane with an operator, with texts and numbers in and out, and without physics.
//!
//! [`Cockpit`] is an ordinary type, tested natively; [`face`] is its WebAssembly interface for a page.

mod cockpit;
mod description;
mod drive;
pub mod face;
mod frame;
mod friction_level;
mod knobs;
mod offered;
mod problem;
mod replay;
mod request;
mod saved;
mod scenario;

pub use cockpit::Cockpit;
pub use drive::TICK;
pub use problem::Problem;
pub use request::Request;
