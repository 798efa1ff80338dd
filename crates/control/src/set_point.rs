//! The set-point of the tip and the joint motion that belongs to it.    theory: docs/theory/control/set_point.md
//!
//! The stick's velocity passes a double lag and moves the set-point; [`redundancy`](crate::redundancy) turns it into
//! joint rates; their integral is the reference. What integration loses on the path is fed back as a correction of
//! the next step, so no inverse kinematics is needed and any chain will do. Joints beyond the first two revolute ones
//! follow their measured positions: where the telescope lags, boom and jib make up for it.

use crate::controller_model::{ControllerModel, Posture};
use crate::holding::Leave;
use crate::keep_out::KeepOut;
use crate::redundancy::{resolve, Motion, Preference, Task};
use crate::slow_down::joint_rates;
use hydrocrane_num::{portable, Vec2};

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
}

impl<const N: usize> Shape<N> {
    /// Bandwidth of each lag where the crane's lowest natural frequency on its oil is `slowest_mode` (rad/s), rad/s.
    pub fn bandwidth(&self, slowest_mode: f64) -> f64 {
        self.stick_bandwidth.min(STICK_PER_MODE * slowest_mode)
    }
}

/// What a sample says of the crane.
#[derive(Debug, Clone, Copy)]
pub struct Means<const N: usize> {
    /// Joint coordinates, rad or m.
    pub observed: [f64; N],
    /// Lowest and highest piston speeds to plan with, m/s.
    pub piston: [[f64; 2]; N],
    /// Of the oil between closed edges, N/m.
    pub stiffness: [f64; N],
    /// How closed valves hold each joint where it is, h of `holding`.
    pub held: [f64; N],
    /// Mass at the tip, kg.
    pub payload: f64,
    /// Lowest natural frequency of the crane on its oil, rad/s.
    pub slowest_mode: f64,
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
    pub leave: Leave,
    lags: [[f64; 2]; 2],
    /// s
    period: f64,
    leaders: [bool; N],
}

impl<const N: usize> Reference<N> {
    /// At rest at `q`, to be moved on once per `period` (s).
    pub fn at(model: &ControllerModel<N>, period: f64, q: [f64; N]) -> Self {
        let posture = model.posture(&q);
        let revolute = model.mechanics.joints.map(|j| j.revolute);
        let rank = |i: usize| revolute[..i].iter().filter(|&&r| r).count();
        // Without two revolute joints every joint leads.
        let few = rank(N) < 2;
        let leaders = std::array::from_fn(|i| few || revolute[i] && rank(i) < 2);
        Reference {
            set_point: posture.tip,
            q,
            rates: [0.0; N],
            acceleration: [0.0; N],
            posture,
            scale: 1.0,
            pace: 0.0,
            leave: Leave { share: 1.0, joint: 0 },
            lags: [[0.0; 2]; 2],
            period,
            leaders,
        }
    }

    /// Speed of the set-point before it is scaled, m/s.
    pub fn speed(&self) -> f64 {
        Vec2::<f64>::c(self.lags[1]).norm()
    }

    /// Whether the set-point still moves or shall move.
    pub fn moving(&self, stick: [f64; 2]) -> bool {
        stick != [0.0; 2] || self.speed().min(self.pace) > STANDING
    }

    /// Where the set-point comes to rest when the stick is released now, if nothing slows it down, m.
    pub fn stopping_place(&self, bandwidth: f64) -> [f64; 2] {
        let kept = portable::exp(-bandwidth * self.period);
        let time = kept * self.period / (1.0 - kept);
        std::array::from_fn(|r| self.set_point[r] + time * (self.lags[0][r] + self.lags[1][r]))
    }

    /// Moves on by one period towards the velocity `wish` (m/s).
    pub fn advance(&mut self, model: &ControllerModel<N>, shape: &Shape<N>, wish: [f64; 2], now: &Means<N>) {
        // The stick as well as its lags: lags wound up at a border would hold the tip there after the stick has turned away.
        let bandwidth = shape.bandwidth(now.slowest_mode);
        self.shape_stick(shape.keep_out.slowed(self.set_point, wish), bandwidth);
        for i in (0..N).filter(|&i| !self.leaders[i]) {
            self.q[i] = now.observed[i];
        }
        let posture = model.posture(&self.q);
        let rate = shape.path_rate.min(MOST_CORRECTED / self.period);
        let correction = std::array::from_fn(|r| rate * (self.set_point[r] - posture.tip[r]));
        let velocity = shape.keep_out.slowed(self.set_point, self.lags[1]);
        let speed = Vec2::<f64>::c(velocity).norm();
        let prefer = self.preference(model, shape, &posture, &now.piston, speed);
        let Motion { rates, scale } = resolve(&posture.jacobian, &Task { velocity, correction }, &prefer);
        let next = std::array::from_fn(|i| self.q[i] + rates[i] * self.period);
        let most = shape.limit_rate * self.period;
        let leave = model.leave([&self.q, &next], &now.held, now.payload, &now.stiffness, most);
        // It comes back slowly: where only some directions are open, it would jump with every correction of the path.
        self.leave = Leave { share: leave.share.min(self.leave.share + most), ..leave };
        let (rates, scale) = (rates.map(|rate| rate * self.leave.share), scale * self.leave.share);
        for r in 0..2 {
            self.set_point[r] += scale * velocity[r] * self.period;
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

    fn preference(
        &self,
        model: &ControllerModel<N>,
        shape: &Shape<N>,
        posture: &Posture<N>,
        piston: &[[f64; 2]; N],
        speed: f64,
    ) -> Preference<N> {
        Preference {
            weights: std::array::from_fn(|i| {
                let capacity = (piston[i][1] - piston[i][0]) / posture.lever_arm[i].abs().max(LEAST_GAIN);
                (shape.effort[i] / capacity.max(LEAST_CAPACITY)).powi(2)
            }),
            rates: std::array::from_fn(|i| {
                let middle = 0.5 * (model.joint_limits[i][0] + model.joint_limits[i][1]);
                shape.centring[i] * speed * (middle - self.q[i])
            }),
            bounds: joint_rates(model, posture, &self.q, piston, shape.limit_rate),
        }
    }

    /// Joints whose bound alone keeps the tip from moving at `velocity` (m/s), each with the rate (rad/s or m/s) that it
    /// would have without; zero for all others. Less than the share `least` of the velocity counts as standing.
    pub fn obstacles(
        &self,
        model: &ControllerModel<N>,
        shape: &Shape<N>,
        velocity: [f64; 2],
        piston: &[[f64; 2]; N],
        least: f64,
    ) -> [f64; N] {
        let prefer = self.preference(model, shape, &self.posture, piston, 0.0);
        let task = Task { velocity, correction: [0.0; 2] };
        let motion = |bounds| resolve(&self.posture.jacobian, &task, &Preference { bounds, ..prefer });
        if motion(prefer.bounds).scale >= least {
            return [0.0; N];
        }
        std::array::from_fn(|i| {
            let mut bounds = prefer.bounds;
            bounds[i] = UNBOUNDED;
            let freed = motion(bounds);
            if freed.scale >= least {
                freed.rates[i]
            } else {
                0.0
            }
        })
    }

    /// `bandwidth`: of each lag, rad/s.
    fn shape_stick(&mut self, wish: [f64; 2], bandwidth: f64) {
        let share = 1.0 - portable::exp(-bandwidth * self.period);
        for r in 0..2 {
            self.lags[0][r] += share * (wish[r] - self.lags[0][r]);
            self.lags[1][r] += share * (self.lags[0][r] - self.lags[1][r]);
        }
    }

    /// Stops where it is.
    pub fn stand(&mut self) {
        self.lags = [[0.0; 2]; 2];
        self.rates = [0.0; N];
        self.acceleration = [0.0; N];
        self.pace = 0.0;
    }
}

/// Bandwidth of the stick's lags in lowest natural frequencies of the crane on its oil: what is asked for faster winds the oil more
/// than it moves the crane.
const STICK_PER_MODE: f64 = 1.0;
/// Corner of the low-pass on the acceleration, in bandwidths of the stick.
const ACCELERATION_PER_STICK: f64 = 5.0;
/// Share of a lost path that is found again in a period, at most: more than all of it would overshoot.
const MOST_CORRECTED: f64 = 0.5;
/// Set-point speed that counts as standing, m/s.
pub const STANDING: f64 = 1e-4;
/// Guards of the weights near a dead centre and for a piston that cannot move.
const LEAST_GAIN: f64 = 1e-6;
const LEAST_CAPACITY: f64 = 1e-9;
/// Rates that no task asks for, rad/s or m/s.
const UNBOUNDED: [f64; 2] = [-1e3, 1e3];
