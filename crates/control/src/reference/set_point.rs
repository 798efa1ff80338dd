//! The set-point of the tip and the joint motion that belongs to it.    theory: docs/theory/control/reference.md
//!
//! The stick's velocity passes a double lag and moves the set-point; [`redundancy`](crate::reference::redundancy) turns it into
//! joint rates; their integral is the reference. What integration loses on the path is fed back as a correction of
//! the next step, so no inverse kinematics is needed and any chain will do. Joints beyond the first two revolute ones
//! follow their measured positions: where the telescope lags, boom and jib make up for it.
//!
//! A crane that slews has its tip in a plane of its own (docs/theory/control/tip.md): the stick's third axis is the rate of the slewing
//! joint. All three slow down together, so that the tip stays on its path.
//!
//! Under levers that hold the height (docs/theory/control/reference.md) the lags are those of the joints' rates.

use crate::model::controller_model::{ControllerModel, Posture};
use crate::model::slewing::SLEW;
use crate::reference::holding::StepLimit;
use crate::reference::keep_out::{Caution, KeepOut};
use crate::reference::redundancy::{level, level_within, resolve, resolve_steadily, Motion, Preference, Task};
use crate::reference::request::{Lags, Request};
use crate::reference::slow_down::joint_rates;
use crate::valve::compression::MOST_COMPRESSION;
use hydrocrane_num::{portable, Real, Vec2, Vec3};

/// How the reference moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape<const N: usize> {
    /// Each of the two lags of the stick, rad/s.
    pub stick_bandwidth: f64,
    /// Rate at which a lost path is found again, 1/s.
    pub path_rate: f64,
    /// Rate of the slow-down before limits, 1/s.
    pub limit_rate: f64,
    /// Pull towards mid-range, rate per tip speed and distance from the middle, 1/m.
    pub centring: [f64; N],
    /// Relative reluctance to use a joint.
    pub effort: [f64; N],
    /// Regions that the set-point stays out of.
    pub keep_out: KeepOut,
    /// Joint that holds the height of the tip under levers.
    pub height_joint: usize,
}

hydrocrane_num::stored!([const N: usize] Shape<N> {
    stick_bandwidth: f64,
    path_rate: f64,
    limit_rate: f64,
    centring: [f64; N],
    effort: [f64; N],
    keep_out: KeepOut,
    height_joint: usize,
});

impl<const N: usize> Shape<N> {
    /// Bandwidth of each lag where the crane's lowest natural frequency on its oil is `slowest_mode` (rad/s) and a motion uses
    /// this share of a piston's full speed, rad/s.
    pub fn bandwidth(&self, slowest_mode: f64, used: f64) -> f64 {
        let slower = if used > COMPRESSED_IN_FULL { portable::sqrt(COMPRESSED_IN_FULL / used) } else { 1.0 };
        let fast = ((slowest_mode / self.stick_bandwidth - 1.0) / (FAST_MODE - 1.0)).clamp(0.0, 1.0);
        self.stick_bandwidth.min((slower + fast * (1.0 - slower)) * slowest_mode)
    }

    /// Whether the crane is so slow on its oil that its lags can be slower than the stick's.
    fn slows(&self, now: &Means<N>) -> bool {
        now.slowest_mode < FAST_MODE * self.stick_bandwidth
    }

    /// Rate of the slow-down before limits, 1/s: a faster one would ask for more than the lags at this `bandwidth` (rad/s) do.
    fn slow_down(&self, bandwidth: f64) -> f64 {
        self.limit_rate.min(bandwidth / core::f64::consts::E)
    }
}

/// What a sample says of the crane.
#[derive(Debug, Clone, Copy)]
pub struct Means<const N: usize> {
    /// Joint coordinates, by the observers of the pistons and as the sensors see them, rad or m.
    pub observed: [f64; N],
    pub seen: [f64; N],
    /// How far off the coordinates can be within the counts of the sensors, rad or m.
    pub unknown: [f64; N],
    /// Place of the tip by those, m.
    pub tip: [f64; 2],
    /// Lowest and highest piston speeds to plan with, m/s.
    pub piston: [[f64; 2]; N],
    /// Chamber pressures, Pa.
    pub pressures: [[f64; 2]; N],
    /// Of the oil between closed edges, N/m.
    pub stiffness: [f64; N],
    /// How closed valves hold each joint where it is, h of `holding`.
    pub held: [f64; N],
    /// Mass at the tip, kg.
    pub payload: f64,
    /// Lowest natural frequency of the crane on its oil, rad/s.
    pub slowest_mode: f64,
    /// How far the tip may be from where the joint sensors see it, m.
    pub uncertainty: f64,
    /// Full speeds of the pistons without a load, m/s.
    pub full_speed: [f64; N],
    /// Share of its speed that a tip far away leaves to the set-point.
    pub following: f64,
    /// Whether a tip that sinks could come into a region.
    pub near_region: bool,
    /// Rates at which joints may correct errors of their measured positions, 1/s.
    pub correctable: [f64; N],
}

/// Of a path.
struct Correction {
    /// m/s
    velocity: [f64; 2],
    /// Share of what the leading joints leave of it that all may correct.
    all: f64,
}

impl Correction {
    const NONE: Correction = Correction { velocity: [0.0; 2], all: 0.0 };
}

/// The reference at one sample.
#[derive(Debug, Clone, Copy)]
pub struct Reference<const N: usize> {
    /// m
    pub set_point: [f64; 2],
    pub q: [f64; N],
    pub rates: [f64; N],
    /// rad/s^2 or m/s^2
    pub acceleration: [f64; N],
    /// Piston positions (m) and dx/dq at `q`.
    pub posture: Posture<N>,
    /// Of the commanded speed, how much the joints allow.
    pub scale: f64,
    /// Speed of the set-point over the last period, m/s.
    pub pace: f64,
    /// What the oil that holds the joints left of the last step.
    pub step_limit: StepLimit,
    /// Of each lag of the stick at the last sample, rad/s.
    bandwidth: f64,
    /// Share of its speed that a tip far away has left at the last sample.
    followed: f64,
    /// Place of the tip as far as regions matter, m.
    tip: [f64; 2],
    /// On the way to limits and regions.
    caution: Caution,
    lags: Lags<3>,
    /// Of the joints' rates, under levers.
    joint_lags: Option<Lags<N>>,
    /// s
    period: f64,
    leaders: [bool; N],
    slews: bool,
}

impl<const N: usize> Reference<N> {
    /// At rest at `q`, to be moved on once per `period` (s).
    pub fn at(model: &ControllerModel<N>, period: f64, q: [f64; N]) -> Self {
        let posture = model.posture(&q);
        let slews = model.slews();
        let revolute: [bool; N] =
            hydrocrane_num::array::from_fn(|i| model.mechanics.joints[i].revolute && !(slews && i == SLEW));
        let rank = |i: usize| revolute[..i].iter().filter(|&&r| r).count();
        // Without two revolute joints in the plane every joint leads.
        let few = rank(N) < 2;
        let leaders = hydrocrane_num::array::from_fn(|i| few || slews && i == SLEW || revolute[i] && rank(i) < 2);
        Reference {
            set_point: posture.tip,
            q,
            rates: [0.0; N],
            acceleration: [0.0; N],
            posture,
            scale: 1.0,
            pace: 0.0,
            step_limit: StepLimit { share: 1.0, joint: 0 },
            bandwidth: f64::INFINITY,
            followed: 1.0,
            tip: posture.tip,
            caution: Caution::NONE,
            lags: Lags::at([0.0; 3]),
            joint_lags: None,
            period,
            leaders,
            slews,
        }
    }

    /// Speed of the set-point before it is scaled, m/s.
    pub fn speed(&self) -> f64 {
        match self.joint_lags {
            Some(_) => self.pace,
            None => self.moved(self.lags.0[1]).norm(),
        }
    }

    /// Builds for the smallest chains only leave the rest out.
    fn slews(&self) -> bool {
        cfg!(feature = "chains") && self.slews
    }

    /// Of the tip in the plane and across it, m/s.
    pub fn velocity(&self) -> Vec3<f64> {
        self.moved(self.of_tip(self.rates))
    }

    /// Velocity of the tip in the plane (m/s) at these rates of the joints, and the rate of the slewing joint, rad/s.
    fn of_tip(&self, rates: [f64; N]) -> [f64; 3] {
        let [x, z] = self.posture.jacobian.map(|row| (0..N).map(|i| row[i] * rates[i]).sum::<f64>());
        [x, z, if self.slews() { rates[SLEW] } else { 0.0 }]
    }

    /// Of the tip in the plane and across it (m/s) at a velocity in the plane and a rate of the slewing joint, rad/s.
    fn moved(&self, [x, z, slew]: [f64; 3]) -> Vec3<f64> {
        self.posture.velocity([x, z], slew)
    }

    /// What asks for this velocity of the tip in the plane and across it, m/s. The slewing joint is asked for no more than its piston has at
    /// full lever, `full` retracting and extending, m/s.
    pub fn asked(&self, [x, z, across]: [f64; 3], full: &[[f64; 2]; N]) -> Request<N> {
        if across == 0.0 || !self.slews() {
            return Request::Tip([x, z, 0.0]);
        }
        let lever_arm = self.posture.lever_arm[SLEW];
        let most = full[SLEW][usize::from(across * lever_arm > 0.0)] / lever_arm.abs().max(LEAST_LEVER_ARM);
        Request::Tip([x, z, (across / self.posture.across).max(-most).min(most)])
    }

    /// From the tip, which is at this place of the plane (m) with the slewing joint at `slew` (rad), to the set-point, in the plane and
    /// across it, m.
    pub fn lag(&self, tip: [f64; 2], slew: f64) -> Vec3<f64> {
        let [x, z] = self.set_point;
        self.posture.velocity([x - tip[0], z - tip[1]], self.q[SLEW] - slew)
    }

    /// Velocity of the tip in the plane and across it that a request leads to where nothing slows it down, m/s.
    pub fn towards(&self, shape: &Shape<N>, request: &Request<N>) -> Vec3<f64> {
        self.moved(self.requested(shape, request))
    }

    /// The same with the rate of the slewing joint, rad/s.
    fn requested(&self, shape: &Shape<N>, request: &Request<N>) -> [f64; 3] {
        match request {
            Request::Tip(velocity) => *velocity,
            Request::Joints(rates) => self.of_tip(level(&self.posture.jacobian, rates, shape.height_joint)),
        }
    }

    /// Whether the set-point still moves or shall move.
    pub fn moving(&self, request: &Request<N>) -> bool {
        !request.is_zero() || self.speed().min(self.pace) > STANDING
    }

    /// Where the set-point comes to rest when the stick is released now, if nothing slows it down, m.
    pub fn stopping_place(&self, bandwidth: f64) -> [f64; 2] {
        let bandwidth = bandwidth.min(self.bandwidth);
        let kept = portable::exp(-bandwidth * self.period);
        let time = kept * self.period / (1.0 - kept);
        let [first, second] = self.joint_lags.map_or(self.lags, |_| Lags::at(self.of_tip(self.rates))).0;
        hydrocrane_num::array::from_fn(|r| self.set_point[r] + time * (first[r] + second[r]))
    }

    /// Moves on by one period towards a request.
    pub fn advance(&mut self, model: &ControllerModel<N>, shape: &Shape<N>, request: Request<N>, now: &Means<N>) {
        // The stick as well as its lags: lags wound up at a border would hold the tip there after the stick has turned away.
        self.caution =
            Caution { rate: shape.slow_down(shape.bandwidth(now.slowest_mode, 0.0)), uncertainty: now.uncertainty };
        self.tip = self.near_set_point(shape, now);
        let request = self.slowed(shape, request);
        let bandwidth = shape.bandwidth(now.slowest_mode, self.used(model, shape, &request, now));
        self.bandwidth = bandwidth;
        let shaped = self.shape_stick(shape, request, bandwidth);
        let follow = 1.0 - portable::exp(-bandwidth * self.period);
        for i in (0..N).filter(|&i| self.joint_lags.is_none() && !self.leaders[i]) {
            // What a count leaves unknown is no jump of the joint: followed without a lag, it would kick the oil through the others.
            let (behind, unknown) = (now.observed[i] - self.q[i], now.unknown[i]);
            self.q[i] += behind - (1.0 - follow) * behind.clamp(-unknown, unknown);
        }
        let (posture, at) = model.posture_at(&self.q);
        self.posture = posture;
        if self.joint_lags.is_some() {
            // Nothing but the height is held.
            self.set_point[0] = posture.tip[0];
        }
        let slowed = self.slowed(shape, shaped);
        let velocity = self.towards(shape, &slowed);
        let speed = velocity.norm();
        let prefer = self.preference(model, shape, &posture, &now.piston, velocity.in_plane().norm());
        let prefer = Preference { rates: self.going_on(velocity.in_plane(), &prefer.rates, bandwidth), ..prefer };
        let Motion { rates, scale } = self.motion(shape, &slowed, &self.correction(shape, now), &prefer);
        let next = model.at(&hydrocrane_num::array::from_fn(|i| self.q[i] + rates[i] * self.period));
        let most = self.caution.rate * self.period;
        let limit = model.step_limit([&at, &next], &now.held, now.payload, &now.stiffness, most);
        // It comes back slowly: where only some directions are open, it would jump with every correction of the path.
        self.step_limit = StepLimit { share: limit.share.min(self.step_limit.share + most), ..limit };
        let pistons = hydrocrane_num::array::from_fn(|i| posture.lever_arm[i] * rates[i]);
        // A slow crane that stops at once swings on its oil: the set-point loses its speed as behind its lags.
        let slow = shape.slows(now);
        let kept = if slow { 1.0 - (bandwidth * self.period).min(1.0) } else { 0.0 };
        let held = model.braking_share(&at, &rates, bandwidth, now, slow && now.near_region).max(kept);
        // But it stops at once where it would end near a dead centre, which a joint that has passed does not come back from.
        let held = held.min(model.held_share(&rates, bandwidth, now));
        let left = scale * held;
        if left < 1.0 {
            // Lags that were wound up meanwhile would not let the set-point stop in time, and it would jump once its way is free.
            self.lags = self.lags.scaled(left);
            self.joint_lags = self.joint_lags.map(|lags| lags.scaled(left));
        }
        self.followed = now.following.max(if slow { self.followed + kept - 1.0 } else { 0.0 });
        let share = self.step_limit.share.min(model.pump_share(&pistons, &now.pressures)).min(held).min(self.followed);
        let (rates, scale) = (rates.map(|rate| rate * share), scale * share);
        for (place, velocity) in self.set_point.iter_mut().zip([velocity.x, velocity.z]) {
            *place += scale * velocity * self.period;
        }
        for i in 0..N {
            self.q[i] += rates[i] * self.period;
        }
        // Behind a low-pass well above the stick's: rates jump where a joint meets a limit.
        let share = 1.0 - portable::exp(-ACCELERATION_PER_STICK * bandwidth * self.period);
        for (i, slow) in self.acceleration.iter_mut().enumerate() {
            *slow += share * ((rates[i] - self.rates[i]) / self.period - *slow);
        }
        (self.rates, self.scale, self.pace, self.posture) = (rates, scale, scale * speed, posture);
    }

    /// Largest share of a piston's full speed that the motion at hand or the requested one uses; only where it counts.
    fn used(&self, model: &ControllerModel<N>, shape: &Shape<N>, request: &Request<N>, now: &Means<N>) -> f64 {
        if shape.bandwidth(now.slowest_mode, 1.0) == shape.stick_bandwidth {
            return 0.0;
        }
        let prefer = self.preference(model, shape, &self.posture, &now.piston, 0.0);
        let requested = self.motion(shape, request, &Correction::NONE, &prefer).rates;
        let used = |i: usize| {
            let rate = requested[i].abs().max(self.rates[i].abs());
            (rate * self.posture.lever_arm[i] / now.full_speed[i]).abs()
        };
        (0..N).map(used).fold(0.0, f64::max)
    }

    fn preference(
        &self,
        model: &ControllerModel<N>,
        shape: &Shape<N>,
        posture: &Posture<N>,
        piston: &[[f64; 2]; N],
        speed: f64,
    ) -> Preference<N> {
        Preference {
            weights: hydrocrane_num::array::from_fn(|i| {
                let capacity = (piston[i][1] - piston[i][0]) / posture.lever_arm[i].abs().max(LEAST_GAIN);
                (shape.effort[i] / capacity.max(LEAST_CAPACITY)).square()
            }),
            rates: hydrocrane_num::array::from_fn(|i| {
                let middle = 0.5 * (model.joint_limits[i][0] + model.joint_limits[i][1]);
                shape.centring[i] * speed * (middle - self.q[i])
            }),
            bounds: joint_rates(model, posture, &self.q, piston, shape.limit_rate.min(self.caution.rate)),
        }
    }

    /// Rates that go on as they are, slower where the tip is, and approach those `preferred` behind a lag: where a limit lets a joint
    /// go, as in every fast stop, the way in which the joints share the motion would else jump, and excite the oil.
    fn going_on(&self, now: Vec2<f64>, preferred: &[f64; N], bandwidth: f64) -> [f64; N] {
        let before = self.velocity().in_plane();
        let kept = (now.dot(before) / before.dot(before).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let share = portable::exp(-bandwidth * self.period);
        hydrocrane_num::array::from_fn(|i| preferred[i] + share * (kept * self.rates[i] - preferred[i]))
    }

    /// A request slowed down before regions to keep out of.
    pub fn slowed(&self, shape: &Shape<N>, request: Request<N>) -> Request<N> {
        match request {
            Request::Tip([x, z, slew]) => {
                let left = self.kept_out(shape, [x, z]);
                Request::Tip([left[0], left[1], slew * share(left, [x, z])])
            }
            Request::Joints(_) => {
                let [x, z, _] = self.requested(shape, &request);
                request.scaled(share(self.kept_out(shape, [x, z]), [x, z]))
            }
        }
    }

    /// Where the tip of a slow crane is, as far as regions matter: at the set-point but for what it is off it beyond what their margin
    /// covers, m.
    fn near_set_point(&self, shape: &Shape<N>, now: &Means<N>) -> [f64; 2] {
        let off = Vec2::<f64>::c(now.tip) - Vec2::c(self.set_point);
        let covered = TOLERATED + now.uncertainty;
        if !shape.slows(now) || off.norm() <= covered {
            return self.set_point;
        }
        let share = 1.0 - covered / off.norm();
        [self.set_point[0] + share * off.x, self.set_point[1] + share * off.z]
    }

    /// A velocity slowed down before regions that the set-point nears, or the tip where it is far from it.
    fn kept_out(&self, shape: &Shape<N>, velocity: [f64; 2]) -> [f64; 2] {
        let left = shape.keep_out.slowed(self.set_point, velocity, &self.caution);
        if self.tip == self.set_point {
            return left;
        }
        shape.keep_out.slowed(self.tip, left, &self.caution)
    }

    /// What brings the reference back to its path.
    fn correction(&self, shape: &Shape<N>, now: &Means<N>) -> Correction {
        let rate = shape.path_rate.min(MOST_CORRECTED / self.period);
        let all = (0..N).filter(|&i| !self.leaders[i]).map(|i| now.correctable[i]).fold(rate, f64::min);
        let velocity = hydrocrane_num::array::from_fn(|r| rate * (self.set_point[r] - self.posture.tip[r]));
        Correction { velocity, all: all / rate }
    }

    /// Rates of the joints for a request and a correction of the path.
    fn motion(
        &self,
        shape: &Shape<N>,
        request: &Request<N>,
        correction: &Correction,
        prefer: &Preference<N>,
    ) -> Motion<N> {
        let jacobian = &self.posture.jacobian;
        match *request {
            Request::Tip(velocity) => {
                let led = self.led(correction, prefer);
                let correction = hydrocrane_num::array::from_fn(|r| {
                    let led: f64 = (0..N).map(|i| jacobian[r][i] * led[i]).sum();
                    correction.all * (correction.velocity[r] - led)
                });
                let bounds = hydrocrane_num::array::from_fn(|i| prefer.bounds[i].map(|bound| bound - led[i]));
                let prefer = Preference { bounds, ..*prefer };
                let Motion { rates, scale } = self.resolved(resolve_steadily, velocity, correction, &prefer);
                Motion { rates: hydrocrane_num::array::from_fn(|i| led[i] + rates[i]), scale }
            }
            Request::Joints(rates) => {
                level_within(jacobian, &rates, shape.height_joint, correction.velocity[1], &prefer.bounds)
            }
        }
    }

    /// Rates of the joints for a velocity in the plane with its `correction` (m/s) and the slewing joint's rate (rad/s), all slowed down by
    /// one share.
    fn resolved(
        &self,
        resolve: fn(&[[f64; N]; 2], &Task, &Preference<N>) -> Motion<N>,
        [x, z, slew]: [f64; 3],
        correction: [f64; 2],
        prefer: &Preference<N>,
    ) -> Motion<N> {
        let bound = prefer.bounds[SLEW][usize::from(slew > 0.0)];
        let allowed = if slew == 0.0 || !self.slews() { 1.0 } else { (bound / slew).clamp(0.0, 1.0) };
        let task = Task { velocity: [allowed * x, allowed * z], correction };
        let Motion { mut rates, scale } = resolve(&self.posture.jacobian, &task, prefer);
        let scale = allowed * scale;
        if self.slews() {
            rates[SLEW] = scale * slew;
        }
        Motion { rates, scale }
    }

    /// Rates with which the leading joints alone correct the path, as far as they can: a joint that follows its measured position and
    /// corrects what that is off closes a loop over its own swing.
    fn led(&self, correction: &Correction, prefer: &Preference<N>) -> [f64; N] {
        if self.leaders == [true; N] || correction.velocity == [0.0; 2] {
            return [0.0; N];
        }
        let bounds = hydrocrane_num::array::from_fn(|i| if self.leaders[i] { prefer.bounds[i] } else { [0.0; 2] });
        let task = Task { velocity: [0.0; 2], correction: correction.velocity };
        resolve(&self.posture.jacobian, &task, &Preference { rates: [0.0; N], bounds, ..*prefer }).rates
    }

    /// Rates of the joints that levers ask for while one joint holds the height: at full lever the speeds `full` of the pistons,
    /// retracting and extending, or less where the height could not be held as fast.
    pub fn lever_rates(&self, shape: &Shape<N>, full: &[[f64; 2]; N], levers: &[f64; N]) -> [f64; N] {
        let (posture, follower) = (&self.posture, shape.height_joint);
        let lift = posture.jacobian[1];
        let full = |i: usize, sense: usize| full[i][sense] / posture.lever_arm[i].abs().max(LEAST_LEVER_ARM);
        let held = full(follower, 0).min(full(follower, 1)) * lift[follower].abs().max(LEAST_LIFT);
        hydrocrane_num::array::from_fn(|i| {
            let most = if i == follower { f64::INFINITY } else { held / lift[i].abs() };
            (levers[i] * full(i, usize::from(levers[i] > 0.0)).min(most)) * posture.lever_arm[i].signum()
        })
    }

    /// Joints whose bound alone keeps the tip from moving as requested, each with the rate (rad/s or m/s) that it
    /// would have without; zero for all others. Less than the share `least` of the velocity counts as standing.
    pub fn obstacles(
        &self,
        model: &ControllerModel<N>,
        shape: &Shape<N>,
        request: &Request<N>,
        piston: &[[f64; 2]; N],
        least: f64,
    ) -> [f64; N] {
        let prefer = self.preference(model, shape, &self.posture, piston, 0.0);
        let nothing = Correction::NONE;
        if self.motion(shape, request, &nothing, &prefer).scale >= least {
            return [0.0; N];
        }
        hydrocrane_num::array::from_fn(|i| {
            let mut bounds = prefer.bounds;
            bounds[i] = UNBOUNDED;
            let prefer = Preference { bounds, ..prefer };
            let freed = match *request {
                Request::Tip(velocity) => self.resolved(resolve, velocity, [0.0; 2], &prefer),
                Request::Joints(_) => self.motion(shape, request, &nothing, &prefer),
            };
            if freed.scale >= least {
                freed.rates[i]
            } else {
                0.0
            }
        })
    }

    /// The request behind its lags, each of this `bandwidth`, rad/s.
    fn shape_stick(&mut self, shape: &Shape<N>, request: Request<N>, bandwidth: f64) -> Request<N> {
        let share = 1.0 - portable::exp(-bandwidth * self.period);
        match request {
            Request::Tip(velocity) => {
                if self.joint_lags.take().is_some() {
                    self.lags = Lags::at(self.of_tip(self.rates));
                }
                Request::Tip(self.lags.follow(velocity, share))
            }
            Request::Joints(rates) => {
                let mut lags = self.joint_lags.unwrap_or_else(|| Lags::at(self.as_asked(shape.height_joint)));
                let rates = lags.follow(rates, share);
                self.joint_lags = Some(lags);
                Request::Joints(rates)
            }
        }
    }

    /// What would have to be asked of the joints for the rates at hand.
    fn as_asked(&self, follower: usize) -> [f64; N] {
        let mut asked = self.rates;
        asked[follower] += asked[follower] - level(&self.posture.jacobian, &self.rates, follower)[follower];
        asked
    }

    /// Stops where it is.
    pub fn stand(&mut self) {
        (self.lags, self.joint_lags) = (Lags::at([0.0; 3]), None);
        self.rates = [0.0; N];
        self.acceleration = [0.0; N];
        self.pace = 0.0;
    }
}

/// Length of `left` as a share of that of `whole`, all of it where that has none.
fn share(left: [f64; 2], whole: [f64; 2]) -> f64 {
    let [left, whole] = [left, whole].map(|velocity| Vec2::<f64>::c(velocity).norm());
    if whole > 0.0 {
        left / whole
    } else {
        1.0
    }
}

/// Share of a piston's full speed from which on the lags are slower than the lowest mode of the crane on its oil. A motion that
/// starts or stops with the speed v behind lags of the bandwidth w compresses the oil with v/e (w/w_1)^2: of what the drive gives for that,
/// a part is left for corrections.
const COMPRESSED_IN_FULL: f64 = PLANNED_COMPRESSION * MOST_COMPRESSION * core::f64::consts::E;
const PLANNED_COMPRESSION: f64 = 0.7;
/// Lowest mode, in bandwidths of the stick, from which on the lags stay as they are: they wind the oil with a sixth of the speed at most.
const FAST_MODE: f64 = 1.5;
/// Corner of the low-pass on the acceleration, in bandwidths of the stick.
const ACCELERATION_PER_STICK: f64 = 5.0;
/// Share of a lost path that is found again in a period, at most: more than all of it would overshoot.
const MOST_CORRECTED: f64 = 0.5;
/// Guards of levers near a dead centre, m/rad, and where the joint that holds the height lifts nothing, m/rad or m/m: there the
/// levers still ask for something, so that whoever holds them is told why the tip stands.
const LEAST_LEVER_ARM: f64 = 1e-3;
const LEAST_LIFT: f64 = 0.1;
/// Distance of the tip from its set-point that the margin of regions covers, m.
const TOLERATED: f64 = 2e-3;
/// Set-point speed that counts as standing, m/s.
pub const STANDING: f64 = 1e-4;
/// Guards of the weights near a dead centre and for a piston that cannot move.
const LEAST_GAIN: f64 = 1e-6;
const LEAST_CAPACITY: f64 = 1e-9;
/// Rates that no task asks for, rad/s or m/s.
const UNBOUNDED: [f64; 2] = [-1e3, 1e3];
