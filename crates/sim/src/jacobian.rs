//! Exact Jacobian, assembled from narrow duals.
//!
//! A cylinder's laws see six local numbers (x, v, p1, p2, xs, z) and no other cylinder, so six-wide duals give
//! its block; the mechanics is differentiated with respect to the joint coordinates and rates only. The blocks
//! are joined by the chain rule through x(q), v = g(q) q' and q'' = M^-1 (g f - b).

use crate::cylinder_unit::{CylinderUnit, LocalRates, LocalState, Mains};
use crate::layout::Layout;
use crate::ledger::{powers, LEDGER_PER_CYLINDER};
use crate::plant::Plant;
use crate::rhs::{joint_state, Evaluation};
use hydrocrane_num::{small, Dual, Real};
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

/// Derivatives of one output of a cylinder with respect to the states it can see.
struct Row<T> {
    q: T,
    qd: T,
    p1: T,
    p2: T,
    xs: T,
    z: T,
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
    /// Writes d(derivative)/d(state), row-major `n x n`, and, if asked, the rows of the ledger's powers with this oil.
    #[allow(clippy::too_many_arguments)]
    pub fn jacobian(
        &self,
        lifted: &Lifted<T, N>,
        layout: &Layout,
        x: &[T],
        u: &[T],
        payload: T,
        jacobian: &mut [T],
        mut ledger: Option<(&OilTables, &mut [T])>,
    ) {
        let n = layout.len();
        jacobian.fill(T::c(0.0));
        if let Some((_, rows)) = &mut ledger {
            rows.fill(T::c(0.0));
        }
        let e = self.evaluate(layout, x, payload);
        let mut write = Writer { layout, n, jacobian };
        let forces: [Row<T>; N] = std::array::from_fn(|c| {
            let (local, rates) = lifted.local(c, &e.local[c]);
            let piston = lifted.piston(c, x[layout.q(c)], x[layout.qd(c)]);
            write.row(layout.p1(c), c, &piston.row(&rates.p1_rate.derivative));
            write.row(layout.p2(c), c, &piston.row(&rates.p2_rate.derivative));
            if let Some(z) = layout.z(c) {
                write.row(z, c, &piston.row(&rates.z_rate.derivative));
            }
            write.spool(c, lifted.spool(c, x[layout.xs(c)], x[layout.vs(c)], u[c]));
            if let Some((oil, rows)) = &mut ledger {
                let mut write = Writer { layout, n, jacobian: rows };
                for (i, power) in powers(oil, &local, &rates).iter().enumerate() {
                    write.row(c * LEDGER_PER_CYLINDER + i, c, &piston.row(&power.derivative));
                }
            }
            piston.row(&rates.force.derivative)
        });
        self.joint_rows(lifted, layout, x, payload, &e, &forces, &mut write);
    }

    /// Rows of q' and q'': solves M (dq''/dy) = d(g f - b - M q'')/dy column by column.
    #[allow(clippy::too_many_arguments)]
    fn joint_rows(
        &self,
        lifted: &Lifted<T, N>,
        layout: &Layout,
        x: &[T],
        payload: T,
        e: &Evaluation<T, N>,
        forces: &[Row<T>],
        write: &mut Writer<T>,
    ) {
        let mass = e.mass_matrix;
        let (by_q, by_qd) = lifted.residual_slopes(layout, x, payload, e);
        for c in 0..N {
            write.set(layout.q(c), layout.qd(c), T::c(1.0));
            let gain = e.strokes[c].1;
            let mut along_q: [T; N] = std::array::from_fn(|j| by_q[j][c]);
            let mut along_qd: [T; N] = std::array::from_fn(|j| by_qd[j][c]);
            along_q[c] += gain * forces[c].q;
            along_qd[c] += gain * forces[c].qd;
            write.column(layout.q(c), &small::solve_spd(&mass, &along_q));
            write.column(layout.qd(c), &small::solve_spd(&mass, &along_qd));

            // A unit of this cylinder's force, once, serves all of its own states.
            let mut unit = [T::c(0.0); N];
            unit[c] = gain;
            let response = small::solve_spd(&mass, &unit);
            let scaled = |slope: T| response.map(|r| r * slope);
            write.column(layout.p1(c), &scaled(forces[c].p1));
            write.column(layout.p2(c), &scaled(forces[c].p2));
            if let Some(z) = layout.z(c) {
                write.column(z, &scaled(forces[c].z));
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

/// Places entries by the layout.
struct Writer<'a, T> {
    layout: &'a Layout,
    n: usize,
    jacobian: &'a mut [T],
}

impl<T: Real> Writer<'_, T> {
    fn set(&mut self, row: usize, column: usize, value: T) {
        self.jacobian[row * self.n + column] = value;
    }

    fn row(&mut self, row: usize, c: usize, d: &Row<T>) {
        let l = self.layout;
        for (column, value) in [(l.q(c), d.q), (l.qd(c), d.qd), (l.p1(c), d.p1), (l.p2(c), d.p2), (l.xs(c), d.xs)] {
            self.set(row, column, value);
        }
        if let Some(z) = l.z(c) {
            self.set(row, z, d.z);
        }
    }

    fn spool(&mut self, c: usize, d: [[T; 2]; 2]) {
        let rows = [self.layout.xs(c), self.layout.vs(c)];
        for i in 0..2 {
            for j in 0..2 {
                self.set(rows[i], rows[j], d[i][j]);
            }
        }
    }

    /// One column of the q'' rows.
    fn column(&mut self, column: usize, values: &[T]) {
        for (j, &value) in values.iter().enumerate() {
            self.set(self.layout.qd(j), column, value);
        }
    }
}
