//! Spool commands of all cylinders on common times.

use super::start::known;
use crate::inputs::options::Commands;
use crate::model::Model;
use crate::warning::short;
use hydrocrane_machine::scenario::{Interpolation, SpoolCommand};

/// The commands on common times, the first of them zero; cylinders without a command keep their spools centred.
///
/// # Errors
/// An unknown cylinder, a command beyond its spool's stroke, and a mixture of held and linearly interpolated commands.
pub fn commands(stated: &[SpoolCommand], model: &dyn Model) -> Result<Commands, String> {
    let cylinders = &model.machine().cylinders;
    let names: Vec<&str> = cylinders.iter().map(|c| c.name.as_str()).collect();
    known("cylinder", stated.iter().map(|command| command.cylinder.as_str()), &names)?;
    let mut times = vec![0.0];
    times.extend(stated.iter().flat_map(|command| &command.time).copied().filter(|t| *t >= 0.0));
    times.sort_by(f64::total_cmp);
    times.dedup();
    let mut values = vec![0.0; times.len() * names.len()];
    // A constant is the same with both interpolations, so it does not determine the interpolation.
    let varied = stated.iter().filter(|c| c.spool.iter().any(|spool| *spool != c.spool[0]));
    let linear: Vec<bool> = varied.map(|command| command.interpolation == Interpolation::Linear).collect();
    if linear.contains(&true) && linear.contains(&false) {
        return Err("the commands of one scenario must share one interpolation, `hold` or `linear`".into());
    }
    for command in stated {
        let c = names.iter().position(|name| *name == command.cylinder).unwrap_or_default();
        check_stroke(command, cylinders[c].valve.stroke)?;
        for (row, t) in times.iter().enumerate() {
            values[row * names.len() + c] = at(command, *t);
        }
    }
    Ok(Commands { times, values, linear: linear.contains(&true) })
}

fn check_stroke(command: &SpoolCommand, stroke: f64) -> Result<(), String> {
    let largest = command.spool.iter().fold(0.0, |most: f64, spool| most.max(spool.abs()));
    if largest <= stroke * (1.0 + 1e-9) {
        return Ok(());
    }
    let (cylinder, asked, there) = (&command.cylinder, short(largest * 1e3), short(stroke * 1e3));
    Err(format!(
        "the command of `{cylinder}` demands {asked} mm of spool; its valve has {there} mm (commands are in metres)"
    ))
}

/// The command at time `t`: a held one is zero before its first time, an interpolated one keeps its end values.
fn at(command: &SpoolCommand, t: f64) -> f64 {
    let (times, spool) = (&command.time, &command.spool);
    let next = times.partition_point(|time| *time <= t);
    match (command.interpolation, next) {
        (Interpolation::Hold, 0) => 0.0,
        (Interpolation::Linear, 0) => spool[0],
        (Interpolation::Linear, next) if next < times.len() => {
            let (t0, u0) = (times[next - 1], spool[next - 1]);
            (spool[next] - u0) / (times[next] - t0) * (t - t0) + u0
        }
        (_, next) => spool[next - 1],
    }
}
