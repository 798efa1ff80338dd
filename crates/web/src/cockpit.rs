//! A crane with a controller and an operator at the sticks.

use crate::description;
use crate::drive::{begin, repeat, Drive, TICK};
use crate::frame::Frame;
use crate::offered;
use crate::problem::Problem;
use crate::replay;
use crate::request::Request;
use crate::saved;
use hydrocrane_sim::Warning;
use serde_json::{json, Value};

/// At most one drive at a time.
#[derive(Default)]
pub struct Cockpit {
    drive: Option<Drive>,
    frame: Frame,
}

impl Cockpit {
    /// Begins the drive that `request` (JSON) describes, or continues with it; returns the description of signals and
    /// controls. After an error the present drive continues.
    pub fn open(&mut self, request: &str) -> Result<Value, Problem> {
        let request = Request::read(request)?;
        let replay = request.scenario.as_deref().map(|text| replay::of(text, &request)).transpose()?;
        let going = self.drive.as_mut().filter(|_| request.keep_state && replay.is_none());
        let goes_on = going.map_or(Ok(false), |drive| drive.change(&request))?;
        if !goes_on {
            self.drive = Some(match replay {
                Some(replay) => repeat(replay)?,
                None => begin(offered::comfortable(request)?)?,
            });
        }
        let Some(drive) = &self.drive else { return Err(Problem::plain("there is no drive")) };
        self.frame.measure(drive);
        Ok(description::of(drive))
    }

    /// Deflections from -1 to 1: x and z of the tip, or one per cylinder.
    pub fn set_sticks(&mut self, deflections: &[f64]) {
        if let Some(drive) = &mut self.drive {
            if deflections.iter().any(|deflection| *deflection != 0.0) {
                drive.take_over();
            }
            drive.playback.live.set_sticks(deflections);
        }
    }

    /// Moves the tip to a point (x, z), m, until a stick is moved.
    pub fn go_to(&mut self, place: [f64; 2]) -> Result<(), Problem> {
        let drive = self.drive.as_mut().ok_or_else(|| Problem::plain("there is no drive"))?;
        if drive.playback.live.follows_commands() {
            return Err(Problem::plain("spool commands are repeated; begin a drive of the tip first"));
        }
        drive.playback.live.go_to(place, None).map_err(Problem::plain)?;
        drive.take_over();
        Ok(())
    }

    /// Cancels the goal.
    pub fn drop_goal(&mut self) {
        if let Some(drive) = self.drive.as_mut().filter(|drive| drive.playback.live.goal().is_some()) {
            drive.take_over();
            drive.playback.live.drop_goal();
        }
    }

    /// Sets the share of the full speed from the next sample on.
    pub fn set_precision(&mut self, share: f64) {
        if let Some(drive) = &mut self.drive {
            drive.playback.live.set_precision(share);
        }
    }

    /// Sets the payload from the next sample on, kg: picks up or releases a load.
    pub fn carry(&mut self, mass: f64) {
        if let Some(drive) = &mut self.drive {
            drive.take_over();
            drive.playback.live.carry(mass);
        }
    }

    /// Advances by `ticks` of 1 ms; returns whether the drive continues.
    pub fn advance(&mut self, ticks: u32) -> bool {
        let Some(drive) = &mut self.drive else { return false };
        drive.ticks += u64::from(ticks);
        let goes_on = drive.advance(drive.ticks as f64 * TICK);
        if drive.replayed && drive.playback.live.replaying() && drive.playback.live.time() > drive.scenario.duration {
            drive.take_over();
        }
        goes_on
    }

    /// The numbers of the present instant, in the order of the description.
    pub fn frame(&mut self) -> &[f64] {
        match &self.drive {
            Some(drive) => self.frame.fill(drive),
            None => &[],
        }
    }

    /// The numbers of a recorded instant of the same machine: time, payload, states in order. `None` if they are
    /// invalid.
    pub fn show(&mut self, recorded: &[f64]) -> &[f64] {
        self.drive.as_ref().and_then(|drive| self.frame.show(drive, recorded)).unwrap_or_default()
    }

    /// Events since the last call, and the outcome if the drive has ended; a new description if a replay has reached
    /// another phase.
    pub fn events(&mut self) -> Value {
        let Some(drive) = &mut self.drive else { return json!({ "events": [], "ended": null, "replaying": false }) };
        let mut events: Vec<Value> = Vec::new();
        for event in drive.playback.live.events() {
            events.push(json!({ "time": event.time, "text": event.text }));
        }
        let (_, loads) = drive.playback.live.loads();
        for load in &loads[drive.loads_sent..] {
            let text = format!("the tip carries {} kg in place of {} kg", load.mass[1], load.mass[0]);
            events.push(json!({ "time": load.time, "text": text }));
        }
        drive.loads_sent = loads.len();
        for warning in drive.playback.warnings() {
            let Warning { time, kind, text, cure, .. } = warning;
            events.push(json!({ "time": time, "text": text, "warning": kind, "cure": cure }));
        }
        let changed = std::mem::take(&mut drive.changed).then(|| description::of(drive));
        let ended = drive
            .playback
            .outcome()
            .map(|end| json!({ "kind": end.kind.name(), "time": end.time, "message": end.message }));
        json!({ "events": events, "ended": ended, "replaying": drive.playback.live.replaying(), "changed": changed })
    }

    /// The drive as a scenario file that `hydrocrane simulate` repeats.
    pub fn save(&self) -> Result<String, Problem> {
        let drive = self.drive.as_ref().ok_or_else(|| Problem::plain("there is no drive to be saved"))?;
        saved::scenario(drive)
    }
}
