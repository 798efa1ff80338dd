//! Flows beside each other: those of the valves and lines of one cylinder, and those of cylinders by the time of their strokes.

use super::{digits, Axis};
use crate::model::Machine;
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::Result;
use std::cmp::Ordering;

/// Tables of valves and lines of a cylinder with a nominal flow.
const TABLES: [&str; 8] = [
    "valve",
    "counterbalance",
    "pilot-check",
    "hose-burst",
    "port-relief",
    "crossover-relief",
    "anti-cavitation",
    "line",
];
/// Times that a value lies outside of the only other one, and of all of several, which may not be wrong all at once. Real flows of a
/// section, each at a drop of its own, differ by some three, and so do real times of strokes.
const APART: [f64; 2] = [20.0, 5.0];

/// Whether `own` is much smaller or larger than the `others`, and these from the smallest to the largest.
fn apart(own: f64, others: &[f64]) -> Option<(Ordering, [f64; 2])> {
    let least = others.iter().copied().reduce(f64::min)?;
    let most = others.iter().copied().fold(least, f64::max);
    let times = APART[usize::from(others.len() > 1)];
    let order = if own * times < least {
        Ordering::Less
    } else if own > times * most {
        Ordering::Greater
    } else {
        return None;
    };
    Some((order, [least, most]))
}

/// A nominal flow, m^3/s, of a section.
struct Flow<'a> {
    table: Reader<'a>,
    cylinder: usize,
    kind: &'static str,
    flow: f64,
}

/// A relief valve may be as large as it likes: some are stated by their opening. Of a valve and one other, speeds tell of the valve.
pub fn sections<T: Number>(root: &Reader, machine: &Machine<T>) -> Result<()> {
    let mut flows = Vec::new();
    for kind in TABLES {
        for (_, table) in root.named_tables(kind)? {
            let Some(flow) = table.optional_quantity::<f64>("nominal-flow")?.filter(|_| !table.is_doubted()) else {
                continue;
            };
            let name = table.text("cylinder")?;
            let cylinder = machine.cylinders.iter().position(|of| of.name == name);
            flows.extend(cylinder.map(|cylinder| Flow { table, cylinder, kind, flow }));
        }
    }
    for (place, own) in flows.iter().enumerate() {
        let fed = |(other, of): &(usize, &Flow)| {
            *other != place && of.cylinder == own.cylinder && !of.kind.ends_with("relief")
        };
        let others: Vec<f64> = flows.iter().enumerate().filter(fed).map(|(_, of)| of.flow).collect();
        let Some((order, ends)) = apart(own.flow, &others) else { continue };
        let large = order == Ordering::Greater;
        if (own.kind == "valve" && others.len() == 1) || (own.kind.ends_with("relief") && large) {
            continue;
        }
        let [least, most] = ends.map(|flow| digits(60e3 * flow));
        let of = &machine.cylinders[own.cylinder];
        let beside = match others.len() {
            1 => format!("the {least} l/min of valve.{}", of.valve.name),
            _ if least == most => format!("the {least} l/min of the others at cylinder `{}`", of.name),
            _ => format!("the {least} to {most} l/min of the others at cylinder `{}`", of.name),
        };
        own.table.required("nominal-flow", "a volume flow")?.warn(
            format!("{} beside {beside}", if large { "large" } else { "small" }),
            "check the unit of all these nominal flows: ml or l, per minute or second?".into(),
        );
    }
    Ok(())
}

/// Times of whole strokes at full opening without a load. Of two cylinders the slower one is named.
pub fn strokes<T: Number>(axes: &[Axis<T>]) -> Result<()> {
    let sound: Vec<&Axis<T>> = axes.iter().filter(|axis| !axis.is_doubted() && axis.sizes.asked > 0.0).collect();
    let times: Vec<f64> = sound.iter().map(|axis| axis.sizes.stroke * axis.sizes.areas[0] / axis.sizes.asked).collect();
    for (place, axis) in sound.iter().enumerate() {
        let others = [&times[..place], &times[place + 1..]].concat();
        let Some((order, ends)) = apart(times[place], &others) else { continue };
        let slow = order == Ordering::Greater;
        if !slow && others.len() == 1 {
            continue;
        }
        let [least, most] = ends.map(digits);
        let taken = match others.len() {
            1 => format!("the other one {least} s"),
            _ => format!("the others {least} to {most} s"),
        };
        axis.valve.required("nominal-flow", "a volume flow")?.warn(
            format!(
                "{}: at full opening cylinder `{}` takes {} s for its stroke, and {taken}",
                if slow { "small" } else { "large" },
                axis.of.name,
                digits(times[place])
            ),
            "check the nominal flows and drops of these valves, and the bores and strokes, with their units".into(),
        );
    }
    Ok(())
}
