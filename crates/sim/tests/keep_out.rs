//! Tip control and the thesis's controller before regions and borders, with the true crane in the loop.

use hydrocrane_control::controller::Controller;
use hydrocrane_control::keep_out::{KeepOut, Region};
use hydrocrane_control::nominal::Nominal;
use hydrocrane_machine::{load, Machine, OverrideValue};
use hydrocrane_num::Draws;
use hydrocrane_sim::controllers::{build as controller, nominal};
use hydrocrane_sim::integrator::Tolerances;
use hydrocrane_sim::{
    build, simulate_sampled, EquilibriumMode, Model, OutcomeKind, RunOptions, SampledPlan, SampledRun, SensorMode,
    Sensors, StickKind, Sticks,
};
use std::sync::Arc;

const START: [f64; 3] = [1.745_329_251_994_329_5, 1.745_329_251_994_329_5, 0.0];
const PERIOD: f64 = 0.01;

/// A loop to be run: machine, controller, what the tip carries, how it is measured, what the operator does.
struct Case {
    machine: Machine,
    name: &'static str,
    start: [f64; 3],
    payload: f64,
    sensors: (SensorMode, u64),
    sticks: Sticks,
    duration: f64,
}

impl Case {
    fn new(name: &'static str, overrides: &[(&str, OverrideValue)]) -> Self {
        let overrides: Vec<_> = overrides.iter().map(|(key, value)| (key.to_string(), value.clone())).collect();
        Case {
            machine: load("rottne-f9-lab", &overrides).expect("a valid machine"),
            name,
            start: START,
            payload: 0.0,
            sensors: (SensorMode::Ideal, 0),
            sticks: Sticks::centred(StickKind::Tip, 3),
            duration: 10.0,
        }
    }

    fn held(self, times: &[f64], sticks: &[[f64; 2]]) -> Self {
        let sticks = Sticks { times: times.to_vec(), deflections: sticks.concat(), ..self.sticks };
        Case { sticks, ..self }
    }

    fn run(&self) -> Ride {
        let model = build(&self.machine).expect("a machine that can be built");
        let mut controller = controller(&self.machine, self.name).expect("a controller");
        let x0 = model.equilibrium(&self.start, EquilibriumMode::Hold, self.payload).expect("a pose to rest in");
        let sensors = Sensors::new(model.as_ref(), self.sensors.0, self.sensors.1, &[]).expect("known sensors");
        let plan = SampledPlan { sticks: self.sticks.clone(), sensors, delay: 0.0 };
        let record: Vec<f64> = (0..=(self.duration / PERIOD) as usize).map(|k| k as f64 * PERIOD).collect();
        let options = RunOptions {
            method: "rodas5p".to_string(),
            tolerances: Tolerances { relative: 1e-4, absolute: 1e-4, max_step: 0.01 },
            payload: self.payload,
            ledger: false,
            max_steps: 10_000_000,
        };
        let controller: &mut dyn Controller = controller.as_mut();
        let done =
            simulate_sampled(model.as_ref(), &x0, self.duration, controller, &plan, &record, &options, &mut |_| true);
        assert_eq!(done.run.outcome.kind, OutcomeKind::Completed, "{}", done.run.outcome.message);
        assert!(done.events.is_empty(), "{:?}", done.events);
        Ride { believed: nominal::<3>(&self.machine).expect("a nominal model"), model, done }
    }

    fn keep_out(&self) -> KeepOut {
        let regions = self.machine.keep_out.iter().map(|(_, corners)| Region::new(corners.clone())).collect();
        KeepOut { regions, margin: 0.0, rate: 0.0 }
    }
}

/// A run and what can be asked of it.
struct Ride {
    believed: Nominal<3>,
    model: Arc<dyn Model>,
    done: SampledRun,
}

impl Ride {
    fn postures(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        let n = self.model.layout().len();
        self.done.run.states.chunks_exact(n).map(|x| std::array::from_fn(|i| x[i]))
    }

    fn tips(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        self.postures().map(|q| self.model.tip(&q))
    }

    fn end(&self) -> [f64; 2] {
        self.tips().last().expect("a record")
    }

    /// Least distance of the true tip from the regions, m.
    fn nearest(&self, keep: &KeepOut) -> f64 {
        self.tips().map(|tip| keep.distance(tip)).fold(f64::INFINITY, f64::min)
    }

    /// Farthest way of a piston into an end stop's zone, m; no joint is beyond its limits.
    fn into_stops(&self) -> f64 {
        let mut over = 0.0f64;
        for q in self.postures() {
            let stroke = self.believed.posture(&q).stroke;
            for i in 0..3 {
                let [low, high] = self.believed.joint_limits[i];
                assert!(q[i] > low && q[i] < high, "joint {i} at {}", q[i]);
                let [low, high] = self.believed.cylinders[i].free;
                over = over.max(stroke[i] - high).max(low - stroke[i]);
            }
        }
        over
    }
}

/// Sticks thrown for `duration`, harder than the crane can follow; three in four downwards or inwards, where the regions are.
fn thrown(seed: u64, duration: f64) -> (Vec<f64>, Vec<[f64; 2]>) {
    let mut dice = Draws::new(seed, "sticks");
    let (mut times, mut sticks, mut t) = (Vec::new(), Vec::new(), 0.0);
    while t < duration {
        let towards = |s: f64, dice: &mut Draws| if dice.uniform() < 0.5 { -s.abs() } else { s };
        let (x, z) = (dice.symmetric(), dice.symmetric());
        times.push(t);
        sticks.push([towards(x, &mut dice), towards(z, &mut dice)]);
        t += 2.0 + 1.8 * dice.symmetric();
    }
    (times, sticks)
}

#[test]
fn random_sticks_keep_the_tip_out_of_the_regions() {
    for (payload, mode) in [
        (0.0, SensorMode::Ideal),
        (200.0, SensorMode::Ideal),
        (0.0, SensorMode::DataSheet),
        (200.0, SensorMode::DataSheet),
    ] {
        let (mut nearest, mut over, mut near) = (f64::INFINITY, 0.0f64, 0);
        for seed in 1..=3 {
            let (times, sticks) = thrown(seed, 120.0);
            let case = Case::new("tip", &[("control.tip.full-speed", OverrideValue::Number(1.0))]);
            let case = Case { payload, sensors: (mode, seed), duration: 120.0, ..case }.held(&times, &sticks);
            let (ride, keep) = (case.run(), case.keep_out());
            nearest = nearest.min(ride.nearest(&keep));
            over = over.max(ride.into_stops());
            near += ride.tips().filter(|tip| keep.distance(*tip) < 0.06).count();
        }
        println!(
            "{payload:3} kg, {mode:?}: tip no nearer than {:.1} mm, {:.1} s at a border, {:.2} mm into an end stop's zone",
            nearest * 1e3,
            near as f64 * PERIOD,
            over * 1e3
        );
        assert!(near > 100, "the sticks never led to a border");
        assert!(nearest > 0.0, "{:.1} mm inside", -1e3 * nearest);
    }
}
