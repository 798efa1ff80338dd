//! Machine and scenario files: TOML with units at the values, checked, with provenance and helpful errors.
//!
//! [`load`] turns a bundled name or a path into a [`model::Machine`]; every problem is one [`MachineError`] that names
//! place, key and cure. Nothing here knows physics.

pub mod by_keys;
mod errors;
mod keys;
mod load;
pub mod model;
mod names;
mod nearest;
mod number;
mod reading;
pub mod scenario;
#[cfg(feature = "schema")]
mod schema;
mod sections;
mod text;
pub mod units;
mod whole;

pub use errors::{shortened, ErrorKind, FilePosition, Location, MachineError, Problem, ERROR_SLUGS};
pub use keys::{Key, CONTROLLERS, PLAUSIBILITY, TIP_AXES};
pub use load::{is_path, load, parse, tables_of, whole_text, whole_text_of, Template};
pub use model::Machine;
pub use names::{name_fault, text_fault};
pub use nearest::suggestion;
pub use number::{Number, Variable};
pub use scenario::{load_scenario, parse_scenario, parse_scenario_with, Scenario, MOST_SEED};
#[cfg(feature = "schema")]
pub use schema::FileKind;
pub use text::bundled::{bundled_machines, bundled_scenarios};
pub use text::disk::{path_fault, read as read_file};
pub use text::merge::OverrideValue;
pub use units::misread::quantity;
pub use units::unit_exponents;
