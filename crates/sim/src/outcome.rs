//! Outcome of a run.

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutcomeKind {
    Completed,
    /// A piston left its cylinder: a chamber volume reached zero.
    StrokeLimit,
    SolverFailed,
    ControllerFailed,
    /// The initial state is not admissible.
    BadState,
    Interrupted,
}

impl OutcomeKind {
    /// The name in messages and files.
    pub fn name(self) -> &'static str {
        match self {
            OutcomeKind::Completed => "completed",
            OutcomeKind::StrokeLimit => "stroke-limit",
            OutcomeKind::SolverFailed => "solver-failed",
            OutcomeKind::ControllerFailed => "controller-failed",
            OutcomeKind::BadState => "bad-state",
            OutcomeKind::Interrupted => "interrupted",
        }
    }
}

/// Kind, time and reason of the end of a run. The results until then are in its record.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    pub kind: OutcomeKind,
    /// s
    pub time: f64,
    pub message: String,
}
