//! The right-hand side: geometry, cylinders, forces, accelerations.

use crate::cylinder_unit::{LocalRates, LocalState};
use crate::layout::Layout;
use crate::plant::Plant;
use hydrocrane_num::small::Spd;
use hydrocrane_num::Real;
use hydrocrane_physics::geometry::chain::ChainPose;

/// Everything computed on the way to the state derivative.
pub struct Evaluation<T, const N: usize> {
    pub pose: ChainPose<T, N>,
    /// Piston position and d(piston position)/d(joint coordinate).
    pub strokes: [(T, T); N],
    pub local: [LocalState<T>; N],
    pub rates: [LocalRates<T>; N],
    /// The mass matrix, factored.
    pub mass: Spd<T, N>,
    /// rad/s^2 or m/s^2
    pub qdd: [T; N],
}

/// Joint part of the state.
#[inline(always)]
pub fn joint_state<T: Real, const N: usize>(layout: &Layout, x: &[T]) -> ([T; N], [T; N]) {
    let (mut q, mut qd) = ([T::c(0.0); N], [T::c(0.0); N]);
    for i in 0..N {
        (q[i], qd[i]) = (x[layout.q(i)], x[layout.qd(i)]);
    }
    (q, qd)
}

/// Cylinder part of the state, given its piston.
#[inline(always)]
pub fn local_state<T: Real>(layout: &Layout, x: &[T], c: usize, position: T, velocity: T) -> LocalState<T> {
    LocalState {
        x: position,
        v: velocity,
        p1: x[layout.p1(c)],
        p2: x[layout.p2(c)],
        spool: x[layout.xs(c)],
        z: layout.z(c).map_or(T::c(0.0), |i| x[i]),
    }
}

impl<T: Real, const N: usize> Plant<T, N> {
    /// All laws at one state; `payload` in kg at the tip.
    pub fn evaluate(&self, layout: &Layout, x: &[T], payload: T) -> Evaluation<T, N> {
        T::apart(
            #[inline(always)]
            || self.evaluate_here(layout, x, payload),
        )
    }

    #[inline(always)]
    fn evaluate_here(&self, layout: &Layout, x: &[T], payload: T) -> Evaluation<T, N> {
        let (q, qd) = joint_state::<T, N>(layout, x);
        let pose = self.mechanics.pose(&q);
        let equations = self.mechanics.equations(&pose, &qd, payload);
        // Loops in place of array functions: their large results would be copied about.
        let mut strokes = [(T::c(0.0), T::c(0.0)); N];
        let mut local = [LocalState::default(); N];
        let mut rates = [LocalRates::default(); N];
        let mut driving = [T::c(0.0); N];
        for c in 0..N {
            strokes[c] = self.actuations[c].stroke(&pose.joints[c]);
            local[c] = local_state(layout, x, c, strokes[c].0, strokes[c].1 * qd[c]);
            rates[c] = T::apart(
                #[inline(always)]
                || self.cylinders[c].rates(&self.fluid, &self.mains, &local[c]),
            );
            driving[c] = strokes[c].1 * rates[c].force - equations.bias[c];
        }
        let mass = Spd::new(&equations.mass_matrix);
        let qdd = mass.solve(&driving);
        Evaluation { pose, strokes, local, rates, mass, qdd }
    }

    /// Writes the state derivative for the spool commands `u` (m).
    pub fn derivative(&self, layout: &Layout, x: &[T], u: &[T], payload: T, dx: &mut [T]) -> Evaluation<T, N> {
        let e = self.evaluate(layout, x, payload);
        T::apart(
            #[inline(always)]
            || self.write_rates(layout, x, u, &e, dx),
        );
        e
    }

    #[inline(always)]
    fn write_rates(&self, layout: &Layout, x: &[T], u: &[T], e: &Evaluation<T, N>, dx: &mut [T]) {
        for j in 0..N {
            dx[layout.q(j)] = x[layout.qd(j)];
            dx[layout.qd(j)] = e.qdd[j];
        }
        for c in 0..N {
            dx[layout.p1(c)] = e.rates[c].p1_rate;
            dx[layout.p2(c)] = e.rates[c].p2_rate;
            let spool = self.cylinders[c].spool.rates(x[layout.xs(c)], x[layout.vs(c)], u[c]);
            dx[layout.xs(c)] = spool.0;
            dx[layout.vs(c)] = spool.1;
            if let Some(z) = layout.z(c) {
                dx[z] = e.rates[c].z_rate;
            }
        }
    }
}
