//! What is driven: a bundled machine in one of the cockpit's modes with a payload.

use hydrocrane_machine::{bundled_machines, Machine};
use hydrocrane_sim::model::controllers::{CONTROLLERS, LEVER};
use hydrocrane_sim::{build, Model};
use hydrocrane_web::Request;
use serde_json::{json, Value};
use std::sync::Arc;

#[derive(Debug, Clone)]
pub struct Case {
    pub machine: String,
    pub mode: String,
    /// kg
    pub payload: f64,
    /// Whether the ground carries, as in drives of the page.
    pub ground: bool,
}

/// Names of all bundled machines, and of all modes.
pub fn machines() -> Vec<&'static str> {
    bundled_machines().iter().map(|(name, _)| *name).collect()
}

pub fn modes() -> Vec<&'static str> {
    std::iter::once(LEVER).chain(CONTROLLERS).collect()
}

impl Case {
    /// What the page asks for; sticks as it sets them up.
    pub fn request(&self) -> Value {
        let Case { machine, mode, payload, ground } = self;
        json!({
            "machine": machine, "controller": mode, "payload": payload,
            "full-speed": 0.3, "dead-zone": 0.0, "ramp": 0.0, "ground": ground,
        })
    }

    /// The machine as the drive has it.
    pub fn model(&self) -> Result<(Machine, Arc<dyn Model>), String> {
        let request = Request::read(&self.request().to_string()).map_err(|problem| problem.message().to_string())?;
        let (machine, _) = request.machine(&[]).map_err(|problem| problem.message().to_string())?;
        let model = build(&machine).map_err(|error| error.to_string())?;
        Ok((machine, model))
    }

    /// Why the machine cannot have the mode.
    pub fn without(&self, model: &dyn Model) -> Option<&'static str> {
        let folds = || model.inverse_kinematics([0.0; 2], 0.0).is_ok();
        (self.mode == "heinze-pid" && !folds()).then_some("its inverse kinematics needs two revolute joints")
    }

    pub fn axes(&self, machine: &Machine) -> usize {
        if self.mode == LEVER {
            machine.cylinders.len()
        } else {
            2
        }
    }
}
