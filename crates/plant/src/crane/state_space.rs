//! The crane as a system of ordinary differential equations x' = f(x, u) with outputs and an energy ledger.
//!
//! Slices of joints, cylinders and states have the lengths of the layout; SI units throughout.

use crate::crane::limits::outside_limits;
use crate::crane::{array, Crane};
use crate::equations::laws::Moment;
#[cfg(feature = "output-derivatives")]
use crate::equations::outputs;
use crate::equations::outputs::OutputInfo;
#[cfg(feature = "output-derivatives")]
use crate::equations::rhs::Evaluator;
use crate::errors::PoseError;
use crate::layout::Layout;
use crate::precision::stiffness;
#[cfg(feature = "reference")]
use crate::reference;
use crate::resting::rest::EquilibriumMode;
use hydrocrane_machine::Machine;
#[cfg(feature = "output-derivatives")]
use hydrocrane_num::Dual;
use hydrocrane_ode::BlockArrow;
use hydrocrane_physics::dynamics::equations_of_motion::RigidChain;

/// A number with its derivative along a direction of the state.
#[cfg(feature = "output-derivatives")]
type Along = Dual<f64, 1>;

pub trait StateSpace: Send + Sync {
    fn machine(&self) -> &Machine;
    fn layout(&self) -> &Layout;
    /// Writes the state derivative.
    fn derivative(&self, x: &[f64], u: &[f64], payload: f64, dx: &mut [f64]);
    /// Writes the state derivative and its Jacobian.
    fn linearise(&self, x: &[f64], u: &[f64], payload: f64, dx: &mut [f64], jacobian: &mut BlockArrow<f64>);
    /// Updates the derivative and its Jacobian at the state `x` to other commands `u`.
    fn update_input(&self, x: &[f64], u: &[f64], dx: &mut [f64], jacobian: &mut BlockArrow<f64>);
    /// Energy in the spring of the ground, J.
    fn ground_energy(&self, q: &[f64], payload: f64) -> f64;
    /// Writes the powers of the ledger, W: cylinder by cylinder its [terms](crate::LEDGER_TERMS), then
    /// [those of ground and supply](crate::shared_terms).
    fn powers(&self, x: &[f64], payload: f64, powers: &mut [f64]);
    /// Row-major Jacobian.
    fn jacobian(&self, x: &[f64], u: &[f64], payload: f64, jacobian: &mut [f64]) {
        let mut blocks = BlockArrow::new(self.layout().blocks());
        self.linearise(x, u, payload, &mut vec![0.0; x.len()], &mut blocks);
        blocks.write_dense(x.len(), jacobian);
    }
    /// The same derivative by the readable one-function model; `None` if a law is switched to as-printed.
    #[cfg(feature = "reference")]
    fn reference_derivative(&self, x: &[f64], u: &[f64], payload: f64) -> Option<Vec<f64>>;
    /// Time derivative of the state derivative for commands `u` that change at `rate` (m/s).
    fn command_derivative(&self, x: &[f64], u: &[f64], rate: &[f64], dfdt: &mut [f64]);
    /// Size of the estimated `error` of a step `from` one state `to` another: one if the error of each state is its scale,
    /// or that of the oil's density a thousandth.
    fn error_size(&self, from: &[f64], to: &[f64], error: &[f64]) -> f64;
    /// Narrows the `tolerances` of pressures where a step `from` one state `to` another passes soft oil.
    fn narrow(&self, from: &[f64], to: &[f64], tolerances: &mut [f64]);
    /// Whether every piston is inside its cylinder.
    fn admissible(&self, x: &[f64]) -> bool;
    fn output_info(&self) -> &[OutputInfo];
    fn outputs(&self, x: &[f64], payload: f64, out: &mut [f64]);
    /// The same with NaN for `energy.oil`, whose tables take longer to build than a run of a few seconds.
    fn outputs_without_oil(&self, x: &[f64], payload: f64, out: &mut [f64]);
    /// Writes the exact directional derivatives of the outputs `along` a direction of the state; NaN for `energy.oil`.
    #[cfg(feature = "output-derivatives")]
    fn output_derivatives(&self, x: &[f64], along: &[f64], payload: f64, out: &mut [f64]);
    fn equilibrium(&self, q: &[f64], mode: EquilibriumMode, payload: f64) -> Result<Vec<f64>, PoseError>;
}

impl<const N: usize> StateSpace for Crane<N> {
    fn machine(&self) -> &Machine {
        &self.machine
    }

    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn derivative(&self, x: &[f64], u: &[f64], payload: f64, dx: &mut [f64]) {
        self.laws.derivative(Moment { layout: &self.layout, x, u, payload }, dx);
    }

    fn linearise(&self, x: &[f64], u: &[f64], payload: f64, dx: &mut [f64], jacobian: &mut BlockArrow<f64>) {
        self.laws.linearise(Moment { layout: &self.layout, x, u, payload }, dx, jacobian);
    }

    fn update_input(&self, x: &[f64], u: &[f64], dx: &mut [f64], jacobian: &mut BlockArrow<f64>) {
        self.laws.update_input(x, u, dx, jacobian);
    }

    fn ground_energy(&self, q: &[f64], payload: f64) -> f64 {
        let mechanics = &self.plant().mechanics;
        let tip = mechanics.tip_position(&mechanics.pose(&array::<N>(q)));
        self.plant().ground.as_ref().map_or(0.0, |ground| ground.energy(tip, payload))
    }

    fn powers(&self, x: &[f64], payload: f64, powers: &mut [f64]) {
        self.laws.powers(&self.layout, self.oil(), x, payload, powers);
    }

    #[cfg(feature = "reference")]
    fn reference_derivative(&self, x: &[f64], u: &[f64], payload: f64) -> Option<Vec<f64>> {
        reference::state_derivative(&self.machine, x, u, payload)
    }

    fn command_derivative(&self, x: &[f64], u: &[f64], rate: &[f64], dfdt: &mut [f64]) {
        self.plant().command_derivative(&self.layout, x, u, rate, dfdt);
    }

    fn error_size(&self, from: &[f64], to: &[f64], error: &[f64]) -> f64 {
        self.precision.mean_square(&self.plant().fluid, &self.layout, from, to, |i| error[i]).sqrt()
    }

    fn narrow(&self, from: &[f64], to: &[f64], tolerances: &mut [f64]) {
        for i in self.layout.pressures() {
            tolerances[i] *= stiffness(&self.plant().fluid, from[i], to[i]);
        }
    }

    fn admissible(&self, x: &[f64]) -> bool {
        let q: [f64; N] = hydrocrane_num::array::from_fn(|i| x[self.layout.q(i)]);
        q.iter().zip(&self.safe).all(|(q, [lower, upper])| lower <= q && q <= upper) || self.fits(&q)
    }

    fn output_info(&self) -> &[OutputInfo] {
        &self.outputs
    }

    fn outputs(&self, x: &[f64], payload: f64, out: &mut [f64]) {
        self.write_outputs(Some(self.oil()), x, payload, out);
    }

    fn outputs_without_oil(&self, x: &[f64], payload: f64, out: &mut [f64]) {
        self.write_outputs(None, x, payload, out);
    }

    #[cfg(feature = "output-derivatives")]
    fn output_derivatives(&self, x: &[f64], along: &[f64], payload: f64, out: &mut [f64]) {
        let plant = self.plant().map(&mut |number| Along::constant(*number));
        let evaluator = Evaluator::<Along, Along, N>::new(&plant, &self.layout);
        let moving = |(&value, &along): (&f64, &f64)| Along { value, derivative: [along] };
        let x: Vec<Along> = x.iter().zip(along).map(moving).collect();
        let mut outputs = vec![Along::constant(0.0); out.len()];
        let at = evaluator.evaluated(&self.layout, &x, Along::constant(payload));
        outputs::write(&plant, None::<fn(Along) -> Along>, &at, &mut outputs);
        out.iter_mut().zip(outputs).for_each(|(out, output)| *out = output.derivative[0]);
    }

    fn equilibrium(&self, q: &[f64], mode: EquilibriumMode, payload: f64) -> Result<Vec<f64>, PoseError> {
        if let Some((joint, compared)) = outside_limits(&self.machine.joints, &self.limits, q) {
            return Err(PoseError::OutsideLimits { joint, compared });
        }
        let q = self.on_the_stops(array::<N>(q), payload);
        self.require_above_the_ground(&q, payload)?;
        self.plant().rest(&self.machine, &self.layout, &q, mode, payload)
    }
}
