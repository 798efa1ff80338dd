//! What a scenario states against time and its run never reaches: often a time in ms, or one since 1970.

use crate::warning::{short, Warning};
use hydrocrane_machine::scenario::{Interpolation, Scenario, SpoolCommand};
use hydrocrane_machine::Machine;

const CURE: &str =
    "times are in s from the start of the run: check their unit and their zero, or state a longer duration";
/// Fewest times of a series within the run, of those that have more than one.
const FEWEST: usize = 2;
/// A command with its first time alone in the run is in another unit where the next one comes so many times later than the end while
/// another command fits the run, or where the last one comes so many times later: runs are also shortened for a look at their start.
const LATE: [f64; 2] = [10.0, 500.0];
/// Share of the run, and of a spool's stroke, that is no more than one in a unit a thousand times smaller.
const THOUSANDTH: f64 = 1.001e-3;
/// Share of the run that all times in minutes lie within, where they fill half of it in seconds or more, and how many times are more than one pulse.
const MINUTES: f64 = 1.0 / 30.0;
const MANY: usize = 4;

/// Warnings on series that hardly overlap the run of `scenario` on `machine`, on events after its end, and on spools that hardly move.
pub fn unreached(scenario: &Scenario, machine: &Machine) -> Vec<Warning> {
    let end = scenario.duration;
    let after = |what: String, time: f64| {
        format!("{what} at {} s, after the end of the run at {} s: it never happens", short(time), short(end))
    };
    let mut texts: Vec<String> = series(scenario).filter_map(|series| series.unreached(end)).collect();
    // Those of Python have no names.
    let named = |name: &str| if name.is_empty() { "a phase begins".into() } else { format!("phase `{name}` begins") };
    let phases = scenario.phases.iter().map(|phase| (named(&phase.name), phase.time));
    let faults =
        scenario.faults.sensors.iter().map(|fault| (format!("the sensor of `{}` fails", fault.signal), fault.from));
    let burst = |cylinder: &str, side: &str| format!("the hose to the {side} of cylinder `{cylinder}` bursts");
    let bursts = scenario.faults.bursts.iter().map(|hose| (burst(&hose.cylinder, hose.side.name()), hose.time));
    texts.extend(
        phases.chain(faults).chain(bursts).filter(|(_, time)| *time >= end).map(|(what, time)| after(what, time)),
    );
    let goal = scenario.goals.first().filter(|goal| goal.time >= end);
    texts.extend(goal.map(|goal| after("the first goal of the tip is given".into(), goal.time)));
    // A load that changes at the very end does change.
    let load = scenario.load.changes.first().filter(|(time, _)| *time > end);
    texts.extend(load.map(|(time, _)| after("the load changes for the first time".into(), *time)));
    if scenario.record_interval > end {
        texts.push(format!(
            "the record interval of {} s is longer than the run of {} s: no more than its start and its end are recorded",
            short(scenario.record_interval),
            short(end)
        ));
    }
    let warned = |text, cure: &str| Warning { time: 0.0, kind: "never-happens", key: None, text, cure: cure.into() };
    let light = light(scenario, machine);
    let still = scenario.commands.iter().filter_map(|command| still(command, machine));
    texts
        .into_iter()
        .map(|text| warned(text, CURE))
        .chain(still.map(|text| warned(text, "check its unit: m, mm or um?")))
        .chain(light)
        .collect()
}

/// Warning on a load that is nothing beside the links: of `payload`, which is also checked in the machine file, or of its changes.
fn light(scenario: &Scenario, machine: &Machine) -> Option<Warning> {
    let moving = machine.moving_mass();
    let is_light = |mass: &f64| 0.0 < *mass && *mass <= THOUSANDTH * moving;
    let change = || scenario.load.changes.iter().map(|(_, mass)| *mass).find(is_light);
    let stated = scenario.load.payload.filter(is_light);
    let key = if stated.is_some() { "payload" } else { "payload-changes" };
    let mass = stated.or_else(change)?;
    Some(Warning {
        time: 0.0,
        kind: "implausible-value",
        key: Some(format!("scenario.{key}")),
        text: format!("the load of {} kg is small: the moving links have {} kg", short(mass), short(moving)),
        cure: "check its unit: g, kg or t? State 0 kg for none".into(),
    })
}

/// What is wrong with a command that hardly opens its valve.
fn still(command: &SpoolCommand, machine: &Machine) -> Option<String> {
    let of = machine.cylinders.iter().find(|of| of.name == command.cylinder)?;
    let (most, stroke) = (command.spool.iter().fold(0.0, |most: f64, spool| most.max(spool.abs())), of.valve.stroke);
    (0.0 < most && most <= THOUSANDTH * stroke).then(|| {
        let (name, most, stroke) = (&of.name, short(1e3 * most), short(1e3 * stroke));
        format!("the command of `{name}` moves its spool by {most} mm at most, of a stroke of {stroke} mm")
    })
}

/// Values against time.
struct Series {
    what: String,
    /// s, not all ascending where it holds those of several commands.
    times: Vec<f64>,
    linear: bool,
    /// Whether all comes to rest: what ends in motion goes on until the end of the run.
    rests: bool,
}

/// The commands of each cylinder that does not fit the run, or all of them together; the supply pressure; the sticks of the start and of
/// each phase.
fn series(scenario: &Scenario) -> impl Iterator<Item = Series> + '_ {
    let linear = |interpolation| interpolation == Interpolation::Linear;
    let supply = scenario.supply.iter().map(move |supply| Series {
        what: "the measured supply pressure".into(),
        times: supply.time.clone(),
        linear: linear(supply.interpolation),
        rests: false,
    });
    let phases = scenario.phases.iter().filter(|phase| phase.time < scenario.duration);
    let sticks = scenario.joystick.iter().chain(phases.filter_map(|phase| phase.joystick.as_ref()));
    let sticks = sticks.map(move |stick| Series {
        what: "the sticks".into(),
        times: stick.time.clone(),
        linear: linear(stick.interpolation),
        rests: stick.axes.iter().all(|axis| axis.last() == Some(&0.0)),
    });
    let end = scenario.duration;
    let fits = scenario.commands.iter().any(|one| inside(&one.time, end) >= FEWEST);
    let outside = scenario.commands.iter().filter(|one| outside(&one.time, end, fits));
    let mut commands: Vec<Series> = outside
        .map(|command| Series {
            what: format!("the command of `{}`", command.cylinder),
            times: command.time.clone(),
            linear: linear(command.interpolation),
            rests: false,
        })
        .collect();
    if commands.is_empty() && !scenario.commands.is_empty() {
        commands.push(Series {
            what: "the spool commands".into(),
            times: scenario.commands.iter().flat_map(|command| command.time.iter().copied()).collect(),
            linear: scenario.commands.iter().any(|command| linear(command.interpolation)),
            rests: scenario.commands.iter().all(|command| command.spool.last() == Some(&0.0)),
        });
    }
    commands.into_iter().chain(supply).chain(sticks)
}

impl Series {
    /// What is wrong if it hardly overlaps a run until `end` (s).
    fn unreached(&self, end: f64) -> Option<String> {
        let [first, last] = ends(&self.times)?;
        let inside = inside(&self.times, end);
        let (all, what) = (self.times.len(), &self.what);
        let unlike = all > FEWEST && last <= THOUSANDTH * end;
        let minutes = self.rests && all >= MANY && last <= MINUTES * end;
        if 0.0 <= first && first < last && end.is_finite() && (unlike || minutes) {
            let [last, end] = [last, end].map(short);
            return Some(format!("all {all} times of {what} lie within the first {last} s of the run of {end} s"));
        }
        // One value holds for the whole run, and so does a line from before it to beyond.
        let constant = first == last && first <= end;
        let spans = self.linear && first <= 0.0 && end <= last && self.times.len() <= FEWEST;
        (inside < FEWEST && !constant && !spans).then(|| {
            let [first, last, end] = [first, last, end].map(short);
            format!(
                "of the {all} times of {what}, from {first} to {last} s, {inside} lie within the run from 0 to {end} s"
            )
        })
    }
}

/// Whether these times are not those of a run until `end` (s), which another command `fits`.
fn outside(times: &[f64], end: f64, fits: bool) -> bool {
    let Some([first, last]) = ends(times).filter(|[first, last]| first < last || *first > end) else { return false };
    let late = if fits { times.iter().all(|time| *time <= 0.0 || *time > LATE[0] * end) } else { last > LATE[1] * end };
    first > end || (end.is_finite() && last <= THOUSANDTH * end) || late
}

fn inside(times: &[f64], end: f64) -> usize {
    times.iter().filter(|time| (0.0..=end).contains(*time)).count()
}

/// The first and the last time.
fn ends(times: &[f64]) -> Option<[f64; 2]> {
    let least = times.iter().copied().reduce(f64::min)?;
    Some([least, times.iter().copied().reduce(f64::max)?])
}
