//! What makes a run doubtful.

/// Why a run may be wrong.
#[derive(Debug, Clone, PartialEq)]
pub struct Warning {
    /// When it began, s.
    pub time: f64,
    /// Short stable name.
    pub kind: &'static str,
    /// What was found, with its numbers and units.
    pub text: String,
    /// What helps.
    pub cure: String,
}
