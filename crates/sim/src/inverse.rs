//! Joints from strokes.

use crate::limits::{Drivetrain, JointLimits};

/// A stroke that no joint coordinate inside the limits gives.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "cylinder `{cylinder}`: stroke {stroke} m is outside {lower:.6} to {upper:.6} m, its range inside the joint limits"
)]
pub struct StrokeError {
    pub cylinder: String,
    pub stroke: f64,
    pub lower: f64,
    pub upper: f64,
}

/// Rounding allowed at the ends of the stroke range, m.
const SLACK: f64 = 1e-9;

/// The joint coordinate of one stroke, thesis (12) and its four-bar counterpart, on the branch inside the limits.
pub fn joint_from_stroke(train: &Drivetrain, limits: &JointLimits, x: f64) -> Result<f64, StrokeError> {
    let [lower, upper] = train.stroke_range(limits);
    if !(x >= lower - SLACK && x <= upper + SLACK) {
        return Err(StrokeError { cylinder: train.cylinder.name.clone(), stroke: x, lower, upper });
    }
    Ok(train.joint_from_stroke(limits, x.clamp(lower, upper)))
}
