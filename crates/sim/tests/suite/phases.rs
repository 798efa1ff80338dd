//! Runs in phases: what a phase takes over, what begins anew, what cannot be.

use hydrocrane_machine::{load, OverrideValue};
use hydrocrane_ode::{StepControl, Tolerances};
use hydrocrane_sim::controller::{Controller, Fault, Measurement, Stick};
use hydrocrane_sim::{
    build, simulate_phases, Driver, EquilibriumMode, Model, OutcomeKind, Phase, PhasedRun, RunOptions, SampledPlan,
    Sensors, StickKind, Sticks,
};
use std::sync::Arc;

const Q: [f64; 3] = [1.7, 1.7, 0.2];
const END: f64 = 0.1;

/// Gives one command and notes when it was begun and asked.
struct Constant {
    spool: f64,
    begun: Vec<f64>,
    asked: Vec<f64>,
}

fn constant(spool: f64) -> Constant {
    Constant { spool, begun: Vec::new(), asked: Vec::new() }
}

impl Controller for Constant {
    fn period(&self) -> f64 {
        0.01
    }
    fn reset(&mut self, first: &Measurement) {
        self.begun.push(first.t);
    }
    fn step(&mut self, measured: &Measurement, _: Stick, spool: &mut [f64]) -> Result<(), Fault> {
        self.asked.push(measured.t);
        spool.fill(self.spool);
        Ok(())
    }
    fn set_point(&self) -> Option<[f64; 2]> {
        None
    }
}

fn model(changes: &[(String, OverrideValue)]) -> Arc<dyn Model> {
    build(&load("rottne-f9-lab", changes).expect("a machine")).expect("that can be built")
}

fn run(models: [&dyn Model; 2], at: f64, controllers: [&mut Constant; 2], delay: f64) -> PhasedRun {
    let plan =
        |m: &dyn Model| SampledPlan { sticks: Sticks::centred(StickKind::Tip, 2), sensors: Sensors::ideal(m), delay };
    let options = RunOptions {
        method: "hc-rosenbrock-3".into(),
        tolerances: Tolerances { relative: 1e-4, absolute: 1e-4, max_step: 1e-3 },
        control: StepControl::Even,
        payload: 0.0,
        payload_changes: Vec::new(),
        supply: None,
        ledger: true,
        max_steps: 1_000_000,
    };
    let x0 = models[0].equilibrium(&Q, EquilibriumMode::Hold, 0.0).expect("a pose to rest in");
    let [one, two] = controllers;
    let plans = [plan(models[0]), plan(models[1])];
    let first = Phase { from: 0.0, model: models[0], changes: Vec::new(), driver: Driver::Controller(one, &plans[0]) };
    let later =
        vec![Phase { from: at, model: models[1], changes: Vec::new(), driver: Driver::Controller(two, &plans[1]) }];
    let record: Vec<f64> = (0..=100).map(|i| f64::from(i) * 1e-3).collect();
    simulate_phases(&x0, END, first, later, &record, &options, &mut |_| true)
}

#[test]
fn a_controller_begins_where_its_phase_does_and_counts_its_samples_from_there() {
    let m = model(&[]);
    let (mut one, mut two) = (constant(0.01), constant(-0.02));
    let done = run([m.as_ref(), m.as_ref()], 0.034, [&mut one, &mut two], 0.0);
    assert_eq!((one.begun, two.begun), (vec![0.0], vec![0.034]));
    assert_eq!(one.asked, [0.0, 0.01, 0.02, 0.03]);
    assert_eq!(two.asked.len(), 7);
    assert!((two.asked[6] - 0.094).abs() < 1e-12);
    assert_eq!(done.samples.iter().map(|rows| rows.times.len()).collect::<Vec<_>>(), [4, 7]);
}

#[test]
fn commands_under_way_still_arrive() {
    let m = model(&[]);
    let (mut one, mut two) = (constant(0.01), constant(-0.02));
    let done = run([m.as_ref(), m.as_ref()], 0.034, [&mut one, &mut two], 0.006).run;
    let lift: Vec<f64> = done.commands.chunks_exact(3).map(|row| row[0]).collect();
    let first = lift.iter().position(|&u| u == -0.02).expect("the second controller's command");
    // One delay after the phase began; until then the last command of the first controller holds.
    assert!(lift[first - 1] == 0.01 && done.times[first] > 0.0399, "{}", done.times[first]);
}

#[test]
fn what_cannot_follow_is_told_before_the_run() {
    let (m, other) = (model(&[]), model(&[("friction.lift.model".into(), OverrideValue::Text("static".into()))]));
    for (second, at, part) in [(&m, 0.0, "positive"), (&m, f64::NAN, "positive"), (&other, 0.05, "other states")] {
        let done = run([m.as_ref(), second.as_ref()], at, [&mut constant(0.0), &mut constant(0.0)], 0.0).run;
        assert_eq!((done.outcome.kind, done.times.len()), (OutcomeKind::BadState, 0));
        assert!(done.outcome.message.contains(part), "{}", done.outcome.message);
    }
}
