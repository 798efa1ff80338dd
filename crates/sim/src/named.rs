//! Controllers that a scenario can name.

use crate::controllers;
use hydrocrane_control::controller::Controller;
use hydrocrane_control::lever::Lever;
use hydrocrane_machine::Machine;

/// Lever control's name.
pub const LEVER: &str = "lever";
/// Period of lever control where the machine states none, s.
const LEVER_PERIOD: f64 = 0.01;

/// The controller `name` for a machine, at the machine's period where it states one.
pub fn controller(machine: &Machine, name: &str) -> Result<Box<dyn Controller>, String> {
    let wanted = machine.control.period;
    let built: Box<dyn Controller> = if name == LEVER {
        let strokes = machine.cylinders.iter().map(|cylinder| cylinder.valve.stroke).collect();
        Box::new(Lever::new(wanted.unwrap_or(LEVER_PERIOD), strokes))
    } else {
        controllers::build(machine, name)?
    };
    match wanted {
        Some(period) if (period - built.period()).abs() > 1e-12 => {
            Err(format!("`{name}` samples every {} s; it cannot be run at {period} s", built.period()))
        }
        _ => Ok(built),
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
    fn lever_control_takes_the_period_of_the_machine() {
        let machine = load("rottne-f9-lab", &[("control.period".into(), OverrideValue::Number(0.02))]).unwrap();
        assert_eq!(controller(&machine, LEVER).unwrap().period(), 0.02);
    }
}
