//! The monitor of the sensors: silent on every machine in order, quick when a sensor fails.

use hydrocrane_machine::{load, OverrideValue};
use hydrocrane_num::Draws;
use hydrocrane_sim::integrator::Tolerances;
use hydrocrane_sim::{
    build, controllers, monitored, simulate_sampled, EquilibriumMode, FaultKind, Model, OutcomeKind, RunOptions,
    SampledPlan, SampledRun, SensorFault, SensorMode, Sensors, StickKind, Sticks,
};
use std::sync::Arc;

/// A machine in a pose from which `tip` can drive it anywhere, with changes by key.
struct Case {
    machine: &'static str,
    pose: &'static [f64],
    changes: Vec<(String, OverrideValue)>,
    payload: f64,
    mode: SensorMode,
    delay: f64,
}

const LAB: (&str, &[f64]) = ("rottne-f9-lab", &[1.745, 1.745, 0.0]);
const LOADER: (&str, &[f64]) = ("hiab-xs031", &[0.35, -1.22, 0.3]);

impl Case {
    fn of((machine, pose): (&'static str, &'static [f64])) -> Self {
        Case { machine, pose, changes: Vec::new(), payload: 0.0, mode: SensorMode::DataSheet, delay: 0.002 }
    }

    fn with(mut self, key: &str, value: f64) -> Self {
        self.changes.push((key.to_string(), OverrideValue::Number(value)));
        self
    }

    /// Every friction force times `factor`.
    fn friction(mut self, factor: f64) -> Self {
        let machine = load(self.machine, &[]).expect("a bundled machine");
        for c in &machine.cylinders {
            for (key, values) in [("coulomb", c.friction.coulomb), ("breakaway", c.friction.breakaway), ("viscous", c.friction.viscous)] {
                let list = values.map(|v| OverrideValue::Number(v * factor)).to_vec();
                self.changes.push((format!("friction.{}.{key}", c.name), OverrideValue::List(list)));
            }
        }
        self
    }

    fn model(&self) -> Arc<dyn Model> {
        build(&load(self.machine, &self.changes).expect("a valid machine")).expect("a machine that can be built")
    }

    /// The controller believes the machine as it is in its file, but for the sampling.
    fn run(&self, name: &str, sticks: Sticks, seed: u64, end: f64, faults: &[SensorFault]) -> SampledRun {
        let model = self.model();
        let model = model.as_ref();
        let sampling: Vec<_> = self.changes.iter().filter(|(key, _)| key.starts_with("control")).cloned().collect();
        let believed = load(self.machine, &sampling).expect("a bundled machine");
        let inner = controllers::build(&believed, name).expect("a controller");
        let mut controller = monitored(&believed, inner, self.delay).expect("a monitor");
        let x0 = model.equilibrium(self.pose, EquilibriumMode::Hold, self.payload).expect("a pose to rest in");
        let sensors = Sensors::new(model, self.mode, seed, faults).expect("known signals");
        let plan = SampledPlan { sticks, sensors, delay: self.delay };
        let record: Vec<f64> = (0..=(end / 0.01) as usize).map(|i| 0.01 * i as f64).collect();
        let tolerances = Tolerances { relative: 1e-4, absolute: 1e-4, max_step: 0.05 };
        let options = RunOptions {
            method: "rodas5p".into(),
            tolerances,
            payload: self.payload,
            ledger: false,
            max_steps: 10_000_000,
        };
        simulate_sampled(model, &x0, end, controller.as_mut(), &plan, &record, &options, &mut |_| true)
    }
}

/// Random deflections of the tip's stick, held or joined, with pauses.
fn random_sticks(seed: u64, end: f64) -> Sticks {
    let mut draws = Draws::new(seed, "operator");
    let mut sticks = Sticks { linear: seed % 2 == 0, dead_zone: 0.05, ramp: 0.1, ..Sticks::centred(StickKind::Tip, 0) };
    let mut t = 0.0;
    while t < end {
        sticks.times.push(t);
        let rest = draws.uniform() < 0.2;
        sticks.deflections.extend([0; 2].map(|_| if rest { 0.0 } else { draws.symmetric() }));
        t += 0.05 + 1.5 * draws.uniform();
    }
    sticks
}

fn assert_silent(what: &str, case: &Case, name: &str, seeds: std::ops::Range<u64>, end: f64) {
    for seed in seeds {
        let done = case.run(name, random_sticks(seed, end), seed, end, &[]);
        assert_eq!(done.run.outcome.kind, OutcomeKind::Completed, "{what}, seed {seed}: {}", done.run.outcome.message);
        assert!(done.events.is_empty(), "{what}, seed {seed}: {:?}", &done.events[..done.events.len().min(3)]);
    }
}


fn tip_at(model: &dyn Model, done: &SampledRun, t: f64) -> [f64; 2] {
    let row = done.run.times.iter().position(|at| *at >= t - 1e-9).expect("a time of the run");
    model.tip(&done.run.states[row * model.layout().len()..][..3])
}


#[test]
fn explore() {
    let mut cases = vec![];
    for place in [LAB, LOADER] {
        for period in [0.005, 0.02, 0.05] { cases.push((format!("{} period {period}", place.0), "tip", Case::of(place).with("control.period", period))); }
        cases.push((format!("{} ideal", place.0), "tip", Case { mode: SensorMode::Ideal, ..Case::of(place) }));
        cases.push((format!("{} delay", place.0), "tip", Case { delay: 0.015, ..Case::of(place) }));
        for (key, unit) in [("fluid.bulk-modulus-max", 0.8), ("fluid.bulk-modulus-max", 1.2)] { let _ = (key, unit); }
        for f in [0.85, 1.15] {
            let m = load(place.0, &[]).unwrap();
            let mut case = Case::of(place);
            for c in &m.cylinders { case = case.with(&format!("valve.{}.nominal-flow", c.valve.name), c.valve.nominal_flow * f); }
            cases.push((format!("{} flow {f}", place.0), "tip", case));
            cases.push((format!("{} supply {f}", place.0), "tip", Case::of(place).with("supply.pressure", m.supply.pressure * f)));
        }
        cases.push((format!("{} pid", place.0), "heinze-pid", Case::of(place)));
        cases.push((format!("{} pid 10ms", place.0), "heinze-pid", Case::of(place).with("control.period", 0.01)));
    }
    cases.push(("printed tip".into(), "tip", Case::of(("heinze-2007", &[1.745, 1.745, 0.0]))));
    cases.push(("single tip".into(), "tip", Case::of(("single-cylinder", &[0.0]))));
    for (what, name, case) in cases {
        for seed in 0..4 {
            let done = case.run(name, random_sticks(seed, 20.0), seed, 20.0, &[]);
            println!("{what} {seed}: {:?} {} events {:?}", done.run.outcome.kind, done.events.len(), done.events.iter().take(2).map(|e| format!("{:.2} {}", e.time, &e.text[..90.min(e.text.len())])).collect::<Vec<_>>());
        }
    }
}
