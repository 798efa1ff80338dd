//! Errors for users: one message, with the place in a file if there is one.

use hydrocrane_machine::{shortened, MachineError};
use hydrocrane_sim::assembly::AssemblyError;
use hydrocrane_sim::BuildError;
use serde_json::{json, Value};

#[derive(Debug, Clone, PartialEq)]
pub struct Problem(Value);

impl Problem {
    pub fn plain(message: impl Into<String>) -> Self {
        Problem(json!({ "message": shortened(&message.into()) }))
    }

    /// Kind of an error, by the name that the page uses.
    pub fn named(slug: &str, message: impl Into<String>) -> Self {
        Problem(json!({ "message": shortened(&message.into()), "slug": slug }))
    }

    /// The error in the form of the command line, with its parts.
    pub fn file(error: &MachineError) -> Self {
        Problem(json!({
            "message": error.to_string(),
            "slug": error.slug(),
            "file": error.file(),
            "line": error.line(),
            "column": error.column(),
            "key": error.key(),
            "cure": error.cure(),
        }))
    }

    pub fn message(&self) -> &str {
        self.0["message"].as_str().unwrap_or_default()
    }

    pub fn line(&self) -> Option<u64> {
        self.0["line"].as_u64()
    }

    pub fn json(&self) -> Value {
        json!({ "error": self.0 })
    }
}

/// An assembly error in the form for the page.
pub fn problem(error: AssemblyError) -> Problem {
    match error {
        AssemblyError::Machine(error) => Problem::file(&error),
        AssemblyError::Build(_, BuildError::Chain(_) | BuildError::Pump) => Problem::named("chain", error.to_string()),
        AssemblyError::Build(..) => Problem::named("cannot-build", error.to_string()),
        other => Problem::plain(other.to_string()),
    }
}
