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

type Local = Dual<f64, 6>;

/// The plant lifted to the duals that differentiate it.
pub struct Lifted<const N: usize> {
    cylinders: [CylinderUnit<Local>; N],
    spools: [CylinderUnit<Dual<f64, 2>>; N],
    fluid: Fluid<Local>,
    mains: Mains<Local>,
    joints: [Joint<Dual<f64, 1>>; N],
    actuations: [Actuation<Dual<f64, 1>>; N],
    mechanics: Mechanics<Dual<f64, N>, N>,
    /// Geometry inside the mechanics pass.
    wide_actuations: [Actuation<Dual<f64, N>>; N],
}

impl<const N: usize> Lifted<N> {
    pub fn new(plant: &Plant<f64, N>) -> Self {
        let local = plant.lift::<Local>();
        Lifted {
            cylinders: local.cylinders,
            spools: plant.cylinders.map(|c| c.lift()),
            fluid: local.fluid,
            mains: local.mains,
            joints: plant.mechanics.joints.map(|j| j.lift()),
            actuations: plant.actuations.map(|a| a.lift()),
            mechanics: plant.mechanics.lift(),
            wide_actuations: plant.actuations.map(|a| a.lift()),
        }
    }
}

/// Derivatives of one output of a cylinder with respect to the states it can see.
struct Row {
    q: f64,
    qd: f64,
    p1: f64,
    p2: f64,
    xs: f64,
    z: f64,
}

/// How the piston follows the joint: g, dg/dq and the joint's rate.
struct Piston {
    gain: f64,
    gain_slope: f64,
    rate: f64,
}

impl Piston {
    /// The chain rule from (x, v, p1, p2, xs, z) to states.
    fn row(&self, d: &[f64; 6]) -> Row {
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

impl<const N: usize> Plant<f64, N> {
    /// Writes d(derivative)/d(state), row-major `n x n`, and, if asked, the rows of the ledger's powers.
    #[allow(clippy::too_many_arguments)]
    pub fn jacobian(
        &self,
        lifted: &Lifted<N>,
        layout: &Layout,
        oil: &OilTables,
        x: &[f64],
        u: &[f64],
        payload: f64,
        jacobian: &mut [f64],
        mut ledger: Option<&mut [f64]>,
    ) {
        let n = layout.len();
        jacobian.fill(0.0);
        if let Some(rows) = ledger.as_deref_mut() {
            rows.fill(0.0);
        }
        let e = self.evaluate(layout, x, payload);
        let mut write = Writer { layout, n, jacobian };
        let forces: [Row; N] = std::array::from_fn(|c| {
            let (local, rates) = lifted.local(c, &e.local[c]);
            let piston = lifted.piston(c, x[layout.q(c)], x[layout.qd(c)]);
            write.row(layout.p1(c), c, &piston.row(&rates.p1_rate.derivative));
            write.row(layout.p2(c), c, &piston.row(&rates.p2_rate.derivative));
            if let Some(z) = layout.z(c) {
                write.row(z, c, &piston.row(&rates.z_rate.derivative));
            }
            write.spool(c, lifted.spool(c, x[layout.xs(c)], x[layout.vs(c)], u[c]));
            if let Some(rows) = ledger.as_deref_mut() {
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
        lifted: &Lifted<N>,
        layout: &Layout,
        x: &[f64],
        payload: f64,
        e: &Evaluation<f64, N>,
        forces: &[Row],
        write: &mut Writer,
    ) {
        let mass = e.mass_matrix;
        let (by_q, by_qd) = lifted.residual_slopes(layout, x, payload, e);
        for c in 0..N {
            write.set(layout.q(c), layout.qd(c), 1.0);
            let gain = e.strokes[c].1;
            let mut along_q: [f64; N] = std::array::from_fn(|j| by_q[j][c]);
            let mut along_qd: [f64; N] = std::array::from_fn(|j| by_qd[j][c]);
            along_q[c] += gain * forces[c].q;
            along_qd[c] += gain * forces[c].qd;
            write.column(layout.q(c), &small::solve_spd(&mass, &along_q));
            write.column(layout.qd(c), &small::solve_spd(&mass, &along_qd));

            // A unit of this cylinder's force, once, serves all of its own states.
            let mut unit = [0.0; N];
            unit[c] = gain;
            let response = small::solve_spd(&mass, &unit);
            let scaled = |slope: f64| response.map(|r| r * slope);
            write.column(layout.p1(c), &scaled(forces[c].p1));
            write.column(layout.p2(c), &scaled(forces[c].p2));
            if let Some(z) = layout.z(c) {
                write.column(z, &scaled(forces[c].z));
            }
        }
    }
}

impl<const N: usize> Lifted<N> {
    fn local(&self, c: usize, s: &LocalState<f64>) -> (LocalState<Local>, LocalRates<Local>) {
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

    fn piston(&self, c: usize, q: f64, qd: f64) -> Piston {
        let pose = self.joints[c].pose(Dual::variable(q, 0));
        let (_, gain) = self.actuations[c].stroke(&pose);
        Piston { gain: gain.value, gain_slope: gain.derivative[0], rate: qd }
    }

    /// d(xs', vs')/d(xs, vs)
    fn spool(&self, c: usize, position: f64, velocity: f64, command: f64) -> [[f64; 2]; 2] {
        let rates =
            self.spools[c].spool.rates(Dual::variable(position, 0), Dual::variable(velocity, 1), Dual::c(command));
        [rates.0.derivative, rates.1.derivative]
    }

    /// Slopes of g f - b - M q'' with f and q'' held, by coordinates and by rates: `[row][variable]`.
    fn residual_slopes(
        &self,
        layout: &Layout,
        x: &[f64],
        payload: f64,
        e: &Evaluation<f64, N>,
    ) -> ([[f64; N]; N], [[f64; N]; N]) {
        let (q, qd) = joint_state::<f64, N>(layout, x);
        let constant = |v: [f64; N]| v.map(Dual::<f64, N>::c);
        let payload = Dual::c(payload);

        let moving: [_; N] = std::array::from_fn(|i| Dual::variable(q[i], i));
        let pose = self.mechanics.pose(&moving);
        let equations = self.mechanics.equations(&pose, &constant(qd), payload);
        let by_q = std::array::from_fn(|j| {
            let (_, gain) = self.wide_actuations[j].stroke(&pose.joints[j]);
            let mut residual = gain * e.rates[j].force - equations.bias[j];
            for k in 0..N {
                residual -= equations.mass_matrix[j][k] * e.qdd[k];
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
struct Writer<'a> {
    layout: &'a Layout,
    n: usize,
    jacobian: &'a mut [f64],
}

impl Writer<'_> {
    fn set(&mut self, row: usize, column: usize, value: f64) {
        self.jacobian[row * self.n + column] = value;
    }

    fn row(&mut self, row: usize, c: usize, d: &Row) {
        let l = self.layout;
        for (column, value) in [(l.q(c), d.q), (l.qd(c), d.qd), (l.p1(c), d.p1), (l.p2(c), d.p2), (l.xs(c), d.xs)] {
            self.set(row, column, value);
        }
        if let Some(z) = l.z(c) {
            self.set(row, z, d.z);
        }
    }

    fn spool(&mut self, c: usize, d: [[f64; 2]; 2]) {
        let rows = [self.layout.xs(c), self.layout.vs(c)];
        for i in 0..2 {
            for j in 0..2 {
                self.set(rows[i], rows[j], d[i][j]);
            }
        }
    }

    /// One column of the q'' rows.
    fn column(&mut self, column: usize, values: &[f64]) {
        for (j, &value) in values.iter().enumerate() {
            self.set(self.layout.qd(j), column, value);
        }
    }
}
