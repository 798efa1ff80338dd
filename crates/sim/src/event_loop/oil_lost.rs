//! Oil that leaves through hoses that leak: what a run has lost of it.

use crate::event_loop::driven::Driven;
use hydrocrane_machine::model::Cylinder;
use hydrocrane_ode::Stepper;

/// Volumes lost since the start, a pair per cylinder: piston side, rod side.
pub(crate) struct OilLost {
    /// m^3
    pub volumes: Vec<f64>,
    /// m^3/s at the time `since` (s).
    flows: Vec<f64>,
    since: f64,
    outputs: Vec<f64>,
    /// Places of these flows among the outputs.
    columns: Vec<usize>,
}

impl OilLost {
    /// `None` where no hose can leak. Builds for the smallest chains only have none.
    pub fn new(stepper: &Stepper, driven: &Driven) -> Option<Self> {
        if !cfg!(feature = "chains") || !driven.model.machine().cylinders.iter().any(Cylinder::has_hose_leak) {
            return None;
        }
        let names = driven.model.output_info().iter().map(|info| info.name.as_str());
        let lost = |(_, name): &(usize, &str)| name.ends_with(".lost1") || name.ends_with(".lost2");
        let columns: Vec<usize> = names.enumerate().filter(lost).map(|(i, _)| i).collect();
        let none = vec![0.0; columns.len()];
        let outputs = vec![0.0; driven.model.output_info().len()];
        let mut lost = OilLost { volumes: none.clone(), flows: none, since: stepper.t, outputs, columns };
        lost.begin(stepper, driven);
        Some(lost)
    }

    /// Flows from the state of `stepper` on, after a change of the machine.
    pub fn begin(&mut self, stepper: &Stepper, driven: &Driven) {
        driven.model.outputs_without_oil(&stepper.x, driven.payload, &mut self.outputs);
        self.flows.iter_mut().zip(&self.columns).for_each(|(flow, at)| *flow = self.outputs[*at]);
        self.since = stepper.t;
    }

    /// Adds what has left over the last step, by the trapezoidal rule.
    pub fn add(&mut self, stepper: &Stepper, driven: &Driven) {
        let (before, began) = (self.flows.clone(), self.since);
        self.begin(stepper, driven);
        let time = 0.5 * (stepper.t - began);
        for (volume, (before, now)) in self.volumes.iter_mut().zip(before.iter().zip(&self.flows)) {
            *volume += time * (before + now);
        }
    }
}
