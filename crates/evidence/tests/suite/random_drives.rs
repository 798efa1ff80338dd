//! The short form of `make drives`: a few seconds of random sticks for every bundled machine and mode.

use hydrocrane_evidence::bound::Bounds;
use hydrocrane_evidence::case::{machines, modes, Case};
use hydrocrane_evidence::core::{Core, Native};
use hydrocrane_evidence::course::{Course, Plan};
use hydrocrane_evidence::drives::{campaign, drive, Options, TIP};
use hydrocrane_evidence::lowering::lowering;
use serde_json::json;

fn options(drives: u64, seconds: f64) -> Options {
    Options { drives, seconds, followed: 2.0, seed: 0, threads: 2, keep: None, page: None }
}

#[test]
fn random_drives_hold_with_every_machine_mode_and_payload() {
    let mut cases = Vec::new();
    for machine in machines() {
        for mode in modes() {
            let payloads = [0.0, 80.0, 300.0];
            cases.extend(payloads.map(|payload| Case {
                machine: machine.into(),
                mode: mode.into(),
                payload,
                ground: true,
            }));
        }
    }
    let all = campaign(&cases, &options(1, 8.0), &|_| ()).expect("drives");
    let faults: Vec<String> = all
        .iter()
        .flat_map(|f| {
            f.faults().into_iter().map(move |fault| format!("{} {} {} kg: {fault}", f.machine, f.mode, f.payload))
        })
        .collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(all.iter().filter(|f| f.refused.is_none()).count() >= 24, "hardly anything was driven");
}

/// A chamber cavitates when the lift stops at once: steps of 1 ms went wrong by half a metre.
#[test]
fn a_lift_that_stops_with_a_cavitating_chamber_ends_where_the_adaptive_method_ends() {
    let done = lowering().expect("two runs");
    assert!(done.difference < TIP, "{} m", done.difference);
    assert!(done.gap.share < 0.01, "open by {} J", done.gap.residual);
    assert_eq!(done.outcome, "completed");
    assert!((done.peaks[0] / done.peaks[1] - 1.0).abs() < 0.1, "{:?}", done.peaks);
}

/// A core that tells wrong numbers, as a drive that blew up did.
struct Wrong(fn(&mut Course));

impl Core for Wrong {
    fn drive(&mut self, plan: &Plan) -> Result<Course, String> {
        let mut course = Native.drive(plan)?;
        (self.0)(&mut course);
        Ok(course)
    }
}

#[test]
fn every_kind_of_wrong_drive_is_found() {
    let case = Case { machine: "rig-rottne".into(), mode: "lever".into(), payload: 0.0, ground: false };
    type Change = fn(&mut Course);
    let wrong: [(&str, Change); 5] = [
        ("ended", |course| {
            let ended = json!({ "kind": "solver-failed", "time": 1.0, "message": "no" });
            course.ended = serde_json::from_value(ended).ok();
        }),
        ("supply and load", |course| {
            let at = course.index("cylinder.test.p1").expect("a chamber");
            course.peaks[0][at] = 1e9;
        }),
        ("supply and load", |course| {
            let at = course.index("cylinder.test.p2").expect("a chamber");
            course.peaks[1][at] = f64::NAN;
        }),
        ("ledger", |course| {
            let at = course.index("ledger.supply").expect("a term");
            course.rows.iter_mut().for_each(|row| row[at] *= 1.05);
        }),
        ("adaptive", |course| course.tip.iter_mut().for_each(|tip| tip[1] += 0.006)),
    ];
    let right = drive(&case, &options(1, 6.0), &mut Native).expect("a drive");
    assert!(right.faults().is_empty(), "{:?}", right.faults());
    for (what, change) in wrong {
        let faults = drive(&case, &options(1, 6.0), &mut Wrong(change)).expect("a drive").faults();
        assert!(faults.len() == 1 && faults[0].contains(what), "{what}: {faults:?}");
    }
}

#[test]
fn the_bound_at_rest_is_that_of_a_hanging_load() {
    // Rod side of the friction rig: piston side on the supply, and the load pulls outward.
    let case = Case { machine: "rig-rottne".into(), mode: "lever".into(), payload: 115.0, ground: false };
    let (machine, model) = case.model().expect("a machine");
    let [piston, rod] = [0.05f64, 0.03].map(|d| std::f64::consts::FRAC_PI_4 * d * d);
    let load = -(115.0 + 5.173) * 9.81;
    let friction = model.steady_friction(0, 1.0);
    let supply = machine.supply.pressure;
    let bounds = Bounds::new(model.as_ref(), 115.0).at(&[0.0]);
    let expected = (supply * piston - load + friction) / (piston - rod);
    assert!((bounds[1].rest / expected - 1.0).abs() < 1e-9, "{} {expected}", bounds[1].rest);
    assert_eq!(bounds[0].rest, supply);
    assert!(bounds[1].motion > 0.0);
}
