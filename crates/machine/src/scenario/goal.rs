//! `[goal]` of a scenario: goals of the tip with their times.

use super::{check_series, Result};
use crate::errors::ErrorKind;
use crate::reading::reader::{Field, Reader};

/// From `time` on the tip moves to `place` on a straight line, until another goal is given or a stick is moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goal {
    /// s
    pub time: f64,
    /// (x, z), m
    pub place: [f64; 2],
    /// m/s; `None`: that of full stick.
    pub speed: Option<f64>,
    /// Time at which it is cancelled, s, if it is not reached before.
    pub until: Option<f64>,
}

/// The goals in order of time.
pub fn read(root: &Reader) -> Result<Vec<Goal>> {
    let Some(table) = root.table("goal")? else { return Ok(Vec::new()) };
    // A phase can bring the controller that has goals.
    if root.has("command") && !root.has("phase") {
        let message = "excludes `command`, which is given too";
        return Err(root
            .key_error(ErrorKind::ConflictingKeys, "goal", message)
            .help("either goals of the tip or spool commands move the crane"));
    }
    let time_field = table.required("time", "a list of times, for example [\"0.5 s\", \"6 s\"]")?;
    let times = time_field.series()?;
    if let Some(time) = times.first().filter(|time| **time < 0.0) {
        let message = format!("a goal at {time} s, before the run has begun");
        return Err(time_field.error(ErrorKind::OutOfRange, message).help("give times of zero or more"));
    }
    let mut axes = Vec::new();
    for axis in ["x", "z"] {
        let field =
            table.required(axis, "a list with one coordinate for each time, for example [\"2.5 m\", \"3 m\"]")?;
        let values = field.series()?;
        check_series(&times, &values, &time_field, &field)?;
        axes.push(values);
    }
    let speeds = match table.optional("speed")? {
        None => None,
        Some(field) => {
            let speeds = field.series()?;
            check_series(&times, &speeds, &time_field, &field)?;
            if let Some(speed) = speeds.iter().find(|speed| **speed <= 0.0) {
                let message = format!("a speed of {speed} m/s reaches no goal");
                return Err(field.error(ErrorKind::OutOfRange, message).help("give speeds above zero"));
            }
            Some(speeds)
        }
    };
    let goal = |row: usize| Goal {
        time: times[row],
        place: [axes[0][row], axes[1][row]],
        speed: speeds.as_ref().map(|speeds| speeds[row]),
        until: None,
    };
    let mut goals: Vec<Goal> = (0..times.len()).map(goal).collect();
    if let Some(field) = table.optional("drop")? {
        drop_at(&mut goals, &field)?;
    }
    Ok(goals)
}

/// Each time cancels the previous goal.
fn drop_at(goals: &mut [Goal], field: &Field) -> Result<()> {
    for time in field.series()? {
        let before = goals.partition_point(|goal| goal.time < time);
        let goal = goals[..before].last_mut().filter(|goal| goal.until.is_none());
        let Some(goal) = goal else {
            let message = format!("there is no goal to cancel at {time} s");
            let cure = "give increasing times, each after the goal that it cancels and at most one for each goal";
            return Err(field.error(ErrorKind::OutOfRange, message).help(cure));
        };
        goal.until = Some(time);
    }
    Ok(())
}
