//! Which modes a machine can have, and how a fresh drive begins where nobody says otherwise.

use crate::problem::Problem;
use crate::request::{Request, HEIGHT};
use hydrocrane_machine::model::JointKind;
use hydrocrane_machine::Machine;
use hydrocrane_sim::controllers::{CONTROLLERS, LEVER};
use serde_json::Value;

/// Speed of the tip at full stick where the machine states none, m/s. From its start, the laboratory crane follows it
/// within 3 % in every direction; at 0.3 m/s it loses half in the worst one.
const COMFORTABLE: f64 = 0.15;

/// Names of the modes. One stick moves the tip in a plane, which takes two joints; `heinze-pid` needs two that turn.
pub fn modes(machine: &Machine) -> Vec<&'static str> {
    let turning = machine.joints.iter().filter(|joint| matches!(joint.kind, JointKind::Revolute(_))).count();
    let has = |name: &&str| machine.joints.len() >= 2 && (*name != "heinze-pid" || turning >= 2);
    let holding = (machine.joints.len() >= 2).then_some(HEIGHT);
    CONTROLLERS.into_iter().filter(has).chain(holding).chain([LEVER]).collect()
}

/// An error where the machine cannot have the mode that is asked for.
pub fn check(machine: &Machine, mode: &str) -> Result<(), Problem> {
    let modes = modes(machine);
    if modes.contains(&mode) || !CONTROLLERS.contains(&mode) && mode != HEIGHT {
        return Ok(());
    }
    let there = modes.join(", ");
    Err(Problem::plain(format!("{} cannot be driven in mode `{mode}`; it has {there}", machine.name)))
}

/// A fresh drive: levers where the machine cannot have the mode, a comfortable speed where neither request nor machine states
/// one.
pub fn comfortable(mut request: Request) -> Result<Request, Problem> {
    let (machine, _) = request.machine(&[])?;
    if check(&machine, &request.controller).is_err() {
        request.controller = LEVER.into();
    }
    if request.full_speed.is_none() {
        for mode in modes(&machine).into_iter().filter(|mode| CONTROLLERS.contains(mode)) {
            if machine.control.gain(mode, "full-speed").is_none() {
                request.overrides.insert(format!("control.{mode}.full-speed"), Value::from(COMFORTABLE));
            }
        }
    }
    Ok(request)
}
