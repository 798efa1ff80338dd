//! Errors of a machine, a pose or a stroke.

/// Supported numbers of joints.
const CHAINS: &str = if cfg!(feature = "chains") { "1 to 6" } else { "1 or 3" };

/// A machine with a valid description that cannot be simulated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BuildError {
    /// Unsupported number of joints.
    #[error("the machine has {0} joints; chains of {chains} joints can be simulated", chains = CHAINS)]
    Chain(usize),
    /// Hydraulics of mobile machines, or a chain in space, in a build for the smallest chains only.
    #[error(
        "the machine has a pump, a measured supply, compensators, curves of metering edges, separate meter-out, load-holding or port valves, or a joint with an axis \
         of its own, for which this program has no laws; plain spool valves at a constant pressure can be simulated"
    )]
    Pump,
    #[error("machine.tip lies on link `{0}`; it must lie on the last link of the chain, `{1}`")]
    TipNotOnLastLink(String, String),
    #[error("cylinder.{0}.linkage: the barrel must be pinned to the parent link `{1}` of its joint")]
    BarrelOnChild(String, String),
    #[error("link.{0}: a joint has an axis of its own, and this link has no `inertia-x` and `inertia-z`")]
    Flat(String),
    #[error("cylinder.{0}: no joint coordinate between the ends of its stroke was found; the linkage cannot close")]
    NoStroke(String),
    #[error("link.{0}: its mass or moment of inertia differs too much from those of the other links; the motion of the joints cannot be resolved in double precision")]
    Unresolvable(String),
    #[error("joint.{0}.limits: the cylinder `{1}` reverses inside these limits, so one stroke would belong to two joint coordinates; {2}")]
    DeadCentreInside(String, String, String),
    #[error("joint.{0}.limits: nowhere inside these limits is the piston of `{1}` between its ends; {2}")]
    LimitsBeyondStroke(String, String, String),
    #[error("the derivative of `{0}` is not finite in the middle of the joint limits; some value of this machine is extreme")]
    NotFinite(String),
}

/// A stroke that no joint coordinate inside the limits reaches.
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

/// A pose in which the crane cannot rest.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PoseError {
    #[error("joint {joint} is at {compared}; choose a pose inside them")]
    OutsideLimits { joint: String, compared: String },
    #[error(
        "joint `{joint}` at {coordinate:.6}: the piston of `{cylinder}` would be at {position:.4} m, \
         its ends are at {lower:.4} and {upper:.4} m; choose a pose inside the joint limits"
    )]
    OutsideStroke { joint: String, coordinate: f64, cylinder: String, position: f64, lower: f64, upper: f64 },
    #[error(
        "the tip at {tip:.3} m, with a load that hangs {hang:.3} m below it, is inside the ground, whose surface is at {surface:.3} m: \
         the ground would push with {pushed:.0} N, more than the weight of crane and load ({weight:.0} N); raise the tip"
    )]
    InTheGround { tip: f64, hang: f64, surface: f64, pushed: f64, weight: f64 },
    #[error(
        "cylinder `{cylinder}` cannot keep its pressures in this pose: it has to carry {force:.0} N, and no spool \
         opening balances its leakage between tank and supply pressure; lower the payload or choose mode \"hold\""
    )]
    NotSteady { cylinder: String, force: f64 },
}
