//! `[priority]`: the section that is served first.

use crate::errors::ErrorKind;
use crate::model::{Compensator, Cylinder, Machine, Mains, Priority, Supply};
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::{reference, supply, Result};

/// Share of the range beyond which the others are free: the end is rounded.
const FREE: f64 = 1.1;

/// Adds it to the mains, if there is one.
pub fn read<T: Number>(root: &Reader, cylinders: &[Cylinder<T>], supply: &mut Supply<T>) -> Result<()> {
    let Some(table) = root.table("priority")? else { return Ok(()) };
    let names: Vec<&str> = cylinders.iter().map(|cylinder| cylinder.name.as_str()).collect();
    let cylinder = reference::index(&table.required("cylinder", "the name of its cylinder")?, "cylinder", &names)?;
    let priority: Priority<T> =
        Priority { cylinder, margin: table.quantity("margin")?, range: table.quantity_or_default("range")? };
    if cylinders.len() == 1 {
        let message = "the machine has no other section that could give way";
        return Err(root.error(ErrorKind::ConflictingKeys, "priority", message).help("leave the table out"));
    }
    let Some((mains, sensing)) = supply.mains.as_mut().and_then(|mains| {
        let margin = mains.load_sensing.as_ref()?.margin.plain();
        Some((mains, margin))
    }) else {
        let message = "no pump senses the load, so that nothing tells when the others have to give way";
        return Err(root
            .error(ErrorKind::ConflictingKeys, "priority", message)
            .help("use a [pump.<name>] of type \"load-sensing\", or a \"fixed\" one with `ls-margin`"));
    };
    if priority.margin.plain() >= sensing {
        let message = "not below the margin of the pump: the other sections would never move";
        return Err(table
            .error(ErrorKind::OutOfRange, "margin", message)
            .help("give what the section needs over its edge, below `ls-margin` of the pump"));
    }
    mains.priority = Some(priority);
    Ok(())
}

/// Warns if the others give way before the pump is exhausted, or too late for the section that is served first.
pub fn check<T: Number>(root: &Reader, machine: &Machine<T>) -> Result<()> {
    let Some((mains, priority)) = machine.supply.mains.as_ref().and_then(|of| Some((of, of.priority.as_ref()?))) else {
        return Ok(());
    };
    let table = root.table("priority")?.expect("the table that it was read from");
    let (kept, range) = (priority.margin.plain(), priority.range.plain());
    let (left, free) = (left_when_exhausted(mains), kept + FREE * range);
    if free > left {
        table.required("margin", "a pressure")?.warn(
            format!(
                "high: with `range`, the others are free from {:.1} bar on, and the pump leaves {:.1} bar at full displacement",
                free / 1e5,
                left / 1e5
            ),
            "lower it or `range`, or raise `ls-margin` of the pump; else the others give way before the pump is exhausted".into(),
        );
    }
    let valve = &machine.cylinders[priority.cylinder].valve;
    if let Compensator::Before(setting) = &valve.compensator {
        if setting.plain() > kept {
            table.required("margin", "a pressure")?.warn(
                format!("low: the compensator of valve `{}` takes {:.1} bar", valve.name, setting.plain() / 1e5),
                "raise it to that setting, or expect the section to slow down before the others have given way".into(),
            );
        }
    }
    Ok(())
}

/// Margin over the load-sensing line at full displacement, Pa.
fn left_when_exhausted<T: Number>(mains: &Mains<T>) -> f64 {
    mains.load_sensing.as_ref().map_or(0.0, |sensing| sensing.margin.plain()) - supply::control_range(mains)
}
