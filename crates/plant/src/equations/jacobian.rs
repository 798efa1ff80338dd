//! Exact Jacobian, assembled from the derivatives of its parts.
//!
//! The laws of a cylinder depend on six local numbers (x, v, p1, p2, xs, z) and on no other cylinder. The inverse dynamics
//! gives its derivatives by joint coordinates and rates. The chain rule through x(q), v = g(q) q' and
//! q'' = M^-1 (g f + J^T F - b) assembles the blocks.

use crate::cylinders::axis_derivatives::{
    OpeningDerivatives, Piston, RateDerivatives, SupplyDerivatives, TankDerivatives, FEEDING,
};
use crate::cylinders::axis_group::{AxisGroup, Member};
use crate::cylinders::in_chains::in_chains;
use crate::cylinders::local::StateRates;
use crate::cylinders::supply::Demand;
use crate::equations::plant::moving_stroke;
use crate::equations::rhs::{joint_state, write_joints, Accelerated, Evaluator, Placed};
use crate::equations::shared_states::{AskedByPressures, DRAWN, RETURNED, SIGNAL, TANK};
use crate::layout::Layout;
use hydrocrane_num::linear::small::Spd;
use hydrocrane_num::{Pack, Real};
use hydrocrane_ode::{AxisOpening, BlockArrow, Row, SharedDerivatives, MAX_ACTING};

impl<T: Real, L: Pack<T>, const N: usize> Evaluator<T, L, N> {
    /// Writes the state derivative and its Jacobian.
    #[inline(always)]
    pub fn linearise(&self, layout: &Layout, x: &[T], u: &[T], payload: T, dx: &mut [T], jacobian: &mut BlockArrow<T>) {
        let (placed, lever_arm_derivatives) = T::outlined_if_dual(
            #[inline(always)]
            || self.place_moving(layout, x),
        );
        let pressures = self.pressures(layout, x);
        let mut shared = match self.plant.mains(layout) {
            Some(_) => jacobian.shared.take(),
            None => None,
        };
        let mut openings = in_chains(jacobian.openings.take());
        let mut asked = Asked::<T, N>::none(self.plant.no_demand(self.plant.pressures_at(layout, x).tank));
        let mut forces = [T::c(0.0); N];
        for group in &self.groups {
            let local = group.local(&placed.positions, &placed.velocities, x);
            let piston = Piston {
                lever_arm: group.gather(|m| placed.lever_arms[m.cylinder]),
                lever_arm_derivative: group.gather(|m| lever_arm_derivatives[m.cylinder]),
                rate: group.gather(|m| placed.rates[m.cylinder]),
            };
            let mut by_supply = None;
            let mut linearised = if shared.is_some() {
                let (linearised, of_supply) = group.linearised_on_mains(&pressures, &local, &piston);
                by_supply = Some(of_supply);
                linearised
            } else {
                group.linearised(&pressures, &local, &piston)
            };
            if jacobian.secants {
                let more = group.lifted.tangent_less_secant(local.v);
                linearised.force.q += more * piston.lever_arm_derivative * piston.rate;
                linearised.force.qd += more * piston.lever_arm;
            }
            group.write_rates(&linearised.rates, &mut forces, dx);
            group.write_derivatives(&linearised, jacobian);
            group.write_spool_derivatives(x, u, dx, jacobian);
            if let (Some(own), Some(by_opening)) = (&mut openings, group.by_opening(&pressures, &local, &piston)) {
                let at = self.plant.tank_line(layout).zip(self.plant.mains(layout)).map(|(tank, first)| tank - first);
                L::outlined(
                    #[inline(always)]
                    || {
                        group.write_openings(by_opening.rate, dx);
                        group.write_opening_derivatives(&by_opening, at, &mut own[..]);
                    },
                );
            }
            if let (Some(shared), Some(by_supply)) = (&mut shared, &by_supply) {
                L::outlined(
                    #[inline(always)]
                    || asked.add_supply(group, by_supply, &linearised.rates, shared),
                );
                if let Some(at) = self.plant.tank_line(layout) {
                    let by_tank = group.by_tank(&pressures, &local, &piston);
                    L::outlined(
                        #[inline(always)]
                        || asked.add_tank(group, &by_tank, linearised.rates.returned, at - shared.at.first, shared),
                    );
                }
            }
        }
        if let Some(mut shared) = shared {
            L::outlined(
                #[inline(always)]
                || {
                    self.write_shared(
                        layout,
                        x,
                        &mut asked,
                        openings.as_mut().map(|own| &mut own[..N]),
                        dx,
                        &mut shared,
                    )
                },
            );
            jacobian.shared = Some(shared);
        }
        jacobian.openings = openings;
        let accelerated = self.plant.accelerate(&placed, &forces, payload);
        write_joints(layout, &placed.rates, &accelerated.qdd, dx);
        self.write_accelerations(&placed, &lever_arm_derivatives, &forces, &accelerated, payload, jacobian);
    }

    /// Writes the rates of the supply and their derivatives.
    #[inline(always)]
    fn write_shared(
        &self,
        layout: &Layout,
        x: &[T],
        asked: &mut Asked<T, N>,
        mut openings: Option<&mut [AxisOpening<T>]>,
        dx: &mut [T],
        out: &mut SharedDerivatives<T>,
    ) {
        let Asked { demand, signals, by_pressures } = asked;
        let rows = &mut out.by_axes[SIGNAL];
        (demand.signal, by_pressures.signal) = keep_highest(signals, demand.signal, rows, openings.as_deref_mut());
        self.plant.write_supply(layout, x, *demand, dx);
        self.plant.write_supply_derivatives(layout, x, *demand, *by_pressures, openings, out);
    }

    /// Updates the rates and their Jacobian at the state `x` to other spool commands `u`, which act on the spools alone.
    #[inline(always)]
    pub fn update_input(&self, x: &[T], u: &[T], dx: &mut [T], jacobian: &mut BlockArrow<T>) {
        for group in &self.groups {
            group.write_spool_derivatives(x, u, dx, jacobian);
        }
    }

    /// As `place`, with the derivatives of the lever arms by their joints.
    #[inline(always)]
    fn place_moving(&self, layout: &Layout, x: &[T]) -> (Placed<T, N>, [T; N]) {
        let (q, rates) = joint_state::<T, N>(layout, x);
        let pose = self.pose(&q);
        let none = [T::c(0.0); N];
        let mut placed = Placed { pose, rates, positions: none, lever_arms: none, velocities: none };
        let mut lever_arm_derivatives = none;
        for c in 0..N {
            let (position, lever_arm) = moving_stroke(&self.pistons[c], &pose.joints[c]);
            placed.positions[c] = position.value;
            placed.lever_arms[c] = lever_arm.value;
            placed.velocities[c] = lever_arm.value * rates[c];
            lever_arm_derivatives[c] = lever_arm.derivative[0];
        }
        (placed, lever_arm_derivatives)
    }

    /// Derivatives of q'' from those of g f + J^T F - b - M q'' at given q'': solves M (dq''/dy) = d(...)/dy column by column.
    #[inline(always)]
    fn write_accelerations(
        &self,
        placed: &Placed<T, N>,
        lever_arm_derivatives: &[T; N],
        forces: &[T; N],
        accelerated: &Accelerated<T, N>,
        payload: T,
        out: &mut BlockArrow<T>,
    ) {
        let Accelerated { mass, qdd } = accelerated;
        let mechanics = &self.plant.mechanics;
        let mut needed = T::outlined_if_dual(
            #[inline(always)]
            || self.plant.force_derivatives(&placed.pose, &placed.rates, qdd, payload),
        );
        if let Some(ground) = &self.ground {
            let given = T::outlined_if_dual(
                #[inline(always)]
                || mechanics.contact_derivatives(ground, &placed.pose, &placed.rates, payload),
            );
            for j in 0..N {
                for c in 0..N {
                    needed.by_q[j][c] -= given.by_q[j][c];
                    needed.by_qd[j][c] -= given.by_qd[j][c];
                }
            }
        }
        for c in 0..N {
            let lever_arm = placed.lever_arms[c];
            let derivatives = &mut out.cylinders[c];
            let (mut along_q, mut along_qd, mut unit) = ([T::c(0.0); N], [T::c(0.0); N], [T::c(0.0); N]);
            for j in 0..N {
                along_q[j] = -needed.by_q[j][c];
                along_qd[j] = -needed.by_qd[j][c];
            }
            // A cylinder's lever arm and force depend only on its own joint.
            along_q[c] += forces[c] * lever_arm_derivatives[c] + lever_arm * derivatives.force.q;
            along_qd[c] += lever_arm * derivatives.force.qd;
            unit[c] = lever_arm;
            let (along_q, along_qd) = (solve(mass, &along_q), solve(mass, &along_qd));
            derivatives.response[..N].copy_from_slice(&solve(mass, &unit));
            for j in 0..N {
                out.by_q[j][c] = along_q[j];
                out.by_qd[j][c] = along_qd[j];
            }
        }
    }
}

/// What the valves ask of the supply, with the derivatives by its pressures.
struct Asked<T, const N: usize> {
    demand: Demand<T>,
    /// By cylinder.
    signals: [Signal<T>; N],
    by_pressures: AskedByPressures<T>,
}

impl<T: Real, const N: usize> Asked<T, N> {
    fn none(demand: Demand<T>) -> Self {
        Asked { demand, signals: [Signal::of(demand.signal); N], by_pressures: AskedByPressures::default() }
    }

    /// Adds what a group draws and signals.
    #[inline(always)]
    fn add_supply<L: Pack<T>>(
        &mut self,
        group: &AxisGroup<L>,
        by_supply: &SupplyDerivatives<L>,
        rates: &StateRates<L>,
        out: &mut SharedDerivatives<T>,
    ) {
        group.write_supply_derivatives(by_supply, &mut self.signals, out);
        self.demand.drawn += group.sum(rates.drawn);
        for (sum, flow) in self.by_pressures.drawn.iter_mut().zip(by_supply.flow) {
            *sum += group.sum(flow);
        }
    }

    /// Adds what it returns (m^3/s) to a tank line, whose pressure is the shared state `at`.
    #[inline(always)]
    fn add_tank<L: Pack<T>>(
        &mut self,
        group: &AxisGroup<L>,
        by_tank: &TankDerivatives<L>,
        returned: L,
        at: usize,
        out: &mut SharedDerivatives<T>,
    ) {
        group.write_tank_derivatives(by_tank, at, &mut self.signals, out);
        self.demand.returned += group.sum(returned);
        self.by_pressures.drawn[TANK] += group.sum(by_tank.flow);
        self.by_pressures.returned[TANK] += group.sum(by_tank.returned);
        for (sum, flow) in self.by_pressures.returned.iter_mut().zip(by_tank.by_feeding) {
            *sum += group.sum(flow);
        }
    }
}

/// What a valve gives to the load-sensing line, Pa, and its derivatives by the pressures of mains, load-sensing line and tank line.
#[derive(Clone, Copy)]
struct Signal<T> {
    pressure: T,
    by: [T; MAX_ACTING],
}

impl<T: Real> Signal<T> {
    fn of(pressure: T) -> Self {
        Signal { pressure, by: [T::c(0.0); MAX_ACTING] }
    }
}

/// The highest of the `signals` and of `tank`, with its derivatives by pressures, in their rows and by `openings`; lower signals have no
/// effect.
#[inline(always)]
fn keep_highest<T: Real>(
    signals: &[Signal<T>],
    tank: T,
    derivatives: &mut [Row<T>],
    mut openings: Option<&mut [AxisOpening<T>]>,
) -> (T, [T; MAX_ACTING]) {
    let mut highest = Signal::of(tank);
    for signal in signals {
        highest.pressure = highest.pressure.max(signal.pressure);
    }
    for (c, (signal, row)) in signals.iter().zip(derivatives).enumerate() {
        let lower = signal.pressure.lt(highest.pressure) | signal.pressure.le(tank);
        let kept = |derivative: T| T::select(lower, T::c(0.0), derivative);
        *row = row.map(kept);
        if let Some(own) = openings.as_mut().map(|openings| &mut openings[c].on_shared[SIGNAL]) {
            *own = kept(*own);
        }
        for (sum, by) in highest.by.iter_mut().zip(signal.by) {
            *sum += kept(by);
        }
    }
    highest.by[TANK] += T::select(highest.pressure.le(tank), T::c(1.0), T::c(0.0));
    (highest.pressure, highest.by)
}

#[inline(always)]
fn solve<T: Real, const N: usize>(mass: &Spd<T, N>, right: &[T; N]) -> [T; N] {
    T::outlined_if_dual(
        #[inline(always)]
        || mass.solve(right),
    )
}

impl<L: Real> AxisGroup<L> {
    #[inline(always)]
    fn write_derivatives<T: Real>(&self, linearised: &RateDerivatives<L>, out: &mut BlockArrow<T>)
    where
        L: Pack<T>,
    {
        for lane in 0..L::WIDTH {
            let Some(member) = self.member(lane) else { break };
            let derivatives = &mut out.cylinders[member.cylinder];
            derivatives.p1 = linearised.p1.lane(lane);
            derivatives.p2 = linearised.p2.lane(lane);
            derivatives.z = linearised.z.lane(lane);
            derivatives.force = linearised.force.lane(lane);
        }
    }

    /// Derivatives by the pressures of the supply, and those of the demand on it; the `signals` to the load-sensing
    /// line.
    #[inline(always)]
    fn write_supply_derivatives<T: Real, const N: usize>(
        &self,
        by_supply: &SupplyDerivatives<L>,
        signals: &mut [Signal<T>; N],
        out: &mut SharedDerivatives<T>,
    ) where
        L: Pack<T>,
    {
        for lane in 0..L::WIDTH {
            let Some(Member { cylinder, .. }) = self.member(lane) else { break };
            for j in 0..FEEDING {
                out.on_axes[j][*cylinder] = [by_supply.p1[j].lane(lane), by_supply.p2[j].lane(lane)];
            }
            out.by_axes[DRAWN][*cylinder] = by_supply.drawn.lane(lane);
            out.by_axes[SIGNAL][*cylinder] = by_supply.by_signal.lane(lane);
            let signal = &mut signals[*cylinder];
            signal.pressure = by_supply.signal.lane(lane);
            for (by, number) in signal.by.iter_mut().zip(by_supply.signal_by) {
                *by = number.lane(lane);
            }
        }
    }

    /// Derivatives by the pressure of the tank line, shared state `at`, and those of what returns to it.
    #[inline(always)]
    fn write_tank_derivatives<T: Real, const N: usize>(
        &self,
        by_tank: &TankDerivatives<L>,
        at: usize,
        signals: &mut [Signal<T>; N],
        out: &mut SharedDerivatives<T>,
    ) where
        L: Pack<T>,
    {
        for lane in 0..L::WIDTH {
            let Some(Member { cylinder, .. }) = self.member(lane) else { break };
            out.on_axes[at][*cylinder] = [by_tank.p1.lane(lane), by_tank.p2.lane(lane)];
            out.by_axes[RETURNED][*cylinder] = by_tank.by_states.lane(lane);
            signals[*cylinder].by[TANK] = by_tank.signal.lane(lane);
        }
    }

    /// Derivatives of and by the openings of compensators that follow late, those of the demand on the supply in the places of its rows;
    /// `tank` is the number of the tank line among the shared states.
    #[inline(always)]
    fn write_opening_derivatives<T: Real>(
        &self,
        by_opening: &OpeningDerivatives<L>,
        tank: Option<usize>,
        out: &mut [AxisOpening<T>],
    ) where
        L: Pack<T>,
    {
        for lane in 0..L::WIDTH {
            let Some(Member { cylinder, .. }) = self.member(lane) else { break };
            let own = &mut out[*cylinder];
            *own = AxisOpening {
                on_pressures: [by_opening.p1.lane(lane), by_opening.p2.lane(lane)],
                by_axis: by_opening.by_states.lane(lane),
                own: by_opening.own.lane(lane),
                ..AxisOpening::default()
            };
            for (by, number) in own.by_acting.iter_mut().zip(by_opening.by_feeding) {
                *by = number.lane(lane);
            }
            if let Some(tank) = tank {
                own.by_acting[tank] = by_opening.by_tank.lane(lane);
            }
            own.on_shared[DRAWN] = by_opening.flow.lane(lane);
            own.on_shared[SIGNAL] = by_opening.signal.lane(lane);
            own.on_shared[RETURNED] = by_opening.returned.lane(lane);
        }
    }

    /// The spools' rates and d(xs', vs')/d(xs, vs).
    #[inline(always)]
    fn write_spool_derivatives<T: Real>(&self, x: &[T], u: &[T], dx: &mut [T], out: &mut BlockArrow<T>)
    where
        L: Pack<T>,
    {
        let (position, velocity) = (self.gather(|m| x[m.at.xs]), self.gather(|m| x[m.at.vs]));
        let [along, across] = self.lifted.spool_rates(position, velocity, self.gather(|m| u[m.cylinder]));
        for lane in 0..L::WIDTH {
            let Some(Member { cylinder, at }) = self.member(lane) else { break };
            dx[at.xs] = along.value.lane(lane);
            dx[at.vs] = across.value.lane(lane);
            let by = |derivatives: &[L; 2]| [derivatives[0].lane(lane), derivatives[1].lane(lane)];
            out.cylinders[*cylinder].spool = [by(&along.derivative), by(&across.derivative)];
        }
    }
}
