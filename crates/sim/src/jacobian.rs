//! Exact Jacobian, assembled from narrow duals.
//!
//! A cylinder's laws see six local numbers (x, v, p1, p2, xs, z) and no other cylinder, so six-wide duals give
//! its block; the mechanics is differentiated with respect to the joint coordinates and rates only. The blocks
//! are joined by the chain rule through x(q), v = g(q) q' and q'' = M^-1 (g f - b).

use crate::bordered::{Bordered, Row};
use crate::cylinder_unit::{CylinderUnit, LocalRates, LocalState, Mains};
use crate::layout::Layout;
use crate::ledger::{powers, LEDGER_PER_CYLINDER};
use crate::plant::Plant;
use crate::rhs::{joint_state, Evaluation};
use hydrocrane_num::{Dual, Real};
use hydrocrane_physics::dynamics::Mechanics;
use hydrocrane_physics::geometry::frames::Joint;
use hydrocrane_physics::geometry::stroke::Actuation;
use hydrocrane_physics::hydraulics::fluid::{Fluid, OilTables};
use hydrocrane_physics::hydraulics::spool::Spool;

type Local<T> = Dual<T, 6>;

/// The plant lifted to the duals that differentiate it. Over duals itself, it gives the Jacobian's own derivatives.
pub struct Lifted<T, const N: usize> {
    cylinders: [CylinderUnit<Local<T>>; N],
    spools: [Spool<Dual<T, 2>>; N],
    fluid: Fluid<Local<T>>,
    mains: Mains<Local<T>>,
    joints: [Joint<Dual<T, 1>>; N],
    actuations: [Actuation<Dual<T, 1>>; N],
    mechanics: Mechanics<Dual<T, N>, N>,
}

impl<T: Real, const N: usize> Lifted<T, N> {
    pub fn new(plant: &Plant<T, N>) -> Self {
        let local = plant.map(&mut Local::constant);
        Lifted {
            cylinders: local.cylinders,
            spools: plant.cylinders.map(|c| c.spool.map(&mut Dual::constant)),
            fluid: local.fluid,
            mains: local.mains,
            joints: plant.mechanics.joints.map(|j| j.map(&mut Dual::constant)),
            actuations: plant.actuations.map(|a| a.map(&mut Dual::constant)),
            mechanics: plant.mechanics.map(&mut Dual::constant),
        }
    }
}

/// How the piston follows the joint: g, dg/dq and the joint's rate.
struct Piston<T> {
    gain: T,
    gain_slope: T,
    rate: T,
}

impl<T: Real> Piston<T> {
    /// The chain rule from (x, v, p1, p2, xs, z) to states.
    #[inline(always)]
    fn row(&self, d: &[T; 6]) -> Row<T> {
        Row {
            q: d[0] * self.gain + d[1] * self.gain_slope * self.rate,
            qd: d[1] * self.gain,
            p1: d[2],
            p2: d[3],
            xs: d[4],
            z: d[5],
        }
    }
}

impl<T: Real, const N: usize> Plant<T, N> {
    /// Writes the slopes of the state derivative, and those of the ledger's powers if `out` has room for them and this oil
    /// is given. The evaluation is the one at this state.
    #[allow(clippy::too_many_arguments)]
    pub fn slopes(
        &self,
        lifted: &Lifted<T, N>,
        layout: &Layout,
        x: &[T],
        u: &[T],
        payload: T,
        e: &Evaluation<T, N>,
        oil: Option<&OilTables>,
        out: &mut Bordered<T>,
    ) {
        T::apart(
            #[inline(always)]
            || self.slopes_here(lifted, layout, x, u, payload, e, oil, out),
        );
    }

    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    fn slopes_here(
        &self,
        lifted: &Lifted<T, N>,
        layout: &Layout,
        x: &[T],
        u: &[T],
        payload: T,
        e: &Evaluation<T, N>,
        oil: Option<&OilTables>,
        out: &mut Bordered<T>,
    ) {
        let mut gain_slopes = [T::c(0.0); N];
        for c in 0..N {
            let (local, rates) = local(&lifted.cylinders[c], &lifted.fluid, &lifted.mains, &e.local[c]);
            let piston = lifted.piston(c, x[layout.q(c)], x[layout.qd(c)]);
            gain_slopes[c] = piston.gain_slope;
            let slopes = &mut out.cylinders[c];
            slopes.p1 = piston.row(&rates.p1_rate.derivative);
            slopes.p2 = piston.row(&rates.p2_rate.derivative);
            slopes.z = piston.row(&rates.z_rate.derivative);
            let mut force = rates.force.derivative;
            if out.secants {
                force[1] += self.cylinders[c].friction.tangent_less_secant(e.local[c].v);
            }
            slopes.force = piston.row(&force);
            slopes.spool = lifted.spool(c, x[layout.xs(c)], x[layout.vs(c)], u[c]);
            if let (Some(oil), false) = (oil, out.quadratures.is_empty()) {
                let rows = &mut out.quadratures[c * LEDGER_PER_CYLINDER..][..LEDGER_PER_CYLINDER];
                for (row, power) in rows.iter_mut().zip(powers(oil, &local, &rates)) {
                    *row = piston.row(&power.derivative);
                }
            }
        }
        let by_q = lifted.residual_by_position(layout, x, payload, e, &gain_slopes);
        let by_qd = self.residual_by_rate(layout, x, payload, e);
        accelerations(e, by_q, by_qd, out);
    }
}

/// Slopes of q'' from those of g f - b - M q'' at constant force: solves M (dq''/dy) = d(g f - b - M q'')/dy column by column.
#[inline(always)]
fn accelerations<T: Real, const N: usize>(
    e: &Evaluation<T, N>,
    by_q: [[T; N]; N],
    by_qd: [[T; N]; N],
    out: &mut Bordered<T>,
) {
    for c in 0..N {
        let gain = e.strokes[c].1;
        let slopes = &mut out.cylinders[c];
        let (mut along_q, mut along_qd) = ([T::c(0.0); N], [T::c(0.0); N]);
        for j in 0..N {
            (along_q[j], along_qd[j]) = (by_q[j][c], by_qd[j][c]);
        }
        along_q[c] += gain * slopes.force.q;
        along_qd[c] += gain * slopes.force.qd;
        let mut unit = [T::c(0.0); N];
        unit[c] = gain;
        let (along_q, along_qd) = (e.mass.solve(&along_q), e.mass.solve(&along_qd));
        slopes.response[..N].copy_from_slice(&e.mass.solve(&unit));
        for j in 0..N {
            out.by_q[j][c] = along_q[j];
            out.by_qd[j][c] = along_qd[j];
        }
    }
}

/// One cylinder's laws with their derivatives by its six local numbers.
#[inline(always)]
fn local<T: Real>(
    unit: &CylinderUnit<Local<T>>,
    fluid: &Fluid<Local<T>>,
    mains: &Mains<Local<T>>,
    s: &LocalState<T>,
) -> (LocalState<Local<T>>, LocalRates<Local<T>>) {
    let local = LocalState {
        x: Dual::variable(s.x, 0),
        v: Dual::variable(s.v, 1),
        p1: Dual::variable(s.p1, 2),
        p2: Dual::variable(s.p2, 3),
        spool: Dual::variable(s.spool, 4),
        z: Dual::variable(s.z, 5),
    };
    (
        local,
        T::apart(
            #[inline(always)]
            || unit.rates(fluid, mains, &local),
        ),
    )
}

impl<T: Real, const N: usize> Lifted<T, N> {
    #[inline(always)]
    fn piston(&self, c: usize, q: T, qd: T) -> Piston<T> {
        let pose = self.joints[c].pose(Dual::variable(q, 0));
        let (_, gain) = self.actuations[c].stroke(&pose);
        Piston { gain: gain.value, gain_slope: gain.derivative[0], rate: qd }
    }

    /// d(xs', vs')/d(xs, vs)
    #[inline(always)]
    fn spool(&self, c: usize, position: T, velocity: T, command: T) -> [[T; 2]; 2] {
        let rates =
            self.spools[c].rates(Dual::variable(position, 0), Dual::variable(velocity, 1), Dual::constant(command));
        [rates.0.derivative, rates.1.derivative]
    }

    /// Slopes of g f - b - M q'' by coordinates, with f and q'' held: `[row][variable]`.
    #[inline(always)]
    fn residual_by_position(
        &self,
        layout: &Layout,
        x: &[T],
        payload: T,
        e: &Evaluation<T, N>,
        gain_slopes: &[T; N],
    ) -> [[T; N]; N] {
        let (q, qd) = joint_state::<T, N>(layout, x);
        let mut moving = [Dual::constant(T::c(0.0)); N];
        for i in 0..N {
            moving[i] = Dual::variable(q[i], i);
        }
        let pose = self.mechanics.pose(&moving);
        let (qd, qdd) = (qd.map(Dual::constant), e.qdd.map(Dual::constant));
        let needed = self.mechanics.forces(&pose, &qd, Some(&qdd), Dual::constant(payload));
        let mut out = [[T::c(0.0); N]; N];
        for j in 0..N {
            for i in 0..N {
                out[j][i] = -needed[j].derivative[i];
            }
            // A cylinder's gain moves with its own joint alone.
            out[j][j] += e.rates[j].force * gain_slopes[j];
        }
        out
    }
}

impl<T: Real, const N: usize> Plant<T, N> {
    /// Slopes of -b by rates: `[row][variable]`. The bias is of second degree in the rates, so that a central difference
    /// over any width is its derivative; the width of two keeps rounding that of the bias itself.
    #[inline(always)]
    fn residual_by_rate(&self, layout: &Layout, x: &[T], payload: T, e: &Evaluation<T, N>) -> [[T; N]; N] {
        let (_, qd) = joint_state::<T, N>(layout, x);
        let mut out = [[T::c(0.0); N]; N];
        for i in 0..N {
            let (mut ahead, mut behind) = (qd, qd);
            ahead[i] += T::c(1.0);
            behind[i] -= T::c(1.0);
            let ahead = self.mechanics.forces(&e.pose, &ahead, None, payload);
            let behind = self.mechanics.forces(&e.pose, &behind, None, payload);
            for j in 0..N {
                out[j][i] = (behind[j] - ahead[j]) * 0.5;
            }
        }
        out
    }
}
