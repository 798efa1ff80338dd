//! Possible modes of a machine, and defaults of a new drive.

use crate::problem::Problem;
use crate::request::{Request, HEIGHT};
use hydrocrane_machine::model::JointKind;
use hydrocrane_machine::Machine;
use hydrocrane_sim::model::controllers::{CONTROLLERS, LEVER};
use serde_json::Value;

/// Default speed of the tip at full stick, m/s. From its start, the laboratory crane follows it within 3 % in every
/// direction; at 0.3 m/s it loses half of it in the worst direction.
const COMFORTABLE: f64 = 0.15;

/// Names of the modes. One stick moves the tip in a plane, which needs two joints and a machine that stays in it; `heinze-pid` needs
/// two revolute ones.
pub fn modes(machine: &Machine) -> Vec<&'static str> {
    let turning = machine.joints.iter().filter(|joint| matches!(joint.kind, JointKind::Revolute(_))).count();
    let plane = machine.joints.len() >= 2 && !machine.is_spatial();
    let has = |name: &&str| plane && (*name != "heinze-pid" || turning >= 2);
    let holding = plane.then_some(HEIGHT);
    CONTROLLERS.into_iter().filter(has).chain(holding).chain([LEVER]).collect()
}

/// An error if the requested mode is not possible for the machine.
pub fn check(machine: &Machine, mode: &str) -> Result<(), Problem> {
    let modes = modes(machine);
    if modes.contains(&mode) || !CONTROLLERS.contains(&mode) && mode != HEIGHT {
        return Ok(());
    }
    let there = modes.join(", ");
    Err(Problem::plain(format!("{} cannot be driven in mode `{mode}`; it has {there}", machine.name)))
}

/// A new drive: levers if the mode is not possible, the default speed if neither request nor machine states one.
pub fn comfortable(mut request: Request) -> Result<Request, Problem> {
    let (machine, _) = request.machine(&[])?;
    if check(&machine, &request.controller).is_err() {
        request.controller = LEVER.into();
    }
    if request.full_speed.is_none() {
        for mode in modes(&machine).into_iter().filter(|mode| CONTROLLERS.contains(mode)) {
            if machine.control.stated(mode, "full-speed").is_none() {
                request.overrides.insert(format!("control.{mode}.full-speed"), Value::from(COMFORTABLE));
            }
        }
    }
    Ok(request)
}
