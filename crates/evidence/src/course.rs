//! What a core tells of one drive.

use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;

/// What is to be driven.
#[derive(Debug, Clone, Serialize)]
pub struct Plan {
    pub request: Value,
    pub moves: Vec<crate::sticks::Move>,
    /// The drive is saved and its tip followed until here, ticks.
    pub followed: u32,
}

/// Ticks between rows, and between places of the tip.
pub const ROWS: u32 = 1000;
pub const PLACES: u32 = 10;

/// How a drive ended before its time.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Ended {
    pub kind: String,
    pub time: f64,
    pub message: String,
}

#[derive(Debug, Clone, Default, Deserialize)]
pub struct Course {
    /// Why there is no drive.
    pub refused: Option<String>,
    /// Names of the numbers of a row.
    pub signals: Vec<String>,
    pub ended: Option<Ended>,
    /// The start, each second, and the end.
    #[serde(deserialize_with = "tables")]
    pub rows: Vec<Vec<f64>>,
    /// Lowest and highest value of each signal over all ticks.
    #[serde(deserialize_with = "numbers")]
    pub low: Vec<f64>,
    #[serde(deserialize_with = "numbers")]
    pub high: Vec<f64>,
    /// Rows at which each chamber (signals that end with .p1 or .p2, in order) had its highest pressure.
    #[serde(deserialize_with = "tables")]
    pub peaks: Vec<Vec<f64>>,
    /// The tip every 10 ms until `followed`, m.
    #[serde(deserialize_with = "tables")]
    pub tip: Vec<Vec<f64>>,
    /// The drive until there as a scenario.
    pub saved: Option<String>,
    pub steps: Steps,
}

/// Time per step of 1 ms, s.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub struct Steps {
    pub count: u64,
    pub total: f64,
    /// Of the first step of a drive, which makes tables, and of all others.
    pub first: f64,
    pub worst: f64,
    /// Steps but the first that took longer than [`LONG`].
    pub long: u64,
}

/// The budget of a step's worst case, s.
pub const LONG: f64 = 0.5e-3;

impl Steps {
    pub fn take(&mut self, seconds: f64) {
        self.count += 1;
        self.total += seconds;
        if self.count == 1 {
            self.first = seconds;
            return;
        }
        self.worst = self.worst.max(seconds);
        self.long += u64::from(seconds > LONG);
    }

    pub fn add(&mut self, other: &Steps) {
        self.count += other.count;
        self.total += other.total;
        self.first = self.first.max(other.first);
        self.worst = self.worst.max(other.worst);
        self.long += other.long;
    }
}

pub fn is_chamber(signal: &str) -> bool {
    signal.ends_with(".p1") || signal.ends_with(".p2")
}

impl Course {
    pub fn index(&self, signal: &str) -> Option<usize> {
        self.signals.iter().position(|known| known == signal)
    }

    /// Takes notice of an instant.
    pub fn see(&mut self, tick: u32, row: &[f64], last: bool, followed: u32) {
        let row = &row[..self.signals.len()];
        if self.low.is_empty() {
            (self.low, self.high) = (row.to_vec(), row.to_vec());
            self.peaks = self.signals.iter().filter(|name| is_chamber(name)).map(|_| row.to_vec()).collect();
        }
        let mut chamber = 0;
        for (i, name) in self.signals.iter().enumerate() {
            self.low[i] = self.low[i].min(row[i]);
            if is_chamber(name) {
                // What is no number counts as the highest.
                if row[i] > self.high[i] || row[i].is_nan() {
                    self.peaks[chamber].copy_from_slice(row);
                }
                chamber += 1;
            }
            self.high[i] = self.high[i].max(row[i]);
        }
        if tick.is_multiple_of(ROWS) || last {
            self.rows.push(row.to_vec());
        }
        if tick.is_multiple_of(PLACES) && tick <= followed {
            let place = ["tip.x", "tip.z"].map(|name| self.index(name).map_or(f64::NAN, |at| row[at]));
            self.tip.push(place.to_vec());
        }
    }
}

/// JSON has no word for numbers that are not finite.
fn number(value: Option<f64>) -> f64 {
    value.unwrap_or(f64::NAN)
}

fn numbers<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<f64>, D::Error> {
    Ok(Vec::<Option<f64>>::deserialize(from)?.into_iter().map(number).collect())
}

fn tables<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<Vec<f64>>, D::Error> {
    let rows = Vec::<Vec<Option<f64>>>::deserialize(from)?;
    Ok(rows.into_iter().map(|row| row.into_iter().map(number).collect()).collect())
}
