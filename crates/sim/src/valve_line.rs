//! From a controller's command to the spools: signal chain, limits, delays.

use hydrocrane_machine::model::{SignalChain, Valve};
use hydrocrane_machine::Machine;
use hydrocrane_plant::layout::MAX_JOINTS;
use std::collections::VecDeque;

/// The way of each cylinder's command.
pub(crate) struct ValveLines {
    lines: Vec<Line>,
    /// Commands that the spools have received, m.
    pub arrived: [f64; MAX_JOINTS],
}

struct Line {
    chain: SignalChain,
    stroke: f64,
    delay: f64,
    /// (time of arrival, value), in the order sent.
    pending: VecDeque<(f64, f64)>,
}

impl Line {
    fn new(valve: &Valve) -> Self {
        Line { chain: valve.command, stroke: valve.stroke, delay: delay(valve), pending: VecDeque::new() }
    }
}

/// Rounding allowed between a time of arrival and the time at hand, s.
const ROUNDING: f64 = 1e-12;

impl ValveLines {
    pub fn new(machine: &Machine) -> Self {
        let lines = machine.cylinders.iter().map(|c| Line::new(&c.valve)).collect();
        ValveLines { lines, arrived: [0.0; MAX_JOINTS] }
    }

    /// Goes on with the valves of `machine`; commands under way still arrive when they would have.
    pub fn follow(&mut self, machine: &Machine) {
        for (line, cylinder) in self.lines.iter_mut().zip(&machine.cylinders) {
            let pending = std::mem::take(&mut line.pending);
            *line = Line { pending, ..Line::new(&cylinder.valve) };
        }
    }

    pub fn clear(&mut self) {
        self.lines.iter_mut().for_each(|line| line.pending.clear());
        self.arrived.fill(0.0);
    }

    /// Sends the commands `u` (m) off at time `now`.
    /// They leave in the order sent, so `now` must not fall.
    pub fn send(&mut self, now: f64, u: &[f64]) {
        for (line, &u) in self.lines.iter_mut().zip(u) {
            let value = through(&line.chain, u).clamp(-line.stroke, line.stroke);
            line.pending.push_back((now + line.delay, value));
        }
    }

    /// Delivers what arrives until `now`; whether anything changed.
    pub fn receive(&mut self, now: f64) -> bool {
        let before = self.arrived;
        for (line, arrived) in self.lines.iter_mut().zip(&mut self.arrived) {
            while let Some(&(_, value)) = line.pending.front().filter(|(t, _)| *t <= now + ROUNDING) {
                *arrived = value;
                line.pending.pop_front();
            }
        }
        self.arrived != before
    }

    pub fn next_arrival(&self) -> Option<f64> {
        self.lines.iter().filter_map(|line| line.pending.front()).map(|&(t, _)| t).reduce(f64::min)
    }
}

/// Time from a command to its arrival at the spool, s.
pub(crate) fn delay(valve: &Valve) -> f64 {
    valve.command.delay + valve.delay
}

/// The chain without its delay. Inside the dead band only the offset is left.
pub(crate) fn through(chain: &SignalChain, u: f64) -> f64 {
    let beyond = u - u.clamp(-chain.dead_band, chain.dead_band);
    (chain.offset + chain.gain * beyond).clamp(chain.low, chain.high)
}

#[cfg(test)]
mod tests {
    use super::*;

    const IDENTITY: SignalChain =
        SignalChain { offset: 0.0, gain: 1.0, dead_band: 0.0, low: -0.05, high: 0.05, delay: 0.0 };

    #[test]
    fn the_identity_changes_nothing() {
        for u in [-0.05, -0.01, 0.0, 0.02] {
            assert_eq!(through(&IDENTITY, u), u);
        }
    }

    #[test]
    fn dead_band_gain_offset_and_limits_act_in_this_order() {
        let chain = SignalChain { offset: 0.001, gain: -2.0, dead_band: 0.003, low: -0.02, high: 0.01, delay: 0.0 };
        assert_eq!(through(&chain, 0.002), 0.001);
        assert!((through(&chain, 0.008) - (0.001 - 2.0 * 0.005)).abs() < 1e-15);
        assert_eq!(through(&chain, 0.05), -0.02);
        assert_eq!(through(&chain, -0.05), 0.01);
    }
}
