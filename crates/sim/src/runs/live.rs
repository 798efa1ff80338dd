//! A crane driven live: the loop of a sampled run, step by step, with sticks that an operator moves.
//!
//! The operator's input takes effect at the controller's next sample and is recorded there, so that
//! [`simulate_phases`](crate::simulate_phases) with the same options repeats the drive to the last bit.

use crate::event_loop::driven::{stepper, Driven};
use crate::event_loop::EventLoop;
use crate::inputs::faults::{start_fault, state_fault};
use crate::inputs::options::{Commands, RunOptions};
use crate::inputs::sensing::Sensors;
use crate::inputs::stick::Sticks;
use crate::inputs::supply::RateAtHand;
use crate::model::model_change::{count_due, take, ModelChange, ModelChanges, OwnedChanges};
use crate::model::payload::{Loads, PayloadChange, PayloadEvent};
use crate::model::Model;
use crate::outcome::Outcome;
use crate::runs::phases::{changes_fault, states_fault};
use crate::runs::sampled::{plan_fault, Event, Sampled, SampledPlan, Sampling};
use crate::runs::schedule::Schedule;
use crate::warning::Warning;
use hydrocrane_control::interface::controller::{Controller, Goal};
use hydrocrane_plant::layout::MAX_JOINTS;
use std::sync::Arc;

/// Rounding tolerance between the requested time and the end of a step, s.
pub(crate) const ROUNDING: f64 = 1e-9;

pub struct Live {
    model: Arc<dyn Model>,
    /// Machines that take its place.
    changes: OwnedChanges,
    controller: Box<dyn Controller>,
    going: EventLoop,
    sampled: Sampled,
    /// Spool commands against time, until a phase under the controller begins.
    schedule: Option<Schedule>,
    options: RunOptions,
    loads: Loads,
    commands: CommandsAtHand,
    /// At the tip, kg: now, and from the next sample on.
    payload: f64,
    wanted_payload: f64,
    deflections: Vec<f64>,
    /// Share of the full speed in force.
    precision: f64,
    /// A goal for the next sample, and whether the present one is cancelled there.
    goal: Option<Goal>,
    dropping: bool,
    set_point: Option<[f64; 3]>,
    sampled_until: f64,
    /// Time at which the next phase begins, s.
    phase_end: f64,
    /// Whether sticks and loads are those of the plan (a replay).
    replaying: bool,
    ended: Option<Outcome>,
}

/// Commands at a time (s), and their rates of change from there on; with that of a measured supply pressure.
#[derive(Debug, Clone, Copy)]
struct CommandsAtHand {
    base: [f64; MAX_JOINTS],
    slope: [f64; MAX_JOINTS],
    since: f64,
    supply: RateAtHand,
}

impl CommandsAtHand {
    fn of(driven: &Driven) -> Self {
        CommandsAtHand { base: driven.base, slope: driven.slope, since: driven.since, supply: driven.supply.now }
    }
}

impl Live {
    /// Begins at rest at time zero in state `x0`, with a machine and those that take its place; the error states why that is
    /// impossible. The sticks of `plan` define kind, dead zone and ramp. If they move, or if `options` have loads, the drive is a
    /// replay of both until an operator [takes over](Self::take_over).
    pub fn new(
        (model, changes): (Arc<dyn Model>, OwnedChanges),
        controller: Box<dyn Controller>,
        x0: &[f64],
        plan: &SampledPlan,
        options: RunOptions,
    ) -> Result<Self, String> {
        let fault = start_fault(model.as_ref(), x0, &options)
            .or_else(|| plan_fault(plan, controller.period()))
            .or_else(|| changes_fault(model.as_ref(), &ModelChange::all(&changes), 0.0));
        if let Some(fault) = fault {
            return Err(fault);
        }
        let stepper = stepper(x0, model.as_ref(), &options).ok_or_else(|| format!("no method `{}`", options.method))?;
        let driven = Driven::new(model.as_ref(), &options, 0.0);
        let sampled = Sampled::new(0.0, x0, &driven, plan);
        let (going, commands) = (EventLoop::new(stepper, &driven), CommandsAtHand::of(&driven));
        Ok(Live {
            going,
            sampled,
            schedule: None,
            commands,
            controller,
            loads: Loads::new(&options.payload_changes),
            replaying: !plan.sticks.idle() || !options.payload_changes.is_empty(),
            payload: options.payload,
            wanted_payload: options.payload,
            deflections: vec![0.0; plan.sticks.axes],
            precision: 1.0,
            goal: None,
            dropping: false,
            set_point: None,
            sampled_until: 0.0,
            phase_end: f64::INFINITY,
            ended: None,
            options,
            model,
            changes,
        })
    }

    /// At the start: spool commands against time in place of the controller, until an operator takes over.
    pub fn with_commands(mut self, commands: &Commands) -> Self {
        let mut driven = Driven::new(self.model.as_ref(), &self.options, 0.0);
        let mut schedule = Schedule::new(commands, self.model.as_ref());
        schedule.begin(0.0, &mut driven);
        self.commands = CommandsAtHand::of(&driven);
        (self.schedule, self.replaying) = (Some(schedule), true);
        self
    }

    /// The plan goes on until an operator [takes over](Self::take_over), for example by phases to come.
    pub(crate) fn replay(&mut self) {
        self.replaying = true;
    }

    /// The present machine and those that will take its place.
    pub(crate) fn machines(&self) -> (Arc<dyn Model>, OwnedChanges) {
        (self.model.clone(), self.changes.clone())
    }

    /// Sets the sticks from the next sample on. Missing and NaN deflections count as centred; a stick ends at -1 and 1.
    pub fn set_sticks(&mut self, deflections: &[f64]) {
        for (axis, held) in self.deflections.iter_mut().enumerate() {
            let wanted = deflections.get(axis).copied().unwrap_or(0.0);
            *held = if wanted.is_nan() { 0.0 } else { wanted.clamp(-1.0, 1.0) };
        }
    }

    /// Sets the `share` of the full speed from the next sample on, for precise work. NaN counts as full speed.
    pub fn set_precision(&mut self, share: f64) {
        self.precision = if share.is_nan() { 1.0 } else { share.clamp(0.0, 1.0) };
    }

    /// Moves the tip to `place` (x, z), m, from the next sample on, at `speed` (m/s, default that of full stick), until
    /// a stick is moved. The error states why it cannot.
    pub fn go_to(&mut self, place: [f64; 2], speed: Option<f64>) -> Result<(), String> {
        if let Some(speed) = speed.filter(|speed| !(speed.is_finite() && *speed > 0.0)) {
            return Err(format!("the speed to a goal is {speed} m/s; it must be greater than zero"));
        }
        let goal = Goal { place, speed, share: 1.0, given: 0.0, until: f64::INFINITY };
        if self.deflections.iter().any(|d| d.abs() > self.sticks().dead_zone) {
            return Err(format!("the tip cannot go to {}: a stick is deflected; release it first", goal.name()));
        }
        if let Some(why) = self.controller.refuses(place) {
            return Err(format!("the tip cannot go to {}: {why}", goal.name()));
        }
        (self.goal, self.dropping) = (Some(goal), false);
        Ok(())
    }

    /// Cancels the goal from the next sample on: the tip comes to rest smoothly.
    pub fn drop_goal(&mut self) {
        (self.goal, self.dropping) = (None, true);
    }

    /// The present goal of the tip, or that of the next sample (x, z), m.
    pub fn goal(&self) -> Option<[f64; 2]> {
        let going = self.goal.or_else(|| self.sampled.hand.goal().filter(|_| !self.dropping));
        going.map(|goal| goal.place)
    }

    /// Ends a replay: from the next sample on the sticks are those of [`Self::set_sticks`], and no more loads come. Spool
    /// commands against time continue until another phase [begins](Self::go_on).
    pub fn take_over(&mut self) {
        if !self.replaying {
            return;
        }
        self.replaying = false;
        self.loads.forget();
        self.wanted_payload = self.payload;
        if self.schedule.is_none() {
            self.sampled.take_over(self.controller.period());
        }
    }

    /// Whether spool commands against time are repeated.
    pub fn follows_commands(&self) -> bool {
        self.schedule.is_some()
    }

    pub fn replaying(&self) -> bool {
        self.replaying
    }

    /// Sets the payload to `mass` (kg) from the next sample on; an invalid mass is ignored.
    pub fn carry(&mut self, mass: f64) {
        if mass.is_finite() && mass >= 0.0 {
            self.wanted_payload = mass;
        }
    }

    /// Begins another phase: `model`, or the last of `changes` that is due, with `controller` and the sticks of `plan`, which
    /// keep their deflections if they are the same. Returns the record of the sticks so far. After an error nothing is changed.
    ///
    /// A phase that an operator begins starts [at a sample](Self::finish_sample). Any phase ends spool commands.
    pub fn go_on(
        &mut self,
        (model, mut changes): (Arc<dyn Model>, OwnedChanges),
        controller: Box<dyn Controller>,
        plan: &SampledPlan,
    ) -> Result<Sticks, String> {
        let due = count_due(changes.iter().map(|(time, _)| *time), self.time());
        let model = take(&mut changes, due).unwrap_or(model);
        let fault = states_fault(self.model.as_ref(), model.as_ref())
            .or_else(|| changes_fault(model.as_ref(), &ModelChange::all(&changes), self.time()))
            .or_else(|| plan_fault(plan, controller.period()))
            .or_else(|| state_fault(model.as_ref(), self.state()));
        if let Some(fault) = fault {
            return Err(fault);
        }
        let sticks = self.sticks().clone();
        if (sticks.kind, sticks.axes) != (plan.sticks.kind, plan.sticks.axes) {
            self.deflections = vec![0.0; plan.sticks.axes];
        }
        let before = self.model.clone();
        let mut driven = self.driven(before.as_ref());
        self.going.go_on(&mut driven, model.as_ref());
        let (now, x) = (self.going.stepper.t, &self.going.stepper.x);
        if self.schedule.take().is_some() {
            driven.hold(now);
            self.sampled = Sampled::new(now, x, &driven, plan);
        } else {
            self.sampled.go_on(now, x, &driven, plan);
        }
        self.commands = CommandsAtHand::of(&driven);
        (self.model, self.changes, self.controller, self.set_point) = (model, changes, controller, None);
        self.phase_end = f64::INFINITY;
        Ok(sticks)
    }

    /// Advances to the next sample after time `after` (s), where another phase can begin; with spool commands against
    /// time it can at any time. An error is the outcome of the drive.
    pub fn finish_sample(&mut self, after: f64) -> Result<f64, Outcome> {
        loop {
            match self.sample_due() {
                Some(now) if now > after => return Ok(now),
                _ if self.schedule.is_some() && self.time() > after => return Ok(self.time()),
                _ => self.advance(self.time() + 2.0 * ROUNDING)?,
            }
        }
    }

    /// Time of the next sample, if that is before the next step.
    fn sample_due(&self) -> Option<f64> {
        let sampled = self.schedule.is_none();
        self.going.due().filter(|now| sampled && *now >= self.sampled.next_sample(self.controller.period()))
    }

    /// The crane with its present inputs.
    fn driven<'a>(&self, model: &'a dyn Model) -> Driven<'a> {
        let CommandsAtHand { base, slope, since, supply } = self.commands;
        let mut driven = Driven::new(model, &self.options, since);
        driven.supply.now = supply;
        Driven { payload: self.payload, base, slope, since, ..driven }
    }

    /// Ends the present phase at `time` (s), at which a step then ends.
    pub fn end_phase_at(&mut self, time: f64) {
        self.phase_end = time;
    }

    /// Advances to time `until` (s) in whole steps. An error is the outcome of the drive, and is final.
    pub fn advance(&mut self, until: f64) -> Result<(), Outcome> {
        if let Some(outcome) = &self.ended {
            return Err(outcome.clone());
        }
        let (model, mut changes) = (self.model.clone(), std::mem::take(&mut self.changes));
        let mut driven = self.driven(model.as_ref());
        driven.loads = std::mem::take(&mut self.loads);
        driven.changes = ModelChanges::new(ModelChange::all(&changes));
        let mut going = Ok(());
        while going.is_ok() && self.time() < until - ROUNDING {
            self.write_down(&mut driven);
            going = match &mut self.schedule {
                Some(schedule) => self.going.step(&mut driven, schedule, self.phase_end),
                None => {
                    let mut sampling = Sampling { state: &mut self.sampled, controller: self.controller.as_mut() };
                    self.going.step(&mut driven, &mut sampling, self.phase_end)
                }
            };
            if let Some(place) = self.sampled.samples.set_points.last() {
                self.set_point = (!place[0].is_nan()).then_some(*place);
                self.sampled.samples.clear();
            }
        }
        self.commands = CommandsAtHand::of(&driven);
        self.payload = driven.payload;
        self.loads = driven.loads;
        let done = driven.changes.done();
        if let Some(model) = take(&mut changes, done) {
            self.model = model;
        }
        self.changes = changes;
        self.ended = going.clone().err();
        going
    }

    /// Records the operator's input at a sample.
    fn write_down(&mut self, driven: &mut Driven) {
        let Some(now) = self.sample_due() else { return };
        self.sampled_until = now;
        if self.replaying {
            return;
        }
        self.sampled.hand.hold(now, &self.deflections, self.precision);
        if std::mem::take(&mut self.dropping) {
            self.sampled.hand.drop_goal(now);
        }
        if let Some(goal) = self.goal.take() {
            self.sampled.hand.go_to(Goal { given: now, ..goal });
        }
        // The payload at the start is that of the start pressures, so a change takes effect at the second sample.
        if self.wanted_payload != driven.payload && now > 0.0 {
            driven.loads.add(PayloadChange { time: now, mass: self.wanted_payload });
        }
    }

    /// The machine now.
    pub fn model(&self) -> &dyn Model {
        self.model.as_ref()
    }

    /// Time between samples, s.
    pub fn period(&self) -> f64 {
        self.controller.period()
    }

    /// Time of the last sample, s, until which the drive is recorded.
    pub fn sampled_until(&self) -> f64 {
        self.sampled_until
    }

    /// s since the start
    pub fn time(&self) -> f64 {
        self.going.stepper.t
    }

    pub fn state(&self) -> &[f64] {
        &self.going.stepper.x
    }

    /// Energies since the start, J: the cylinders' terms, then those of the payload; empty without ledger.
    pub fn energies(&self) -> Vec<f64> {
        let own = self.going.stepper.integrals();
        let payload = if own.is_empty() { &[][..] } else { &self.loads.account };
        [own, payload].concat()
    }

    /// At the tip, kg.
    pub fn payload(&self) -> f64 {
        self.payload
    }

    /// Spool commands at the valves, m.
    pub fn commands(&self) -> Vec<f64> {
        self.driven(self.model.as_ref()).command(self.time())[..self.model.layout().joints()].to_vec()
    }

    /// Set-point of the tip (x, y, z), m, if the controller has one.
    pub fn set_point(&self) -> Option<[f64; 3]> {
        self.set_point
    }

    /// Deflections at the last sample, after dead zone and ramp.
    pub fn sticks_at(&self) -> &[f64] {
        self.sampled.hand.at()
    }

    pub fn sensors(&self) -> &Sensors {
        &self.sampled.sensors
    }

    /// Events since the last call.
    pub fn events(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.sampled.events)
    }

    /// Warnings since the last call.
    pub fn warnings(&mut self) -> Vec<Warning> {
        let found = self.going.warnings(self.model.as_ref());
        self.sampled.paths.warning().into_iter().chain(found).collect()
    }

    /// Outcome of the drive, if it has ended.
    pub fn outcome(&self) -> Option<&Outcome> {
        self.ended.as_ref()
    }

    /// Record of the sticks.
    pub fn sticks(&self) -> &Sticks {
        self.sampled.hand.sticks()
    }

    /// Payload at the start, kg, and the loads picked up and released since.
    pub fn loads(&self) -> (f64, &[PayloadEvent]) {
        (self.options.payload, &self.loads.events)
    }
}
