//! The thesis's tip controller, sampled.                     theory: docs/theory/control/heinze_pid.md
//!
//! Table 6: the stick moves a set-point once per set-point interval; inverse kinematics turns it into joint targets; a
//! PID per joint (129), (130) drives the joint's spool. The program drives cylinder 2 the other way round because
//! its joint angle falls as the piston extends; here the sign is that of dx/dq. The printed run has a set-point interval of
//! 5 s: one set-point, 2.5 m away. Departs from the source: the PID runs at a fixed period, not at every evaluation
//! of the right-hand side (E22). Steps 6 and 8, which the program leaves out, are settings: the
//! [working area](crate::thesis::working_area) and the [penalty](crate::thesis::penalty).

use crate::interface::controller::{copied_by_clone, Controller, Fault, Measurement, Stick};
use crate::model::controller_model::ControllerModel;
use crate::model::inverse_kinematics::{branches, Printed, TooFewRevolute};
use crate::reference::slow_down::{checked, checked_stick};
use crate::thesis::penalty::{self, Weights};
use crate::thesis::pid::{Gains, Pid};
use crate::thesis::working_area::WorkingArea;
use core::f64::consts::PI;
use hydrocrane_num::Real;

/// How the coordinates of prismatic joints are chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Extension<const N: usize> {
    /// Zero, as in the program.
    Zero,
    /// By the penalty function (131) over this many candidates.
    Penalty { weights: Weights<N>, candidates: usize },
}

#[derive(Debug, Clone, PartialEq)]
pub struct Settings<const N: usize> {
    /// s
    pub period: f64,
    /// Time between set-points, s.
    pub set_point_interval: f64,
    /// Tip speed at full stick, m/s.
    pub full_speed: f64,
    /// Per sample: m of spool per rad or m.
    pub gains: [Gains; N],
    pub extension: Extension<N>,
    pub printed: Printed,
    /// Where the set-point may go; `None`: anywhere, as in the program.
    pub working_area: Option<WorkingArea>,
}

hydrocrane_num::stored!([const N: usize] enum Extension<N> {
    0: Zero {},
    1: Penalty { weights: Weights<N>, candidates: usize },
});
hydrocrane_num::stored!([const N: usize] Settings<N> {
    period: f64,
    set_point_interval: f64,
    full_speed: f64,
    gains: [Gains; N],
    extension: Extension<N>,
    printed: Printed,
    working_area: Option<WorkingArea>,
});

/// K_i of joint 1 and of the others, K_p, K_d: section 7.2.
pub fn printed_gains<const N: usize>() -> [Gains; N] {
    let of = |integral| Gains { proportional: 1.0, integral, derivative: 0.01 };
    hydrocrane_num::array::from_fn(|i| of(if i == 0 { 1e-4 } else { 5e-3 }))
}

#[derive(Clone)]
pub struct HeinzePid<const N: usize> {
    model: ControllerModel<N>,
    settings: Settings<N>,
    pids: [Pid; N],
    target: [f64; N],
    set_point: [f64; 2],
    /// Time of the next set-point; `None` before the first sample.
    due: Option<f64>,
}

impl<const N: usize> HeinzePid<N> {
    pub fn new(model: ControllerModel<N>, settings: Settings<N>) -> Self {
        let pids = hydrocrane_num::array::from_fn(|i| {
            let stroke = model.cylinders[i].stroke;
            Pid::new(settings.gains[i], [-stroke, stroke])
        });
        HeinzePid { model, settings, pids, target: [0.0; N], set_point: [0.0; 2], due: None }
    }

    pub fn model(&self) -> &ControllerModel<N> {
        &self.model
    }

    fn begin(&mut self, q: &[f64; N], t: f64) {
        self.pids.iter_mut().for_each(Pid::reset);
        self.target = *q;
        self.set_point = self.model.tip(q);
        self.due = Some(t);
        let held = self.settings.extension == Extension::Zero;
        if held && self.settings.working_area.is_some() && self.posture_for(self.set_point, q) == Ok(None) {
            // With the telescope out the tip may lie where no posture reaches with the telescope at zero.
            self.target = self.at_zero(q);
            self.set_point = self.model.tip(&self.target);
        }
    }

    /// Moves the set-point and finds joint targets; one that is not accepted leaves both as they are.
    fn aim(&mut self, q: &[f64; N], stick: [f64; 2]) -> Result<(), Fault> {
        if stick == [0.0; 2] && self.settings.extension != Extension::Zero {
            // The penalty pulls the telescope to its middle; it shall not while the stick is centred.
            return Ok(());
        }
        let velocity = self.allowed(stick.map(|s| s * self.settings.full_speed));
        let moved =
            hydrocrane_num::array::from_fn(|r| self.set_point[r] + velocity[r] * self.settings.set_point_interval);
        if self.settings.working_area.as_ref().is_some_and(|area| !area.accepts(self.set_point, moved)) {
            return Ok(());
        }
        if let Some(target) = self.posture_for(moved, q).map_err(Fault::TooFewRevolute)? {
            self.target = target;
            self.set_point = moved;
        }
        Ok(())
    }

    /// The stick's velocity, slowed down before the borders of the working area. A set-point that comes seldom leaps
    /// farther than a velocity at its start can tell: it is left to be accepted or not.
    fn allowed(&self, velocity: [f64; 2]) -> [f64; 2] {
        let interval = self.settings.set_point_interval;
        match &self.settings.working_area {
            Some(area) if area.limit_rate * interval < 1.0 => {
                let searched = self.settings.extension != Extension::Zero;
                let moves = self.model.mechanics.joints.map(|joint| joint.revolute || searched);
                area.slowed(&self.model, &self.target, &moves, self.set_point, velocity)
            }
            _ => velocity,
        }
    }

    fn posture_for(&self, tip: [f64; 2], q: &[f64; N]) -> Result<Option<[f64; N]>, TooFewRevolute> {
        match &self.settings.extension {
            Extension::Zero => self.nearest_branch(tip, q),
            Extension::Penalty { weights, candidates } => penalty::search(&self.model, weights, tip, q, *candidates),
        }
    }

    /// Inverse kinematics with prismatic joints at zero, on the branch nearest to the posture; whatever the limits
    /// without a working area.
    fn nearest_branch(&self, tip: [f64; 2], q: &[f64; N]) -> Result<Option<[f64; N]>, TooFewRevolute> {
        let whole_turn = q.map(|q| [q.min(0.0) - PI, q.max(0.0) + PI]);
        let area = self.settings.working_area.as_ref();
        let limits = area.map_or(whole_turn, |area| area.limits(&self.model, &self.target));
        let printed =
            Printed { unreachable: self.settings.printed.unreachable && area.is_none(), ..self.settings.printed };
        let found = branches(&self.model.mechanics, &limits, tip, &self.at_zero(q), printed)?;
        let distance = |c: &[f64; N]| (0..N).map(|i| (c[i] - q[i]).square()).sum::<f64>();
        Ok(found.into_iter().flatten().min_by(|a, b| distance(a).total_cmp(&distance(b))))
    }

    /// The posture with prismatic joints at zero, or with a working area as near to it as their limits allow.
    fn at_zero(&self, q: &[f64; N]) -> [f64; N] {
        let nearest =
            |[low, high]: [f64; 2]| if self.settings.working_area.is_some() { low.max(0.0).min(high) } else { 0.0 };
        hydrocrane_num::array::from_fn(|i| match self.model.mechanics.joints[i].revolute {
            true => q[i],
            false => nearest(self.model.joint_limits[i]),
        })
    }
}

impl<const N: usize> Controller for HeinzePid<N> {
    copied_by_clone!();

    fn period(&self) -> f64 {
        self.settings.period
    }

    fn reset(&mut self, first: &Measurement) {
        self.due = None;
        if let Ok((q, _)) = checked::<N>(first) {
            self.begin(&q, first.t);
        }
    }

    fn step(&mut self, measured: &Measurement, stick: Stick, spool: &mut [f64]) -> Result<(), Fault> {
        let (q, _) = checked::<N>(measured)?;
        let [x, z, _] = checked_stick(stick, false)?;
        if self.due.is_none() {
            self.begin(&q, measured.t);
        }
        // Half a period forgives rounding of the clock.
        if self.due.is_none_or(|due| measured.t > due - 0.5 * self.settings.period) {
            self.aim(&q, [x, z])?;
            self.due = Some(measured.t + self.settings.set_point_interval);
        }
        let strokes = self.model.strokes(&q);
        for (i, (pid, out)) in self.pids.iter_mut().zip(spool).enumerate() {
            let (_, lever_arm) = strokes[i];
            *out = lever_arm.signum() * pid.step(self.target[i] - q[i]);
        }
        Ok(())
    }

    fn set_point(&self) -> Option<[f64; 2]> {
        self.due.map(|_| self.set_point)
    }
}
