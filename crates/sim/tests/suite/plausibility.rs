//! The monitor of the sensors: silent on every machine in order, quick when a sensor fails.

use hydrocrane_machine::{load, parse, OverrideValue};
use hydrocrane_num::RandomStream;
use hydrocrane_ode::{StepControl, Tolerances};
use hydrocrane_sim::{
    build, simulate_sampled, EquilibriumMode, Event, FaultKind, Model, OutcomeKind, RunOptions, SampledPlan,
    SampledRun, SensorFault, SensorMode, Sensors, StickKind, Sticks,
};
use std::sync::Arc;

/// A machine in a pose from which `tip` can drive it anywhere, with changes by key.
pub struct Case {
    machine: &'static str,
    pose: &'static [f64],
    changes: Vec<(String, OverrideValue)>,
    /// Sections that its file has besides.
    pub besides: String,
    payload: f64,
    mode: SensorMode,
    delay: f64,
}

pub const LAB: (&str, &[f64]) = ("rottne-f9-lab", &[1.745, 1.745, 0.0]);
pub const LOADER: (&str, &[f64]) = ("hiab-xs031", &[0.35, -1.22, 0.3]);

impl Case {
    pub fn of((machine, pose): (&'static str, &'static [f64])) -> Self {
        Case {
            machine,
            pose,
            changes: Vec::new(),
            besides: String::new(),
            payload: 0.0,
            mode: SensorMode::DataSheet,
            delay: 0.002,
        }
    }

    pub fn with(mut self, key: &str, value: f64) -> Self {
        self.changes.push((key.to_string(), OverrideValue::Number(value)));
        self
    }

    /// Every friction force times `factor`.
    fn friction(mut self, factor: f64) -> Self {
        let machine = load(self.machine, &[]).expect("a bundled machine");
        for c in &machine.cylinders {
            for (key, values) in
                [("coulomb", c.friction.coulomb), ("breakaway", c.friction.breakaway), ("viscous", c.friction.viscous)]
            {
                let list = values.map(|v| OverrideValue::Number(v * factor)).to_vec();
                self.changes.push((format!("friction.{}.{key}", c.name), OverrideValue::List(list)));
            }
        }
        self
    }

    pub fn model(&self) -> Arc<dyn Model> {
        self.built(&self.changes)
    }

    fn built(&self, changes: &[(String, OverrideValue)]) -> Arc<dyn Model> {
        let text = format!("extends = \"{}\"\n[machine]\nclass = \"setting\"\n{}", self.machine, self.besides);
        build(&parse(&text, "own.toml", changes).expect("a valid machine")).expect("a machine that can be built")
    }

    /// The controller model is the machine of the file, but for the sampling.
    pub fn run(&self, name: &str, sticks: Sticks, seed: u64, end: f64, faults: &[SensorFault]) -> SampledRun {
        let model = self.model();
        let model = model.as_ref();
        let sampling: Vec<_> = self.changes.iter().filter(|(key, _)| key.starts_with("control")).cloned().collect();
        let known = self.built(&sampling);
        let mut controller = known.with_sensor_monitor(known.controller(name).expect("a controller"), self.delay);
        let x0 = model.equilibrium(self.pose, EquilibriumMode::Hold, self.payload).expect("a pose to rest in");
        let sensors = Sensors::new(model, self.mode, seed, faults).expect("known signals");
        let plan = SampledPlan { sticks, sensors, delay: self.delay };
        let record: Vec<f64> = (0..=(end / 0.01) as usize).map(|i| 0.01 * i as f64).collect();
        // The printed laws jump: a tight tolerance would chatter across the jumps.
        let printed = !model.machine().errata.friction_map;
        let (method, tolerance) = if printed { ("tsit5", 1e-2) } else { ("rodas5p", 1e-4) };
        let tolerances = Tolerances { relative: tolerance, absolute: tolerance, max_step: 0.05 };
        let options = RunOptions {
            payload_changes: Vec::new(),
            supply: None,
            method: method.into(),
            tolerances,
            control: StepControl::Adaptive,
            payload: self.payload,
            ledger: false,
            max_steps: 10_000_000,
        };
        let mut done = simulate_sampled(model, &x0, end, controller.as_mut(), &plan, &record, &options, &mut |_| true);
        let stops = done.run.warnings.iter().filter(|w| w.kind == "sensor-stop");
        done.events.extend(stops.map(|w| Event {
            time: w.time,
            text: w.text.clone(),
            alarm: Some(hydrocrane_control::interface::controller::Alarm::SensorStop),
        }));
        done.events.sort_by(|a, b| a.time.total_cmp(&b.time));
        done
    }
}

/// Random deflections of the tip's stick, held or joined, with pauses.
fn random_sticks(seed: u64, end: f64) -> Sticks {
    let mut random = RandomStream::new(seed, "operator");
    let mut sticks =
        Sticks { linear: seed.is_multiple_of(2), dead_zone: 0.05, ramp: 0.1, ..Sticks::centred(StickKind::Tip, 2) };
    let mut t = 0.0;
    while t < end {
        sticks.times.push(t);
        let rest = random.uniform() < 0.2;
        sticks.deflections.extend([0; 2].map(|_| if rest { 0.0 } else { random.symmetric() }));
        t += 0.05 + 1.5 * random.uniform();
    }
    sticks
}

pub fn assert_silent(what: &str, case: &Case, name: &str, seeds: std::ops::Range<u64>, end: f64) {
    for seed in seeds {
        let done = case.run(name, random_sticks(seed, end), seed, end, &[]);
        assert_eq!(done.run.outcome.kind, OutcomeKind::Completed, "{what}, seed {seed}: {}", done.run.outcome.message);
        // A tip at the end of its range may say so; no sensor is accused.
        let alarms: Vec<_> = done.events.iter().filter(|e| !e.text.starts_with("the tip stands")).take(3).collect();
        assert!(alarms.is_empty(), "{what}, seed {seed}: {alarms:?}");
    }
}

#[test]
fn minutes_of_random_sticks_raise_no_alarm_whatever_load_and_friction() {
    for (seed, (payload, friction)) in (0..).zip([(0.0, 0.5), (0.0, 2.0), (100.0, 1.0), (200.0, 0.5), (200.0, 2.0)]) {
        for place in [LAB, LOADER] {
            let case = Case { payload, ..Case::of(place) }.friction(friction);
            let what = format!("{}, {payload} kg, friction times {friction}", place.0);
            assert_silent(&what, &case, "tip", seed..seed + 1, 60.0);
        }
    }
}

#[test]
fn no_period_delay_controller_or_machine_raises_an_alarm() {
    for place in [LAB, LOADER] {
        for period in [0.005, 0.02, 0.05] {
            let case = Case::of(place).with("control.period", period);
            assert_silent(&format!("{}, period {period}", place.0), &case, "tip", 0..2, 10.0);
        }
        let ideal = Case { mode: SensorMode::Ideal, ..Case::of(place) };
        assert_silent("ideal sensors", &ideal, "tip", 0..2, 10.0);
        assert_silent("late", &Case { delay: 0.015, ..Case::of(place) }, "tip", 0..2, 10.0);
        assert_silent("heinze-pid", &Case::of(place).with("control.period", 0.01), "heinze-pid", 0..2, 10.0);
    }
    assert_silent("heinze-pid at its own period", &Case::of(LAB), "heinze-pid", 0..1, 2.0);
    assert_silent("printed", &Case::of(("heinze-2007", LAB.1)), "tip", 0..2, 10.0);
    assert_silent("one cylinder", &Case::of(("single-cylinder", &[0.0])), "tip", 0..2, 10.0);
}

#[test]
fn valves_and_pumps_within_the_tolerances_raise_no_alarm() {
    for place in [LAB, LOADER] {
        let machine = load(place.0, &[]).expect("a bundled machine");
        for factor in [0.85, 1.15] {
            let scaled = |case: Case, c: &hydrocrane_machine::model::Cylinder| {
                case.with(&format!("valve.{}.nominal-flow", c.valve.name), factor * c.valve.nominal_flow)
            };
            let case = machine.cylinders.iter().fold(Case::of(place), scaled);
            assert_silent(&format!("{}, flow times {factor}", place.0), &case, "tip", 0..2, 10.0);
        }
        for factor in [0.97, 1.03] {
            let case = Case::of(place).with("supply.pressure", factor * machine.supply.pressure);
            assert_silent(&format!("{}, supply times {factor}", place.0), &case, "tip", 0..2, 10.0);
        }
    }
}

/// The stick pushed from 0.5 s until `release`.
pub fn pushed(direction: [f64; 2], release: f64) -> Sticks {
    let deflections = [direction, [0.0; 2]].concat();
    Sticks { times: vec![0.5, release], deflections, ..Sticks::centred(StickKind::Tip, 2) }
}

fn fault(signal: &str, kind: FaultKind, until: f64) -> SensorFault {
    SensorFault { signal: signal.into(), kind, from: 1.5, until: until.is_finite().then_some(until) }
}

pub const FOR_EVER: f64 = f64::INFINITY;
pub const UP: [f64; 2] = [0.0, 1.0];
pub const OUT: [f64; 2] = [1.0, 0.0];

/// A run of the laboratory crane at 0.2 m/s for 5 s, the stick released at 3 s.
fn failing(direction: [f64; 2], fault: SensorFault) -> (Arc<dyn Model>, SampledRun) {
    let case = Case::of(LAB).with("control.tip.full-speed", 0.2);
    let done = case.run("tip", pushed(direction, 3.0), 1, 5.0, &[fault]);
    assert_eq!(done.run.outcome.kind, OutcomeKind::Completed, "{}", done.run.outcome.message);
    (case.model(), done)
}

/// Places of the tip after the fault, from where it was then, along and across `direction`, m.
fn way(model: &dyn Model, done: &SampledRun, direction: [f64; 2]) -> Vec<[f64; 2]> {
    let n = model.layout().len();
    let tips: Vec<[f64; 2]> = done.run.states.chunks(n).skip(150).map(|x| model.tip_in_plane(&x[..3])).collect();
    let [x0, z0] = tips[0];
    let [a, b] = direction;
    tips.iter().map(|[x, z]| [(x - x0) * a + (z - z0) * b, (x - x0) * b - (z - z0) * a]).collect()
}

fn largest(way: &[[f64; 2]], axis: usize) -> f64 {
    way.iter().fold(0.0, |most, place| most.max(place[axis].abs()))
}

const JOINTS: [&str; 3] = ["joint.boom.q", "joint.jib.q", "joint.extension.q"];

#[test]
fn a_reading_that_stays_missing_impossible_or_astray_stops_the_crane() {
    let pressures = ["lift", "jib", "extension"].map(|c| [1, 2].map(|side| format!("cylinder.{c}.p{side}"))).concat();
    let mut faults: Vec<(&str, FaultKind, &str)> = Vec::new();
    for signal in JOINTS {
        faults.extend([0.01, -0.01, 0.3, -0.3].map(|size| (signal, FaultKind::Jump(size), "jumped")));
        faults.push((signal, FaultKind::DropOut, "gives no reading"));
    }
    faults.extend(["joint.boom.q", "joint.jib.q"].map(|s| (s, FaultKind::Jump(std::f64::consts::TAU), "out of range")));
    faults.extend(pressures.iter().map(|p| (p.as_str(), FaultKind::DropOut, "gives no reading")));
    faults.extend(pressures.iter().map(|p| (p.as_str(), FaultKind::Jump(600e5), "out of range")));
    for (signal, kind, words) in faults {
        for direction in [UP, OUT] {
            let (model, done) = failing(direction, fault(signal, kind, FOR_EVER));
            let [event] = &done.events[..] else { panic!("{signal} {kind:?}: {:?}", done.events) };
            assert!((event.time - 1.55).abs() < 1e-9, "{signal} {kind:?}: {event:?}");
            assert!(event.text.contains(signal) && event.text.contains("neutral"), "{event:?}");
            assert!(
                event.text.contains(words) || words == "jumped" && event.text.contains("out of range"),
                "{event:?}"
            );
            assert!(done.samples.commands[3 * 320..].iter().all(|u| *u == 0.0), "{signal} {kind:?}: not held");
            let way = way(model.as_ref(), &done, direction);
            // At 0.2 m/s: 10 mm ridden through and 27 mm by the lags of the stick.
            let (on, aside) = (largest(&way, 0), largest(&way, 1));
            assert!(on < 40e-3 && aside < 4e-3, "{signal} {kind:?}: {on} on, {aside} aside");
        }
    }
}

#[test]
fn a_frozen_joint_is_found_once_its_piston_has_moved() {
    for signal in JOINTS {
        for direction in [UP, OUT] {
            let (model, done) = failing(direction, fault(signal, FaultKind::Freeze, FOR_EVER));
            let [event] = &done.events[..] else { panic!("{signal}: {:?}", done.events) };
            assert!(event.text.contains(signal) && event.text.contains("frozen"), "{event:?}");
            assert!(event.time - 1.5 < 0.5, "{signal}: found after {} s", event.time - 1.5);
            let way = way(model.as_ref(), &done, direction);
            assert!(largest(&way, 1) < 15e-3, "{signal}: {} m astray", largest(&way, 1));
            assert!(largest(&way, 0) < 0.1, "{signal}: {} m on", largest(&way, 0));
        }
    }
}

#[test]
fn what_goes_unseen_of_a_pressure_leaves_the_tip_near_its_line() {
    for c in ["lift", "jib", "extension"] {
        for (side, kind) in
            [(1, FaultKind::Freeze), (2, FaultKind::Freeze), (1, FaultKind::Jump(-20e5)), (2, FaultKind::Jump(50e5))]
        {
            for direction in [UP, OUT] {
                let signal = format!("cylinder.{c}.p{side}");
                let (model, done) = failing(direction, fault(&signal, kind, FOR_EVER));
                let astray = largest(&way(model.as_ref(), &done, direction), 1);
                assert!(astray < 10e-3, "{signal} {kind:?}: {astray} m");
                assert!(done.events.iter().all(|e| e.text.contains(&signal)), "{:?}", done.events);
            }
        }
    }
}

#[test]
fn control_returns_when_the_sensor_does_and_the_stick_is_released() {
    let kinds = [FaultKind::DropOut, FaultKind::Freeze, FaultKind::Jump(0.05), FaultKind::Jump(9.0)];
    for (kind, release) in kinds.into_iter().flat_map(|kind| [(kind, 2.0), (kind, 3.5)]) {
        let case = Case::of(LAB).with("control.tip.full-speed", 0.2);
        let mut sticks = pushed(UP, release);
        sticks.times.extend([4.0, 4.5]);
        sticks.deflections.extend([0.0, -1.0, 0.0, 0.0]);
        let done = case.run("tip", sticks, 1, 6.0, &[fault("joint.jib.q", kind, 2.5)]);
        let [_, back] = &done.events[..] else { panic!("{kind:?}: {:?}", done.events) };
        assert!(back.text.contains("control restarts"), "{back:?}");
        // Half a second after the sensor is back at 2.5 s, but not with the stick pushed.
        let expected = release.max(3.0);
        assert!((back.time - expected).abs() < 0.02, "{kind:?}, released at {release}: {back:?}");
        // A crane that stops by itself takes 1.7 s at most until its valves are closed.
        let stopped = done.events[0].time + if kind == FaultKind::Freeze { 0.12 } else { 1.7 };
        let held = (stopped / 0.01).round() as usize..(100.0 * expected) as usize;
        for u in held.flat_map(|k| &done.samples.commands[3 * k..3 * k + 3]) {
            assert_eq!(*u, 0.0, "{kind:?}: not held");
        }
        let moving = &done.samples.commands[3 * 420..3 * 450];
        assert!(moving.iter().any(|u| u.abs() > 1e-3), "{kind:?}: the crane does not move again");
    }
}

#[test]
fn a_jump_that_stays_is_not_accepted_however_steady_it_reads() {
    let (_, done) = failing(UP, fault("joint.jib.q", FaultKind::Jump(0.05), FOR_EVER));
    assert_eq!(done.events.len(), 1, "{:?}", done.events);
}

#[test]
fn thresholds_of_the_machine_file_are_kept() {
    let alarms = |key: &str, value: f64, kind: FaultKind| {
        let case =
            Case::of(LAB).with("control.tip.full-speed", 0.2).with(&format!("control.plausibility.{key}"), value);
        let done = case.run("tip", pushed(UP, 3.0), 1, 4.0, &[fault("joint.jib.q", kind, FOR_EVER)]);
        done.events.iter().map(|e| e.time).next()
    };
    assert_eq!(alarms("jump", 1.0, FaultKind::Jump(0.05)), None);
    assert!(alarms("frozen", 5e-3, FaultKind::Freeze) > alarms("frozen", 1e-3, FaultKind::Freeze));
}
