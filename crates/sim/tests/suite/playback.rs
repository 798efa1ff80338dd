//! Scenarios played live: nobody takes over, and they are the run; an operator takes over, and the plan ends.

use hydrocrane_machine::scenario::Stage;
use hydrocrane_machine::{parse_scenario, OverrideValue};
use hydrocrane_sim::assembly::{assemble, Assembly, AssemblyError, Machines, RunSettings, Surroundings};
use hydrocrane_sim::controller::Controller;
use hydrocrane_sim::{Model, OutcomeKind, Playback};
use std::sync::Arc;

const HEAD: &str = r#"
[scenario]
name = "played"
machine = "rottne-f9-lab"
duration = "0.6 s"
[initial.joint]
boom = "100 deg"
jib = "100 deg"
extension = "0.2 m"
[payload]
time = ["0.1 s", "0.5 s"]
mass = ["40 kg", "10 kg"]
"#;
const COMMANDS: &str =
    "[command.lift]\ntime = [\"0 s\", \"0.2 s\"]\nspool = [\"1 mm\", \"5 mm\"]\ninterpolation = \"linear\"\n";
const TIP: &str = "[controller]\nname = \"tip\"\n";
const LEVERS: &str =
    "[phase.levers]\ntime = \"0.3 s\"\njoystick = { mode = \"lever\", time = [\"0.4 s\"], jib = [0.3] }\n";
const IDLE: &str = "[phase.idle]\ntime = \"0.305 s\"\ncontroller.name = \"lever\"\n";
const BURST: &str =
    "[burst.torn]\ncylinder = \"lift\"\nside = \"piston-side\"\ntime = \"0.35 s\"\nopening = \"5 mm^2\"\n";

fn assembly(parts: &[&str]) -> Assembly {
    let text = [&[HEAD], parts].concat().concat();
    let scenario = parse_scenario(&text, "played.toml", &[]).unwrap_or_else(|error| panic!("{error}"));
    let settings = RunSettings { ledger: false, max_steps: 1_000_000 };
    let mut machines = Machines { machine: "rottne-f9-lab", text: None };
    assemble(&scenario, settings, &mut machines).unwrap_or_else(|error| panic!("{error}"))
}

fn playback(parts: &[&str]) -> Playback {
    Playback::new(assembly(parts)).expect("it can begin")
}

#[test]
fn nobody_takes_over_and_it_is_the_run_to_the_last_bit() {
    for parts in [
        &[COMMANDS][..],
        &[COMMANDS, LEVERS],
        &[COMMANDS, IDLE, BURST],
        &[TIP],
        &[TIP, LEVERS],
        &[TIP, IDLE],
        &[TIP, BURST],
        &[TIP, LEVERS, BURST],
    ] {
        let mut played = playback(parts);
        assert!(played.advance_samples(Some(0.6)), "{parts:?}");
        // At a sample, where a step of the drive ends.
        let end = played.live.time();
        let run = Assembly { end, ..assembly(parts) }.run(&[end], &mut |_| true).run;
        assert_eq!(run.outcome.kind, OutcomeKind::Completed, "{}", run.outcome.message);
        assert_eq!(played.live.state(), run.states, "{parts:?}");
        assert_eq!(played.live.payload(), 10.0, "{parts:?}");
        assert_eq!(played.live.loads().1, run.payload_events, "{parts:?}");
    }
}

#[test]
fn whoever_takes_over_keeps_the_load_and_ends_the_plan() {
    for (parts, axes) in [(&[COMMANDS, LEVERS][..], 3), (&[TIP, LEVERS], 2)] {
        let mut played = playback(parts);
        assert!(played.advance_samples(Some(0.2)));
        assert!(played.live.replaying());
        played.take_over();
        assert!(!played.live.replaying() && !played.live.follows_commands());
        assert!(played.advance_samples(Some(0.5)));
        assert_eq!((played.live.payload(), played.live.loads().1.len()), (40.0, 1), "{parts:?}");
        assert_eq!((played.next_phase(), played.live.sticks().axes), (f64::INFINITY, axes), "{parts:?}");
        played.live.carry(5.0);
        assert!(played.advance_samples(Some(0.1)));
        assert_eq!(played.live.payload(), 5.0, "{parts:?}");
    }
}

#[test]
fn samples_count_from_the_begin_of_each_stage() {
    let mut played = playback(&[TIP, IDLE]);
    let mut times = Vec::new();
    while played.live.time() < 0.32 {
        assert!(played.advance_samples(None));
        times.push(played.live.time());
    }
    let expected: Vec<f64> = (1..=30).map(|k| f64::from(k) * 0.01).chain([0.305, 0.315, 0.325]).collect();
    assert_eq!(times.len(), expected.len());
    assert!(times.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-12), "{times:?}");
    // A long step ends at the first sample that is due.
    let mut long = playback(&[TIP, IDLE]);
    assert!(long.advance_samples(Some(0.303)));
    assert_eq!(long.live.time(), 0.305);
    assert!(long.advance_samples(Some(0.012)));
    assert!((long.live.time() - 0.325).abs() < 1e-12);
}

/// Makes machines, and counts them.
struct Counting<'a> {
    inner: Machines<'a>,
    made: usize,
}

impl Surroundings for Counting<'_> {
    fn machine(
        &mut self,
        source: Option<&str>,
        overrides: &[(String, OverrideValue)],
    ) -> Result<Arc<dyn Model>, AssemblyError> {
        self.made += 1;
        self.inner.machine(source, overrides)
    }

    fn own_controller(&mut self, _: usize, _: &Stage, _: &Arc<dyn Model>) -> Option<Box<dyn Controller>> {
        None
    }
}

#[test]
fn phases_that_change_no_value_of_the_machine_make_none() {
    let text: Vec<String> = (1..=300)
        .map(|i| {
            let value = if i == 100 { "overrides = { \"supply.pressure\" = \"120 bar\" }\n" } else { "" };
            format!("[phase.p{i}]\ntime = \"{i} ms\"\njoystick = {{ time = [\"{i} ms\"], x = [0.1] }}\n{value}")
        })
        .collect();
    let text = [HEAD, TIP, &text.concat()].concat();
    let scenario = parse_scenario(&text, "many.toml", &[]).unwrap_or_else(|error| panic!("{error}"));
    let mut counting = Counting { inner: Machines { machine: "rottne-f9-lab", text: None }, made: 0 };
    let settings = RunSettings { ledger: false, max_steps: 1_000_000 };
    let assembly = assemble(&scenario, settings, &mut counting).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((assembly.stages.len(), counting.made), (301, 2));
}
