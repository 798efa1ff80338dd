//! A scenario played live, stage by stage, until an operator takes over: the page and `LiveSimulator` drive by it.
//!
//! If nobody takes over, it repeats [`simulate_phases`](crate::simulate_phases) to the last bit. An operator who takes over ends
//! the plan: its sticks, goals, loads and later stages; hoses still burst and sensors still fail. Spool commands give way
//! to levers.

use crate::assembly::{levers, AssembledStage, Assembly, OwnedDriver};
use crate::inputs::sensing::SensorFault;
use crate::inputs::stick::Sticks;
use crate::model::controllers::LEVER;
use crate::model::Model;
use crate::outcome::{Outcome, OutcomeKind};
use crate::runs::live::{Live, ROUNDING};
use crate::warning::Warning;
use hydrocrane_machine::scenario::{ControllerChoice, Stage};
use std::collections::VecDeque;
use std::sync::Arc;

/// Share of a period by which a time counts as that of the sample before it.
const SHARE: f64 = 1e-6;

pub struct Playback {
    pub live: Live,
    now: PlayedStage,
    /// Earlier stages, with the record of their sticks.
    earlier: Vec<(PlayedStage, Sticks)>,
    coming: VecDeque<AssembledStage>,
    sensor_faults: Vec<SensorFault>,
    /// Time at which spool commands end, s.
    end: f64,
    /// The reason if the next stage cannot begin.
    stuck: Option<String>,
    /// Warnings on the start that were not yet returned.
    doubts: Vec<Warning>,
}

/// A stage that has begun, with its machine.
pub struct PlayedStage {
    pub stage: Stage,
    pub model: Arc<dyn Model>,
}

impl Playback {
    /// At the start of a scenario.
    ///
    /// # Errors
    /// The reason why it cannot begin.
    pub fn new(assembly: Assembly) -> Result<Self, String> {
        let Assembly { x0, doubts, end, options, stages, sensor_faults } = assembly;
        let mut coming = VecDeque::from(stages);
        let first = coming.pop_front().ok_or("a scenario has a stage")?;
        let now = PlayedStage { stage: first.stage.clone(), model: first.model.clone() };
        let mut live = first.live(&x0, options)?;
        if !coming.is_empty() {
            live.replay();
        }
        let earlier = Vec::new();
        let mut playback = Playback { live, now, earlier, coming, sensor_faults, end, stuck: None, doubts };
        playback.live.end_phase_at(playback.next_phase());
        Ok(playback)
    }

    /// The present stage.
    pub fn now(&self) -> &PlayedStage {
        &self.now
    }

    /// The stages that have begun, with the record of the sticks in each.
    pub fn played(&self) -> impl Iterator<Item = (&PlayedStage, &Sticks)> {
        let earlier = self.earlier.iter().map(|(stage, sticks)| (stage, sticks));
        earlier.chain([(&self.now, self.live.sticks())])
    }

    /// Number of stages that have ended.
    pub fn ended_stages(&self) -> usize {
        self.earlier.len()
    }

    /// Time until which the drive is recorded, s.
    pub fn recorded_until(&self) -> f64 {
        if self.live.follows_commands() {
            self.live.time()
        } else {
            self.live.sampled_until()
        }
    }

    /// Time at which the next stage begins, or spool commands end, s.
    pub fn next_phase(&self) -> f64 {
        match self.coming.front() {
            Some(next) => next.stage.from,
            None if self.live.follows_commands() && self.live.time() < self.end - ROUNDING => self.end,
            None => f64::INFINITY,
        }
    }

    /// Advances to time `until` (s) through the stages; returns whether the drive continues.
    pub fn advance(&mut self, until: f64) -> bool {
        while self.next_phase() <= until && self.stuck.is_none() && self.live.advance(self.next_phase()).is_ok() {
            self.stuck = self.next_stage().err();
        }
        self.stuck.is_none() && self.live.advance(until).is_ok()
    }

    /// Advances to the next sample, or by `duration` (s) and on to a sample; the begin of a stage counts as one.
    pub fn advance_samples(&mut self, duration: Option<f64>) -> bool {
        let target = duration.map(|duration| self.live.time() + duration);
        loop {
            let (begin, phase) = (self.now.stage.from, self.next_phase());
            let periods = |time: f64| (time - begin) / self.live.period();
            let sample = match target {
                Some(target) => (periods(target) - SHARE).ceil(),
                None => (periods(self.live.time()) + SHARE).floor() + 1.0,
            };
            let sample = begin + sample * self.live.period();
            if sample <= phase {
                return self.advance(sample);
            }
            if !self.advance(phase) {
                return false;
            }
            if target.is_none_or(|target| target <= phase) {
                return true;
            }
        }
    }

    fn next_stage(&mut self) -> Result<(), String> {
        if let Some(stage) = self.coming.pop_front() {
            self.go_on(stage)?;
        }
        self.live.end_phase_at(self.next_phase());
        Ok(())
    }

    fn go_on(&mut self, stage: AssembledStage) -> Result<(), String> {
        let OwnedDriver::Controller(controller, plan) = stage.driver else {
            return Err("spool commands against time begin with the drive".into());
        };
        let sticks = self.live.go_on((stage.model.clone(), stage.changes), controller, &plan)?;
        let now = PlayedStage { stage: stage.stage, model: stage.model };
        self.earlier.push((std::mem::replace(&mut self.now, now), sticks));
        Ok(())
    }

    /// Ends the plan when an operator moves a stick, a load or a knob. In place of spool commands levers begin at once.
    pub fn take_over(&mut self) {
        self.end_plan();
        if self.live.follows_commands() && self.outcome().is_none() {
            self.stuck = self.begin_levers().err();
        }
    }

    fn end_plan(&mut self) {
        self.live.take_over();
        self.live.end_phase_at(f64::INFINITY);
        self.coming.clear();
    }

    fn begin_levers(&mut self) -> Result<(), String> {
        let (model, changes) = self.live.machines();
        let (controller, plan) = levers(model.as_ref(), &self.sensor_faults)?;
        let choice = Some(ControllerChoice::named(LEVER));
        let stage = Stage {
            from: self.live.time(),
            overrides: self.now.stage.overrides.clone(),
            controller: choice,
            joystick: None,
        };
        let driver = OwnedDriver::Controller(controller, Box::new(plan));
        self.begin(AssembledStage { stage, controller_model: model.clone(), model, changes, driver }).map(|_| ())
    }

    /// Ends the plan and begins a stage of the operator's at the next sample; returns whether the drive continues.
    ///
    /// # Errors
    /// The reason why the stage cannot begin.
    pub fn change(&mut self, stage: AssembledStage) -> Result<bool, String> {
        self.end_plan();
        self.begin(stage)
    }

    fn begin(&mut self, mut stage: AssembledStage) -> Result<bool, String> {
        let Ok(from) = self.live.finish_sample(self.now.stage.from) else { return Ok(false) };
        stage.stage.from = from;
        self.go_on(stage).map(|()| true)
    }

    /// Outcome of the drive, if it has ended.
    pub fn outcome(&self) -> Option<Outcome> {
        let stuck = self.stuck.as_ref().map(|reason| {
            let message = format!(
                "the next phase of the replay cannot begin: {reason}; move a stick before that time to take over"
            );
            Outcome { kind: OutcomeKind::BadState, time: self.live.time(), message }
        });
        stuck.or_else(|| self.live.outcome().cloned())
    }

    /// Warnings since the last call.
    pub fn warnings(&mut self) -> Vec<Warning> {
        let doubts = std::mem::take(&mut self.doubts);
        [doubts, self.live.warnings()].concat()
    }
}
