//! Crane-tip control on the laboratory crane, with ideal measurements.

use hydrocrane_control::interface::controller::{Controller, Fault, Measurement, Reading, Stick};
use hydrocrane_control::model::controller_model::ControllerModel;
use hydrocrane_control::model::feed_forward::steady_speed;
use hydrocrane_control::reference::redundancy::{resolve, Preference, Task};
use hydrocrane_control::thesis::heinze_pid::{self, HeinzePid};
use hydrocrane_control::tip::Tip;
use hydrocrane_machine::{load, Machine, OverrideValue};
use hydrocrane_num::RandomStream;
use hydrocrane_ode::{StepControl, Tolerances};
use hydrocrane_sim::model::controllers::{heinze_settings, tip_settings};
use hydrocrane_sim::{build, Crane, EquilibriumMode, Model, OutcomeKind, RunOptions, Simulator};
use std::sync::Arc;
use std::time::Instant;

const START: [f64; 3] = [1.745_329_251_994_329_5, 1.745_329_251_994_329_5, 0.0];
const SENSES: [(&str, [f64; 2]); 4] =
    [("up", [0.0, 1.0]), ("down", [0.0, -1.0]), ("out", [1.0, 0.0]), ("in", [-1.0, 0.0])];
const LENGTH: f64 = 0.5;

/// How the crane differs from the controller model and how it is measured.
#[derive(Clone, Copy)]
struct Reality {
    overrides: &'static [(&'static str, f64)],
    /// kg at the tip, unknown to the controller.
    payload: f64,
    /// Steps of the joint sensors, rad or m; zero: ideal.
    counts: [f64; 3],
    /// Added to every measured pressure with alternating sign, Pa.
    pressure_error: f64,
    /// Commands take effect one period late.
    late: bool,
    period: f64,
}

const IDEAL: Reality =
    Reality { overrides: &[], payload: 0.0, counts: [0.0; 3], pressure_error: 0.0, late: false, period: 0.01 };

/// The controller model of this machine.
fn controller_model(machine: &Machine) -> ControllerModel<3> {
    hydrocrane_sim::controller_model(&Crane::new(machine).expect("a machine that can be built"))
}

fn crane(overrides: &[(&str, f64)]) -> Arc<dyn Model> {
    let overrides: Vec<_> = overrides.iter().map(|(k, v)| (k.to_string(), OverrideValue::Number(*v))).collect();
    build(&load("rottne-f9-lab", &overrides).expect("a valid machine")).expect("a machine that can be built")
}

/// The printed laws jump: a tight tolerance would chatter across the jumps.
fn options(model: &dyn Model, payload: f64) -> RunOptions {
    let printed = !model.machine().errata.friction_map;
    let (method, tolerance) = if printed { ("tsit5", 1e-2) } else { ("rodas5p", 1e-5) };
    RunOptions {
        method: method.to_string(),
        tolerances: Tolerances { relative: tolerance, absolute: tolerance, max_step: 0.01 },
        control: StepControl::Adaptive,
        payload,
        payload_changes: Vec::new(),
        supply: None,
        ledger: false,
        max_steps: 10_000_000,
    }
}

/// A controller in the loop with the true crane; the controller's period is the simulator's step.
struct Loop {
    model: Arc<dyn Model>,
    simulator: Simulator,
    controller: Box<dyn Controller>,
    reality: Reality,
    waiting: [f64; 3],
    /// Largest |command| so far, m.
    effort: f64,
}

impl Loop {
    fn new(model: Arc<dyn Model>, controller: Box<dyn Controller>, x0: &[f64], reality: Reality) -> Self {
        let mut simulator =
            Simulator::new(model.clone(), controller.period(), options(model.as_ref(), reality.payload));
        simulator.reset(x0).expect("a state to start from");
        Loop { model, simulator, controller, reality, waiting: [0.0; 3], effort: 0.0 }
    }

    /// `tip` on the laboratory crane at rest; 1 m/s at full stick.
    fn tip_control(reality: Reality) -> Self {
        let known = crane(&[("control.period", reality.period), ("control.tip.full-speed", 1.0)]);
        let controller_model = controller_model(known.machine());
        let settings = tip_settings(known.machine(), &controller_model);
        let controller = Box::new(Tip::new(controller_model, settings));
        let model = crane(reality.overrides);
        let x0 = model.equilibrium(&START, EquilibriumMode::Hold, reality.payload).expect("a pose to rest in");
        Loop::new(model, controller, &x0, reality)
    }

    fn tip(&self) -> [f64; 2] {
        self.model.tip_in_plane(self.joints())
    }

    fn joints(&self) -> &[f64] {
        &self.simulator.state().expect("a state")[..3]
    }

    fn step(&mut self, stick: [f64; 2]) {
        let layout = self.model.layout();
        let x = self.simulator.state().expect("a state");
        let error = self.reality.pressure_error;
        let p: [[f64; 2]; 3] = std::array::from_fn(|c| [x[layout.p1(c)] + error, x[layout.p2(c)] - error]);
        let q: [f64; 3] = std::array::from_fn(|i| match self.reality.counts[i] {
            count if count > 0.0 => (x[i] / count).round() * count,
            _ => x[i],
        });
        let mut spool = [0.0; 3];
        let m = Measurement { t: self.simulator.time(), q: &q, p: &p };
        self.controller.step(&m, Stick::Tip(&stick), &mut spool).expect("a command");
        assert!(spool.iter().all(|u| u.is_finite()));
        self.effort = spool.iter().fold(self.effort, |a, u| a.max(u.abs()));
        if self.reality.late {
            std::mem::swap(&mut self.waiting, &mut spool);
        }
        let outcome = self.simulator.step(&spool);
        assert_eq!(outcome.kind, OutcomeKind::Completed, "{}", outcome.message);
    }
}

/// The speed along a line at which the steady spool demand reaches full stroke somewhere, m/s.
fn full_stroke_speed(n: &ControllerModel<3>, direction: [f64; 2]) -> f64 {
    const STEP: f64 = 1e-3;
    let supply_pressures = n.supply_pressures();
    let mut q = START;
    let mut fastest = f64::INFINITY;
    for _ in 0..(LENGTH / STEP) as usize {
        let posture = n.posture(&q);
        let load = n.cylinder_force(&q, &[0.0; 3], n.payload);
        let speed = |i: usize, sense: f64| {
            let force = load[i] + n.cylinders[i].steady_friction(sense * 0.01);
            steady_speed(&n.cylinders[i], &supply_pressures, force, sense)
        };
        let range: [[f64; 2]; 3] = std::array::from_fn(|i| [speed(i, -1.0), speed(i, 1.0)]);
        let weights = std::array::from_fn(|i| (posture.lever_arm[i] / (range[i][1] - range[i][0])).powi(2));
        let bounds = std::array::from_fn(|i| {
            let (a, b) = (range[i][0] / posture.lever_arm[i], range[i][1] / posture.lever_arm[i]);
            [a.min(b), a.max(b)]
        });
        let task = Task { velocity: direction.map(|d| 100.0 * d), correction: [0.0; 2] };
        let wide = Preference { weights, rates: [0.0; 3], bounds };
        let unlimited = Preference { bounds: [[-1e9, 1e9]; 3], ..wide };
        let unit = resolve(&posture.jacobian, &task, &unlimited);
        let demand = (0..3)
            .map(|i| {
                let piston = posture.lever_arm[i] * unit.rates[i] / 100.0;
                piston / range[i][usize::from(piston > 0.0)]
            })
            .fold(0.0, f64::max);
        fastest = fastest.min(1.0 / demand);
        for i in 0..3 {
            q[i] += unit.rates[i] / 100.0 * STEP;
        }
    }
    fastest
}

#[derive(Debug)]
struct Deviation {
    /// m
    largest: f64,
    rms: f64,
    /// Mean speed after the first half second, m/s.
    speed: f64,
    /// Largest share of a spool's stroke.
    effort: f64,
}

/// Runs along a line at `speed` with the stick ramped over 0.2 s.
fn drive_line(direction: [f64; 2], speed: f64, mut l: Loop) -> Deviation {
    let from = l.tip();
    let (mut largest, mut sum, mut count, mut travelled) = (0.0f64, 0.0, 0.0, 0.0);
    let mut early = (0.0, 0.0);
    while travelled < LENGTH {
        assert!(l.simulator.time() < 60.0, "the tip got {travelled} m far");
        let ramp = (l.simulator.time() / 0.2).min(1.0) * speed;
        l.step(direction.map(|d| d * ramp.min(1.0)));
        let [x, z] = [l.tip()[0] - from[0], l.tip()[1] - from[1]];
        travelled = x * direction[0] + z * direction[1];
        let aside = z * direction[0] - x * direction[1];
        if l.simulator.time() <= 0.5 {
            early = (l.simulator.time(), travelled);
        }
        largest = largest.max(aside.abs());
        sum += aside * aside;
        count += 1.0;
    }
    let speed = (travelled - early.1) / (l.simulator.time() - early.0);
    Deviation { largest, rms: f64::sqrt(sum / count), speed, effort: l.effort / 0.05 }
}

fn table(title: &str, reality: Reality) -> Vec<(f64, Deviation)> {
    let n = controller_model(crane(&[]).machine());
    let mut rows = Vec::new();
    for (name, direction) in SENSES {
        let full = full_stroke_speed(&n, direction);
        for share in [0.8, 2.0] {
            let d = drive_line(direction, share * full, Loop::tip_control(reality));
            println!(
                "{title:28} {name:5} {:.3} m/s ({share}): max {:6.2} mm rms {:6.2} mm, {:.3} m/s, spool {:.0} %",
                share * full,
                d.largest * 1e3,
                d.rms * 1e3,
                d.speed,
                d.effort * 100.0
            );
            rows.push((share, d));
        }
    }
    rows
}

#[test]
fn keeps_its_path() {
    for (share, d) in table("ideal", IDEAL) {
        let (largest, rms) = if share < 1.0 { (0.005, 0.002) } else { (0.010, 0.004) };
        assert!(d.largest <= largest && d.rms <= rms, "{d:?}");
    }
}

#[test]
fn keeps_its_path_although_the_controller_is_wrong_about_the_crane() {
    let count = f64::to_radians(0.09);
    let counts = [count, count, 0.0005];
    let small_valve: &[(&str, f64)] = &[("valve.lift.nominal-flow", 0.9e-4)];
    let cases = [
        ("late by 10 ms", Reality { late: true, ..IDEAL }),
        ("20 ms", Reality { period: 0.02, ..IDEAL }),
        ("20 ms, late by 20 ms", Reality { period: 0.02, late: true, ..IDEAL }),
        ("100 kg unknown", Reality { payload: 100.0, ..IDEAL }),
        ("200 kg unknown, late", Reality { payload: 200.0, late: true, ..IDEAL }),
        ("encoder counts, late", Reality { counts, late: true, ..IDEAL }),
        ("pressures +-1.2 bar", Reality { pressure_error: 1.2e5, ..IDEAL }),
        ("supply 130 for 140 bar", Reality { overrides: &[("supply.pressure", 130e5)], ..IDEAL }),
        ("lift valve 10 % smaller", Reality { overrides: small_valve, ..IDEAL }),
    ];
    for (title, reality) in cases {
        for (share, d) in table(title, reality) {
            let (largest, rms) = if share < 1.0 { (0.005, 0.002) } else { (0.010, 0.004) };
            assert!(d.largest <= largest && d.rms <= rms, "{title}: {d:?}");
        }
    }
}

#[test]
fn random_sticks_stay_within_the_limits() {
    let known = controller_model(crane(&[]).machine());
    for seed in 1..=4 {
        let mut l = Loop::tip_control(IDEAL);
        let mut random = RandomStream::new(seed, "sticks");
        let (mut stick, mut until, mut farthest, mut over) = ([0.0; 2], 0.0, 0.0f64, 0.0f64);
        while l.simulator.time() < 60.0 {
            if l.simulator.time() >= until {
                // Pushed beyond what the crane can do, so that every limit is met.
                stick = [random.symmetric(), random.symmetric()].map(|s| if s.abs() < 0.1 { 0.0 } else { s });
                until = l.simulator.time() + 2.0 + 1.8 * random.symmetric();
            }
            l.step(stick);
            let q: [f64; 3] = std::array::from_fn(|i| l.joints()[i]);
            let posture = known.posture(&q);
            let set_point = l.controller.set_point().expect("a set-point");
            farthest = farthest.max((set_point[0] - l.tip()[0]).hypot(set_point[1] - l.tip()[1]));
            for i in 0..3 {
                let [low, high] = known.cylinders[i].free;
                over = over.max(posture.stroke[i] - high).max(low - posture.stroke[i]);
                let [low, high] = known.joint_limits[i];
                assert!(q[i] > low && q[i] < high, "joint {i} at {} after {} s", q[i], l.simulator.time());
            }
        }
        println!(
            "seed {seed}: {:.2} mm into an end stop's zone, tip to set-point {:.1} mm",
            over * 1e3,
            farthest * 1e3
        );
        assert!(over < 0.001 && farthest < 0.01);
    }
}

#[test]
fn releasing_the_stick_stops_the_tip() {
    let n = controller_model(crane(&[]).machine());
    for (name, direction) in SENSES {
        let speed = 0.8 * full_stroke_speed(&n, direction);
        let mut l = Loop::tip_control(IDEAL);
        while l.simulator.time() < 2.0 {
            l.step(direction.map(|d| d * speed));
        }
        let released = l.tip();
        let (mut at_one_second, mut moved) = (released, 0.0f64);
        while l.simulator.time() < 6.0 {
            l.step([0.0; 2]);
            let tip = l.tip();
            if l.simulator.time() < 3.0 {
                at_one_second = tip;
            }
            moved = moved.max((tip[0] - released[0]).hypot(tip[1] - released[1]));
        }
        let drift = (l.tip()[0] - at_one_second[0]).hypot(l.tip()[1] - at_one_second[1]);
        println!("{name:5} {speed:.3} m/s: stops within {:.1} mm, drifts {:.3} mm in 3 s", moved * 1e3, drift * 1e3);
        // The double lag of the stick alone takes speed x 2 / (15 rad/s).
        assert!(moved < speed * 2.0 / 15.0 + 0.005 && drift < 0.003);
    }
}

/// Height and distance of the tip over time with the thesis's task: all pressures zero, one set-point for all 5 s.
fn published_task(machine: &str, stick: [f64; 2], period: f64) -> [[f64; 2]; 2] {
    let model = build(&load(machine, &[]).expect("a bundled machine")).expect("a machine that can be built");
    let controller_model = controller_model(model.machine());
    let settings = heinze_settings(model.machine(), &controller_model);
    let settings = heinze_pid::Settings { period, set_point_interval: 5.0, working_area: None, ..settings };
    let controller = Box::new(HeinzePid::new(controller_model, settings));
    let mut x0 = vec![0.0; model.layout().len()];
    x0[..3].copy_from_slice(&START);
    let mut l = Loop::new(model, controller, &x0, IDEAL);
    let mut at_three = [0.0; 2];
    while l.simulator.time() < 5.0 - 0.5 * period {
        l.step(stick);
        if l.simulator.time() <= 3.0 {
            at_three = l.tip();
        }
    }
    [at_three, l.tip()]
}

#[test]
fn the_thesis_controller_sampled_on_the_printed_machine() {
    for period in [2.8e-4, 2e-4] {
        let [_, end] = published_task("heinze-2007", [0.0, 0.5], period);
        println!("vertical, {period} s: x = {:.3} m, z = {:.3} m after 5 s", end[0], end[1]);
        assert!((end[1] - 1.137).abs() < 0.02, "{end:?}");
    }
}

#[test]
fn the_thesis_controller_on_its_horizontal_task() {
    let [three, five] = published_task("heinze-2007", [-0.5, 0.0], 2e-4);
    assert!((three[1] + 0.606).abs() < 0.02 && (five[1] + 0.310).abs() < 0.02, "{three:?} {five:?}");
}

#[test]
fn every_bundled_machine_gets_a_controller_that_moves_its_tip() {
    for name in ["rottne-f9-lab", "hiab-xs031", "single-cylinder"] {
        let machine = load(name, &[]).expect("a bundled machine");
        let n = machine.joints.len();
        let model = build(&machine).expect("a machine that can be built");
        let mut controller = model.controller("tip").expect("a controller");
        let q: Vec<f64> = model.joint_limits().iter().map(|l| 0.5 * (l.lower + l.upper)).collect();
        let x0 = model.equilibrium(&q, EquilibriumMode::Hold, 0.0).expect("a pose to rest in");
        let layout = model.layout();
        let mut simulator = Simulator::new(model.clone(), controller.period(), options(model.as_ref(), 0.0));
        simulator.reset(&x0).expect("a state to start from");
        let mut spool = vec![0.0; n];
        let from = model.tip_in_plane(&q);
        let mut aside = 0.0f64;
        for _ in 0..100 {
            let x = simulator.state().expect("a state");
            aside = aside.max((model.tip_in_plane(&x[..n])[0] - from[0]).abs());
            let p: Vec<[f64; 2]> = (0..n).map(|c| [x[layout.p1(c)], x[layout.p2(c)]]).collect();
            let m = Measurement { t: simulator.time(), q: &x[..n], p: &p };
            controller.step(&m, Stick::Tip(&[0.0, 0.15]), &mut spool).expect("a command");
            assert_eq!(simulator.step(&spool).kind, OutcomeKind::Completed);
        }
        let to = model.tip_in_plane(&simulator.state().expect("a state")[..n]);
        println!("{name}: {:.3} m up in 1 s, at most {aside:.4} m aside", to[1] - from[1]);
        assert!(to[1] - from[1] > 0.005 && aside < 0.02, "{name}");
    }
}

#[test]
fn bad_input_is_a_fault_and_the_next_good_sample_is_not() {
    let mut l = Loop::tip_control(IDEAL);
    l.step([0.0, 0.1]);
    let (p, mut spool) = ([[40e5, 40e5]; 3], [0.0; 3]);
    let torn = Measurement { t: 0.01, q: &[START[0], f64::NAN, 0.0], p: &p };
    let stick = Stick::Tip(&[0.0, 0.1]);
    assert_eq!(l.controller.step(&torn, stick, &mut spool), Err(Fault::BadMeasurement(Reading::Joint(1))));
    let good = Measurement { t: 0.01, q: &START, p: &p };
    assert_eq!(l.controller.step(&good, Stick::Tip(&[0.0, 2.0]), &mut spool), Err(Fault::BadStick));
    assert_eq!(l.controller.step(&good, Stick::Lever(&[0.0; 3]), &mut spool), Err(Fault::WrongStick("tip")));
    assert_eq!(spool, [0.0; 3]);
    l.step([0.0, 0.1]);
    let unknown = crane(&[]).controller("tipp").err().expect("no such controller");
    assert!(unknown.contains("tip, heinze-pid"), "{unknown}");
}

#[test]
#[ignore = "a study: prints, asserts nothing"]
fn sampling_study_of_the_thesis_controller() {
    for machine in ["heinze-2007", "rottne-f9-lab"] {
        for (name, stick) in [("vertical", [0.0, 0.5]), ("horizontal", [-0.5, 0.0])] {
            for period in [2e-4, 1e-3, 1e-2] {
                let [three, five] = published_task(machine, stick, period);
                println!("{machine} {name} {period} s: (x, z) {three:.3?} m after 3 s, {five:.3?} m after 5 s");
            }
        }
    }
}

#[test]
#[ignore = "a benchmark: run it alone and optimised"]
fn one_step_takes_less_than_20_microseconds() {
    let mut l = Loop::tip_control(IDEAL);
    let mut times = Vec::new();
    let p = [[40e5, 40e5]; 3];
    let mut spool = [0.0; 3];
    l.controller.reset(&Measurement { t: 0.0, q: &START, p: &p });
    for k in 0..20_000 {
        let t = 0.01 * k as f64;
        let q = [START[0] + 0.1 * t.sin(), START[1] + 0.1 * (0.7 * t).sin(), 0.05 * (0.3 * t).sin()];
        let stick = Stick::Tip(&[(0.5 * t).sin(), (0.4 * t).cos()]);
        let begun = Instant::now();
        l.controller.step(&Measurement { t, q: &q, p: &p }, stick, &mut spool).expect("a command");
        times.push(begun.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    let (median, high) = (times[times.len() / 2], times[times.len() * 99 / 100]);
    println!("tip: median {:.2} us, 99th percentile {:.2} us", median * 1e6, high * 1e6);
    assert!(high < 20e-6);
}
