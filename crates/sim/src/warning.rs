//! A warning of a run.

/// A warning that a run may be wrong.
#[derive(Debug, Clone, PartialEq)]
pub struct Warning {
    /// Begin, s.
    pub time: f64,
    /// Short stable name.
    pub kind: &'static str,
    /// Dotted path of the value of a file that it is about.
    pub key: Option<String>,
    /// The finding, with numbers and units.
    pub text: String,
    /// The cure.
    pub cure: String,
}

/// A number with six digits, for messages.
pub(crate) fn short(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}
