//! Tip control and the thesis's controller before regions and borders, with the true crane in the loop.

use hydrocrane_control::interface::controller::{Controller, Measurement, Stick};
use hydrocrane_control::model::controller_model::ControllerModel;
use hydrocrane_control::reference::keep_out::{KeepOut, Region};
use hydrocrane_machine::{load, Machine, OverrideValue};
use hydrocrane_num::RandomStream;
use hydrocrane_ode::{StepControl, Tolerances};
use hydrocrane_sim::controller_model;
use hydrocrane_sim::{
    build, simulate_sampled, Crane, EquilibriumMode, Model, OutcomeKind, RunOptions, SampledPlan, SampledRun,
    SensorMode, Sensors, StickKind, Sticks,
};
use std::sync::Arc;
use std::time::Instant;

const START: [f64; 3] = [1.745_329_251_994_329_5, 1.745_329_251_994_329_5, 0.0];
const PERIOD: f64 = 0.01;
/// What the controllers keep by default, m.
const MARGIN: f64 = 0.05;

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
            sticks: Sticks::centred(StickKind::Tip, 2),
            duration: 10.0,
        }
    }

    fn held(self, times: &[f64], sticks: &[[f64; 2]]) -> Self {
        let sticks = Sticks { times: times.to_vec(), deflections: sticks.concat(), ..self.sticks };
        Case { sticks, ..self }
    }

    fn run(&self) -> Finished {
        let model = build(&self.machine).expect("a machine that can be built");
        let mut controller = model.controller(self.name).expect("a controller");
        let x0 = model.equilibrium(&self.start, EquilibriumMode::Hold, self.payload).expect("a pose to rest in");
        let sensors = Sensors::new(model.as_ref(), self.sensors.0, self.sensors.1, &[]).expect("known sensors");
        let plan = SampledPlan { sticks: self.sticks.clone(), sensors, delay: 0.0 };
        let record: Vec<f64> = (0..=(self.duration / PERIOD) as usize).map(|k| k as f64 * PERIOD).collect();
        let options = RunOptions {
            payload_changes: Vec::new(),
            supply: None,
            method: "rodas5p".to_string(),
            tolerances: Tolerances { relative: 1e-4, absolute: 1e-4, max_step: 0.01 },
            control: StepControl::Adaptive,
            payload: self.payload,
            ledger: false,
            max_steps: 10_000_000,
        };
        let controller: &mut dyn Controller = controller.as_mut();
        let done =
            simulate_sampled(model.as_ref(), &x0, self.duration, controller, &plan, &record, &options, &mut |_| true);
        assert_eq!(done.run.outcome.kind, OutcomeKind::Completed, "{}", done.run.outcome.message);
        // A tip that stands may say so.
        assert!(done.events.iter().all(|e| e.text.starts_with("the tip stands")), "{:?}", done.events);
        Finished {
            known: controller_model(&Crane::new(&self.machine).expect("a machine that can be built")),
            model,
            done,
        }
    }

    fn keep_out(&self) -> KeepOut {
        let regions = self.machine.keep_out.iter().map(|(_, corners)| Region::new(corners.clone())).collect();
        KeepOut { regions, margin: 0.0, rate: 0.0 }
    }
}

/// A run and what can be asked of it.
struct Finished {
    known: ControllerModel<3>,
    model: Arc<dyn Model>,
    done: SampledRun,
}

impl Finished {
    fn postures(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        let n = self.model.layout().len();
        self.done.run.states.chunks_exact(n).map(|x| std::array::from_fn(|i| x[i]))
    }

    fn tips(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        self.postures().map(|q| self.model.tip_in_plane(&q))
    }

    fn end(&self) -> [f64; 2] {
        self.tips().last().expect("a record")
    }

    /// Least distance of the true tip from the regions, m.
    fn nearest(&self, keep: &KeepOut) -> f64 {
        self.tips().map(|tip| keep.distance(tip)).fold(f64::INFINITY, f64::min)
    }

    /// Farthest travel of a piston into an end stop's zone, m; no joint is beyond its limits.
    fn deepest_in_a_stop(&self) -> f64 {
        let mut over = 0.0f64;
        for q in self.postures() {
            let stroke = self.known.posture(&q).stroke;
            for i in 0..3 {
                let [low, high] = self.known.joint_limits[i];
                assert!(q[i] > low && q[i] < high, "joint {i} at {}", q[i]);
                let [low, high] = self.known.cylinders[i].free;
                over = over.max(stroke[i] - high).max(low - stroke[i]);
            }
        }
        over
    }
}

/// Sticks thrown for `duration`, harder than the crane can follow; three in four downwards or inwards, where the regions are.
fn thrown(seed: u64, duration: f64) -> (Vec<f64>, Vec<[f64; 2]>) {
    let mut random = RandomStream::new(seed, "sticks");
    let (mut times, mut sticks, mut t) = (Vec::new(), Vec::new(), 0.0);
    while t < duration {
        let towards = |s: f64, random: &mut RandomStream| if random.uniform() < 0.5 { -s.abs() } else { s };
        let (x, z) = (random.symmetric(), random.symmetric());
        times.push(t);
        sticks.push([towards(x, &mut random), towards(z, &mut random)]);
        t += 2.0 + 1.8 * random.symmetric();
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
            let (run, keep) = (case.run(), case.keep_out());
            nearest = nearest.min(run.nearest(&keep));
            over = over.max(run.deepest_in_a_stop());
            near += run.tips().filter(|tip| keep.distance(*tip) < 0.06).count();
        }
        println!(
            "{payload:3} kg, {mode:?}: tip no nearer than {:.1} mm, {:.1} s at a border, {:.2} mm into an end stop's zone",
            nearest * 1e3,
            near as f64 * PERIOD,
            over * 1e3
        );
        assert!(near > 100, "the sticks never led to a border");
        assert!(nearest > MARGIN - 0.01, "{:.1} mm from a region", 1e3 * nearest);
        assert!(over < 0.001, "{:.2} mm into an end stop's zone", 1e3 * over);
    }
}

#[test]
fn the_tip_stops_above_the_ground_and_leaves_it_as_the_stick_says() {
    let slow = [("control.tip.full-speed", OverrideValue::Number(0.2))];
    let case = Case::new("tip", &slow).held(&[0.0, 12.0, 15.0], &[[0.3, -1.0], [-1.0, 0.0], [0.0, 1.0]]);
    let case = Case { duration: 17.0, ..case };
    let run = case.run();
    let at = |t: f64| run.tips().nth((t / PERIOD).round() as usize).expect("a sample");
    let ground = |t: f64| at(t)[1] + 1.21;
    println!("{:.4} m and {:.4} m above the ground after 11 s and 12 s", ground(11.0), ground(12.0));
    assert!((ground(12.0) - MARGIN).abs() < 0.001 && (at(12.0)[0] - at(11.0)[0]).abs() < 0.001, "slides");
    let (along, up) = (at(12.0)[0] - at(15.0)[0], at(17.0)[1] - at(15.0)[1]);
    println!("then {along:.3} m along it in 3 s and {up:.3} m up in 2 s");
    // At 0.2 m/s, less the two lags of the stick.
    assert!(along > 0.5 && up > 0.34 && (ground(15.0) - ground(12.0)).abs() < 0.005);
}

/// A pose whose tip lies in a region: the way out is open, the way in is not.
#[test]
fn from_inside_a_region_the_tip_only_leaves() {
    let slow = [("control.tip.full-speed", OverrideValue::Number(0.2))];
    let inside = [0.9, 1.4, 0.0];
    let leave = Case { start: inside, duration: 3.0, ..Case::new("tip", &slow) }.held(&[0.0], &[[0.0, 1.0]]);
    let enter = Case { start: inside, duration: 3.0, ..Case::new("tip", &slow) }.held(&[0.0], &[[0.0, -1.0]]);
    let (keep, way) = (leave.keep_out(), |run: &Finished| run.end()[1] - run.tips().next().expect("a start")[1]);
    let (out, deeper) = (leave.run(), enter.run());
    println!("starts {:.3} m from the border; {:.3} m up, {:.4} m down", out.nearest(&keep), way(&out), way(&deeper));
    assert!(out.nearest(&keep) < -0.1 && way(&out) > 0.2 && way(&deeper).abs() < 0.002);
}

/// The thesis's controller, sampled at 1 ms, 0.2 m/s at full stick; `more` below `control.heinze-pid`.
fn thesis_controller(more: &[(&str, OverrideValue)], stick: [f64; 2]) -> Case {
    let speed = ("full-speed", OverrideValue::Number(0.2));
    let keys: Vec<_> =
        more.iter().chain([&speed]).map(|(k, v)| (format!("control.heinze-pid.{k}"), v.clone())).collect();
    let period = ("control.period", OverrideValue::Number(1e-3));
    let overrides: Vec<_> = keys.iter().map(|(k, v)| (k.as_str(), v.clone())).chain([period]).collect();
    Case { duration: 20.0, ..Case::new("heinze-pid", &overrides) }.held(&[0.0], &[stick])
}

fn in_plane(places: &[[f64; 3]]) -> Vec<[f64; 2]> {
    places.iter().map(|[x, _, z]| [*x, *z]).collect()
}

/// Largest step of the set-point's speed from sample to sample once it moves, and its speed at the end, m/s.
fn speeds(points: &[[f64; 2]]) -> (f64, f64) {
    let steps: Vec<f64> = points.windows(2).map(|p| (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1]) / 1e-3).collect();
    let jump = steps.windows(2).map(|s| (s[1] - s[0]).abs()).fold(0.0, f64::max);
    (jump, steps[steps.len() - 1])
}

#[test]
fn the_set_point_of_the_thesis_controller_stops_smoothly_in_the_working_area() {
    for (stick, name) in [([0.0, 1.0], "up"), ([0.0, -1.0], "down"), ([1.0, 0.0], "out"), ([-1.0, 0.0], "in")] {
        let case = thesis_controller(&[], stick);
        let (run, keep) = (case.run(), case.keep_out());
        let points = &in_plane(&run.done.samples.set_points);
        let nearest = points.iter().map(|p| keep.distance(*p)).fold(f64::INFINITY, f64::min);
        let [from, to] = [points[0], points[points.len() - 1]];
        let way = (to[0] - from[0]) * stick[0] + (to[1] - from[1]) * stick[1];
        let (jump, last) = speeds(points);
        let over = run.deepest_in_a_stop();
        println!(
            "{name:4}: {way:.3} m of 4 m, {:.1} mm from a region; speed steps by {:.2} mm/s and ends at {:.4} mm/s; {:.2} mm \
             into an end stop's zone",
            nearest * 1e3,
            jump * 1e3,
            last * 1e3,
            over * 1e3
        );
        assert!(way > 0.8 && way < 2.2 && nearest > MARGIN - 1e-6);
        assert!(jump < 0.001 && last < 0.001, "stops with a jolt");
        // The set-point keeps off the end stops; the PID overshoots it.
        assert!(over < 0.005);
    }
    let printed = thesis_controller(&[("working-area", OverrideValue::Text("none".into()))], [0.0, -1.0]);
    let points = in_plane(&printed.run().done.samples.set_points);
    assert!(printed.keep_out().distance(points[points.len() - 1]) < -0.5, "the program has no working area");
}

#[test]
fn a_leaping_set_point_is_accepted_or_stays() {
    let seldom = [("set-point-interval", OverrideValue::Number(5.0))];
    // 1 m down ends in the margin of the ground, 1 m out beyond the reach, half of either does not.
    for (stick, way) in [([0.0, -1.0], 0.0), ([1.0, 0.0], 0.0), ([0.0, -0.5], 0.5), ([0.5, 0.0], 0.5)] {
        let run = Case { duration: 1.0, ..thesis_controller(&seldom, stick) }.run();
        let (from, to) = (run.tips().next().expect("a start"), in_plane(&run.done.samples.set_points)[0]);
        let leap = (to[0] - from[0]).hypot(to[1] - from[1]);
        assert!((leap - way).abs() < 1e-9, "{stick:?}: {leap}");
    }
}

#[test]
fn the_penalty_moves_the_telescope_when_boom_and_jib_do_not_reach() {
    let run = |extension: &str| {
        let searched = [("extension", OverrideValue::Text(extension.into()))];
        thesis_controller(&searched, [1.0, 0.0]).held(&[0.0, 15.0], &[[1.0, 0.0], [0.0, 0.0]]).run()
    };
    let [fixed, searched] = ["zero", "penalty"].map(run);
    let telescope = |run: &Finished, t: f64| run.postures().nth((t / PERIOD).round() as usize).expect("a sample")[2];
    for (run, name) in [(&fixed, "zero"), (&searched, "penalty")] {
        println!(
            "{name:7}: reaches x = {:.3} m, telescope at {:.3} m, {:.2} mm into an end stop's zone",
            run.end()[0],
            telescope(run, 20.0),
            run.deepest_in_a_stop() * 1e3
        );
        assert!(run.deepest_in_a_stop() < 0.01);
    }
    assert!(telescope(&fixed, 20.0).abs() < 0.002 && telescope(&searched, 20.0) > 0.2);
    assert!(searched.end()[0] > fixed.end()[0] + 0.2);
    assert!((telescope(&searched, 20.0) - telescope(&searched, 17.0)).abs() < 0.005, "creeps with the stick centred");
}

#[test]
#[ignore = "a benchmark: run it alone and optimised"]
fn one_step_of_the_penalty_search_takes_less_than_a_period() {
    let case = thesis_controller(&[("extension", OverrideValue::Text("penalty".into()))], [1.0, 0.0]);
    let crane = Crane::<3>::new(&case.machine).expect("a machine that can be built");
    let mut thesis = crane.controller(case.name).expect("a controller");
    let (p, mut spool) = ([[40e5, 40e5]; 3], [0.0; 3]);
    let mut times: Vec<f64> = (0..20_000)
        .map(|k| {
            let t = 1e-3 * k as f64;
            let q = [START[0] + 0.1 * t.sin(), START[1] + 0.1 * (0.7 * t).sin(), 0.05 * (0.3 * t).sin()];
            let stick = Stick::Tip(&[(0.5 * t).sin(), (0.4 * t).cos()]);
            let begun = Instant::now();
            thesis.step(&Measurement { t, q: &q, p: &p }, stick, &mut spool).expect("a command");
            begun.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    let (median, high) = (times[times.len() / 2], times[times.len() * 99 / 100]);
    println!("heinze-pid with the penalty: median {:.2} us, 99th percentile {:.2} us", median * 1e6, high * 1e6);
    assert!(high < 2e-4);
}
