//! A model with its commands and loads: the system of the integrator.

use crate::inputs::command_path::CommandPaths;
use crate::inputs::options::RunOptions;
use crate::inputs::supply::Prescribed;
use crate::model::method_choice::jumps;
use crate::model::model_change::ModelChanges;
use crate::model::payload::Loads;
use crate::model::Model;
use hydrocrane_ode::{method, Linearisation, Stepper, System};
use hydrocrane_plant::layout::MAX_JOINTS;

/// The model with its commands, as the system of the integrator.
pub(crate) struct Driven<'a> {
    pub model: &'a dyn Model,
    pub payload: f64,
    pub loads: Loads,
    pub changes: ModelChanges<'a>,
    pub supply: Prescribed,
    /// Commands at `since` and their rates of change, constant over the present interval.
    pub base: [f64; MAX_JOINTS],
    pub slope: [f64; MAX_JOINTS],
    pub since: f64,
}

impl<'a> Driven<'a> {
    /// The model with its spools centred.
    pub fn new(model: &'a dyn Model, options: &RunOptions, since: f64) -> Self {
        Driven {
            model,
            payload: options.payload,
            loads: Loads::new(&options.payload_changes),
            changes: ModelChanges::default(),
            supply: Prescribed::new(model, options),
            base: [0.0; MAX_JOINTS],
            slope: [0.0; MAX_JOINTS],
            since,
        }
    }

    pub fn command(&self, t: f64) -> [f64; MAX_JOINTS] {
        hydrocrane_num::array::from_fn(|c| self.base[c] + self.slope[c] * (t - self.since))
    }

    /// Holds the commands from time `now` (s) on.
    pub fn hold(&mut self, now: f64) {
        (self.base, self.slope, self.since) = (self.command(now), [0.0; MAX_JOINTS], now);
    }

    /// Delivers the commands that arrive until `now` (s).
    pub fn receive(&mut self, paths: &mut CommandPaths, now: f64, stepper: &mut Stepper) {
        if paths.receive(now) {
            (self.base, self.slope, self.since) = (paths.arrived, [0.0; MAX_JOINTS], now);
            stepper.refresh();
        }
    }

    /// Picks up and releases the loads that are due at the time of `stepper`.
    pub fn change_payload(&mut self, stepper: &mut Stepper) {
        if self.loads.come_and_go(self.model, stepper.t, &mut stepper.x, &mut self.payload) {
            stepper.restart();
        }
    }
}

impl System for Driven<'_> {
    fn dimension(&self) -> usize {
        self.model.layout().len()
    }
    fn derivative(&self, t: f64, x: &[f64], dx: &mut [f64]) {
        self.model.derivative(x, &self.command(t), self.payload, dx);
        self.supply.write(dx);
    }
    fn quadrature_rates(&self, x: &[f64], dw: &mut [f64]) {
        self.model.powers(x, self.payload, dw);
    }
    fn linearise(&self, t: f64, x: &[f64], at: &mut Linearisation) {
        let (rate, jacobian) = at.block_arrow(self.model.layout().blocks(), 0);
        self.model.linearise(x, &self.command(t), self.payload, rate, &mut jacobian[0]);
        self.supply.write(rate);
    }
    fn update_input(&self, t: f64, x: &[f64], at: &mut Linearisation) {
        let (rate, jacobian) = at.block_arrow(self.model.layout().blocks(), 0);
        self.model.update_input(x, &self.command(t), rate, &mut jacobian[0]);
        self.supply.write(rate);
    }
    fn time_derivative(&self, t: f64, x: &[f64], dfdt: &mut [f64]) -> bool {
        let driven = self.slope != [0.0; MAX_JOINTS];
        if driven {
            self.model.command_derivative(x, &self.command(t), &self.slope, dfdt);
        }
        driven
    }
    fn admissible(&self, x: &[f64]) -> bool {
        self.model.admissible(x)
    }
    fn scales(&self) -> &[f64] {
        &self.model.layout().scales
    }
    fn parts(&self) -> usize {
        self.model.layout().joints()
    }
    fn narrow(&self, from: &[f64], to: &[f64], tolerances: &mut [f64]) {
        self.model.narrow(from, to, tolerances);
    }
    fn error_size(&self, from: &[f64], to: &[f64], error: &[f64]) -> f64 {
        self.model.error_size(from, to, error)
    }
}

/// A stepper at time zero; `None` if there is no such method, which [`start_fault`] detects first.
pub(crate) fn stepper(x0: &[f64], model: &dyn Model, options: &RunOptions) -> Option<Stepper> {
    let method = method(&options.method, x0.len())?;
    let stepper = Stepper::new(method, options.tolerances, 0.0, x0, options.quadratures(model));
    Some(stepper.with_control(options.control).with_jumps(jumps(model.machine())))
}
