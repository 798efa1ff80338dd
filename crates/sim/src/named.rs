//! Controllers that a scenario can name.

use crate::controllers;
use hydrocrane_control::controller::Controller;
use hydrocrane_control::heinze_pid::HeinzePid;
use hydrocrane_control::lever::Lever;
use hydrocrane_control::tip::Tip;
use hydrocrane_machine::Machine;

/// Lever control's name.
pub const LEVER: &str = "lever";
/// Period of lever control where the machine states none, s.
const LEVER_PERIOD: f64 = 0.01;

/// The controller `name` for a machine, with the machine's period and gains where it states them.
pub fn controller(machine: &Machine, name: &str) -> Result<Box<dyn Controller>, String> {
    if name == LEVER {
        let strokes = machine.cylinders.iter().map(|cylinder| cylinder.valve.stroke).collect();
        return Ok(Box::new(Lever::new(machine.control.period.unwrap_or(LEVER_PERIOD), strokes)));
    }
    match machine.joints.len() {
        1 => sized::<1>(machine, name),
        2 => sized::<2>(machine, name),
        3 => sized::<3>(machine, name),
        4 => sized::<4>(machine, name),
        5 => sized::<5>(machine, name),
        6 => sized::<6>(machine, name),
        _ => controllers::build(machine, name),
    }
}

fn sized<const N: usize>(machine: &Machine, name: &str) -> Result<Box<dyn Controller>, String> {
    let own = &machine.control;
    let full_speed = own.gain(name, "full-speed");
    match name {
        "tip" => {
            let mut settings = controllers::tip_settings::<N>(machine)?;
            settings.period = own.period.unwrap_or(settings.period);
            settings.full_speed = full_speed.unwrap_or(settings.full_speed);
            Ok(Box::new(Tip::new(controllers::nominal::<N>(machine)?, settings)))
        }
        "heinze-pid" => {
            let mut settings = controllers::heinze_settings::<N>(machine);
            if let Some(period) = own.period {
                (settings.period, settings.set_point_interval) = (period, period);
            }
            settings.full_speed = full_speed.unwrap_or(settings.full_speed);
            Ok(Box::new(HeinzePid::new(controllers::nominal::<N>(machine)?, settings)))
        }
        _ => controllers::build(machine, name),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hydrocrane_machine::{load, OverrideValue, CONTROLLERS};

    #[test]
    fn every_controller_of_the_file_format_can_be_built_and_no_other() {
        let machine = load("rottne-f9-lab", &[]).unwrap();
        assert_eq!(CONTROLLERS.map(|(name, _)| name), controllers::CONTROLLERS);
        for (name, _) in CONTROLLERS {
            assert!(controller(&machine, name).unwrap().period() > 0.0);
        }
        let message = controller(&machine, "tipp").err().unwrap();
        assert!(message.contains("tip, heinze-pid"), "{message}");
    }

    #[test]
    fn every_controller_takes_the_period_of_the_machine() {
        let machine = load("rottne-f9-lab", &[("control.period".into(), OverrideValue::Number(0.02))]).unwrap();
        for name in [LEVER, "tip", "heinze-pid"] {
            assert_eq!(controller(&machine, name).unwrap().period(), 0.02, "{name}");
        }
    }
}
