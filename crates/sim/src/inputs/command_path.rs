//! The command path: from a controller's command to the spools by signal chain, limits and delays.

use crate::warning::{short, Warning};
use hydrocrane_machine::model::{SignalChain, Valve};
use hydrocrane_machine::Machine;
use hydrocrane_num::{Archive, Dual, Real};
use hydrocrane_physics::hydraulics::hysteresis;
use hydrocrane_plant::layout::MAX_JOINTS;
use std::collections::VecDeque;

/// The command path of each cylinder.
pub(crate) struct CommandPaths {
    paths: Vec<CommandPath>,
    /// Commands that the spools have received, m.
    pub arrived: [f64; MAX_JOINTS],
    /// The first command far beyond its spool's stroke, and whether it has been reported.
    astray: Option<Warning>,
    reported: bool,
}

struct CommandPath {
    chain: SignalChain,
    stroke: f64,
    delay: f64,
    /// (time of arrival, value), in the order sent.
    pending: VecDeque<(f64, f64)>,
}

impl CommandPath {
    fn new(valve: &Valve) -> Self {
        CommandPath { chain: valve.command, stroke: valve.stroke, delay: delay(valve), pending: VecDeque::new() }
    }
}

/// Strokes beyond which a command is one in another unit: a command in mm is a thousand times as large as in m, so that one of a tenth of
/// the stroke is found.
const FAR: f64 = 100.0;
/// Rounding allowed between a time of arrival and the time at hand, s.
const ROUNDING: f64 = 1e-12;
/// Most commands per spool, sent and not arrived, that are stored with a state.
const MOST_PENDING: u64 = 1 << 20;

impl CommandPaths {
    /// With the commands `arrived` (m) at the spools, and no others sent.
    pub fn new(machine: &Machine, arrived: [f64; MAX_JOINTS]) -> Self {
        let paths = machine.cylinders.iter().map(|c| CommandPath::new(&c.valve)).collect();
        CommandPaths { paths, arrived, astray: None, reported: false }
    }

    /// Continues with the valves of `machine`; commands that were sent still arrive on time.
    pub fn follow(&mut self, machine: &Machine) {
        for (path, cylinder) in self.paths.iter_mut().zip(&machine.cylinders) {
            let pending = std::mem::take(&mut path.pending);
            *path = CommandPath { pending, ..CommandPath::new(&cylinder.valve) };
        }
    }

    pub fn clear(&mut self) {
        self.paths.iter_mut().for_each(|path| path.pending.clear());
        self.arrived.fill(0.0);
        (self.astray, self.reported) = (None, false);
    }

    /// Looks at the commands `u` (m) of a controller for one far beyond the stroke of its spool.
    pub fn look(&mut self, now: f64, machine: &Machine, u: &[f64]) {
        if self.reported || self.astray.is_some() {
            return;
        }
        self.astray = machine.cylinders.iter().zip(u).find_map(|(c, u)| astray(now, &c.name, c.valve.stroke, *u));
    }

    /// The warning of a command far beyond its spool's stroke, once.
    pub fn warning(&mut self) -> Option<Warning> {
        let found = self.astray.take();
        self.reported |= found.is_some();
        found
    }

    /// Sends the commands `u` (m) at time `now`, which must not decrease, because commands arrive in the order sent.
    pub fn send(&mut self, now: f64, u: &[f64]) {
        for ((path, &u), arrived) in self.paths.iter_mut().zip(u).zip(&self.arrived) {
            let before = path.pending.back().map_or(*arrived, |(_, value)| *value);
            let value = follow(&path.chain, before, at_spool(&path.chain, path.stroke, u));
            path.pending.push_back((now + path.delay, value));
        }
    }

    /// Delivers the commands that arrive until `now`; returns whether a spool command changed.
    pub fn receive(&mut self, now: f64) -> bool {
        let before = self.arrived;
        for (path, arrived) in self.paths.iter_mut().zip(&mut self.arrived) {
            while let Some(&(_, value)) = path.pending.front().filter(|(t, _)| *t <= now + ROUNDING) {
                *arrived = value;
                path.pending.pop_front();
            }
        }
        self.arrived != before
    }

    /// Commands at the spools, and those sent and not arrived.
    pub fn archive(&mut self, archive: &mut Archive) {
        archive.numbers(&mut self.arrived);
        for path in &mut self.paths {
            let mut count = path.pending.len() as u64;
            archive.whole(&mut count);
            // Damaged bytes must not cause a huge allocation.
            path.pending.resize(count.min(MOST_PENDING) as usize, (0.0, 0.0));
            for (time, value) in &mut path.pending {
                archive.number(time);
                archive.number(value);
            }
        }
    }

    pub fn next_arrival(&self) -> Option<f64> {
        self.paths.iter().filter_map(|path| path.pending.front()).map(|&(t, _)| t).reduce(f64::min)
    }
}

/// The warning of a command `u` (m) at the time `now` (s) to the cylinder of this name and spool stroke (m), where it is far beyond it.
pub(crate) fn astray(now: f64, name: &str, stroke: f64, u: f64) -> Option<Warning> {
    (u.abs() > FAR * stroke).then(|| Warning {
        time: now,
        kind: "command-beyond-stroke",
        key: None,
        text: format!(
            "a command puts the spool of `{name}` at {} m, of a stroke of {} mm; it goes to its end",
            short(u),
            short(1e3 * stroke)
        ),
        cure: "spool commands are in m, positive extends the piston".to_string(),
    })
}

/// Command that a spool follows, m, after the one `before`, where `value` arrives at its pilot stage, which may have hysteresis.
pub fn follow(chain: &SignalChain, before: f64, value: f64) -> f64 {
    if chain.play == 0.0 {
        return value;
    }
    hysteresis::follow(chain.play, before, value)
}

/// Whether a pilot stage of `machine` has hysteresis: what its spool does then depends on what it did before.
pub fn has_hysteresis(machine: &Machine) -> bool {
    machine.cylinders.iter().any(|c| c.valve.command.play > 0.0)
}

/// Time from a command to its arrival at the spool, s.
pub(crate) fn delay(valve: &Valve) -> f64 {
    valve.command.delay + valve.delay
}

/// Longest time from a command to its arrival at a spool of `machine`, s.
pub fn longest_delay(machine: &Machine) -> f64 {
    machine.cylinders.iter().map(|c| delay(&c.valve)).fold(0.0, f64::max)
}

/// Commands that arrive at the spools of `machine` for the commands `u`, all in m, and their derivatives by these;
/// without the delay and the hysteresis.
pub fn at_spools(machine: &Machine, u: &[f64]) -> Vec<(f64, f64)> {
    let valves = machine.cylinders.iter().map(|c| &c.valve);
    let one = |(valve, &u): (&Valve, &f64)| {
        let spool: Dual<f64, 1> = at_spool(&valve.command, valve.stroke, Dual::variable(u, 0));
        (spool.value, spool.derivative[0])
    };
    valves.zip(u).map(one).collect()
}

/// Command that arrives at a spool of this stroke (m), or at its pilot stage, for the command `u`.
pub fn at_spool<T: Real>(chain: &SignalChain, stroke: f64, u: T) -> T {
    Real::clamp(apply_signal_chain(chain, u), T::c(-stroke), T::c(stroke))
}

/// Commands at which the characteristic of a spool of this stroke (m) has kinks: the ends of dead band, signal and
/// stroke.
pub(crate) fn kinks(chain: &SignalChain, stroke: f64) -> Vec<f64> {
    let band = [-chain.dead_band, chain.dead_band];
    let mut kinks: Vec<f64> = if chain.dead_band > 0.0 { band.to_vec() } else { Vec::new() };
    let beyond = [chain.low, chain.high, -stroke, stroke].map(|end| (end - chain.offset) / chain.gain);
    kinks.extend(beyond.iter().filter(|u| u.is_finite() && **u != 0.0).map(|u| u + chain.dead_band.copysign(*u)));
    kinks.sort_by(f64::total_cmp);
    kinks.dedup();
    kinks
}

/// Applies the signal chain, without its delay, to the command `u`. Inside the dead band only the offset remains.
pub fn apply_signal_chain<T: Real>(chain: &SignalChain, u: T) -> T {
    let beyond = u - Real::clamp(u, T::c(-chain.dead_band), T::c(chain.dead_band));
    Real::clamp(beyond * chain.gain + chain.offset, T::c(chain.low), T::c(chain.high))
}
