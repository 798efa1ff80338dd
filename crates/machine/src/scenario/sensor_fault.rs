//! `[sensor-fault.<name>]` of a scenario: faults of sensors.

use super::{ControllerChoice, Result, SensorQuality};
use crate::errors::ErrorKind;
use crate::model::Machine;
use crate::nearest::suggestion;
use crate::reading::reader::{Field, Reader};
use crate::sections::coordinate;
use crate::units::quantities::{ANGLE, ANGULAR_VELOCITY, FORCE, LENGTH, PRESSURE, VELOCITY};
use crate::units::Quantity;

/// A sensor that fails from one time to another.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorFault {
    /// Its signal, for example `joint.boom.q`.
    pub signal: String,
    pub kind: FaultKind,
    /// s
    pub from: f64,
    /// s; `None`: to the end.
    pub until: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FaultKind {
    Freeze,
    /// By this much, SI.
    Jump(f64),
    DropOut,
}

pub fn read(root: &Reader, machine: &Machine, controller: Option<&ControllerChoice>) -> Result<Vec<SensorFault>> {
    let tables = root.named_tables("sensor-fault")?;
    let Some(choice) = controller else {
        return match tables.is_empty() {
            true => Ok(Vec::new()),
            false => Err(root
                .key_error(ErrorKind::MissingKey, "sensor-fault", "without a controller the sensors are not read")
                .help("add [controller] or [joystick]")),
        };
    };
    let measured = measured(machine, choice);
    tables.iter().map(|(_, table)| fault(table, &measured)).collect()
}

/// Every signal that a run with this controller measures, with its quantity.
pub fn measured(machine: &Machine, choice: &ControllerChoice) -> Vec<(String, Quantity)> {
    let joints = machine.joints.iter().map(|j| (format!("joint.{}.q", j.name), coordinate(&j.kind)));
    let pressures = machine
        .cylinders
        .iter()
        .flat_map(|c| [1, 2].map(|side| (format!("cylinder.{}.p{side}", c.name), PRESSURE.quantity())));
    let mut signals: Vec<(String, Quantity)> = joints.chain(pressures).collect();
    if choice.sensors == SensorQuality::DataSheet {
        for sensor in &machine.sensors {
            if !signals.iter().any(|(signal, _)| *signal == sensor.measures) {
                signals.push((sensor.measures.clone(), quantity(machine, &sensor.measures)));
            }
        }
    }
    signals
}

/// Unit of a signal that is neither a joint coordinate nor a pressure.
fn quantity(machine: &Machine, signal: &str) -> Quantity {
    let rate = |name: &str| {
        let joint = machine.joints.iter().find(|j| j.name == name);
        let turns = joint.is_some_and(|j| coordinate(&j.kind).dimension == ANGLE.quantity().dimension);
        if turns {
            ANGULAR_VELOCITY.quantity()
        } else {
            VELOCITY.quantity()
        }
    };
    match signal.split('.').collect::<Vec<_>>()[..] {
        [.., "force"] => FORCE.quantity(),
        [.., "x"] => LENGTH.quantity(),
        [_, name, "qd"] => rate(name),
        _ => VELOCITY.quantity(),
    }
}

fn fault(table: &Reader, measured: &[(String, Quantity)]) -> Result<SensorFault> {
    let signal = table.required("signal", "a signal, for example \"joint.boom.q\"")?;
    let quantity = quantity_of(&signal, measured)?;
    let from = table.quantity("from")?;
    let until = table.optional_quantity("until")?;
    if let Some(end) = until.filter(|end| *end <= from) {
        let message = format!("the fault ends at {end} s, before it begins at {from} s");
        return Err(table.error(ErrorKind::OutOfRange, "until", message).help("give a time after `from`"));
    }
    Ok(SensorFault { signal: signal.text()?.into(), kind: kind(table, quantity)?, from, until })
}

fn quantity_of<'q>(signal: &Field, measured: &'q [(String, Quantity)]) -> Result<&'q Quantity> {
    let text = signal.text()?;
    let found = measured.iter().find(|(name, _)| name == text);
    found.map(|(_, quantity)| quantity).ok_or_else(|| {
        let help = suggestion(text, measured.iter().map(|(name, _)| name.as_str()));
        signal.error(ErrorKind::UnknownReference, format!("no sensor measures `{text}`")).help(help)
    })
}

fn kind(table: &Reader, quantity: &Quantity) -> Result<FaultKind> {
    let kind = table.choice("kind", &[FaultKind::Freeze, FaultKind::Jump(0.0), FaultKind::DropOut])?;
    if matches!(kind, FaultKind::Jump(_)) {
        return Ok(FaultKind::Jump(table.quantity_of("size", quantity)?));
    }
    if table.has("size") {
        let message = "only a jump has a size";
        return Err(table
            .error(ErrorKind::ConflictingKeys, "size", message)
            .help("set `kind = \"jump\"` or remove it"));
    }
    Ok(kind)
}
