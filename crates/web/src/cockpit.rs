//! A crane with a controller and somebody at the sticks.

use crate::description;
use crate::frame::Frame;
use crate::problem::Problem;
use crate::replay::{self, Replay};
use crate::request::Request;
use crate::saved;
use hydrocrane_machine::OverrideValue;
use hydrocrane_sim::integrator::Tolerances;
use hydrocrane_sim::{
    build, EquilibriumMode, Live, Model, RunOptions, SampledPlan, SensorMode, Sensors, StickKind, Sticks,
};
use serde_json::{json, Value};
use std::sync::Arc;

/// The step of a drive, s.
pub const TICK: f64 = 1e-3;

/// At most one drive at a time.
#[derive(Default)]
pub struct Cockpit {
    drive: Option<Drive>,
    frame: Frame,
}

/// A drive under way.
pub struct Drive {
    pub request: Request,
    pub overrides: Vec<(String, OverrideValue)>,
    pub model: Arc<dyn Model>,
    pub live: Live,
    /// Start pose, rad or m.
    pub pose: Vec<f64>,
    /// Where it went on from another drive, the time shown when it began, s; else it began at rest in its start pose.
    pub continued: Option<f64>,
    /// When a replay ends, s.
    pub replay_until: Option<f64>,
    ticks: u64,
    loads_told: usize,
}

impl Drive {
    /// Time since the last fresh start, s.
    pub fn time(&self) -> f64 {
        self.continued.unwrap_or(0.0) + self.live.time()
    }
}

impl Cockpit {
    /// Begins the drive that `request` (JSON) describes; answers with what there is to see and steer.
    /// After an error the drive at hand goes on.
    pub fn open(&mut self, request: &str) -> Result<Value, Problem> {
        let request = Request::read(request)?;
        let drive = match request.scenario.as_deref().map(replay::of).transpose()? {
            Some((request, again)) => begin(request, None, Some(&again))?,
            None => begin(request, self.drive.as_ref(), None)?,
        };
        let described = description::of(&drive);
        self.frame.measure(&drive);
        self.drive = Some(drive);
        Ok(described)
    }

    /// Deflections from -1 to 1: x and z of the tip, or one per cylinder.
    pub fn steer(&mut self, deflections: &[f64]) {
        if let Some(drive) = &mut self.drive {
            // Whoever moves a stick drives.
            if deflections.iter().any(|deflection| *deflection != 0.0) {
                drive.live.take_over();
            }
            drive.live.steer(deflections);
        }
    }

    /// Takes up a load or lets one go: the payload from the next sample on, kg.
    pub fn carry(&mut self, mass: f64) {
        if let Some(drive) = &mut self.drive {
            drive.live.take_over();
            drive.live.carry(mass);
        }
    }

    /// Goes on by `ticks` of 1 ms; whether the drive goes on after that.
    pub fn advance(&mut self, ticks: u32) -> bool {
        let Some(drive) = &mut self.drive else { return false };
        drive.ticks += u64::from(ticks);
        let goes_on = drive.live.advance(drive.ticks as f64 * TICK).is_ok();
        if drive.replay_until.is_some_and(|end| drive.live.time() > end) {
            drive.live.take_over();
        }
        goes_on
    }

    /// The numbers of the instant; the description says which is which.
    pub fn frame(&mut self) -> &[f64] {
        match &self.drive {
            Some(drive) => self.frame.fill(drive),
            None => &[],
        }
    }

    /// What has happened since the last call, and how the drive ended if it has.
    pub fn events(&mut self) -> Value {
        let Some(drive) = &mut self.drive else { return json!({ "events": [], "ended": null, "replaying": false }) };
        let from = drive.continued.unwrap_or(0.0);
        let mut events: Vec<Value> = Vec::new();
        for event in drive.live.events() {
            events.push(json!({ "time": from + event.time, "text": event.text }));
        }
        let (_, loads) = drive.live.loads();
        for load in &loads[drive.loads_told..] {
            let text = format!("the tip carries {} kg in place of {} kg", load.mass[1], load.mass[0]);
            events.push(json!({ "time": from + load.time, "text": text }));
        }
        drive.loads_told = loads.len();
        let ended =
            drive.live.outcome().map(|o| json!({ "kind": o.kind.name(), "time": from + o.time, "message": o.message }));
        json!({ "events": events, "ended": ended, "replaying": drive.live.replaying() })
    }

    /// The drive as a scenario file that `hydrocrane simulate` repeats.
    pub fn save(&self) -> Result<String, Problem> {
        let drive = self.drive.as_ref().ok_or_else(|| Problem::plain("there is no drive to be saved"))?;
        saved::scenario(drive)
    }
}

fn begin(request: Request, before: Option<&Drive>, again: Option<&Replay>) -> Result<Drive, Problem> {
    let (machine, overrides) = request.machine()?;
    let model =
        build(&machine).map_err(|error| Problem::plain(format!("{}: [cannot-build] {error}", request.machine)))?;
    let payload = request.payload.unwrap_or(machine.payload.mass);
    let limits = model.joint_limits();
    let stated = request.pose(&machine)?;
    let pose: Vec<f64> = stated.iter().zip(limits).map(|(q, l)| q.unwrap_or(0.5 * (l.lower + l.upper))).collect();
    let going = before.filter(|drive| request.keep_state && drive.model.layout().names == model.layout().names);
    let (x0, payload) = match going {
        Some(drive) => (drive.live.state().to_vec(), drive.live.payload()),
        None => {
            let at_rest = model.equilibrium(&pose, EquilibriumMode::Hold, payload);
            (at_rest.map_err(|error| Problem::plain(error.to_string()))?, payload)
        }
    };
    let live = live(&request, &model, &x0, payload, again)?;
    let continued = going.map(Drive::time);
    let replay_until = again.map(|replay| replay.duration);
    Ok(Drive { request, overrides, live, model, pose, continued, replay_until, ticks: 0, loads_told: 0 })
}

/// The loop of plant, sensors and controller, as a scenario with the same settings has it.
fn live(
    request: &Request,
    model: &Arc<dyn Model>,
    x0: &[f64],
    payload: f64,
    again: Option<&Replay>,
) -> Result<Live, Problem> {
    let machine = model.machine();
    let mut controller = model.controller(&request.controller).map_err(Problem::plain)?;
    if !request.lever() {
        controller = model.monitored(controller, request.delay);
    }
    let kind = if request.lever() { StickKind::Lever } else { StickKind::Tip };
    let centred = Sticks::centred(kind, machine.cylinders.len());
    let sticks = again.map_or_else(|| centred.clone(), |replay| replay.sticks(centred.clone()));
    let mode = if request.real_sensors { SensorMode::DataSheet } else { SensorMode::Ideal };
    let plan = SampledPlan {
        sticks: Sticks { dead_zone: request.dead_zone, ramp: request.ramp, ..sticks },
        sensors: Sensors::new(model.as_ref(), mode, request.seed, &[]).map_err(Problem::plain)?,
        delay: request.delay,
    };
    let options = RunOptions {
        method: "ros3l".into(),
        tolerances: Tolerances { relative: 1e-4, absolute: 1e-4, max_step: TICK },
        payload,
        payload_changes: again.map(|replay| replay.loads.clone()).unwrap_or_default(),
        ledger: true,
        max_steps: u64::MAX,
    };
    Live::new(model.clone(), controller, x0, &plan, options).map_err(Problem::plain)
}
