//! A warning of a run.

/// A warning that a run may be wrong.
#[derive(Debug, Clone, PartialEq)]
pub struct Warning {
    /// Begin, s.
    pub time: f64,
    /// Short stable name.
    pub kind: &'static str,
    /// The finding, with numbers and units.
    pub text: String,
    /// The cure.
    pub cure: String,
}
