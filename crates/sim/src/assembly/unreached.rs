//! What a scenario states against time and its run never reaches: often a time in ms, or one since 1970.

use super::start::short;
use crate::warning::Warning;
use hydrocrane_machine::scenario::{Interpolation, Scenario};

const CURE: &str =
    "times are in s from the start of the run: check their unit and their zero, or state a longer duration";
/// Fewest times of a series within the run, of those that have more than one.
const FEWEST: usize = 2;

/// Warnings on series that hardly overlap the run of `scenario`, and on events after its end.
pub(super) fn unreached(scenario: &Scenario) -> Vec<Warning> {
    let end = scenario.duration;
    let after = |what: String, time: f64| {
        format!("{what} at {} s, after the end of the run at {} s: it never happens", short(time), short(end))
    };
    let mut texts: Vec<String> = series(scenario).filter_map(|series| series.unreached(end)).collect();
    let phases = scenario.phases.iter().map(|phase| (format!("phase `{}` begins", phase.name), phase.time));
    let faults =
        scenario.sensor_faults.iter().map(|fault| (format!("the sensor of `{}` fails", fault.signal), fault.from));
    let burst = |cylinder: &str, side: &str| format!("the hose to the {side} of cylinder `{cylinder}` bursts");
    let bursts = scenario.bursts.iter().map(|hose| (burst(&hose.cylinder, hose.side.name()), hose.time));
    texts.extend(
        phases.chain(faults).chain(bursts).filter(|(_, time)| *time >= end).map(|(what, time)| after(what, time)),
    );
    let goal = scenario.goals.first().filter(|goal| goal.time >= end);
    texts.extend(goal.map(|goal| after("the first goal of the tip is given".into(), goal.time)));
    // A load that changes at the very end does change.
    let load = scenario.payload_changes.first().filter(|(time, _)| *time > end);
    texts.extend(load.map(|(time, _)| after("the load changes for the first time".into(), *time)));
    let warned = |text| Warning { time: 0.0, kind: "never-happens", text, cure: CURE.into() };
    texts.into_iter().map(warned).collect()
}

/// Values against time.
struct Series {
    what: String,
    /// s, not all ascending where it holds those of several commands.
    times: Vec<f64>,
    linear: bool,
}

/// The commands of each cylinder, and all of them together; the supply pressure; the sticks of the start and of each phase.
fn series(scenario: &Scenario) -> impl Iterator<Item = Series> + '_ {
    let linear = |interpolation| interpolation == Interpolation::Linear;
    let supply = scenario.supply.iter().map(move |supply| Series {
        what: "the measured supply pressure".into(),
        times: supply.time.clone(),
        linear: linear(supply.interpolation),
    });
    let phases = scenario.phases.iter().filter(|phase| phase.time < scenario.duration);
    let sticks = scenario.joystick.iter().chain(phases.filter_map(|phase| phase.joystick.as_ref()));
    let sticks = sticks.map(move |stick| Series {
        what: "the sticks".into(),
        times: stick.time.clone(),
        linear: linear(stick.interpolation),
    });
    let outside = scenario.commands.iter().filter(|one| !overlaps(&one.time, scenario.duration));
    let mut commands: Vec<Series> = outside
        .map(|command| Series {
            what: format!("the command of `{}`", command.cylinder),
            times: command.time.clone(),
            linear: linear(command.interpolation),
        })
        .collect();
    if commands.is_empty() && !scenario.commands.is_empty() {
        commands.push(Series {
            what: "the spool commands".into(),
            times: scenario.commands.iter().flat_map(|command| command.time.iter().copied()).collect(),
            linear: scenario.commands.iter().any(|command| linear(command.interpolation)),
        });
    }
    commands.into_iter().chain(supply).chain(sticks)
}

impl Series {
    /// What is wrong if it hardly overlaps a run until `end` (s).
    fn unreached(&self, end: f64) -> Option<String> {
        let [first, last] = ends(&self.times)?;
        let inside = self.times.iter().filter(|time| (0.0..=end).contains(*time)).count();
        // One value holds for the whole run, and so does a line from before it to beyond.
        let constant = first == last && first <= end;
        let spans = self.linear && first <= 0.0 && end <= last && self.times.len() <= FEWEST;
        (inside < FEWEST && !constant && !spans).then(|| {
            let (all, first, last, end) = (self.times.len(), short(first), short(last), short(end));
            let what = &self.what;
            format!(
                "of the {all} times of {what}, from {first} to {last} s, {inside} lie within the run from 0 to {end} s"
            )
        })
    }
}

fn overlaps(times: &[f64], end: f64) -> bool {
    ends(times).is_none_or(|[first, last]| first <= end && (0.0 <= last || first == last))
}

/// The first and the last time.
fn ends(times: &[f64]) -> Option<[f64; 2]> {
    let least = times.iter().copied().reduce(f64::min)?;
    Some([least, times.iter().copied().reduce(f64::max)?])
}
