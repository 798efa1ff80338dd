//! How a run ended.

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutcomeKind {
    Completed,
    /// A piston left its cylinder: a chamber volume reached zero.
    StrokeLimit,
    SolverFailed,
    ControllerFailed,
    /// The initial state is not one the equations can start from.
    BadState,
    Interrupted,
}

impl OutcomeKind {
    /// The name people see.
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

/// How, when and why a run ended. What it computed until then is in its record.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    pub kind: OutcomeKind,
    /// s
    pub time: f64,
    pub message: String,
}
