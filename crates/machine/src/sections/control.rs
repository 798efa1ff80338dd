//! `[control]`: the sample period, and the gains of each controller in `[control.<controller>]`.

use crate::keys::{Key, Value, CONTROLLERS, PLAUSIBILITY};
use crate::model::{Control, Joint, ThesisSteps};
use crate::reader::Reader;
use crate::sections::{reference, Result};

/// The tables of `[control.heinze-pid]` with a weight per joint.
const HEINZE_WEIGHTS: [&str; 2] = ["motion-weight", "middle-weight"];

pub fn read<T>(root: &Reader, joints: &[Joint<T>]) -> Result<Control> {
    let Some(table) = root.table("control")? else { return Ok(Control::default()) };
    let names: Vec<&str> = joints.iter().map(|joint| joint.name.as_str()).collect();
    let mut control = Control { period: table.optional_quantity("period")?, ..Control::default() };
    for (name, keys) in CONTROLLERS.into_iter().chain([PLAUSIBILITY]) {
        let Some(own) = table.table(name)? else { continue };
        let mut gains = read_gains(&own, keys)?;
        if name == "heinze-pid" {
            gains.extend(read_weights(&own, &names)?);
            control.thesis = read_switches(&own)?;
        }
        if name == "tip" {
            control.estimates_pressures = own.choice_or_default("pressures", &[false, true])?;
            let field = own.optional("height-joint")?;
            control.height_joint = field.map(|field| reference::index(&field, "joint", &names)).transpose()?;
        }
        control.gains.push((name.to_string(), gains));
    }
    Ok(control)
}

fn read_switches(table: &Reader) -> Result<ThesisSteps> {
    Ok(ThesisSteps {
        working_area: table.choice_or_default("working-area", &[true, false])?,
        penalty: table.choice_or_default("extension", &[true, false])?,
    })
}

/// One weight per joint, by the joint's name.
fn read_weights(table: &Reader, names: &[&str]) -> Result<Vec<(String, f64)>> {
    let mut weights = Vec::new();
    for key in HEINZE_WEIGHTS {
        let Some(own) = table.table_of(key, names)? else { continue };
        for name in names {
            if let Some(weight) = own.optional_quantity(name)? {
                weights.push((format!("{key}.{name}"), weight));
            }
        }
    }
    Ok(weights)
}

/// Every quantity among `keys` that the file states.
fn read_gains(table: &Reader, keys: &[Key]) -> Result<Vec<(String, f64)>> {
    let mut gains = Vec::new();
    for key in keys.iter().filter(|key| matches!(key.value, Value::Quantity(..))) {
        if let Some(value) = table.optional_quantity(key.name)? {
            gains.push((key.name.to_string(), value));
        }
    }
    Ok(gains)
}
