//! Control of the crane tip: one stick, all cylinders, a straight path.  theory: docs/theory/control/tip.md
//!
//! Per sample: pressures and positions -> [`Drive`] (observer, speeds the valves can give now) -> [`Reference`]
//! (set-point, redundancy, scaling that keeps the direction) -> modelled load forces -> spool commands.

use crate::estimate::{
    chamber_estimate::Pressures, model_error::Straying, observer, readings::Readings, standstill::Sinking,
    standstill::Standstill,
};
use crate::interface::controller::{copied_by_clone, Controller, Fault, Goal, Measurement, Stick};
use crate::interface::notice::{Aim, Cause, Indices, News, Notice};
use crate::interface::point_to_point::{Stretch, Travel};
use crate::interface::signal::Signal;
use crate::model::controller_model::{ControllerModel, Posture};
use crate::model::{feed_forward::Moment, oil_modes::OilModes, slewing::SLEW};
use crate::reference::holding::Hold;
use crate::reference::request::Request;
use crate::reference::set_point::{Means, Reference, STANDING};
use crate::reference::slow_down::checked;
use crate::reference::wanted::Wanted;
use crate::regulate::damping::Damping;
use crate::regulate::drive::{Demand, Drive};
pub use crate::regulate::tip_settings::Settings;
use crate::regulate::weighing::Weighing;
#[cfg(feature = "std")]
use crate::{
    estimate::valve_learning::LearntValve,
    interface::{controller::Report, notice::Names},
    reference::reach,
};
use hydrocrane_num::{Real, Vec2, Vec3};

#[derive(Clone)]
pub struct Tip<const N: usize> {
    model: ControllerModel<N>,
    settings: Settings<N>,
    state: Option<State<N>>,
    /// What messages call joints and cylinders.
    #[cfg(feature = "std")]
    names: Names,
}

#[derive(Clone)]
struct State<const N: usize> {
    reference: Reference<N>,
    drives: [Drive; N],
    damping: Damping<N>,
    readings: [Readings; N],
    /// Where the pistons have stopped, from their references, m.
    settled: [f64; N],
    /// Mass at the tip as the pressures tell it, or without them the speeds of the pistons, kg.
    payload: f64,
    weighing: Weighing,
    /// Lowest natural frequency of the crane on its oil, rad/s.
    slowest: f64,
    /// Whether the forces of all cylinders are known at this sample.
    forces_known: bool,
    /// How far the tip may be from where the joint sensors see it, m.
    uncertainty: f64,
    /// Since the set-point stopped, s.
    still: f64,
    standstill: Standstill,
    /// Joints that closed valves cannot hold, and pistons that the load pushes back.
    unheld: [bool; N],
    yielding: [bool; N],
    /// The velocity asked for at the last sample, m/s.
    asked: [f64; 2],
    /// On the way to a goal.
    travel: Option<Travel>,
    sinking: Sinking,
    /// How long the reversed stick has pointed back to a tip that is too far behind, s.
    reversed: f64,
    /// Off its path.
    straying: Straying,
    /// What whoever holds the stick should know and has not been given yet.
    news: News,
}

/// Distance from the margin of a region within which a tip that sinks could come into it, m.
const SINKING: f64 = 0.2;
/// Share of the speed asked for that counts as nothing left of it.
const BLOCKED: f64 = 0.1;
/// Time after which a tip counts as held, s: longer than half a swing of a boom on its oil.
const HELD: f64 = 1.5;

/// Distance of the tip from its set-point at which this stands, in those at which it begins to wait.
const FARTHEST: f64 = 3.0;

/// Speed below which a tip on its way to a goal may count as standing, m/s.
const CREEPING: f64 = 2e-3;
/// Distance of the tip from a goal at which it is there, m, or what the joint sensors do not see of it, if that is more.
const THERE: f64 = 2e-3;
/// Distance of the tip from a goal up to which errors are still corrected, m, and for how long at most, s.
const CLOSE: f64 = 5e-4;
const CORRECTING: f64 = 4.0;
/// Distance of the tip from its path from on which a cause is looked for, as a share of the lag at which it waits: 10 mm of the usual 30.
const STRAYED: f64 = 1.0 / 3.0;
/// How far the tip may be behind a set-point that accelerates, as a share of the lag at which it waits.
const BEHIND: f64 = 0.25;

/// What a reading is off the truth by, in counts of its sensor, at most.
const HALF_A_COUNT: f64 = 0.5;
/// Time over which the payload is weighed, s: longer than a swing.
const WEIGHING: f64 = 1.0;

impl<const N: usize> Tip<N> {
    pub fn new(model: ControllerModel<N>, settings: Settings<N>) -> Self {
        Tip {
            model,
            settings,
            state: None,
            #[cfg(feature = "std")]
            names: Names::default(),
        }
    }

    /// With names for its messages.
    #[cfg(feature = "std")]
    pub fn named(self, names: Names) -> Self {
        Tip { names, ..self }
    }

    pub fn model(&self) -> &ControllerModel<N> {
        &self.model
    }

    /// What has happened since the last call.
    pub fn take_notices(&mut self) -> News {
        self.state.as_mut().map(|state| core::mem::take(&mut state.news)).unwrap_or_default()
    }

    /// Joint coordinates and pressures of a measurement, without those pressures that are only estimated.
    fn checked(&self, measured: &Measurement) -> Result<([f64; N], [[f64; 2]; N]), Fault> {
        match self.settings.drive.pressures {
            Pressures::Measured => checked::<N>(measured),
            Pressures::Estimated(_) => checked::<N>(&Measurement { p: &[[0.0; 2]; N], ..*measured }),
        }
    }
}

impl<const N: usize> State<N> {
    /// Begins at rest. A function of its own: its stack is no part of that of every sample.
    #[inline(never)]
    fn begin<'a>(
        place: &'a mut Option<Self>,
        n: &ControllerModel<N>,
        s: &Settings<N>,
        q: [f64; N],
        p: &[[f64; 2]; N],
    ) -> &'a mut Self {
        place.insert(State::at(n, s, q, p))
    }

    /// At rest, as first measured.
    fn at(n: &ControllerModel<N>, s: &Settings<N>, q: [f64; N], p: &[[f64; 2]; N]) -> Self {
        let (reference, at) = (Reference::at(n, s.period, q), n.at(&q));
        let load = n.cylinder_force(&q, &[0.0; N], n.payload);
        let supply_pressures = n.supply_pressures();
        let drives: [Drive; N] = hydrocrane_num::array::from_fn(|c| {
            let moment = Moment { stroke: reference.posture.stroke[c], p: p[c] };
            Drive::at(n.cylinders[c], n.fluid, supply_pressures, s.drive, s.period, moment, load[c])
        });
        let force: [f64; N] = hydrocrane_num::array::from_fn(|c| drives[c].force());
        let excess = hydrocrane_num::array::from_fn(|c| reference.posture.lever_arm[c] * (force[c] - load[c]));
        let damping =
            Damping::at(s.damping, &excess, &hydrocrane_num::array::from_fn(|c| &drives[c].commanded().answer));
        State {
            reference,
            drives,
            damping,
            readings: q.map(Readings::at),
            settled: [0.0; N],
            payload: n.payload_of(&at, &force).unwrap_or(n.payload),
            weighing: Weighing::new(n.mechanics.bodies.iter().map(|body| body.mass).sum(), s.period),
            slowest: f64::INFINITY,
            forces_known: true,
            uncertainty: 0.0,
            still: s.settling,
            standstill: Standstill::default(),
            unheld: [false; N],
            yielding: [false; N],
            asked: [0.0; 2],
            travel: None,
            sinking: Sinking::default(),
            reversed: 0.0,
            straying: Straying::default(),
            news: News::default(),
        }
    }

    /// What `f` tells of each drive, without copies of them.
    fn of_each<T>(&self, f: impl Fn(&Drive) -> T) -> [T; N] {
        hydrocrane_num::array::from_fn(|c| f(&self.drives[c]))
    }

    /// Starts the set-point anew where the reversed stick has long pointed back to a tip that does not come: the ground holds it.
    fn follow_the_stick_back(
        &mut self,
        model: &ControllerModel<N>,
        s: &Settings<N>,
        request: &Request<N>,
        lag: Vec3<f64>,
        now: &Means<N>,
        waiting: f64,
    ) {
        let reversed = waiting < BLOCKED && self.reference.towards(&s.shape, request).dot(lag) < 0.0;
        self.reversed = if reversed { self.reversed + s.period } else { 0.0 };
        if self.reversed >= HELD {
            self.reversed = 0.0;
            self.follow_anew(model, s, now);
        }
    }

    /// Starts the set-point anew from where the tip is.
    fn follow_anew(&mut self, model: &ControllerModel<N>, s: &Settings<N>, now: &Means<N>) {
        self.reference = Reference::at(model, s.period, now.seen);
        self.drives.iter_mut().for_each(Drive::follow_anew);
    }

    /// Finds out why the tip stands though it shall move. `waiting`: share of the request that is left.
    fn look_for_standstill(
        &mut self,
        model: &ControllerModel<N>,
        s: &Settings<N>,
        request: &Request<N>,
        now: &Means<N>,
        waiting: f64,
    ) {
        let speed = |request: &Request<N>| self.reference.towards(&s.shape, request).norm();
        let asked = speed(request);
        // A goal is given up only where the tip hardly gets any nearer.
        let least = if self.travel.is_some() { asked.min(CREEPING / BLOCKED) } else { asked };
        if !self.standstill.watch(least, self.reference.pace, s.period) {
            return;
        }
        let open = self.reference.slowed(&s.shape, *request);
        let barred = speed(&open) < BLOCKED * asked;
        let obstacles = self.reference.obstacles(model, &s.shape, &open, &now.piston, BLOCKED);
        let (overloaded, limited) = self.sorted(&obstacles);
        let cause = if !overloaded.is_empty() {
            if waiting < BLOCKED {
                // Where the tip cannot be lifted back to is no place to wait for: the other ways must stay open.
                self.follow_anew(model, s, now);
            }
            Cause::Load(overloaded)
        } else if self.reference.step_limit.share < BLOCKED {
            Cause::Holding(self.reference.step_limit.joint)
        } else if waiting < BLOCKED {
            Cause::Lag
        } else if barred {
            Cause::Region
        } else {
            Cause::Range(limited)
        };
        let aim = self.travel.take().map_or(Aim::Stick, |travel| Aim::Place(travel.goal.place));
        self.news.tell(Notice::Stands(cause, aim));
    }

    /// What the operator asks for: by the sticks, or the velocity that leads to the goal.
    fn request(&mut self, s: &Settings<N>, stick: Wanted<N>) -> Request<N> {
        let request = match stick {
            Wanted::Goal(goal) => return Request::Tip(self.towards_goal(s, goal)),
            Wanted::Velocity(velocity) => self.reference.asked(velocity, &s.lever_speeds),
            Wanted::Levers(levers) => Request::Joints(self.reference.lever_rates(&s.shape, &s.lever_speeds, &levers)),
        };
        if let Some(travel) = self.travel.take().filter(|travel| !travel.over) {
            self.news.tell(Notice::GivenUp { place: travel.goal.name(), cancelled: request.is_zero() });
        }
        request
    }

    /// The velocity that leads to a goal in the plane, m/s.
    fn towards_goal(&mut self, s: &Settings<N>, goal: Goal) -> [f64; 3] {
        // The share of the speed may change on the way.
        let same = |travel: &Travel| (travel.goal.given, travel.goal.place) == (goal.given, goal.place);
        let mut travel = self.travel.filter(same).unwrap_or_else(|| Travel::to(goal, self.asked));
        let bandwidth = s.shape.bandwidth(self.slowest, 0.0);
        let from = self.reference.stopping_place(bandwidth);
        let left = hydrocrane_num::array::from_fn(|r| goal.place[r] - from[r]);
        let speed = goal.share * goal.speed.unwrap_or(s.full_speed);
        let velocity =
            travel.velocity(&Stretch { left, speed, bandwidth, behind: BEHIND * s.lag_limit, period: s.period });
        // By what is left, not by what is asked for, which begins as small.
        let asked = bandwidth * Vec2::<f64>::c(left).norm();
        travel.over |= asked.max(self.reference.speed()) < STANDING;
        self.travel = Some(travel);
        let [x, z] = if travel.over { [0.0; 2] } else { velocity };
        [x, z, 0.0]
    }

    /// Whether the tip, whose set-point is at its goal, is still brought nearer: on soft oil it comes there later.
    /// What lies within the counts of the joint sensors is none of its errors.
    fn corrects(&mut self, s: &Settings<N>, measured: &Posture<N>, counts: &[f64; N]) -> bool {
        let Some(travel) = self.travel.as_mut().filter(|travel| travel.over) else { return false };
        travel.waited += s.period;
        let count: f64 =
            measured.jacobian.iter().flatten().zip(counts.iter().cycle()).map(|(j, q)| (j * q).abs()).sum();
        travel.waited < CORRECTING && (Vec2::<f64>::c(travel.goal.place) - Vec2::c(measured.tip)).norm() > CLOSE + count
    }

    /// Tells once of cylinders that the supply pressure cannot hold at rest.
    fn look_for_sinking(&mut self, s: &Settings<N>) {
        let sinking: Indices = (0..N).filter(|&c| self.drives[c].sinks()).collect();
        if !self.sinking.lasted(sinking.is_empty(), s.period, HELD) {
            return;
        }
        // Else the tip would go back some time later, when a swing lets the supply pressure win.
        sinking.iter().for_each(|c| self.drives[c].stay());
        if !core::mem::replace(&mut self.sinking.reported, true) {
            self.news.tell(Notice::Sinks(sinking));
        }
    }

    /// Tells that the tip was off its path, though it may come later or sooner, and which error of the model is likely.
    fn look_for_straying(&mut self, s: &Settings<N>, lag: Vec3<f64>, measured: &Posture<N>) {
        let (velocity, most) = (self.reference.velocity(), STRAYED * s.lag_limit + self.uncertainty);
        let velocity = Some(velocity).filter(|velocity| velocity.norm() > STANDING);
        let Some(off) = self.straying.watch(lag, velocity, most, self.still > 0.0, s.period) else { return };
        let share = |c: &usize| self.drives[*c].error().square() * measured.tip_per_stroke(*c).square();
        let counts = |c: &usize| share(c).is_finite() && share(c) > 0.0;
        if let Some(c) = (0..N).filter(counts).max_by(|a, b| share(a).total_cmp(&share(b))) {
            self.news.tell(Notice::Strays(off, c, self.drives[c].error().likely()));
        }
    }

    /// Tells how near the tip has come to its goal once everything stands.
    fn look_for_arrival(&mut self, tip: [f64; 2]) {
        let Some(Travel { goal, .. }) = self.travel.take_if(|travel| travel.over) else { return };
        let off = (Vec2::<f64>::c(goal.place) - Vec2::c(tip)).norm();
        let there = off < THERE.max(self.uncertainty);
        let aim = Aim::Place(goal.place);
        self.news.tell(if there { Notice::Arrived(goal.name()) } else { Notice::Stands(Cause::Lag, aim) });
    }

    /// Tells once of each joint that closed valves cannot hold, and of each piston that the load pushes back.
    fn look_for_runaways(&mut self, holding: &[Hold; N]) {
        for (i, hold) in holding.iter().enumerate() {
            let unheld = hold.share < 0.0;
            if unheld && !self.unheld[i] {
                self.news.tell(Notice::RunsAway(i));
            }
            self.unheld[i] = unheld;
            let yields = self.drives[i].yields();
            if yields && !self.yielding[i] {
                self.news.tell(Notice::Yields(i));
            }
            self.yielding[i] = yields;
        }
    }

    /// Cylinders that the supply pressure cannot move as they would have to, and joints that something else holds.
    fn sorted(&self, obstacles: &[f64; N]) -> (Indices, Indices) {
        let overloaded = |i: usize| !self.drives[i].able((obstacles[i] * self.reference.posture.lever_arm[i]).signum());
        let held_back = || (0..N).filter(|&i| obstacles[i] != 0.0);
        (held_back().filter(|&i| overloaded(i)).collect(), held_back().filter(|&i| !overloaded(i)).collect())
    }

    /// Joint coordinates with those foreseen in the place of missing ones.
    fn filled(&self, model: &ControllerModel<N>, q: &[f64; N], gaps: &[Signal]) -> [f64; N] {
        let mut filled = *q;
        for c in (0..N).filter(|c| gaps.contains(&Signal::Joint(*c))) {
            filled[c] = model.joint_near(c, filled[c], self.drives[c].foreseen());
        }
        filled
    }

    fn step(
        &mut self,
        model: &ControllerModel<N>,
        s: &Settings<N>,
        q: &[f64; N],
        p: &[[f64; 2]; N],
        gaps: &[Signal],
        stick: Wanted<N>,
    ) -> [f64; N] {
        let q = &self.filled(model, q, gaps);
        let (measured, at) = model.posture_at(q);
        let observing = observer::Gains::new(Drive::observer_bandwidth(&s.drive, self.slowest), s.period);
        let (mut counts, mut piston_counts) = ([0.0; N], [0.0; N]);
        for c in 0..N {
            let missing = gaps.contains(&Signal::Joint(c));
            let readings = &mut self.readings[c];
            let resolution = if missing { readings.known() } else { readings.resolution(q[c]) };
            counts[c] = resolution;
            piston_counts[c] = resolution * measured.lever_arm[c].abs();
            let moment = Moment { stroke: measured.stroke[c], p: p[c] };
            self.drives[c].measure(&moment, piston_counts[c], !missing, self.slowest, observing);
        }
        // Half a count of each joint, and the half that a piston at rest goes to the boundary of its count.
        self.uncertainty = (0..N).map(|i| measured.tip_per_joint(i) * counts[i]).sum::<f64>();
        let stiffness = self.of_each(Drive::stiffness);
        let force = self.of_each(Drive::carrying);
        let weighed_before = self.payload;
        self.forces_known = !gaps.iter().any(|gap| matches!(gap, Signal::Pressure(..)));
        if s.drive.pressures != Pressures::Measured {
            self.payload = self.weighing.payload(model, &mut self.drives, q, &piston_counts, self.payload);
        } else if let Some(payload) = model.payload_of(&at, &force).filter(|_| self.forces_known) {
            self.payload += (s.period / WEIGHING).min(1.0) * (payload - self.payload);
        }
        let mass = model.mass_matrix(&at.pose, self.payload);
        let modes = model.oil_modes(&mass, &measured.lever_arm, &stiffness);
        self.slowest = modes.slowest();
        let holding = model.holding(&at, &mass, self.payload, &stiffness);
        self.look_for_runaways(&holding);
        let request = self.request(s, stick);
        self.asked = if let Request::Tip([x, z, _]) = request { [x, z] } else { [0.0; 2] };
        let moving = self.reference.moving(&request) || self.corrects(s, &measured, &counts);
        self.still = if moving { 0.0 } else { self.still + s.period };
        let rest = self.still >= s.settling;
        let target: [f64; N];
        if rest {
            let held = model.strokes(&self.reference.q);
            let band = s.drive.rest_band;
            // Where the piston has stopped, as far as that is near enough.
            target = hydrocrane_num::array::from_fn(|c| held[c].0 + self.settled[c].clamp(-band, band));
            self.straying = Straying::default();
            self.reference.stand();
            self.look_for_sinking(s);
            self.look_for_arrival(measured.tip);
        } else {
            let held = self.reference.posture.stroke;
            self.sinking = Sinking::default();
            let under_way = self.of_each(|drive| drive.commanded().under_way());
            self.settled = hydrocrane_num::array::from_fn(|c| self.drives[c].position() + under_way[c] - held[c]);
            let observed = measured.joints_at(q, &self.of_each(Drive::position));
            // An observer that is slow for a slow swing loses a tip that moves, which the sensors see but for half a count.
            let unknown = counts.map(|count| HALF_A_COUNT * count);
            let seen: [f64; N] =
                hydrocrane_num::array::from_fn(|i| q[i] + (observed[i] - q[i]).clamp(-unknown[i], unknown[i]));
            // Both where the commands under way will have brought the joints.
            let strokes = hydrocrane_num::array::from_fn(|c| measured.stroke[c] + under_way[c]);
            let [observed, seen] = [observed, seen].map(|joints| measured.joints_at(&joints, &strokes));
            let tip = measured.tip_at(q, &seen);
            let lag = self.reference.lag(tip, seen[SLEW]);
            // 1 with the tip at its set-point, 0 with the tip too far behind.
            let waiting = (2.0 - 2.0 * lag.norm() / s.lag_limit).clamp(0.0, 1.0);
            let piston = self.of_each(Drive::range);
            let held = holding.map(|hold| hold.share);
            let now = Means {
                observed,
                seen,
                unknown,
                tip,
                piston,
                pressures: self.of_each(Drive::pressures),
                stiffness,
                held,
                payload: self.payload,
                slowest_mode: self.slowest,
                uncertainty: self.uncertainty,
                full_speed: self.of_each(Drive::full_speed_unloaded),
                near_region: s.shape.keep_out.distance(tip) < s.shape.keep_out.margin + SINKING,
                correctable: holding.map(|hold| s.drive.position * hold.bearable(s.drive.position)),
                following: ((FARTHEST - lag.norm() / s.lag_limit) / (FARTHEST - 1.0)).clamp(0.0, 1.0),
            };
            self.reference.advance(model, &s.shape, request.scaled(waiting), &now);
            self.look_for_standstill(model, s, &request, &now, waiting);
            self.follow_the_stick_back(model, s, &request, lag, &now, waiting);
            self.look_for_straying(s, lag, &measured);
            target = self.reference.posture.stroke;
        }
        let (rates, next) = (self.reference.rates, model.at(&self.reference.q));
        let inertia = modes.torque(&modes.of_motion(&self.reference.acceleration));
        let [load, with_a_kilogram] =
            [0.0, 1.0].map(|more| model.cylinder_force_at(&next, &rates, model.payload + more));
        let mut demands: [Demand; N] = hydrocrane_num::array::from_fn(|c| {
            let retreat = holding[c].retreat();
            let speed = self.reference.posture.lever_arm[c] * rates[c] + measured.lever_arm[c] * retreat;
            let rest = rest && retreat == 0.0;
            // Near a dead centre a torque is no cylinder force, and a pose can have no modes.
            let inertia =
                Some(inertia[c] / self.reference.posture.lever_arm[c]).filter(|f| f.is_finite()).unwrap_or(0.0);
            let per_kilogram = with_a_kilogram[c] - load[c];
            let weighed = per_kilogram * (self.payload - model.payload);
            let newly_weighed = per_kilogram * (self.payload - weighed_before);
            let (load, hold, tip_per_stroke) = (load[c], holding[c], measured.tip_per_stroke(c));
            let (stroke, damping) = (target[c], 0.0);
            Demand { stroke, speed, load, inertia, weighed, newly_weighed, damping, rest, tip_per_stroke, hold }
        });
        self.damp(s, &modes, &measured, &mut demands);
        hydrocrane_num::array::from_fn(|c| self.drives[c].command(&demands[c]))
    }

    /// Adds the speeds that damp the modes on the oil.
    fn damp(&mut self, s: &Settings<N>, modes: &OilModes<N>, measured: &Posture<N>, demands: &mut [Demand; N]) {
        let excess: [f64; N] = hydrocrane_num::array::from_fn(|c| {
            measured.lever_arm[c] * (self.drives[c].force() - self.drives[c].commanded().needed[0])
        });
        let drives = &self.drives;
        let answers = hydrocrane_num::array::from_fn(|c| &drives[c].commanded().answer);
        if s.drive.pressures != Pressures::Measured && self.still == 0.0 {
            // In motion a wrong flow looks like a swing.
            self.damping.begin_anew(&excess, &answers);
            return;
        }
        let known = self.forces_known.then_some(&excess);
        let most = hydrocrane_num::array::from_fn(|c| drives[c].full_speed_unloaded() / measured.lever_arm[c].abs());
        let Some(rates) = self.damping.step(modes, measured, &answers, known, (self.reference.pace, self.still), &most)
        else {
            // Near a dead centre a pose can have no modes.
            self.damping.begin_anew(&excess, &answers);
            return;
        };
        if self.damping.halved {
            self.news.tell(Notice::Oscillates);
        }
        for (c, demand) in demands.iter_mut().enumerate() {
            demand.damping = measured.lever_arm[c] * rates[c];
        }
    }
}

impl<const N: usize> Controller for Tip<N> {
    copied_by_clone!();

    fn period(&self) -> f64 {
        self.settings.period
    }

    fn reset(&mut self, first: &Measurement) {
        self.state = None;
        if let Ok((q, p)) = self.checked(first) {
            State::begin(&mut self.state, &self.model, &self.settings, q, &p);
        }
    }

    fn step(&mut self, measured: &Measurement, stick: Stick, spool: &mut [f64]) -> Result<(), Fault> {
        self.step_without(measured, &[], stick, spool)
    }

    fn step_without(
        &mut self,
        measured: &Measurement,
        gaps: &[Signal],
        stick: Stick,
        spool: &mut [f64],
    ) -> Result<(), Fault> {
        let (q, p) = self.checked(measured)?;
        let stick = Wanted::by(stick, self.settings.full_speed, self.model.slews())?;
        let state = match &mut self.state {
            Some(state) => state,
            none => State::begin(none, &self.model, &self.settings, q, &p),
        };
        let command = state.step(&self.model, &self.settings, &q, &p, gaps, stick);
        if command.iter().any(|u| !u.is_finite()) {
            self.state = None;
            return Err(Fault::NoCommand);
        }
        spool.iter_mut().zip(command).for_each(|(out, u)| *out = u);
        Ok(())
    }

    fn reads_pressures(&self) -> bool {
        self.settings.drive.pressures == Pressures::Measured
    }

    fn stands(&self) -> bool {
        self.state.as_ref().is_none_or(|state| state.still >= self.settings.settling)
    }

    #[cfg(feature = "std")]
    fn refuses(&self, place: [f64; 2]) -> Option<String> {
        if self.model.slews() {
            return Some("goals lie in a plane, and this crane slews; move it with the sticks".to_string());
        }
        let keep_out = &self.settings.shape.keep_out;
        let margin = keep_out.margin + self.state.as_ref().map_or(0.0, |state| state.uncertainty);
        reach::refusal(&self.model, keep_out, margin, place)
    }

    fn heading(&self) -> bool {
        self.state.as_ref().is_some_and(|state| state.travel.is_some())
    }

    fn set_point(&self) -> Option<[f64; 2]> {
        self.state.as_ref().map(|s| s.reference.set_point)
    }

    fn set_point_in_space(&self) -> Option<[f64; 3]> {
        self.state.as_ref().map(|s| self.model.in_space(s.reference.set_point, &s.reference.q))
    }

    #[cfg(feature = "std")]
    fn learnt(&self) -> Vec<LearntValve> {
        let drives = self.state.as_ref().filter(|_| self.settings.drive.learning > 0.0).map(|state| &state.drives);
        drives.map_or(Vec::new(), |drives| drives.iter().map(|drive| drive.learnt()).collect())
    }

    #[cfg(feature = "std")]
    fn notices(&mut self) -> Vec<Report> {
        let news = self.take_notices();
        let report = |notice: &Notice| Report { text: notice.text(&self.names), alarm: notice.alarm() };
        news.iter().map(report).collect()
    }
}
