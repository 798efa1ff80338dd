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
    /// Geometry inside the mechanics pass.
    wide_actuations: [Actuation<Dual<T, N>>; N],
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
            wide_actuations: plant.actuations.map(|a| a.map(&mut Dual::constant)),
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
        for c in 0..N {
            let (local, rates) = lifted.local(c, &e.local[c]);
            let piston = lifted.piston(c, x[layout.q(c)], x[layout.qd(c)]);
            let slopes = &mut out.cylinders[c];
            slopes.p1 = piston.row(&rates.p1_rate.derivative);
            slopes.p2 = piston.row(&rates.p2_rate.derivative);
            slopes.z = piston.row(&rates.z_rate.derivative);
            slopes.force = piston.row(&rates.force.derivative);
            slopes.spool = lifted.spool(c, x[layout.xs(c)], x[layout.vs(c)], u[c]);
            if let (Some(oil), false) = (oil, out.quadratures.is_empty()) {
                let rows = &mut out.quadratures[c * LEDGER_PER_CYLINDER..][..LEDGER_PER_CYLINDER];
                for (row, power) in rows.iter_mut().zip(powers(oil, &local, &rates)) {
                    *row = piston.row(&power.derivative);
                }
            }
        }
        self.accelerations(lifted, layout, x, payload, e, out);
    }

    /// Slopes of q'': solves M (dq''/dy) = d(g f - b - M q'')/dy column by column.
    fn accelerations(
        &self,
        lifted: &Lifted<T, N>,
        layout: &Layout,
        x: &[T],
        payload: T,
        e: &Evaluation<T, N>,
        out: &mut Bordered<T>,
    ) {
        let (by_q, by_qd) = lifted.residual_slopes(layout, x, payload, e);
        for c in 0..N {
            let gain = e.strokes[c].1;
            let slopes = &mut out.cylinders[c];
            let mut along_q: [T; N] = std::array::from_fn(|j| by_q[j][c]);
            let mut along_qd: [T; N] = std::array::from_fn(|j| by_qd[j][c]);
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
}

impl<T: Real, const N: usize> Lifted<T, N> {
    fn local(&self, c: usize, s: &LocalState<T>) -> (LocalState<Local<T>>, LocalRates<Local<T>>) {
        let local = LocalState {
            x: Dual::variable(s.x, 0),
            v: Dual::variable(s.v, 1),
            p1: Dual::variable(s.p1, 2),
            p2: Dual::variable(s.p2, 3),
            spool: Dual::variable(s.spool, 4),
            z: Dual::variable(s.z, 5),
        };
        (local, self.cylinders[c].rates(&self.fluid, &self.mains, &local))
    }

    fn piston(&self, c: usize, q: T, qd: T) -> Piston<T> {
        let pose = self.joints[c].pose(Dual::variable(q, 0));
        let (_, gain) = self.actuations[c].stroke(&pose);
        Piston { gain: gain.value, gain_slope: gain.derivative[0], rate: qd }
    }

    /// d(xs', vs')/d(xs, vs)
    fn spool(&self, c: usize, position: T, velocity: T, command: T) -> [[T; 2]; 2] {
        let rates =
            self.spools[c].rates(Dual::variable(position, 0), Dual::variable(velocity, 1), Dual::constant(command));
        [rates.0.derivative, rates.1.derivative]
    }

    /// Slopes of g f - b - M q'' with f and q'' held, by coordinates and by rates: `[row][variable]`.
    fn residual_slopes(
        &self,
        layout: &Layout,
        x: &[T],
        payload: T,
        e: &Evaluation<T, N>,
    ) -> ([[T; N]; N], [[T; N]; N]) {
        let (q, qd) = joint_state::<T, N>(layout, x);
        let constant = |v: [T; N]| v.map(Dual::<T, N>::constant);
        let payload = Dual::constant(payload);

        let moving: [_; N] = std::array::from_fn(|i| Dual::variable(q[i], i));
        let pose = self.mechanics.pose(&moving);
        let equations = self.mechanics.equations(&pose, &constant(qd), payload);
        let by_q = std::array::from_fn(|j| {
            let (_, gain) = self.wide_actuations[j].stroke(&pose.joints[j]);
            let mut residual = gain * Dual::constant(e.rates[j].force) - equations.bias[j];
            for k in 0..N {
                residual -= equations.mass_matrix[j][k] * Dual::constant(e.qdd[k]);
            }
            residual.derivative
        });

        let still = self.mechanics.pose(&constant(q));
        let turning: [_; N] = std::array::from_fn(|i| Dual::variable(qd[i], i));
        let equations = self.mechanics.equations(&still, &turning, payload);
        let by_qd = std::array::from_fn(|j| (-equations.bias[j]).derivative);
        (by_q, by_qd)
    }
}
