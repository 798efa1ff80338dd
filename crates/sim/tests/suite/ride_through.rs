//! Sensors that fail for a moment, for longer, or that read in coarse steps.

use crate::plausibility::{assert_silent, pushed, Case, FOR_EVER, LAB, LOADER, OUT, UP};
use hydrocrane_machine::load;
use hydrocrane_sim::{FaultKind, OutcomeKind, SampledRun, SensorFault};

/// When a sensor begins to fail, in full motion, s.
const FAILS: f64 = 1.5;
/// When the stick is released, and the end of a run, s.
const RELEASED: f64 = 2.2;
const END: f64 = 3.6;

fn case(place: (&'static str, &'static [f64])) -> Case {
    Case::of(place).with("control.tip.full-speed", 0.2)
}

fn driven(case: &Case, direction: [f64; 2], faults: &[SensorFault]) -> SampledRun {
    let done = case.run("tip", pushed(direction, RELEASED), 1, END, faults);
    assert_eq!(done.run.outcome.kind, OutcomeKind::Completed, "{}", done.run.outcome.message);
    done
}

fn tips(case: &Case, done: &SampledRun) -> Vec<[f64; 2]> {
    let model = case.model();
    let joints = model.machine().joints.len();
    done.run.states.chunks(model.layout().len()).map(|x| model.tip_in_plane(&x[..joints])).collect()
}

/// Largest distance between the tips of two runs until the stick is released, and in all, m.
fn apart(case: &Case, one: &SampledRun, other: &SampledRun) -> [f64; 2] {
    let pairs = tips(case, one).into_iter().zip(tips(case, other));
    let away: Vec<f64> = pairs.map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).collect();
    let moving = (RELEASED / 0.01) as usize;
    [&away[..moving], &away].map(|away| away.iter().copied().fold(0.0, f64::max))
}

fn signals(case: &Case) -> Vec<String> {
    let model = case.model();
    let machine = model.machine();
    let joints = machine.joints.iter().map(|joint| format!("joint.{}.q", joint.name));
    let pressures = machine.cylinders.iter().flat_map(|c| [1, 2].map(|side| format!("cylinder.{}.p{side}", c.name)));
    joints.chain(pressures).collect()
}

fn fault(signal: &str, kind: FaultKind, lasts: f64) -> SensorFault {
    let until = (lasts < FOR_EVER).then_some(FAILS + lasts);
    SensorFault { signal: signal.into(), kind, from: FAILS, until }
}

/// Largest disturbance of the tip's path by faults of this kind, one sensor after the other: in motion and in all, m.
fn disturbance(
    place: (&'static str, &'static [f64]),
    kind: impl Fn(bool) -> FaultKind,
    lasts: f64,
    said: &str,
) -> [f64; 2] {
    let case = case(place);
    let mut most = [0.0f64; 2];
    for direction in [UP, OUT] {
        let healthy = driven(&case, direction, &[]);
        assert!(healthy.events.is_empty(), "{:?}", healthy.events);
        for signal in signals(&case) {
            let kind = kind(signal.starts_with("joint"));
            let done = driven(&case, direction, &[fault(&signal, kind, lasts)]);
            for event in &done.events {
                assert!(event.text.contains(&signal) && event.text.contains(said), "{signal}: {event:?}");
                assert!((event.time - FAILS - lasts).abs() < 1e-9, "{signal}: {event:?}");
            }
            // A jump that the chambers cannot tell from the truth goes unseen.
            assert!(done.events.len() == 1 || kind != FaultKind::DropOut, "{signal}: {:?}", done.events);
            let apart = apart(&case, &healthy, &done);
            println!(
                "{} {signal} {kind:?} for {lasts} s, {direction:?}: {:.2?} mm",
                place.0,
                apart.map(|off| 1e3 * off)
            );
            most = [0, 1].map(|part| most[part].max(apart[part]));
        }
    }
    most
}

#[test]
fn a_sample_that_drops_out_hardly_disturbs_the_path() {
    // After the stop a tip may settle at the other end of a count of its sensors.
    for (place, most) in [(LAB, [3e-4, 1e-3]), (LOADER, [1e-4, 1e-4])] {
        let off = disturbance(place, |_| FaultKind::DropOut, 0.01, "continued without it for 10 ms from 1.500 s");
        assert!(off[0] < most[0] && off[1] < most[1], "{}: {off:?}", place.0);
    }
}

#[test]
fn fifty_milliseconds_without_a_sensor_disturb_the_path_by_less_than_a_millimetre() {
    for (place, most) in [(LAB, 1e-3), (LOADER, 3e-4)] {
        let [_, off] = disturbance(place, |_| FaultKind::DropOut, 0.05, "continued without it for 50 ms from 1.500 s");
        assert!(off < most, "{}: {off}", place.0);
    }
}

#[test]
fn one_outlier_hardly_disturbs_the_path() {
    for (place, most) in [(LAB, 2e-3), (LOADER, 3e-4)] {
        for sense in [1.0, -1.0] {
            let kind = |joint: bool| FaultKind::Jump(if joint { 0.05 * sense } else { 50e5 * sense });
            let [_, off] = disturbance(place, kind, 0.01, "continued without it for 10 ms from 1.500 s");
            assert!(off < most, "{}: {off}", place.0);
        }
    }
}

#[test]
fn longer_failures_stop_the_crane_gently_until_the_sensor_is_back_and_the_stick_released() {
    for place in [LAB, LOADER] {
        let case = case(place);
        let strokes: Vec<f64> = case.model().machine().cylinders.iter().map(|c| c.valve.stroke).collect();
        let steps = |done: &SampledRun| {
            let rows: Vec<&[f64]> = done.samples.commands.chunks(strokes.len()).collect();
            let change = |pair: &[&[f64]]| {
                let moved =
                    pair[1].iter().zip(pair[0]).zip(&strokes).map(|((now, before), s)| (now - before).abs() / s);
                moved.fold(0.0, f64::max)
            };
            rows.windows(2).map(change).fold(0.0, f64::max)
        };
        for direction in [UP, OUT] {
            let healthy = driven(&case, direction, &[]);
            for signal in signals(&case) {
                let done = driven(&case, direction, &[fault(&signal, FaultKind::DropOut, 0.2)]);
                let [stop, back] = &done.events[..] else { panic!("{signal}: {:?}", done.events) };
                assert!(stop.text.contains(&signal) && stop.text.contains("neutral"), "{stop:?}");
                assert!((stop.time - FAILS - 0.05).abs() < 1e-9, "{stop:?}");
                assert!(back.text.contains("control restarts") && (back.time - RELEASED).abs() < 0.02, "{back:?}");
                // As a release of the stick, no spool moves faster.
                let (gentle, usual) = (steps(&done), steps(&healthy));
                let tips = tips(&case, &done);
                let at = |t: f64| tips[(t / 0.01).round() as usize];
                let way = (at(2.2)[0] - at(FAILS)[0]).hypot(at(2.2)[1] - at(FAILS)[1]);
                let rest = (at(2.2)[0] - at(2.1)[0]).hypot(at(2.2)[1] - at(2.1)[1]);
                println!(
                    "{} {signal} {direction:?}: spools {:.0} %/sample, {:.0} usually; stops in {:.1} mm, {:.2} mm in the last 0.1 s",
                    place.0,
                    1e2 * gentle,
                    1e2 * usual,
                    1e3 * way,
                    1e3 * rest
                );
                assert!(gentle <= 1.2 * usual + 0.02, "{signal}: {gentle} for {usual}");
                // The loader crane swings on.
                assert!(way < 0.055 && rest < 5e-3, "{signal}: {way} {rest}");
            }
        }
    }
}

#[test]
fn drop_outs_in_a_row_are_one_long_failure() {
    let case = case(LAB);
    let times = |events: &SampledRun| events.events.iter().map(|e| e.text.contains("neutral")).collect::<Vec<_>>();
    let repeated = |pause: f64| -> Vec<SensorFault> {
        let one = |k: usize| {
            let from = 1.0 + k as f64 * pause;
            SensorFault { signal: "joint.jib.q".into(), kind: FaultKind::DropOut, from, until: Some(from + 0.03) }
        };
        (0..3).map(one).collect()
    };
    assert_eq!(times(&driven(&case, UP, &repeated(0.35))), [false; 3]);
    assert!(times(&driven(&case, UP, &repeated(0.06))).contains(&true));
}

/// A machine whose pressures are measured in 256 steps up to 400 bar.
fn coarse(place: (&'static str, &'static [f64]), noise: f64) -> Case {
    let machine = load(place.0, &[]).expect("a bundled machine");
    let mut case = Case::of(place);
    for cylinder in &machine.cylinders {
        for side in [1, 2] {
            case.besides += &format!(
                "[sensor.{0}-p{side}]\nmeasures = \"cylinder.{0}.p{side}\"\nkind = \"pressure-transmitter\"\n\
                 range = \"400 bar\"\nbits = 8\nnoise = {noise:e}\n",
                cylinder.name
            );
        }
    }
    case
}

#[test]
fn pressures_in_256_steps_are_not_called_frozen() {
    for place in [LAB, LOADER] {
        for noise in [1e-9, 3e-4] {
            let what = format!("{}, 8 bits, noise {noise}", place.0);
            assert_silent(&what, &coarse(place, noise), "tip", 0..3, 30.0);
        }
    }
}

#[test]
fn a_pressure_in_256_steps_that_freezes_is_found_when_the_load_must_have_changed() {
    let case = coarse(LAB, 1e-9).with("control.tip.full-speed", 0.2);
    let frozen = SensorFault { signal: "cylinder.lift.p1".into(), kind: FaultKind::Freeze, from: 0.1, until: None };
    let done = case.run("tip", pushed(UP, 4.0), 1, 5.0, &[frozen]);
    let [event] = &done.events[..] else { panic!("{:?}", done.events) };
    assert!(event.text.contains("cylinder.lift.p1") && event.text.contains("frozen"), "{event:?}");
}
