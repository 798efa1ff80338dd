//! Exact Jacobian, assembled from the slopes of its parts.
//!
//! A cylinder's laws see six local numbers (x, v, p1, p2, xs, z) and no other cylinder; the chain's forces hand out their
//! slopes by joint coordinates and rates. The blocks are joined by the chain rule through x(q), v = g(q) q' and
//! q'' = M^-1 (g f + J^T F - b).

use crate::axis_derivatives::{Piston, RateSlopes};
use crate::axis_group::{AxisGroup, Member};
use crate::layout::Layout;
use crate::rhs::{joint_state, write_joints, Accelerated, Evaluator, Placed};
use hydrocrane_num::{Pack, Real};
use hydrocrane_ode::BlockArrow;

impl<T: Real, L: Pack<T>, const N: usize> Evaluator<T, L, N> {
    /// Writes the state derivative and its slopes.
    #[inline(always)]
    pub fn linearise(&self, layout: &Layout, x: &[T], u: &[T], payload: T, dx: &mut [T], slopes: &mut BlockArrow<T>) {
        let (placed, gain_slopes) = self.place_moving(layout, x);
        let mut forces = [T::c(0.0); N];
        for group in &self.groups {
            let local = group.local(&placed.positions, &placed.velocities, x);
            let piston = Piston {
                gain: group.gather(|m| placed.gains[m.cylinder]),
                gain_slope: group.gather(|m| gain_slopes[m.cylinder]),
                rate: group.gather(|m| placed.rates[m.cylinder]),
            };
            let mut sloped = group.sloped(&local, &piston);
            if slopes.secants {
                let more = group.lifted.tangent_less_secant(local.v);
                sloped.force.q += more * piston.gain_slope * piston.rate;
                sloped.force.qd += more * piston.gain;
            }
            group.write_rates(&sloped.rates, &mut forces, dx);
            group.write_slopes(&sloped, slopes);
            group.write_spool_slopes(x, u, dx, slopes);
        }
        let accelerated = self.plant.accelerate(&placed, &forces, payload);
        write_joints(layout, &placed.rates, &accelerated.qdd, dx);
        self.write_accelerations(&placed, &gain_slopes, &forces, &accelerated, payload, slopes);
    }

    /// Brings the rates and slopes at the state `x` up to other spool commands `u`, which nothing but the spools feels.
    #[inline(always)]
    pub fn update_input(&self, x: &[T], u: &[T], dx: &mut [T], slopes: &mut BlockArrow<T>) {
        for group in &self.groups {
            group.write_spool_slopes(x, u, dx, slopes);
        }
    }

    /// As `place`, and how the gains change with their joints.
    #[inline(always)]
    fn place_moving(&self, layout: &Layout, x: &[T]) -> (Placed<T, N>, [T; N]) {
        let (q, rates) = joint_state::<T, N>(layout, x);
        let pose = self.pose(&q);
        let none = [T::c(0.0); N];
        let mut placed = Placed { pose, rates, positions: none, gains: none, velocities: none };
        let mut gain_slopes = none;
        for c in 0..N {
            let (position, gain) = self.pistons[c].stroke(&pose.joints[c].moving());
            placed.positions[c] = position.value;
            placed.gains[c] = gain.value;
            placed.velocities[c] = gain.value * rates[c];
            gain_slopes[c] = gain.derivative[0];
        }
        (placed, gain_slopes)
    }

    /// Slopes of q'' from those of g f + J^T F - b - M q'' at given q'': solves M (dq''/dy) = d(...)/dy column by column.
    #[inline(always)]
    fn write_accelerations(
        &self,
        placed: &Placed<T, N>,
        gain_slopes: &[T; N],
        forces: &[T; N],
        accelerated: &Accelerated<T, N>,
        payload: T,
        out: &mut BlockArrow<T>,
    ) {
        let Accelerated { mass, qdd } = accelerated;
        let mechanics = &self.plant.mechanics;
        let mut needed = mechanics.force_slopes(&placed.pose, &placed.rates, qdd, payload);
        if let Some(ground) = &self.ground {
            let given = mechanics.contact_slopes(ground, &placed.pose, &placed.rates, payload);
            for j in 0..N {
                for c in 0..N {
                    needed.by_q[j][c] -= given.by_q[j][c];
                    needed.by_qd[j][c] -= given.by_qd[j][c];
                }
            }
        }
        for c in 0..N {
            let gain = placed.gains[c];
            let slopes = &mut out.cylinders[c];
            let (mut along_q, mut along_qd, mut unit) = ([T::c(0.0); N], [T::c(0.0); N], [T::c(0.0); N]);
            for j in 0..N {
                along_q[j] = -needed.by_q[j][c];
                along_qd[j] = -needed.by_qd[j][c];
            }
            // A cylinder's gain and force move with its own joint alone.
            along_q[c] += forces[c] * gain_slopes[c] + gain * slopes.force.q;
            along_qd[c] += gain * slopes.force.qd;
            unit[c] = gain;
            let (along_q, along_qd) = (mass.solve(&along_q), mass.solve(&along_qd));
            slopes.response[..N].copy_from_slice(&mass.solve(&unit));
            for j in 0..N {
                out.by_q[j][c] = along_q[j];
                out.by_qd[j][c] = along_qd[j];
            }
        }
    }
}

impl<L: Real> AxisGroup<L> {
    #[inline(always)]
    fn write_slopes<T: Real>(&self, sloped: &RateSlopes<L>, out: &mut BlockArrow<T>)
    where
        L: Pack<T>,
    {
        for lane in 0..L::WIDTH {
            let Some(member) = self.member(lane) else { break };
            let slopes = &mut out.cylinders[member.cylinder];
            slopes.p1 = sloped.p1.lane(lane);
            slopes.p2 = sloped.p2.lane(lane);
            slopes.z = sloped.z.lane(lane);
            slopes.force = sloped.force.lane(lane);
        }
    }

    /// The spools' rates and d(xs', vs')/d(xs, vs).
    #[inline(always)]
    fn write_spool_slopes<T: Real>(&self, x: &[T], u: &[T], dx: &mut [T], out: &mut BlockArrow<T>)
    where
        L: Pack<T>,
    {
        let (position, velocity) = (self.gather(|m| x[m.at.xs]), self.gather(|m| x[m.at.vs]));
        let [along, across] = self.lifted.spool_rates(position, velocity, self.gather(|m| u[m.cylinder]));
        for lane in 0..L::WIDTH {
            let Some(Member { cylinder, at }) = self.member(lane) else { break };
            dx[at.xs] = along.value.lane(lane);
            dx[at.vs] = across.value.lane(lane);
            let by = |slopes: &[L; 2]| [slopes[0].lane(lane), slopes[1].lane(lane)];
            out.cylinders[*cylinder].spool = [by(&along.derivative), by(&across.derivative)];
        }
    }
}
