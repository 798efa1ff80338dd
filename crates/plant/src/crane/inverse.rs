//! Joints from strokes.

use crate::crane::limits::{JointActuation, JointLimits};
use crate::errors::StrokeError;

/// Rounding allowed at the ends of the stroke range, m.
const SLACK: f64 = 1e-9;

/// The joint coordinate of one stroke, thesis (12) and its four-bar counterpart, on the branch inside the limits.
pub fn joint_from_stroke(train: &JointActuation, limits: &JointLimits, x: f64) -> Result<f64, StrokeError> {
    let [lower, upper] = train.stroke_range(limits);
    if !(x >= lower - SLACK && x <= upper + SLACK) {
        return Err(StrokeError { cylinder: train.cylinder.name.clone(), stroke: x, lower, upper });
    }
    Ok(train.joint_from_stroke(limits, x.clamp(lower, upper)))
}
