//! Spool commands against time, as the spools receive them.

use crate::driven::Driven;
use crate::model::Model;
use crate::options::Commands;

/// Commands as the spools receive them: each delayed by its valve and kept within its stroke.
pub(crate) struct Schedule {
    /// Times at which any command or its rate of change changes.
    pub breaks: Vec<f64>,
    columns: Vec<Column>,
}

struct Column {
    times: Vec<f64>,
    values: Vec<f64>,
    linear: bool,
    delay: f64,
    limit: f64,
}

impl Column {
    /// Value and rate of change just after `t`.
    fn at(&self, t: f64) -> (f64, f64) {
        let t = t - self.delay;
        let next = self.times.partition_point(|&time| time <= t + 1e-12);
        if next == 0 {
            return (0.0, 0.0);
        }
        let here = self.values[next - 1];
        let (value, slope) = match (self.linear, self.times.get(next)) {
            (true, Some(&end)) => {
                let slope = (self.values[next] - here) / (end - self.times[next - 1]);
                (here + slope * (t - self.times[next - 1]), slope)
            }
            _ => (here, 0.0),
        };
        let limited = value.clamp(-self.limit, self.limit);
        (limited, if limited == value { slope } else { 0.0 })
    }
}

impl Schedule {
    pub fn new(commands: &Commands, model: &dyn Model) -> Self {
        let n = model.layout().joints();
        let machine = model.machine();
        let columns: Vec<Column> = (0..n)
            .map(|c| Column {
                times: commands.times.clone(),
                values: commands.values.iter().skip(c).step_by(n).copied().collect(),
                linear: commands.linear,
                delay: machine.cylinders[c].valve.delay,
                limit: machine.cylinders[c].valve.stroke,
            })
            .collect();
        let mut breaks: Vec<f64> = columns.iter().flat_map(Column::breaks).collect();
        breaks.sort_by(f64::total_cmp);
        breaks.dedup_by(|a, b| (*a - *b).abs() < 1e-12);
        Schedule { breaks, columns }
    }

    pub fn apply(&self, t: f64, driven: &mut Driven) {
        driven.since = t;
        for (c, column) in self.columns.iter().enumerate() {
            (driven.base[c], driven.slope[c]) = column.at(t);
        }
    }
}

impl Column {
    /// Its times as the spool sees them, and where a ramp meets the end of the spool's stroke.
    fn breaks(&self) -> Vec<f64> {
        let mut breaks: Vec<f64> = self.times.iter().map(|t| t + self.delay).collect();
        if self.linear {
            for (t, v) in self.times.windows(2).zip(self.values.windows(2)) {
                for limit in [-self.limit, self.limit] {
                    if (v[0] - limit) * (v[1] - limit) < 0.0 {
                        breaks.push(t[0] + (limit - v[0]) / (v[1] - v[0]) * (t[1] - t[0]) + self.delay);
                    }
                }
            }
        }
        breaks
    }
}
