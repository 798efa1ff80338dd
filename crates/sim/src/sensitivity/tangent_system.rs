//! The driven crane with the derivatives of its states by parameters: s' = J s + df/dp, by dual numbers.

use super::inputs::{Differentiated, Inputs, WIDTH};
use crate::event_loop::driven::Driven;
use crate::event_loop::Stepped;
use crate::model::payload::{picks_up, PayloadEvent};
use hydrocrane_num::Field;
use hydrocrane_ode::BlockArrow;
use hydrocrane_ode::System;
use hydrocrane_ode::{Linearisation, Stepper};
use hydrocrane_plant::equations::rhs::Evaluator;
use hydrocrane_plant::layout::Layout;
use hydrocrane_plant::layout::MAX_JOINTS;
use std::cell::RefCell;

/// Up to [`WIDTH`] parameters of one pass with dual numbers.
pub struct Group<const N: usize> {
    pub inputs: Inputs<Differentiated, N>,
    pub evaluator: Evaluator<Differentiated, Differentiated, N>,
    /// Index of the first of them, and how many there are.
    pub first: usize,
    pub count: usize,
}

impl<const N: usize> Group<N> {
    /// Groups for all `parameters`, given the inputs with the derivatives of each group.
    pub fn all(inputs: Vec<Inputs<Differentiated, N>>, parameters: usize, layout: &Layout) -> Vec<Self> {
        let group = |(i, inputs): (usize, Inputs<Differentiated, N>)| {
            let (first, count) = (i * WIDTH, WIDTH.min(parameters - i * WIDTH));
            Group { evaluator: Evaluator::new(&inputs.plant, layout), inputs, first, count }
        };
        inputs.into_iter().enumerate().map(group).collect()
    }

    /// State and tangents, consecutive in `x`, as dual numbers.
    pub fn read(&self, x: &[f64], n: usize, duals: &mut [Differentiated]) {
        for (i, dual) in duals.iter_mut().enumerate() {
            dual.value = x[i];
            for k in 0..self.count {
                dual.derivative[k] = x[(1 + self.first + k) * n + i];
            }
        }
    }

    /// Payload, kg. After its first change it is the mass that the scenario states, whatever the machine carried before.
    pub fn payload(&self, driven: &Driven) -> Differentiated {
        if driven.loads.done() == 0 {
            self.inputs.payload
        } else {
            Differentiated::c(driven.payload)
        }
    }

    /// The effect of a change of the payload on a state; `before` is the payload until then, kg. Returns that from then on.
    fn change_payload(
        &self,
        layout: &Layout,
        state: &mut [Differentiated],
        before: Differentiated,
        change: &PayloadEvent,
    ) -> Differentiated {
        let after = Differentiated::c(change.mass[1]);
        if picks_up(change.mass) {
            let [q, qd] = [layout.q(0), layout.qd(0)];
            let pose: [Differentiated; N] = hydrocrane_num::array::from_fn(|i| state[q + i]);
            let rates: [Differentiated; N] = hydrocrane_num::array::from_fn(|i| state[qd + i]);
            let plant = &self.inputs.plant;
            let attached = plant.attach(&plant.mechanics.pose(&pose), &rates, before, after - before);
            state[qd..qd + N].copy_from_slice(&attached.rates);
        }
        after
    }

    /// The reverse of [`Group::read`].
    pub fn write(&self, duals: &[Differentiated], x: &mut [f64]) {
        let n = duals.len();
        for (i, dual) in duals.iter().enumerate() {
            x[i] = dual.value;
            for k in 0..self.count {
                x[(1 + self.first + k) * n + i] = dual.derivative[k];
            }
        }
    }
}

/// Working space of one evaluation.
struct Scratch {
    x: Vec<Differentiated>,
    rate: Vec<Differentiated>,
    jacobian: BlockArrow<Differentiated>,
}

pub struct TangentSystem<'a, const N: usize> {
    pub driven: Driven<'a>,
    /// Of the machine at the start, then after each change of it.
    groups: &'a [Vec<Group<N>>],
    scales: Vec<f64>,
    scratch: RefCell<Scratch>,
}

impl<'a, const N: usize> TangentSystem<'a, N> {
    /// `sizes` of the parameters, for the scales of the tangents in step control; empty: only the states count.
    pub fn new(driven: Driven<'a>, groups: &'a [Vec<Group<N>>], sizes: &[f64]) -> Self {
        let states = &driven.model.layout().scales;
        let n = states.len();
        let of_tangents = sizes.iter().flat_map(|size| states.iter().map(move |scale| scale / size));
        let scales = states.iter().copied().chain(of_tangents).collect();
        let zeros = |count: usize| vec![Differentiated::c(0.0); count];
        let scratch = RefCell::new(Scratch {
            x: zeros(n),
            rate: zeros(n),
            jacobian: BlockArrow::new(driven.model.layout().blocks()),
        });
        TangentSystem { driven, groups, scales, scratch }
    }

    /// Those of the machine now.
    fn groups(&self) -> &'a [Group<N>] {
        &self.groups[self.driven.changes.done()]
    }

    fn layout(&self) -> &Layout {
        self.driven.model.layout()
    }

    fn command(&self, t: f64) -> [Differentiated; MAX_JOINTS] {
        self.driven.command(t).map(Differentiated::c)
    }
}

impl<'a, const N: usize> Stepped<'a> for TangentSystem<'a, N> {
    fn system(&self) -> &dyn System {
        self
    }
    fn driven(&self) -> &Driven<'a> {
        &self.driven
    }
    fn driven_mut(&mut self) -> &mut Driven<'a> {
        &mut self.driven
    }

    /// The tangents jump by the derivative of the law by which the state jumps.
    fn change_payload(&mut self, stepper: &mut Stepper) {
        if !self.driven.loads.are_due(stepper.t) {
            return;
        }
        let before = stepper.x.clone();
        let payloads: Vec<Differentiated> = self.groups().iter().map(|group| group.payload(&self.driven)).collect();
        let first = self.driven.loads.events.len();
        self.driven.change_payload(stepper);
        let events = &self.driven.loads.events[first..];
        let layout = self.driven.model.layout();
        let Scratch { x: state, .. } = &mut *self.scratch.borrow_mut();
        for (group, payload) in self.groups().iter().zip(payloads) {
            group.read(&before, layout.len(), state);
            events.iter().fold(payload, |payload, change| group.change_payload(layout, state, payload, change));
            group.write(state, &mut stepper.x);
        }
    }
}

impl<const N: usize> System for TangentSystem<'_, N> {
    fn dimension(&self) -> usize {
        self.layout().len() * (1 + self.tangents())
    }
    fn tangents(&self) -> usize {
        self.groups().iter().map(|group| group.count).sum()
    }

    fn derivative(&self, t: f64, x: &[f64], dx: &mut [f64]) {
        let (layout, u) = (self.layout(), self.command(t));
        let Scratch { x: state, rate, .. } = &mut *self.scratch.borrow_mut();
        for group in self.groups() {
            group.read(x, layout.len(), state);
            group.evaluator.derivative(layout, state, &u, group.payload(&self.driven), rate);
            group.write(rate, dx);
        }
        self.driven.supply.write(dx);
    }

    fn linearise(&self, t: f64, x: &[f64], at: &mut Linearisation) {
        let (layout, u) = (self.layout(), self.command(t));
        let Scratch { x: state, rate, jacobian } = &mut *self.scratch.borrow_mut();
        let (rates, blocks) = at.block_arrow(layout.blocks(), self.tangents());
        jacobian.secants = blocks[0].secants;
        for group in self.groups() {
            let Group { evaluator, first, count, .. } = group;
            group.read(x, layout.len(), state);
            evaluator.linearise(layout, state, &u, group.payload(&self.driven), rate, jacobian);
            group.write(rate, rates);
            spread(jacobian, *first, *count, blocks);
        }
        self.driven.supply.write(rates);
    }

    fn time_derivative(&self, t: f64, x: &[f64], dfdt: &mut [f64]) -> bool {
        if self.driven.slope == [0.0; MAX_JOINTS] {
            return false;
        }
        let (layout, u) = (self.layout(), self.command(t));
        let slope = self.driven.slope.map(Differentiated::c);
        let Scratch { x: state, rate, .. } = &mut *self.scratch.borrow_mut();
        for group in self.groups() {
            group.read(x, layout.len(), state);
            group.inputs.plant.command_derivative(layout, state, &u, &slope, rate);
            group.write(rate, dfdt);
        }
        true
    }

    fn admissible(&self, x: &[f64]) -> bool {
        self.driven.model.admissible(&x[..self.layout().len()])
    }
    fn scales(&self) -> &[f64] {
        &self.scales
    }
    fn parts(&self) -> usize {
        self.layout().joints()
    }
    fn narrow(&self, from: &[f64], to: &[f64], tolerances: &mut [f64]) {
        self.driven.model.narrow(from, to, tolerances);
    }
    fn error_size(&self, from: &[f64], to: &[f64], error: &[f64]) -> f64 {
        let n = self.layout().len();
        self.driven.model.error_size(&from[..n], &to[..n], &error[..n])
    }
}

/// Writes the blocks of the state, and those of its derivatives by `count` parameters from the `first` on.
fn spread(jacobian: &BlockArrow<Differentiated>, first: usize, count: usize, blocks: &mut [BlockArrow<f64>]) {
    blocks[0] = jacobian.map(|number| number.value);
    for k in 0..count {
        blocks[1 + first + k] = jacobian.along(|number| number.value, |number| number.derivative[k]);
    }
}
