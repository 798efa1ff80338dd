//! Spool commands against time, on the common command path: signal chain, limits, delays.

use crate::event_loop::driven::Driven;
use crate::event_loop::Events;
use crate::inputs::command_path::{at_spool, delay, follow, kinks};
use crate::inputs::options::Commands;
use crate::model::Model;
use crate::outcome::Outcome;
use hydrocrane_machine::model::Valve;
use hydrocrane_ode::Stepper;

/// Rounding tolerance between the time of a break and the present time, s.
const ROUNDING: f64 = 1e-12;

/// Commands as the spools receive them.
pub(crate) struct Schedule {
    /// Times at which any command or its rate of change changes, ascending, s.
    breaks: Vec<f64>,
    /// The next break.
    next: usize,
    columns: Vec<Column>,
}

/// The command of one cylinder.
pub struct Column {
    times: Vec<f64>,
    values: Vec<f64>,
    linear: bool,
    valve: Valve,
    /// Times of kinks and jumps of the command at the spool, ascending, s.
    pub breaks: Vec<f64>,
    /// With hysteresis, what the spool follows from each of the breaks on.
    followed: Vec<Piece>,
}

/// A straight piece of a command from the time `begin` (s) on: its value there (m) and its rate of change (m/s).
#[derive(Debug, Clone, Copy)]
struct Piece {
    begin: f64,
    value: f64,
    slope: f64,
}

impl Column {
    pub fn new(times: Vec<f64>, values: Vec<f64>, linear: bool, valve: &Valve) -> Self {
        let mut column =
            Column { times, values, linear, valve: valve.clone(), breaks: Vec::new(), followed: Vec::new() };
        column.breaks = column.bends();
        if valve.command.play > 0.0 {
            column.followed = column.with_play();
            column.breaks = column.followed.iter().map(|piece| piece.begin).collect();
        }
        column
    }

    /// What a spool follows that begins in its middle: it stands until the command has crossed the hysteresis.
    fn with_play(&self) -> Vec<Piece> {
        let chain = &self.valve.command;
        let (mut pieces, mut stands) = (Vec::new(), 0.0);
        for (i, &begin) in self.breaks.iter().enumerate() {
            let (given, slope) = self.arriving(begin);
            stands = follow(chain, stands, given);
            pieces.push(Piece { begin, value: stands, slope: 0.0 });
            if slope == 0.0 {
                continue;
            }
            let crossed = begin + (stands + chain.play.copysign(slope) - given) / slope;
            let end = self.breaks.get(i + 1).copied().unwrap_or(f64::INFINITY);
            if crossed < end {
                let begin = crossed.max(begin);
                pieces.push(Piece { begin, value: stands, slope });
                stands += slope * (end - begin);
            }
        }
        pieces
    }

    /// Its times at the spool, and those at which a ramp reaches an end of dead band, signal or stroke.
    fn bends(&self) -> Vec<f64> {
        let late = delay(&self.valve);
        let mut bends: Vec<f64> = self.times.iter().map(|t| t + late).collect();
        if self.linear {
            let kinks = kinks(&self.valve.command, self.valve.stroke);
            for (t, v) in self.times.windows(2).zip(self.values.windows(2)) {
                let crossed = kinks.iter().filter(|kink| (v[0] - **kink) * (v[1] - **kink) < 0.0);
                bends.extend(crossed.map(|kink| t[0] + (kink - v[0]) / (v[1] - v[0]) * (t[1] - t[0]) + late));
            }
        }
        bends.sort_by(f64::total_cmp);
        bends
    }

    /// The command given at time `t` and its rate of change just after it.
    fn given(&self, t: f64) -> (f64, f64) {
        let next = self.times.partition_point(|&time| time <= t + ROUNDING);
        if next == 0 {
            return (0.0, 0.0);
        }
        let here = self.values[next - 1];
        match (self.linear, self.times.get(next)) {
            (true, Some(&end)) => {
                let slope = (self.values[next] - here) / (end - self.times[next - 1]);
                (here + slope * (t - self.times[next - 1]), slope)
            }
            _ => (here, 0.0),
        }
    }

    /// The command at the spool at time `t`, and its rate of change just after it.
    pub fn at(&self, t: f64) -> (f64, f64) {
        if self.valve.command.play == 0.0 {
            return self.arriving(t);
        }
        let begun = self.followed.partition_point(|piece| piece.begin <= t + ROUNDING);
        let last = begun.checked_sub(1).map(|last| self.followed[last]);
        last.map_or((0.0, 0.0), |piece| (piece.value + piece.slope * (t - piece.begin), piece.slope))
    }

    /// The same before the pilot stage.
    fn arriving(&self, t: f64) -> (f64, f64) {
        let late = delay(&self.valve);
        let arrives = |u: f64| at_spool(&self.valve.command, self.valve.stroke, u);
        let (given, slope) = self.given(t - late);
        // Before its first time there is no command, and the spool is centred for any offset of the signal.
        let begun = self.times.first().is_some_and(|first| *first <= t - late + ROUNDING);
        let here = if begun { arrives(given) } else { 0.0 };
        if slope == 0.0 {
            return (here, 0.0);
        }
        // The rate follows from two points well inside the interval up to the next break; at its ends rounding would
        // decide.
        let end = self.breaks[self.breaks.partition_point(|bend| *bend <= t + ROUNDING)..].first();
        let inside = |share: f64| end.map_or(t, |end| t + share * (end - t));
        let [early, late] = [0.25, 0.75].map(|share| arrives(given + slope * (inside(share) - t)));
        let moves = self.valve.command.gain != 0.0 && early != late;
        (here, if moves { slope * self.valve.command.gain } else { 0.0 })
    }
}

impl Schedule {
    pub fn new(commands: &Commands, model: &dyn Model) -> Self {
        let cylinders = &model.machine().cylinders;
        let n = cylinders.len();
        let column = |(c, valve): (usize, &Valve)| {
            let values = commands.values.iter().skip(c).step_by(n).copied().collect();
            Column::new(commands.times.clone(), values, commands.linear, valve)
        };
        let columns: Vec<Column> = cylinders.iter().map(|c| &c.valve).enumerate().map(column).collect();
        let mut breaks: Vec<f64> = columns.iter().flat_map(|column| &column.breaks).copied().collect();
        breaks.sort_by(f64::total_cmp);
        breaks.dedup_by(|a, b| (*a - *b).abs() < ROUNDING);
        Schedule { breaks, next: 0, columns }
    }

    /// Sets the commands of time `t` (s); breaks until then are past.
    pub fn begin(&mut self, t: f64, driven: &mut Driven) {
        driven.since = t;
        for (c, column) in self.columns.iter().enumerate() {
            (driven.base[c], driven.slope[c]) = column.at(t);
        }
        self.next = self.breaks.partition_point(|&b| b <= t + ROUNDING);
    }
}

impl Events for Schedule {
    fn happen(&mut self, now: f64, driven: &mut Driven, stepper: &mut Stepper) -> Result<(), Outcome> {
        if self.next() <= now + ROUNDING {
            self.begin(now, driven);
            stepper.restart();
        }
        Ok(())
    }

    fn next(&self) -> f64 {
        self.breaks.get(self.next).copied().unwrap_or(f64::INFINITY)
    }
}
