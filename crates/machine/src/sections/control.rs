//! `[control]`: the sample period, and the gains of each controller in `[control.<controller>]`.

use crate::keys::{Key, Value, CONTROLLERS, PLAUSIBILITY};
use crate::model::{Control, Joint, ThesisSteps};
use crate::reading::reader::Reader;
use crate::sections::{reference, Result};

/// The tables of `[control.heinze-pid]` with a weight per joint.
const HEINZE_WEIGHTS: [&str; 2] = ["motion-weight", "middle-weight"];

pub fn read<T>(root: &Reader, joints: &[Joint<T>]) -> Result<Control> {
    let table = root.table_or_empty("control")?;
    let names: Vec<&str> = joints.iter().map(|joint| joint.name.as_str()).collect();
    let (tip, thesis) = (table.table_or_empty("tip")?, table.table_or_empty("heinze-pid")?);
    let height_joint = tip.optional("height-joint")?;
    let mut gains = Vec::new();
    for (name, keys) in CONTROLLERS.into_iter().chain([PLAUSIBILITY]) {
        let mut own = read_gains(&table.table_or_empty(name)?, keys)?;
        if name == "heinze-pid" {
            own.extend(read_weights(&thesis, &names)?);
        }
        gains.push((name.to_string(), own));
    }
    Ok(Control {
        period: table.optional_quantity("period")?,
        gains,
        thesis: read_switches(&thesis)?,
        estimates_pressures: tip.choice_or_default("pressures", &[false, true])?,
        height_joint: height_joint.map(|field| reference::index(&field, "joint", &names)).transpose()?,
    })
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
