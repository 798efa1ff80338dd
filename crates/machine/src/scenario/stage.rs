//! Stages of a scenario: its settings at the start, then with each of its phases.

use super::closed_loop::{fitting, ControllerChoice, Joystick, StickMode};
use super::stated::{full_speed_key, stated};
use super::supply::MEASURED;
use super::{Phase, Scenario};
use crate::keys::LEVER;
use crate::text::merge::OverrideValue;

/// Settings from a time on.
#[derive(Debug, Clone, PartialEq)]
pub struct Stage {
    /// s
    pub from: f64,
    /// Overrides of the machine's values, of the scenario and of all phases until here.
    pub overrides: Vec<(String, OverrideValue)>,
    /// `None`: spool commands move the crane.
    pub controller: Option<ControllerChoice>,
    /// `None`: all sticks centred.
    pub joystick: Option<Joystick>,
}

impl Scenario {
    /// All stages, the first from zero on.
    pub fn stages(&self) -> Vec<Stage> {
        let mut stages = vec![self.with_supply(self.start())];
        for phase in &self.phases {
            let next = stages[stages.len() - 1].then(phase);
            stages.push(next);
        }
        stages.into_iter().map(|stage| self.with_hoses(stage)).collect()
    }

    /// The controller of the first stage that has one.
    pub fn first_controller(&self) -> Option<ControllerChoice> {
        self.start().first_controller(&self.phases)
    }

    /// The settings at the start, without what measured pressures and hoses change.
    fn start(&self) -> Stage {
        Stage {
            from: 0.0,
            overrides: self.overrides.clone(),
            controller: self.controller.clone(),
            joystick: self.joystick.clone(),
        }
    }

    /// The stage on a machine with the measured supply pressure, if there is one.
    fn with_supply(&self, mut stage: Stage) -> Stage {
        if self.supply.is_some() {
            let (key, value) = MEASURED;
            stage.overrides.retain(|(other, _)| other != key);
            stage.overrides.push((key.into(), OverrideValue::Text(value.into())));
        }
        stage
    }
}

impl Stage {
    /// The settings after the begin of `phase`. Later statements have priority: an override over earlier tables.
    pub fn then(&self, phase: &Phase) -> Stage {
        let states = |key: &str| phase.overrides.iter().any(|(stated, _)| stated == key);
        let mut overrides = self.overrides.clone();
        overrides.retain(|(key, _)| !states(key));
        overrides.extend(phase.overrides.iter().cloned());
        let mut controller = self.chosen(phase);
        let mut earlier = self.joystick.clone();
        if let Some(choice) = &mut controller {
            let stated = phase.controller.as_ref().is_some_and(|own| own.period.is_some());
            if choice.own.is_none() && states("control.period") && !stated {
                choice.period = None;
            }
            let full_speed = full_speed_key(&choice.name).is_some_and(|key| states(&key));
            if let Some(stick) = earlier.as_mut().filter(|_| full_speed) {
                stick.full_speed = None;
            }
        }
        let stick = phase.joystick.clone().or(earlier);
        let joystick = stick.filter(|stick| controller.as_ref().is_none_or(|choice| stick.fits(choice)));
        Stage { from: phase.time, overrides, controller, joystick }
    }

    /// The controller of this stage, or of the first of `phases` after it that has one.
    pub fn first_controller(self, phases: &[Phase]) -> Option<ControllerChoice> {
        let next = |stage: Stage, phase| if stage.controller.is_some() { stage } else { stage.then(phase) };
        phases.iter().fold(self, next).controller
    }

    /// The controller of the phase; else the previous one, or the one that a stick of the other mode selects.
    fn chosen(&self, phase: &Phase) -> Option<ControllerChoice> {
        if let Some(choice) = &phase.controller {
            let before = self.controller.as_ref().and_then(|before| before.period);
            return Some(ControllerChoice { period: choice.period.or(before), ..choice.clone() });
        }
        match (&phase.joystick, &self.controller) {
            (Some(stick), None) => Some(ControllerChoice::named(fitting(Some(stick)))),
            (Some(stick), Some(before)) if !stick.fits(before) => {
                Some(ControllerChoice { name: fitting(Some(stick)).into(), monitor: None, ..before.clone() })
            }
            (_, before) => before.clone(),
        }
    }

    /// The overrides, with those from the controller's period and the speed at full stick.
    pub fn machine_overrides(&self) -> Vec<(String, OverrideValue)> {
        let mut all = self.overrides.clone();
        for (key, value) in self.loop_overrides() {
            all.retain(|(other, _)| *other != key);
            all.push((key, OverrideValue::Number(value)));
        }
        all
    }

    /// Machine keys that the period of a controller by name and the speed at full stick replace, in SI.
    pub fn loop_overrides(&self) -> Vec<(String, f64)> {
        let Some(choice) = self.controller.as_ref().filter(|choice| choice.own.is_none()) else { return Vec::new() };
        let full_speed = self.joystick.as_ref().and_then(|stick| stick.full_speed);
        let found = stated(None, Some(&choice.name), choice.period, full_speed);
        found.into_iter().map(|stated| (stated.key, stated.value)).collect()
    }

    /// Mode of the sticks.
    pub fn stick_mode(&self) -> StickMode {
        match (&self.joystick, &self.controller) {
            (Some(stick), _) => stick.mode,
            (None, Some(choice)) if choice.own.is_none() && choice.name == LEVER => StickMode::Lever,
            _ => StickMode::Tip,
        }
    }
}
