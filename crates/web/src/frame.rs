//! The numbers of an instant in one row, for charts and drawing.

use crate::drive::Drive;
use hydrocrane_machine::scenario::StickMode;
use hydrocrane_sim::{ledger_terms, ledger_totals, total_terms};
use serde_json::{json, Value};

/// Numbers before the lists.
pub const HEAD: [(&str, &str, &str); 8] = [
    ("time", "s", "time since the start"),
    ("payload", "kg", "payload at the tip"),
    ("tip.vx", "m/s", "velocity of the tip, forward"),
    ("tip.vz", "m/s", "velocity of the tip, up"),
    ("set_point.x", "m", "where the controller wants the tip, forward"),
    ("set_point.z", "m", "where the controller wants the tip, up"),
    ("wanted.vx", "m/s", "velocity of the tip that the stick asks for, forward"),
    ("wanted.vz", "m/s", "velocity of the tip that the stick asks for, up"),
];

/// Most corners of a line of the drawing; a finer outline is thinned out.
const MOST_CORNERS: usize = 200;

/// The corners of a line that a row holds.
pub fn corners(line: &[[f64; 2]]) -> impl Iterator<Item = &[f64; 2]> {
    line.iter().step_by(line.len().div_ceil(MOST_CORNERS).max(1))
}

/// Room for one row.
#[derive(Default)]
pub struct Frame {
    row: Vec<f64>,
    outputs: Vec<f64>,
}

/// Name, unit and meaning of every number of a row; the corners of the drawing follow them.
pub fn signals(drive: &Drive) -> Vec<Value> {
    let entry = |name: &str, unit: &str, long: &str| json!({ "name": name, "unit": unit, "long": long });
    let mut all: Vec<Value> = HEAD.iter().map(|(name, unit, long)| entry(name, unit, long)).collect();
    let layout = drive.model().layout();
    for i in 0..layout.len() {
        all.push(entry(&layout.names[i], layout.units[i], &layout.long_names[i]));
    }
    for output in drive.model().output_info() {
        all.push(entry(&output.name, output.unit, &output.long_name));
    }
    for cylinder in &drive.model().machine().cylinders {
        let long = format!("{} spool command at the valve", cylinder.name);
        all.push(entry(&format!("command.{}", cylinder.name), "m", &long));
    }
    for (name, long, _) in total_terms(drive.model().machine()) {
        all.push(entry(&format!("ledger.{name}"), "J", long));
    }
    all
}

impl Frame {
    /// Makes room for the rows of a drive.
    pub fn measure(&mut self, drive: &Drive) {
        self.outputs = vec![0.0; drive.model().output_info().len()];
        self.row.clear();
    }

    /// The row of the instant.
    pub fn fill(&mut self, drive: &Drive) -> &[f64] {
        let live = &drive.playback.live;
        let ([x, _, z], energies) = (live.set_point().unwrap_or([f64::NAN; 3]), live.energies());
        let instant = Instant {
            time: live.time(),
            payload: live.payload(),
            state: live.state(),
            set_point: [x, z],
            wanted: wanted_velocity(drive),
            commands: &live.commands(),
            energies: &energies,
        };
        self.write(drive, instant)
    }

    /// The row of a recorded instant: `recorded` holds time, payload and the states. Missing values are NaN.
    pub fn show(&mut self, drive: &Drive, recorded: &[f64]) -> Option<&[f64]> {
        let (layout, cylinders) = (drive.model().layout(), drive.model().machine().cylinders.len());
        let [time, payload, state @ ..] = recorded else { return None };
        if state.len() != layout.len() {
            return None;
        }
        let unknown = vec![f64::NAN; ledger_terms(drive.model().machine()).len()];
        let instant = Instant {
            time: *time,
            payload: *payload,
            state,
            set_point: [f64::NAN; 2],
            wanted: [f64::NAN; 2],
            commands: &unknown[..cylinders],
            energies: &unknown,
        };
        Some(self.write(drive, instant))
    }

    fn write(&mut self, drive: &Drive, now: Instant) -> &[f64] {
        let model = drive.playback.live.model();
        let n = model.layout().joints();
        let [vx, _, vz] = model.tip_velocity(&now.state[..n], &now.state[n..2 * n]);
        model.outputs_without_oil(now.state, now.payload, &mut self.outputs);
        self.row.clear();
        self.row.extend([now.time, now.payload]);
        self.row.extend([[vx, vz], now.set_point, now.wanted].iter().flatten());
        self.row.extend_from_slice(now.state);
        self.row.extend_from_slice(&self.outputs);
        self.row.extend_from_slice(now.commands);
        self.row.extend(ledger_totals(now.energies, n));
        for shape in model.drawing(&now.state[..n]) {
            self.row.extend(corners(&shape.line).flatten());
        }
        &self.row
    }
}

/// Data of a row.
struct Instant<'a> {
    time: f64,
    payload: f64,
    state: &'a [f64],
    set_point: [f64; 2],
    wanted: [f64; 2],
    commands: &'a [f64],
    energies: &'a [f64],
}

/// The tip velocity that the stick commands; zero if levers move the cylinders.
fn wanted_velocity(drive: &Drive) -> [f64; 2] {
    let speed = drive.model().machine().control.gain(drive.request.law(), "full-speed");
    match (speed, drive.playback.live.sticks_at()) {
        (Some(speed), &[x, z]) if drive.request.stick_mode() == StickMode::Tip => [speed * x, speed * z],
        _ => [f64::NAN; 2],
    }
}
