//! The model as seen from outside: every question one can ask of a machine, over slices, without its size in the
//! type. A binding or an exporter needs nothing else.
//!
//! Slices of joints, cylinders and states have the lengths that [`Model::layout`] tells; SI units throughout.

#[cfg(feature = "batch")]
use crate::batch::Kernel;
use crate::drawing::Shape;
use crate::equilibrium::EquilibriumMode;
use crate::errors::{PoseError, StrokeError};
use crate::layout::Layout;
use crate::limits::JointLimits;
use crate::outputs::OutputInfo;
use hydrocrane_control::controller::Controller;
use hydrocrane_control::inverse_kinematics::TooFewRevolute;
use hydrocrane_control::keep_out::Region;
use hydrocrane_machine::Machine;
use hydrocrane_ode::BlockArrow;

/// Most joints a chain can have here.
pub const MAX_JOINTS: usize = hydrocrane_ode::MAX_BORDER;

/// The passivity condition of one LuGre cylinder.
#[derive(Debug, Clone, PartialEq)]
pub struct Passivity {
    pub cylinder: String,
    /// Lowest speed where it fails, m/s; `None`: it holds up to `checked_to`.
    pub fails_at: Option<f64>,
    pub checked_to: f64,
}

pub trait Model: Send + Sync {
    fn machine(&self) -> &Machine;
    fn layout(&self) -> &Layout;
    fn joint_limits(&self) -> &[JointLimits];
    /// Piston positions at the joint limits, ascending.
    fn stroke_limits(&self) -> Vec<[f64; 2]>;

    /// Piston positions and their derivatives with respect to the own joint.
    fn strokes(&self, q: &[f64], x: &mut [f64], gain: &mut [f64]);
    fn joints_from_strokes(&self, x: &[f64], q: &mut [f64]) -> Result<(), StrokeError>;
    /// Direction of each cylinder from its barrel pin to its rod pin, rad from x towards z in the inertial frame.
    fn cylinder_slopes(&self, q: &[f64], slopes: &mut [f64]);
    fn tip(&self, q: &[f64]) -> [f64; 2];
    /// Centre of gravity of each moving link, (x, z) pairs in the inertial frame.
    fn centres_of_gravity(&self, q: &[f64], centres: &mut [f64]);
    /// Row-major `2 x n`.
    fn tip_jacobian(&self, q: &[f64], jacobian: &mut [f64]);
    /// `held`: coordinate given to every prismatic joint.
    fn inverse_kinematics(&self, tip: [f64; 2], held: f64) -> Result<Vec<Vec<f64>>, TooFewRevolute>;
    fn drawing(&self, q: &[f64]) -> Vec<Shape>;
    /// Closed curves around the area that the tip can reach.
    fn workspace(&self) -> Vec<Vec<[f64; 2]>>;

    /// Row-major mass matrix and bias force.
    fn equations(&self, q: &[f64], qd: &[f64], payload: f64, mass: &mut [f64], bias: &mut [f64]);
    fn forward_dynamics(&self, q: &[f64], qd: &[f64], force: &[f64], payload: f64, qdd: &mut [f64]);
    fn static_force(&self, q: &[f64], payload: f64, force: &mut [f64]);
    /// Distance of a place (x, z) from the nearest keep-out region, m, negative inside; infinite without regions.
    fn clearance(&self, place: [f64; 2]) -> f64 {
        let regions = self.machine().keep_out.iter().map(|(_, corners)| Region::new(corners.clone()));
        regions.map(|region| region.clearance(place).distance).fold(f64::INFINITY, f64::min)
    }
    /// Velocity (x, z) of the tip, m/s.
    fn tip_velocity(&self, q: &[f64], qd: &[f64]) -> [f64; 2];
    /// The tip with `payload` takes up `load` (kg) that lies still: writes the joint rates after it, tells the loss (J).
    fn attach(&self, q: &[f64], qd: &[f64], payload: f64, load: f64, rates: &mut [f64]) -> f64;
    /// Lowest and highest steady piston speed per cylinder at full spool stroke under the load at rest, in pairs.
    fn piston_speeds(&self, q: &[f64], payload: f64, speeds: &mut [f64]);
    /// (kinetic, potential), J.
    fn energies(&self, q: &[f64], qd: &[f64], payload: f64) -> (f64, f64);

    fn orifice_flow(&self, cylinder: usize, spool: f64, pressure_drop: f64) -> f64;
    fn bulk_modulus(&self, p: f64) -> f64;
    fn density(&self, p: f64) -> f64;
    /// Friction at constant velocity.
    fn steady_friction(&self, cylinder: usize, v: f64) -> f64;
    /// Per cylinder with LuGre friction.
    fn passivity(&self) -> Vec<Passivity>;

    /// Writes the state derivative.
    fn derivative(&self, x: &[f64], u: &[f64], payload: f64, dx: &mut [f64]);
    /// The derivative and its slopes.
    fn linearise(&self, x: &[f64], u: &[f64], payload: f64, dx: &mut [f64], slopes: &mut BlockArrow<f64>);
    /// Brings the derivative and its slopes at the state `x` up to other commands `u`.
    fn update_input(&self, x: &[f64], u: &[f64], dx: &mut [f64], slopes: &mut BlockArrow<f64>);
    /// Energy in the spring of the ground, J.
    fn ground_energy(&self, q: &[f64], payload: f64) -> f64;
    /// Writes the powers of the ledger, W: cylinder by cylinder its [terms](crate::LEDGER_TERMS), then
    /// [that of the ground](crate::ground_terms).
    fn powers(&self, x: &[f64], payload: f64, powers: &mut [f64]);
    /// Row-major Jacobian.
    fn jacobian(&self, x: &[f64], u: &[f64], payload: f64, jacobian: &mut [f64]) {
        let mut slopes = BlockArrow::new(self.layout().axes());
        self.linearise(x, u, payload, &mut vec![0.0; x.len()], &mut slopes);
        slopes.write_dense(x.len(), jacobian);
    }
    /// The same derivative by the readable one-function model; `None` where a law is switched to as-printed.
    fn reference_derivative(&self, x: &[f64], u: &[f64], payload: f64) -> Option<Vec<f64>>;
    /// Derivative of the state derivative by time where the commands change at `rate` (m/s).
    fn command_slope(&self, rate: &[f64], slope: &mut [f64]);
    /// Size of the estimated `error` of a step that led to the state `reached`: one where each state errs by its scale, or
    /// the density of the oil by a thousandth.
    fn error_size(&self, reached: &[f64], error: &[f64]) -> f64;
    /// Whether every piston is inside its cylinder.
    fn admissible(&self, x: &[f64]) -> bool;

    /// The same machine for groups of cranes, in the widest instruction set of this processor or the one `wanted`.
    #[cfg(feature = "batch")]
    fn kernel(&self, wanted: Option<&str>) -> Box<dyn Kernel>;

    fn output_info(&self) -> &[OutputInfo];
    fn outputs(&self, x: &[f64], payload: f64, out: &mut [f64]);
    /// The same with NaN for `energy.oil`, whose tables take longer to make than a run of a few seconds.
    fn outputs_without_oil(&self, x: &[f64], payload: f64, out: &mut [f64]);
    fn equilibrium(&self, q: &[f64], mode: EquilibriumMode, payload: f64) -> Result<Vec<f64>, PoseError>;
    /// Largest spool displacement per cylinder, m.
    fn spool_strokes(&self) -> Vec<f64>;

    /// The controller `name`, which believes this machine; the error says which there are.
    fn controller(&self, name: &str) -> Result<Box<dyn Controller>, String>;
    /// `controller` behind a monitor of the machine's sensors; its commands leave `delay` (s) after each sample.
    fn monitored(&self, controller: Box<dyn Controller>, delay: f64) -> Box<dyn Controller>;
}
