//! How exact a run at the default tolerance promises to be.                  reference: docs/theory/integration.md

/// Distance of the tip from the exact solution, m.
pub const TIP: f64 = 1e-3;
/// Error of a pressure, as a share of the supply pressure.
pub const PRESSURE: f64 = 0.03;
/// Time about a kink, s, for which nothing is promised of pressures: where a valve opens a moment later, another pressure stands for that
/// moment.
pub const BRIEF: f64 = 0.02;
