//! The sampled loop: period, hold, delay, sensors, and what happens when a controller or a sensor fails.

use hydrocrane_control::interface::controller::{Controller, Fault, Measurement, Stick};
use hydrocrane_machine::{load, OverrideValue};
use hydrocrane_num::RandomStream;
use hydrocrane_ode::{StepControl, Tolerances};
use hydrocrane_sim::{
    build, simulate, simulate_sampled, Commands, EquilibriumMode, FaultKind, Model, OutcomeKind, RunOptions,
    SampledPlan, SampledRun, SensorFault, SensorMode, Sensors, StickKind, Sticks, FAILURES_IN_A_ROW,
};
use std::sync::Arc;

const PERIOD: f64 = 0.01;

/// A controller made of one closure: (sample number, measurement, stick) to spool commands.
struct Law<F>(u64, F);

impl<F: FnMut(u64, &Measurement, Stick) -> Result<[f64; 3], Fault> + Send> Controller for Law<F> {
    fn period(&self) -> f64 {
        PERIOD
    }
    fn reset(&mut self, _first: &Measurement) {}
    fn step(&mut self, measured: &Measurement, stick: Stick, spool: &mut [f64]) -> Result<(), Fault> {
        let answer = (self.1)(self.0, measured, stick)?;
        self.0 += 1;
        spool.copy_from_slice(&answer);
        Ok(())
    }
    fn set_point(&self) -> Option<[f64; 2]> {
        None
    }
}

fn model(changes: &[(&str, &str)]) -> Arc<dyn Model> {
    let changes: Vec<_> = changes.iter().map(|(k, v)| (k.to_string(), OverrideValue::Text(v.to_string()))).collect();
    build(&load("rottne-f9-lab", &changes).expect("a valid machine")).expect("a machine that can be built")
}

fn start(m: &dyn Model) -> Vec<f64> {
    let q = [100f64.to_radians(), 100f64.to_radians(), 0.0];
    m.equilibrium(&q, EquilibriumMode::Hold, 0.0).expect("a pose to rest in")
}

fn options() -> RunOptions {
    let tolerances = Tolerances { relative: 1e-4, absolute: 1e-4, max_step: 0.05 };
    RunOptions {
        method: "rodas5p".into(),
        tolerances,
        control: StepControl::Adaptive,
        payload: 0.0,
        payload_changes: Vec::new(),
        supply: None,
        ledger: false,
        max_steps: 1_000_000,
    }
}

fn plan(m: &dyn Model) -> SampledPlan {
    SampledPlan { sticks: Sticks::centred(StickKind::Tip, 2), sensors: Sensors::ideal(m), delay: 0.0 }
}

fn run(m: &dyn Model, end: f64, controller: &mut dyn Controller, plan: &SampledPlan) -> SampledRun {
    let record: Vec<f64> = (0..=(end / 1e-3).round() as usize).map(|i| i as f64 * 1e-3).collect();
    simulate_sampled(m, &start(m), end, controller, plan, &record, &options(), &mut |_| true)
}

#[test]
fn commands_are_held_over_a_period_and_arrive_after_every_delay() {
    let m = model(&[("valve.lift.delay", "3 ms"), ("valve.lift.command.delay", "4 ms")]);
    let plan = SampledPlan { delay: 0.0065, ..plan(m.as_ref()) };
    let mut counting = Law(0, |k, _: &Measurement, _: Stick| Ok([0.001 * (k as f64 + 1.0), 0.001, 0.0]));
    let done = run(m.as_ref(), 0.1, &mut counting, &plan);
    assert_eq!(done.run.outcome.kind, OutcomeKind::Completed, "{}", done.run.outcome.message);
    assert_eq!(done.samples.times.len(), 10, "one sample at each period, none at the end");
    for (t, u) in done.run.times.iter().zip(done.run.commands.chunks(3)) {
        // 6.5 + 4 + 3 ms for the lift; the record lies at whole milliseconds, the arrivals between them.
        let arrived = ((t - 0.0135) / PERIOD).floor() + 1.0;
        assert!((u[0] - 0.001 * arrived.max(0.0)).abs() < 1e-12, "at {t}: {}", u[0]);
        assert_eq!(u[1], if *t < 0.0065 { 0.0 } else { 0.001 }, "at {t}");
    }
}

#[test]
fn a_constant_controller_is_an_open_loop_step() {
    let m = model(&[]);
    let mut constant = Law(0, |_, _: &Measurement, _: Stick| Ok([0.02, 0.0, -0.01]));
    let plan = plan(m.as_ref());
    let closed = run(m.as_ref(), 0.5, &mut constant, &plan);
    let commands = Commands { times: vec![0.0], values: vec![0.02, 0.0, -0.01], linear: false };
    let open = simulate(m.as_ref(), &start(m.as_ref()), 0.5, &commands, &closed.run.times, &options(), &mut |_| true);
    let n = m.layout().len();
    let (a, b) = (&closed.run.states[closed.run.states.len() - n..], &open.states[open.states.len() - n..]);
    for joint in 0..3 {
        assert!((a[joint] - b[joint]).abs() < 2e-5, "{}: {} and {}", m.layout().names[joint], a[joint], b[joint]);
    }
}

#[test]
fn the_controller_sees_the_truth_of_its_own_sample_through_ideal_sensors() {
    let m = model(&[]);
    let mut seen = Vec::new();
    let mut watcher = Law(0, |_, measured: &Measurement, _: Stick| {
        seen.push((measured.t, measured.q[0], measured.p[0][0]));
        Ok([0.02, 0.0, 0.0])
    });
    let plan = plan(m.as_ref());
    let done = run(m.as_ref(), 0.2, &mut watcher, &plan);
    let n = m.layout().len();
    for (k, (t, q, p)) in seen.into_iter().enumerate() {
        let row = &done.run.states[10 * k * n..(10 * k + 1) * n];
        assert!((t - PERIOD * k as f64).abs() < 1e-12);
        assert!((q - row[0]).abs() < 1e-12 && (p - row[m.layout().p1(0)]).abs() < 1e-3, "sample {k}");
    }
}

#[test]
fn commands_beyond_the_stroke_are_clipped_without_an_event() {
    let m = model(&[]);
    let plan = plan(m.as_ref());
    let done = run(m.as_ref(), 0.05, &mut Law(0, |_, _: &Measurement, _: Stick| Ok([9.0, -9.0, 0.0])), &plan);
    let stroke = m.spool_strokes()[0];
    assert_eq!(&done.samples.commands[..3], [stroke, -stroke, 0.0]);
    assert!(done.events.is_empty(), "{:?}", done.events);
}

#[test]
fn a_garbage_command_centres_the_spools_for_its_samples_only() {
    let m = model(&[]);
    let plan = plan(m.as_ref());
    let mut flaky =
        Law(0, |k, _: &Measurement, _: Stick| Ok(if (3..5).contains(&k) { [f64::NAN, 0.01, 0.0] } else { [0.01; 3] }));
    let done = run(m.as_ref(), 0.1, &mut flaky, &plan);
    assert_eq!(done.run.outcome.kind, OutcomeKind::Completed);
    for (k, u) in done.samples.commands.chunks(3).enumerate() {
        assert_eq!(u, if (3..5).contains(&k) { [0.0; 3] } else { [0.01; 3] }, "sample {k}");
    }
    let times: Vec<f64> = done.events.iter().map(|event| event.time).collect();
    assert_eq!(times, [0.03, 0.05], "{:?}", done.events);
    assert!(done.events[0].text.contains("not a finite number") && done.events[0].text.contains("neutral"));
}

#[test]
fn a_controller_that_gives_up_ends_the_run_at_once() {
    let m = model(&[]);
    let plan = plan(m.as_ref());
    let mut torn = Law(0, |k, _: &Measurement, _: Stick| match k {
        3 => Err(Fault::Fatal("torn".into())),
        _ => Ok([0.01; 3]),
    });
    let done = run(m.as_ref(), 0.1, &mut torn, &plan);
    assert_eq!(done.run.outcome.kind, OutcomeKind::ControllerFailed);
    assert_eq!((done.run.outcome.time, done.run.outcome.message.as_str()), (0.03, "torn"));
    assert_eq!(done.events.iter().map(|event| event.text.as_str()).collect::<Vec<_>>(), ["torn; the run ends"]);
    assert_eq!(done.run.times.last(), Some(&0.03));
}

#[test]
fn sticks_may_pass_their_end_by_rounding_only() {
    let m = model(&[]);
    let tip = |z: f64| {
        let sticks = Sticks { times: vec![0.0], deflections: vec![0.0, z], ..Sticks::centred(StickKind::Tip, 2) };
        let mut controller = m.controller("tip").expect("a controller");
        run(m.as_ref(), 0.05, controller.as_mut(), &SampledPlan { sticks, ..plan(m.as_ref()) })
    };
    let rounded = tip(1.0 + 1e-12);
    assert!(rounded.run.outcome.kind == OutcomeKind::Completed && rounded.events.is_empty(), "{:?}", rounded.events);
    assert_eq!(rounded.samples.sticks.iter().copied().fold(0.0, f64::max), 1.0);
    let beyond = tip(1.0 + 1e-6);
    assert_eq!(beyond.run.outcome.kind, OutcomeKind::BadState);
    assert!(beyond.run.outcome.message.contains("between -1 and 1"), "{}", beyond.run.outcome.message);
}

#[test]
fn a_controller_that_stays_broken_ends_the_run_with_what_was_computed() {
    let m = model(&[]);
    let plan = plan(m.as_ref());
    let mut broken =
        Law(
            0,
            |_, measured: &Measurement, _: Stick| {
                if measured.t < 0.195 {
                    Ok([0.01, 0.0, 0.0])
                } else {
                    Err(Fault::Failed("the law gave up".into()))
                }
            },
        );
    let done = run(m.as_ref(), 5.0, &mut broken, &plan);
    assert_eq!(done.run.outcome.kind, OutcomeKind::ControllerFailed);
    assert!(done.run.outcome.message.contains("the law gave up"), "{}", done.run.outcome.message);
    let ended = 0.2 + f64::from(FAILURES_IN_A_ROW - 1) * PERIOD;
    assert!((done.run.outcome.time - ended).abs() < 1e-9, "{}", done.run.outcome.time);
    assert!((done.run.times.last().unwrap() - ended).abs() < 1e-9, "the record reaches the end of the run");
}

#[test]
fn impossible_plans_are_refused_before_the_first_step() {
    let m = model(&[]);
    for delay in [-0.001, f64::NAN] {
        let plan = SampledPlan { delay, ..plan(m.as_ref()) };
        let done = run(m.as_ref(), 0.1, &mut Law(0, |_, _: &Measurement, _: Stick| Ok([0.0; 3])), &plan);
        assert_eq!(done.run.outcome.kind, OutcomeKind::BadState);
        assert!(done.run.outcome.message.contains("delay"), "{}", done.run.outcome.message);
    }
}

#[test]
fn impossible_sticks_are_refused_before_the_first_step() {
    let m = model(&[]);
    for deflection in [1.5, f64::NAN] {
        let mut plan = plan(m.as_ref());
        (plan.sticks.times, plan.sticks.deflections) = (vec![0.0], vec![0.0, deflection]);
        let done = run(m.as_ref(), 0.1, &mut Law(0, |_, _: &Measurement, _: Stick| Ok([0.0; 3])), &plan);
        assert_eq!(done.run.outcome.kind, OutcomeKind::BadState);
        assert!(done.run.outcome.message.contains("deflection"), "{}", done.run.outcome.message);
    }
}

#[test]
fn a_sensor_frozen_from_the_start_stays_at_its_first_reading() {
    let m = model(&[]);
    let fault = SensorFault { signal: "joint.boom.q".into(), kind: FaultKind::Freeze, from: 0.0, until: None };
    let done = measured_under(m.as_ref(), data_sheet(m.as_ref(), 0, &[fault]));
    let width = data_sheet(m.as_ref(), 0, &[]).signals().count();
    let boom: Vec<f64> = done.samples.measured.iter().step_by(width).copied().collect();
    assert!((boom[0] - 100f64.to_radians()).abs() < 0.004 && boom.iter().all(|q| *q == boom[0]), "{boom:?}");
}

fn data_sheet(m: &dyn Model, seed: u64, faults: &[SensorFault]) -> Sensors {
    Sensors::new(m, SensorMode::DataSheet, seed, faults).expect("signals of the machine")
}

fn measured_under(m: &dyn Model, sensors: Sensors) -> SampledRun {
    let plan = SampledPlan { sensors, ..plan(m) };
    run(m, 0.3, &mut Law(0, |_, _: &Measurement, _: Stick| Ok([0.02, 0.01, 0.01])), &plan)
}

#[test]
fn a_seed_repeats_a_run_bit_by_bit_and_another_does_not() {
    let m = model(&[]);
    let measured = |seed| measured_under(m.as_ref(), data_sheet(m.as_ref(), seed, &[])).samples.measured;
    assert_eq!(measured(1), measured(1));
    assert_ne!(measured(1), measured(2));
}

#[test]
fn data_sheet_readings_stay_near_the_truth_and_are_not_it() {
    let m = model(&[]);
    let layout = m.layout();
    for seed in 0..5 {
        let sensors = data_sheet(m.as_ref(), seed, &[]);
        let signals: Vec<String> = sensors.signals().map(str::to_string).collect();
        let done = measured_under(m.as_ref(), sensors);
        for (k, row) in done.samples.measured.chunks(signals.len()).enumerate() {
            let state = &done.run.states[10 * k * layout.len()..(10 * k + 1) * layout.len()];
            // One and a half counts and the division error; linearity, repeatability, noise and half a code of 1250 mm.
            let (angle, share) = ((1.5 * 0.09f64 + 0.05).to_radians(), 0.0025 + 0.0003 + 6.0 * 1e-4 + 0.5 / 4095.0);
            let bounds = [angle, angle, share * 1.25];
            for joint in 0..3 {
                let error = (row[joint] - state[joint]).abs();
                assert!(error <= bounds[joint], "{} at sample {k}: {error}", signals[joint]);
                assert!(error > 0.0, "{} at sample {k}: the reading is the truth", signals[joint]);
            }
        }
    }
}

#[test]
fn failing_sensors_do_what_they_are_told_from_their_time_on() {
    let m = model(&[]);
    let fault = |signal: &str, kind| SensorFault { signal: signal.into(), kind, from: 0.1, until: None };
    let faults = [
        fault("joint.boom.q", FaultKind::Freeze),
        fault("joint.jib.q", FaultKind::Jump(0.5)),
        fault("cylinder.lift.p1", FaultKind::DropOut),
    ];
    let sensors = Sensors::new(m.as_ref(), SensorMode::Ideal, 0, &faults).expect("known signals");
    let width = sensors.signals().count();
    let p1 = sensors.signals().position(|s| s == "cylinder.lift.p1").unwrap();
    let done = measured_under(m.as_ref(), sensors);
    let (rows, n) = (done.samples.measured.chunks(width), m.layout().len());
    let frozen = done.samples.measured[9 * width];
    for (k, row) in rows.enumerate() {
        let truth = &done.run.states[10 * k * n..];
        let failed = k >= 10;
        assert_eq!(row[0], if failed { frozen } else { truth[0] });
        assert!((row[1] - truth[1] - if failed { 0.5 } else { 0.0 }).abs() < 1e-12);
        assert_eq!(row[p1].is_nan(), failed);
    }
}

#[test]
fn a_fault_of_an_unknown_sensor_names_the_known_ones() {
    let m = model(&[]);
    let fault = SensorFault { signal: "joint.bom.q".into(), kind: FaultKind::Freeze, from: 0.0, until: None };
    let message = Sensors::new(m.as_ref(), SensorMode::Ideal, 0, &[fault]).unwrap_err();
    assert!(message.contains("joint.bom.q") && message.contains("joint.boom.q"), "{message}");
}

/// Random deflections of `axes` sticks, held or joined, and the sensors of the data sheets.
fn random_plan(m: &dyn Model, seed: u64, seconds: f64, kind: StickKind) -> SampledPlan {
    let mut random = RandomStream::new(seed, "operator");
    let axes = if kind == StickKind::Tip { 2 } else { 3 };
    let mut sticks =
        Sticks { linear: seed.is_multiple_of(2), dead_zone: 0.05, ramp: 0.1, ..Sticks::centred(kind, axes) };
    let mut t = 0.0;
    while t < seconds {
        sticks.times.push(t);
        sticks.deflections.extend((0..sticks.axes).map(|_| random.symmetric()));
        t += 0.05 + 1.5 * random.uniform();
    }
    SampledPlan { sticks, sensors: data_sheet(m, seed, &[]), delay: 0.002 }
}

fn named_run(m: &dyn Model, name: &str, plan: &SampledPlan, seconds: f64) -> SampledRun {
    let mut controller = m.controller(name).expect("a controller");
    run(m, seconds, controller.as_mut(), plan)
}

#[test]
fn a_minute_of_random_sticks_is_finite_and_stays_inside_the_cylinders() {
    let m = model(&[]);
    for (name, kind) in [("lever", StickKind::Lever), ("tip", StickKind::Tip)] {
        for seed in 0..3 {
            let done = named_run(m.as_ref(), name, &random_plan(m.as_ref(), seed, 60.0, kind), 60.0);
            let outcome = &done.run.outcome;
            assert_eq!(outcome.kind, OutcomeKind::Completed, "{name}, seed {seed}: {}", outcome.message);
            assert!(done.run.states.iter().chain(&done.samples.measured).all(|v| v.is_finite()), "{name}, seed {seed}");
            assert!(done.samples.sticks.iter().all(|d| d.abs() <= 1.0), "{name}, seed {seed}");
            // A tip at the end of its range may say so.
            let others: Vec<_> = done.events.iter().filter(|e| !e.text.starts_with("the tip stands")).collect();
            assert!(others.is_empty(), "{name}, seed {seed}: {others:?}");
        }
    }
}

#[test]
fn tip_control_without_a_reading_closes_the_valves() {
    let m = model(&[]);
    let fault = SensorFault { signal: "joint.jib.q".into(), kind: FaultKind::DropOut, from: 1.0, until: None };
    let plan =
        SampledPlan { sensors: data_sheet(m.as_ref(), 0, &[fault]), ..random_plan(m.as_ref(), 1, 5.0, StickKind::Tip) };
    let done = named_run(m.as_ref(), "tip", &plan, 5.0);
    assert_eq!(done.run.outcome.kind, OutcomeKind::ControllerFailed);
    assert!((done.run.outcome.time - 1.09).abs() < 1e-9, "{}", done.run.outcome.time);
    assert!((done.events[0].time - 1.0).abs() < 1e-9, "{:?}", done.events);
    assert_eq!(&done.samples.commands[done.samples.commands.len() - 3..], [0.0; 3]);
}

#[test]
fn tip_control_with_frozen_or_jumping_sensors_stays_finite() {
    let m = model(&[]);
    for (signal, kind) in [
        ("joint.boom.q", FaultKind::Freeze),
        ("joint.extension.q", FaultKind::Jump(0.3)),
        ("joint.jib.q", FaultKind::Jump(-2.0)),
        ("cylinder.lift.p1", FaultKind::Jump(300e5)),
    ] {
        let fault = SensorFault { signal: signal.into(), kind, from: 1.0, until: None };
        let sensors = data_sheet(m.as_ref(), 0, &[fault]);
        let plan = SampledPlan { sensors, ..random_plan(m.as_ref(), 1, 20.0, StickKind::Tip) };
        let done = named_run(m.as_ref(), "tip", &plan, 20.0);
        let kind = done.run.outcome.kind;
        assert!(matches!(kind, OutcomeKind::Completed | OutcomeKind::ControllerFailed), "{signal}: {kind:?}");
        assert!(done.run.states.iter().all(|v| v.is_finite()), "{signal}");
    }
}
