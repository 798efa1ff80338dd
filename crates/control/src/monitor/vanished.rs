//! Chambers that read nothing, and whether anything carries the crane.  theory: docs/theory/control/plausibility.md
//!
//! Both pressures of a cylinder at nothing are those of a failed sensor, or of a crane that its oil has thrown up. The readings of the
//! joints tell: what falls freely needs no piston force, what stands or moves in any other way does.

use crate::model::controller_model::{ControllerModel, CylinderModel};
use crate::model::oil_displacement::Trust;
use crate::monitor::passage::INTERVAL;
use arrayvec::ArrayVec;

/// Slow and fast motion of a piston, by which its friction is judged, m/s.
const SPEEDS: [f64; 2] = [0.01, 0.1];
/// Samples that are kept of a time, evenly spaced.
const KEPT: usize = 6;

/// A cylinder whose load has vanished from its oil.
#[derive(Debug, Clone)]
pub(crate) struct Vanished<const N: usize> {
    /// Since when, s.
    pub since: f64,
    /// Sense of the force that the oil had before.
    sense: f64,
    /// Joints since then, and the least time between two samples that are kept, s.
    course: ArrayVec<(f64, [f64; N]), KEPT>,
    every: f64,
    /// Whether the motion has shown that something carries the load.
    pub carried: bool,
}

/// What the motion tells of a load that has vanished.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Verdict {
    /// Nothing yet.
    Unknown,
    /// Something carries it: the pressures cannot be right.
    Carried,
    /// Nothing does.
    Falls,
}

impl CylinderModel {
    /// Friction in both directions, N: it turns round with the motion.
    pub(crate) fn friction_both_ways(&self) -> f64 {
        let most = |sense: f64| SPEEDS.iter().fold(0.0f64, |f, v| f.max(self.steady_friction(sense * v).abs()));
        most(1.0) + most(-1.0)
    }

    /// Force that a piston can have while both chambers read nothing, N.
    fn without_oil(&self, trust: &Trust) -> f64 {
        let areas = [self.chambers.area_1, self.chambers.area_2];
        self.friction_both_ways() + areas[0] * trust.pressure[0] + areas[1] * trust.pressure[1]
    }
}

/// Whether both chambers read nothing.
pub(crate) fn nothing(p: [f64; 2], trust: &Trust) -> bool {
    (0..2).all(|side| p[side].abs() <= trust.pressure[side])
}

impl<const N: usize> Vanished<N> {
    /// At time `t` (s) both chambers of cylinder `c` read nothing: whether oil has carried there `before` what the crane with the
    /// joints at `q` needs, with and without its payload.
    pub fn seen(
        model: &ControllerModel<N>,
        c: usize,
        t: f64,
        q: &[f64; N],
        before: [f64; 2],
        trust: &Trust,
    ) -> Option<Self> {
        let (cylinder, unknown) = (&model.cylinders[c], model.cylinders[c].without_oil(trust));
        let had = cylinder.chambers.force(before[0], before[1]);
        let needed = |force: f64| force * had.signum() > unknown;
        let rests = |payload: f64| model.cylinder_force(q, &[0.0; N], payload)[c];
        (needed(had) && needed(rests(0.0)) && needed(rests(model.payload))).then(|| Vanished {
            since: t,
            sense: had.signum(),
            course: ArrayVec::new(),
            every: INTERVAL,
            carried: false,
        })
    }

    /// Takes the readings `q` of a sample, each within half of its `scatter`.
    pub fn judge(
        &mut self,
        model: &ControllerModel<N>,
        c: usize,
        (t, q): (f64, &[f64; N]),
        scatter: &[f64; N],
        trust: &Trust,
    ) -> Verdict {
        let (stroke, [low, high]) = (model.strokes(q)[c].0, model.cylinders[c].free);
        if !(low..=high).contains(&stroke) {
            // An end stop carries more than any load.
            self.course.clear();
            return Verdict::Unknown;
        }
        let verdict = self.motion(t, q).map_or(Verdict::Unknown, |motion| {
            let unknown = model.cylinders[c].without_oil(trust);
            let forces = [0.0, model.payload].map(|payload| motion.force(model, c, payload, scatter, self.sense));
            if forces.iter().all(|[least, _]| *least > unknown) {
                Verdict::Carried
            } else if forces.iter().any(|[_, most]| *most <= unknown) {
                Verdict::Falls
            } else {
                Verdict::Unknown
            }
        });
        if self.course.is_full() {
            let mut kept = false;
            self.course.retain(|_| {
                kept = !kept;
                kept
            });
            self.every = 2.0 * (t - self.since) / KEPT as f64;
        }
        if self.course.last().is_none_or(|(last, _)| t - last >= self.every * (1.0 - 1e-6)) {
            self.course.push((t, *q));
        }
        verdict
    }

    /// The mean motion until `t` (s), from three samples.
    fn motion(&self, t: f64, q: &[f64; N]) -> Option<Motion<N>> {
        let (first, others) = self.course.split_first()?;
        let off = |at: f64| (2.0 * at - first.0 - t).abs();
        let middle = others.iter().min_by(|a, b| off(a.0).total_cmp(&off(b.0)))?;
        let (before, after, all) = (middle.0 - first.0, t - middle.0, t - first.0);
        let rates = |i: usize| [(middle.1[i] - first.1[i]) / before, (q[i] - middle.1[i]) / after];
        Some(Motion {
            q: middle.1,
            qd: hydrocrane_num::array::from_fn(|i| (q[i] - first.1[i]) / all),
            qdd: hydrocrane_num::array::from_fn(|i| 2.0 * (rates(i)[1] - rates(i)[0]) / all),
            unsure: 2.0 * (1.0 / before + 1.0 / after) / all,
        })
    }
}

/// Joints, rates and accelerations over a time.
struct Motion<const N: usize> {
    q: [f64; N],
    qd: [f64; N],
    qdd: [f64; N],
    /// Error of an acceleration in the scatter of its joint, 1/s^2.
    unsure: f64,
}

impl<const N: usize> Motion<N> {
    /// Least and most force in this `sense` that the motion asks of cylinder `c`, N.
    fn force(&self, model: &ControllerModel<N>, c: usize, payload: f64, scatter: &[f64; N], sense: f64) -> [f64; 2] {
        let at = model.at(&self.q);
        let torque = model.inverse_dynamics(&at.pose, &self.qd, Some(&self.qdd), payload)[c];
        let mass = model.mass_matrix(&at.pose, payload)[c];
        let unsure: f64 = (0..N).map(|j| mass[j].abs() * scatter[j] * self.unsure).sum();
        let (force, unsure) = (sense * torque / at.lever_arm[c], unsure / at.lever_arm[c].abs());
        [force - unsure, force + unsure]
    }
}
