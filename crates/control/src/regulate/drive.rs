//! One cylinder's part of tip control: from the piston's reference to a spool command.
//!                                                               theory: docs/theory/control/regulate.md
//!
//! v_c = v_ref + k_p (x_ref - x^ - x_u) - d^ + v_w + v_d
//!
//! and the command that brings the spool to where it gives the speed v_c at the measured pressures. The spool comes there late
//! ([`crate::model::valve_answer`]): x^ is where the piston is, x_u the travel that is left to it by the commands that are under way. v_w compresses the oil for the force that comes
//! ([`crate::valve::compression`]); v_d damps the modes of the crane on its oil ([`crate::regulate::damping`]).
//!
//! At rest the piston is held where it has stopped: v_c = k_h (x_ref - x^) as far as that is beyond a band, and what holds it
//! against creep ([`crate::estimate::rest`]). Zero speed needs an opening that makes up for leakage. The correction begins at the speed that was
//! asked for last and follows behind a low-pass, so that no sample kicks the oil.
//!
//! Near a dead centre, where a joint swings slowly, the corrections k_p (x_ref - x^) - d^ and the learning of d^ shrink with the
//! square of its frequency.
//! The valve stays closed towards a sense in which the supply pressure cannot move the load: opening it would let the load push the
//! piston back. What compresses the oil or damps it passes as long as oil flows that way.

use crate::estimate::chamber_estimate::{ChamberEstimate, Evidence, Pressures, Sent, Surroundings};
use crate::estimate::model_error::ModelError;
use crate::estimate::observer::{self, Observer};
use crate::estimate::rest::{Rest, Resting};
use crate::estimate::valve_learning::{Learning, LearntValve, Sample, ValveFit, NOMINAL};
use crate::model::controller_model::CylinderModel;
use crate::model::feed_forward::{Ahead, Capacity, Moment, Steady, SupplyPressures};
use crate::reference::holding::Hold;
use crate::regulate::drive_state::{DriveModel, Plan, Seen, Shares, RANGE_RATE};
pub use crate::regulate::tip_settings::DriveGains;
use crate::valve::commanded::Commanded;
use crate::valve::compression::{Bounds, Compression, MOST_COMPRESSION};
use crate::valve::overlap::Overlap;
use hydrocrane_physics::hydraulics::fluid::Fluid;

/// What the piston shall do over the coming period.
#[derive(Debug, Clone, Copy)]
pub struct Demand {
    /// m and m/s
    pub stroke: f64,
    pub speed: f64,
    /// Cylinder force without friction at constant joint rates, and what accelerates the crane, N.
    pub load: f64,
    pub inertia: f64,
    /// What the weighed mass at the tip adds to that load beyond the stated one, N, and by how much the last weighing changed it, N.
    pub weighed: f64,
    pub newly_weighed: f64,
    /// Speed that damps the modes on the oil, m/s.
    pub damping: f64,
    /// Stand still: correct gently.
    pub rest: bool,
    /// Travel of the tip per travel of the piston.
    pub tip_per_stroke: f64,
    /// How the oil holds the joint that the cylinder moves.
    pub hold: Hold,
}

#[derive(Debug, Clone, Copy)]
pub struct Drive {
    model: DriveModel,
    gains: DriveGains,
    period: f64,
    shares: Shares,
    /// Where no pressure is measured.
    estimate: Option<ChamberEstimate>,
    /// dv/dF behind the two lags of the observer, m/(s N).
    per_force: [f64; 2],
    observer: Observer,
    observing: observer::Gains,
    learning: Learning,
    /// What the valve is taken to do beyond its model at this sample.
    fit: ValveFit,
    rest: Option<Rest>,
    /// Speed without what holds a piston against creep or compresses the oil, m/s.
    motion: f64,
    /// What the last command asked for, if anything can be learnt of it.
    sample: Option<Sample>,
    overlap: Overlap,
    seen: Seen,
    /// F - F_ref behind a low-pass, N.
    excess: f64,
    compression: Compression,
    plan: Plan,
    commanded: Commanded,
    /// Share of its corrections that the joint bears.
    bearable: f64,
}

/// Bandwidth of the observer in lowest natural frequencies of the crane on its oil: what swings is no missing speed.
const OBSERVER_PER_MODE: f64 = 0.2;
/// Time for which a load goes on growing while the speed to plan with falls, s.
const GROWN: f64 = 2.0 / RANGE_RATE;
/// How far beyond the forces that the supply pressure gives the oil is compressed at most, as a share of their span: a valve that still asks for more
/// stays open until the chamber has all that there is.
const BEYOND_SUPPLY: f64 = 0.04;
/// Share of the position gain that holds a piston at rest.
const HOLDING: f64 = 0.25;
/// Corner of the low-pass on that speed in lowest natural frequencies of the crane on its oil.
const HOLDING_PER_MODE: f64 = 0.5;
/// Multiple of the damping of a valve that can damp in one direction only, about half of the time.
const ONE_WAY: f64 = 1.5;
/// Momentary speed at full stroke from which on a valve may fill a chamber whose load the supply pressure cannot move, as a share of the
/// steady one without load.
const FILLING: f64 = 0.05;
/// Least speed at full stroke, as a share of the steady one: a regenerative cylinder that is still being filled would not
/// move at any opening.
const LEAST_SHARE: f64 = 0.35;

impl Drive {
    /// At rest, with nothing yet known of the load but the measured force.
    pub fn at(
        cylinder: CylinderModel,
        fluid: Fluid<f64>,
        supply_pressures: SupplyPressures,
        gains: DriveGains,
        period: f64,
        mut moment: Moment,
        load: f64,
    ) -> Self {
        let estimate = match gains.pressures {
            Pressures::Measured => None,
            Pressures::Estimated(back) => Some(ChamberEstimate::at(&cylinder, moment.stroke, load, back)),
        };
        if let Some(estimate) = &estimate {
            moment.p = estimate.p;
        }
        let force = cylinder.chambers.force(moment.p[0], moment.p[1]);
        let steady = Steady::new(&cylinder, &supply_pressures);
        let commanded = Commanded::at(&cylinder, period, load);
        let capacity = cylinder.capacity(&fluid, &supply_pressures, &moment);
        let mut drive = Drive {
            model: DriveModel::new(cylinder, fluid, supply_pressures, steady),
            gains,
            period,
            shares: Shares::new(&gains, period),
            estimate,
            per_force: [0.0; 2],
            observer: Observer::at(moment.stroke),
            observing: observer::Gains::new(gains.observer, period),
            learning: Learning::new(gains.learning, period, commanded.answer.valve.lag()),
            fit: NOMINAL,
            rest: None,
            motion: 0.0,
            sample: None,
            overlap: Overlap::of(&cylinder, period),
            seen: Seen::at(moment, capacity, force),
            excess: force - load,
            compression: Compression::default(),
            plan: Plan { load, ..Plan::default() },
            commanded,
            bearable: 1.0,
        };
        drive.plan.momentary = [-1.0, 1.0].map(|sense| drive.full_speed(sense, drive.steady_speed(sense)));
        drive.plan.range = drive.range_now();
        drive
    }

    /// Bandwidth of the observers where the crane's lowest natural frequency on its oil is `slowest`, rad/s.
    pub fn observer_bandwidth(gains: &DriveGains, slowest: f64) -> f64 {
        gains.observer.min(OBSERVER_PER_MODE * slowest)
    }

    /// Takes in a sample whose position has the resolution `count`, m; `seen`: it was measured; `slowest`: lowest natural frequency
    /// of the crane on its oil at the last sample, rad/s; `observing`: the gains for it, those of all drives.
    pub fn measure(&mut self, now: &Moment, count: f64, seen: bool, slowest: f64, observing: observer::Gains) {
        self.observing = observing;
        let before = self.seen.force;
        let p = self.take_pressures(now, count);
        for (slow, p) in self.seen.moment.p.iter_mut().zip(p) {
            *slow += self.shares.pressure * (p - *slow);
        }
        self.seen.moment.stroke = now.stroke;
        (self.seen.count, self.seen.slowest) = (count, slowest);
        self.seen.capacity =
            self.model.cylinder.capacity(&self.model.fluid, &self.model.supply_pressures, &self.when_it_acts());
        self.seen.leaks += observing.lag_share * (self.seen.capacity.closed - self.seen.leaks);
        // Pressures that are estimated follow from the model.
        self.seen.given +=
            if self.estimate.is_none() { (self.seen.force - before) / self.seen.capacity.stiffness } else { 0.0 };
        let before = self.observer.position;
        self.observer.update(now.stroke, self.commanded.expected, &self.observing, self.bearable, count);
        self.seen.speed = (self.observer.position - before) / self.period;
        self.seen.seal = self.model.cylinder.dry_friction(self.seen.speed, self.seen.seal, self.period);
        if let Some(sample) = &mut self.sample {
            let [low, high] = self.model.cylinder.free;
            sample.usable &= seen && (low..=high).contains(&now.stroke);
            let (missing, lag_share) = (self.observer.disturbance, self.observing.lag_share);
            let explained = self.learning.learn(sample, missing, self.seen.given, lag_share);
            self.observer.explain(explained);
        }
        let momentary = [-1.0, 1.0].map(|sense| self.full_speed(sense, self.steady_speed(sense)));
        for (slow, now) in self.plan.momentary.iter_mut().zip(momentary) {
            *slow += self.shares.momentary * (now - *slow);
        }
        // What comes back after a shortage comes back slowly: other joints have taken over.
        let (now, before) = (self.range_now(), self.plan.range);
        self.plan.range = hydrocrane_num::array::from_fn(|s| {
            if now[s].abs() > before[s].abs() {
                before[s] + self.shares.back * (now[s] - before[s])
            } else {
                now[s]
            }
        });
    }

    /// Pressures at a sample, measured or estimated; keeps the force.
    fn take_pressures(&mut self, now: &Moment, count: f64) -> [f64; 2] {
        let Some(estimate) = &mut self.estimate else {
            self.seen.force = self.model.cylinder.chambers.force(now.p[0], now.p[1]);
            // A transmitter reads zero for any vacuum.
            return now.p.map(|p| if p == 0.0 { self.model.fluid.vacuum } else { p });
        };
        let DriveModel { fluid, supply_pressures, .. } = self.model;
        let around = Surroundings { fluid, supply_pressures, period: self.period };
        estimate.advance(
            &self.model.cylinder,
            &around,
            &self.observing,
            (now.stroke, count),
            self.seen.capacity.stiffness,
        );
        self.seen.force = estimate.force;
        estimate.p
    }

    /// The cylinder when a command that is sent now will act: until then the force becomes what the reference needs, and the level of the
    /// pressures follows the spool.
    fn when_it_acts(&self) -> Moment {
        let time = self.commanded.answer.valve.lag() + 1.0 / self.gains.pressure;
        let ahead = Ahead { time, force: self.commanded.force_to_come(), spool: self.commanded.spool };
        self.model.cylinder.ahead(&self.model.fluid, &self.model.supply_pressures, &self.seen.moment, &ahead)
    }

    /// What the last sample, whose position has the resolution `count` (m), tells of the load; asked for once a sample.
    pub fn evidence(&mut self, count: f64) -> Evidence {
        let (expected, full, usable) = self.sample.map_or((0.0, 1.0, false), |s| (s.expected, s.full, s.usable));
        let now = if usable { self.model.steady.per_force(expected, self.true_load()) } else { 0.0 };
        let share = self.observing.lag_share;
        self.per_force[0] += share * (now - self.per_force[0]);
        self.per_force[1] += share * (self.per_force[0] - self.per_force[1]);
        Evidence {
            missing: self.observer.disturbance,
            share: if usable { self.bearable } else { 0.0 },
            uncertainty: count * share / self.period,
            per_force: self.per_force[1],
            full,
            span: self.model.steady.span(),
        }
    }

    /// Takes the load to be `more` (N) than the planned one, which explains `speed` (m/s) of what was missing.
    pub fn carry(&mut self, more: f64, speed: f64) {
        self.excess = more;
        self.observer.explain(speed);
        if let Some(estimate) = &mut self.estimate {
            estimate.explain(speed);
        }
    }

    /// Whether the valve stays closed because the load, which nothing measures, pushes the piston back at rest.
    pub fn yields(&self) -> bool {
        self.estimate.is_some_and(|estimate| estimate.yields)
    }

    /// Loads that the supply pressure can move both ways, lowest and highest, N.
    pub fn movable(&self) -> [f64; 2] {
        let [low, high] = self.model.steady.movable();
        [low - self.model.starting_friction[0], high - self.model.starting_friction[1]]
    }

    /// Cylinder force as measured or estimated, N.
    pub fn force(&self) -> f64 {
        self.seen.force
    }

    /// Cylinder force without the friction of the piston as observed, N.
    pub fn carrying(&self) -> f64 {
        self.seen.force - self.seen.seal - self.model.cylinder.friction.viscous(self.seen.speed)
    }

    /// What the valve was asked for and has given.
    pub fn commanded(&self) -> &Commanded {
        &self.commanded
    }

    /// Cylinder force with the friction at the speed of `d`, N.
    fn planned(&self, d: &Demand) -> f64 {
        d.load + d.inertia + self.dry_friction(d) + self.model.cylinder.friction.viscous(d.speed)
    }

    /// Planned friction without its viscous part, N.
    fn dry_friction(&self, d: &Demand) -> f64 {
        self.model.cylinder.dry_friction(d.speed, self.plan.dry_friction, self.period)
    }

    /// Chamber pressures behind a low-pass, measured or estimated, Pa.
    pub fn pressures(&self) -> [f64; 2] {
        self.seen.moment.p
    }

    /// Observed piston position, m.
    pub fn position(&self) -> f64 {
        self.observer.position
    }

    /// Piston position that the next sample should find, m.
    pub fn foreseen(&self) -> f64 {
        self.observer.foreseen(self.commanded.expected, &self.observing)
    }

    /// Mean of the steady speeds at full stroke without a load, m/s.
    pub fn full_speed_unloaded(&self) -> f64 {
        self.model.steady.speed_unloaded()
    }

    /// Whether the supply pressure can move the load towards `sense` (+1 or -1).
    pub fn able(&self, sense: f64) -> bool {
        self.steady_speed(sense) > 0.0
    }

    /// Lowest and highest piston speed that the reference may plan with, m/s; zero where the supply pressure cannot move the load.
    pub fn range(&self) -> [f64; 2] {
        self.plan.range
    }

    fn range_now(&self) -> [f64; 2] {
        [-1.0, 1.0].map(|s| {
            // More than the steady speed would not last, and what the valve was seen to lack is not there either.
            let momentary = s * self.plan.momentary[usize::from(s > 0.0)];
            // A load that grows will have grown until a piston stops that can go no further.
            let more = s * (self.model.spare + GROWN * (s * self.plan.growth).max(0.0));
            let lasting = momentary.min(s * self.speed_under(more, s)) * self.widest(s);
            let possible = self.gains.reserve * lasting + (s * self.observer.disturbance).min(0.0);
            // A range that vanished from one sample to the next would stop a moving piston at once.
            s * possible.max((1.0 - self.shares.range) * s * self.plan.asked).max(0.0)
        })
    }

    /// Magnitude of the steady speed at full stroke under the load; zero where the supply pressure cannot move it.
    fn steady_speed(&self, sense: f64) -> f64 {
        sense * self.speed_under(0.0, sense)
    }

    /// Steady speed at full stroke under the load and a force `more`, N.
    fn speed_under(&self, more: f64, sense: f64) -> f64 {
        self.model.steady.speed(self.true_load() + self.model.starting_friction[usize::from(sense > 0.0)] + more, sense)
    }

    /// The planned load, put right by what the pressures say of it, N.
    fn true_load(&self) -> f64 {
        self.plan.load + self.excess
    }

    /// Stiffness of the oil between closed edges, N/m.
    pub fn stiffness(&self) -> f64 {
        self.seen.capacity.stiffness
    }

    /// Signed speed at full stroke at the present pressures; `steady` is the magnitude of the steady one.
    fn full_speed(&self, sense: f64, steady: f64) -> f64 {
        let now = sense * self.seen.capacity.full[usize::from(sense > 0.0)];
        sense * now.max(LEAST_SHARE * steady)
    }

    /// Spool command, m.
    pub fn command(&mut self, d: &Demand) -> f64 {
        let g = self.gains;
        let planned = self.planned(d);
        // A reference that jumps, at a limit or a singular pose, is not worth a slammed spool.
        let most = MOST_COMPRESSION * self.model.steady.speed_unloaded();
        let ([low, high], beyond) = (self.model.steady.forces(), BEYOND_SUPPLY * self.model.steady.span());
        let forces = [low - beyond, high + beyond];
        let within = Bounds { forces, speed: most, force_per_speed: self.period * self.seen.capacity.stiffness };
        let compression = self.compression.speed(planned + d.weighed, d.newly_weighed, &within);
        // At a dead centre a load can be no number.
        let growth = Some((d.load - self.plan.load) / self.period).filter(|growth| growth.is_finite()).unwrap_or(0.0);
        self.plan.growth += self.shares.growth * (growth - self.plan.growth);
        (self.plan.load, self.plan.dry_friction) = (d.load, self.dry_friction(d));
        self.plan.asked = d.speed;
        self.bearable = d.hold.bearable(g.position);
        if self.estimate.is_none() {
            let error = self.carrying() - self.commanded.needed[1] - self.excess;
            // A force that the supply pressure limits says nothing of the load.
            self.excess += self.shares.load * if error * (d.load + self.excess) < 0.0 { 0.1 * error } else { error };
        }
        let one_way = !(self.able(1.0) && self.able(-1.0));
        let spring = compression + d.damping * if one_way { ONE_WAY } else { 1.0 };

        let was_at_rest = self.rest.is_some();
        // At rest a wrong guess would kick the oil or have the piston creep; in motion it is found soon.
        let Capacity { closed, full, .. } = self.seen.capacity;
        let mean = 0.5 * (full[1] - full[0]);
        let fit = if d.rest { self.learning.certain(self.seen.leaks, mean) } else { self.learning.fit };
        if let Some(sample) = self.sample.filter(|_| d.rest != was_at_rest) {
            let explained = fit.speed(&sample) - self.fit.speed(&sample);
            self.learning.explain(explained);
            self.observer.explain(explained);
        }
        self.fit = fit;
        // What is missing goes on missing until the command arrives.
        let ahead =
            self.commanded.under_way() + self.bearable * self.commanded.answer.valve.lag() * self.observer.disturbance;
        let behind = d.stroke - self.observer.position - ahead;
        let motion = if d.rest {
            self.speed_at_rest(d)
        } else {
            self.rest = None;
            d.speed + self.bearable * (g.position * behind - self.observer.disturbance)
        };
        // Where the supply pressure cannot move the load, wanting to go there would only keep the damping from the other side.
        let motion = if self.able(motion.signum()) { motion } else { 0.0 };
        if !d.rest {
            self.motion = motion;
        }
        if let Some(estimate) = &mut self.estimate {
            estimate.hold(d.rest, behind.abs(), g.rest_band);
        }
        let gained = [-1.0, 1.0].map(|sense| self.gained(sense));
        let opening = if self.yields() { 0.0 } else { self.opening_for(motion + spring, &gained) };
        let needed = self.opening_for(motion + compression, &gained);
        let shares = [0, 1].map(|side| self.seen.capacity.shares(side, gained[side]));
        let (c, fit, edges) = (&self.model.cylinder, self.fit, &self.model.edges);
        let spool_of = |opening| edges.spool(c, &shares, fit.asked(opening));
        let spool = self.overlap.spool(opening, needed, d.rest, edges.begin(&shares), spool_of);
        let command = c.chain.command(spool).clamp(-c.stroke, c.stroke);
        let spool = c.chain.spool(command);
        let asked = edges.opening(c, &shares, spool);
        let opening = self.fit.opening(asked);
        let reach = full[usize::from(opening > 0.0)] - closed;
        // While chambers fill or a load cannot be moved, the steady law tells nothing of the valve.
        let usable = !d.rest
            && (self.bearable == 1.0 || self.estimate.is_some())
            && self.able(opening.signum())
            && opening * reach > 0.0;
        let compressed = if self.estimate.is_none() { spring } else { 0.0 };
        let sample = Sample { asked, closed, reach, full: mean, expected: 0.0, compression: compressed, usable };
        let expected = self.fit.speed(&sample);
        self.commanded.send(spool, expected - spring, [planned, d.load + d.inertia]);
        if let Some(estimate) = &mut self.estimate {
            estimate.sent = Sent { spool, speed: expected - compression, planned: planned + self.excess };
        }
        self.sample = Some(Sample { expected, ..sample });
        command
    }

    /// Speed that holds the piston, m/s.
    fn speed_at_rest(&mut self, d: &Demand) -> f64 {
        let DriveGains { position, rest_band, .. } = self.gains;
        let now = Resting {
            stroke: d.stroke,
            observed: self.observer.position + self.commanded.under_way(),
            measured: self.seen.moment.stroke,
            count: self.seen.count,
            tip_per_stroke: d.tip_per_stroke,
            slowest: self.seen.slowest,
        };
        // An observer that had to be slowed down for a slow swing has not forgotten the motion yet.
        let settled = OBSERVER_PER_MODE * self.seen.slowest >= self.gains.observer;
        let creep = if settled { self.observer.disturbance } else { 0.0 };
        let rest = self.rest.get_or_insert_with(|| Rest::at(now, creep));
        let against_creep = rest.step(now, self.period);
        let (behind, band) = (rest.place() - now.observed, rest_band.max(self.seen.count));
        let beyond = behind - behind.clamp(-band, band);
        if beyond != 0.0 && rest.coming() && !self.able(beyond.signum()) {
            // Else it would go some time later, when a swing lets the supply pressure win.
            self.stay();
        }
        // A place that changes must not kick the oil, nor must the end of the correction of every error.
        let share = (HOLDING_PER_MODE * self.seen.slowest * self.period).min(1.0);
        self.motion += share * (HOLDING * position * beyond - self.motion);
        self.motion + against_creep
    }

    /// Whether the piston has sunk at rest and the supply pressure cannot bring it back.
    pub fn sinks(&self) -> bool {
        self.rest.and_then(|rest| rest.sunk()).is_some_and(|sense| !self.able(sense))
    }

    /// The reference begins anew from where the crane is: the oil carries the force that it needs already.
    pub fn follow_anew(&mut self) {
        self.compression = Compression::default();
    }

    /// Holds the piston where it is now, if it rests.
    pub fn stay(&mut self) {
        if let Some(rest) = &mut self.rest {
            rest.stay();
        }
    }

    /// What motion tells of the errors of the model.
    pub fn error(&self) -> &ModelError {
        &self.learning.error
    }

    /// What was learnt of the valve.
    pub fn learnt(&self) -> LearntValve {
        let (fit, c) = (&self.learning.fit, &self.model.cylinder);
        LearntValve { chain: fit.chain(&c.chain, self.model.edges.closed_zone(), c.stroke), leakage: fit.leakage }
    }

    /// Largest opening towards `sense` (+1 or -1), as a share of the whole.
    fn widest(&self, sense: f64) -> f64 {
        let widest = sense * self.fit.opening(sense * self.model.reach[usize::from(sense > 0.0)]);
        widest.clamp(0.0, 1.0)
    }

    /// Opening that gives `speed` (m/s), as a signed share of the whole; `gained` as below, retracting and extending.
    fn opening_for(&self, speed: f64, gained: &[Option<f64>; 2]) -> f64 {
        let closed = self.fit.leakage * self.seen.leaks;
        let sense = if speed < closed { -1.0 } else { 1.0 };
        match gained[usize::from(sense > 0.0)] {
            Some(gained) if speed != closed => sense * ((speed - closed) / gained).min(self.widest(sense)),
            _ => 0.0,
        }
    }

    /// Speed at full stroke towards `sense` over that with closed edges, m/s, if the valve may open that way.
    fn gained(&self, sense: f64) -> Option<f64> {
        let steady = self.steady_speed(sense);
        // Where the load would push the piston back in the end, the valve is opened for no motion, but it may fill a chamber for a moment.
        let now = sense * self.seen.capacity.full[usize::from(sense > 0.0)];
        let fills = self.estimate.is_none() && now > FILLING * self.model.steady.speed_unloaded();
        let full = if steady > 0.0 || !fills { self.full_speed(sense, steady) } else { sense * now };
        let gained = full - self.seen.capacity.closed;
        ((steady > 0.0 || fills) && sense * gained > 0.0).then_some(gained)
    }
}
