//! A cylinder's laws with their derivatives, by narrow duals: each law is differentiated by those local numbers alone that it
//! sees, and the results are joined among all six.

use crate::hydraulic_axis::{
    FrictionLaw, FrictionOutput, HydraulicAxis, LawOutputs, LocalRates, LocalState, Port, SupplyPressures,
};
use hydrocrane_num::{Dual, Real};
use hydrocrane_ode::Row;
use hydrocrane_physics::hydraulics::end_stop::EndStop;
use hydrocrane_physics::hydraulics::fluid::Fluid;
use hydrocrane_physics::hydraulics::spool::Spool;

/// A number with its derivatives by the local numbers of a cylinder, in the order of [`LocalState`].
pub type WithDerivatives<L> = Dual<L, 6>;
const X: usize = 0;
const V: usize = 1;
const P1: usize = 2;
const P2: usize = 3;
const SPOOL: usize = 4;
const Z: usize = 5;

/// Speed below which a secant of friction is that of this speed, m/s.
const CREEP: f64 = 1e-9;

/// The laws' parameters as constants among as many variables as each law sees.
#[derive(Debug, Clone)]
pub struct Lifted<L> {
    bulk: Fluid<Dual<L, 1>>,
    friction: FrictionLaw<Dual<L, 2>>,
    end_stop: EndStop<Dual<L, 2>>,
    spool: Spool<Dual<L, 2>>,
    ports: (HydraulicAxis<Dual<L, 3>>, SupplyPressures<Dual<L, 3>>),
    whole: (HydraulicAxis<WithDerivatives<L>>, SupplyPressures<WithDerivatives<L>>),
}

/// How a piston follows its joint: g, dg/dq and the joint's rate.
#[derive(Debug, Clone, Copy)]
pub struct Piston<T> {
    pub lever_arm: T,
    pub lever_arm_derivative: T,
    pub rate: T,
}

impl<T: Real> Piston<T> {
    /// The chain rule from local numbers to states.
    #[inline(always)]
    pub fn row(&self, number: &WithDerivatives<T>) -> Row<T> {
        let d = &number.derivative;
        Row {
            q: d[X] * self.lever_arm + d[V] * self.lever_arm_derivative * self.rate,
            qd: d[V] * self.lever_arm,
            p1: d[P1],
            p2: d[P2],
            xs: d[SPOOL],
            z: d[Z],
        }
    }
}

/// What the laws say, and its derivatives by states.
#[derive(Debug, Clone, Copy)]
pub struct RateDerivatives<L> {
    pub rates: LocalRates<L>,
    pub p1: Row<L>,
    pub p2: Row<L>,
    pub z: Row<L>,
    pub force: Row<L>,
}

impl<L: Real> Lifted<L> {
    pub fn new(unit: &HydraulicAxis<L>, fluid: &Fluid<L>, supply_pressures: &SupplyPressures<L>) -> Self {
        Lifted {
            bulk: fluid.map(&mut Dual::constant),
            friction: unit.friction.map(&mut Dual::constant),
            end_stop: unit.end_stop.map(&mut Dual::constant),
            spool: unit.spool.map(&mut Dual::constant),
            ports: (unit.map(&mut Dual::constant), supply_pressures.map(&mut Dual::constant)),
            whole: (unit.map(&mut Dual::constant), supply_pressures.map(&mut Dual::constant)),
        }
    }

    #[inline(always)]
    pub fn derivatives(&self, s: &LocalState<L>, piston: &Piston<L>) -> RateDerivatives<L> {
        let linearised = self.linearised(s);
        RateDerivatives {
            rates: linearised.map(|number| number.value),
            p1: piston.row(&linearised.p1_rate),
            p2: piston.row(&linearised.p2_rate),
            z: piston.row(&linearised.z_rate),
            force: piston.row(&linearised.force),
        }
    }

    /// Slope of a friction map less its secant F/v through standstill; zero with bristles, which are no map.
    #[inline(always)]
    pub fn tangent_less_secant(&self, v: L) -> L {
        if self.friction.has_bristle() {
            return L::c(0.0);
        }
        L::outlined(
            #[inline(always)]
            || self.tangent_less_secant_of_static(v),
        )
    }

    #[inline(always)]
    fn tangent_less_secant_of_static(&self, v: L) -> L {
        let at = L::select(L::c(CREEP).lt(v.abs()), v, L::c(CREEP));
        let friction = self.friction.evaluate(Dual::variable(at, 0), Dual::constant(L::c(0.0))).force;
        friction.derivative[0] - friction.value / at
    }

    /// (xs', vs') with their derivatives by (xs, vs).
    #[inline(always)]
    pub fn spool_rates(&self, position: L, velocity: L, command: L) -> [Dual<L, 2>; 2] {
        let (position, velocity) = (Dual::variable(position, 0), Dual::variable(velocity, 1));
        let (position_rate, velocity_rate) = self.spool.rates(position, velocity, Dual::constant(command));
        [position_rate, velocity_rate]
    }

    /// The rates with their derivatives by the local numbers.
    #[inline(always)]
    fn linearised(&self, s: &LocalState<L>) -> LocalRates<WithDerivatives<L>> {
        let local = LocalState {
            x: Dual::variable(s.x, X),
            v: Dual::variable(s.v, V),
            p1: Dual::variable(s.p1, P1),
            p2: Dual::variable(s.p2, P2),
            spool: Dual::variable(s.spool, SPOOL),
            z: Dual::variable(s.z, Z),
        };
        let outputs = LawOutputs {
            port_a: self.port_a(s),
            port_b: self.port_b(s),
            bulk: (self.bulk_modulus(s.p1).among([P1]), self.bulk_modulus(s.p2).among([P2])),
            friction: self.friction(s),
            stops: self.stops(s),
        };
        let (unit, supply_pressures) = &self.whole;
        unit.assemble(supply_pressures, &local, &outputs)
    }

    #[inline(always)]
    fn bulk_modulus(&self, p: L) -> Dual<L, 1> {
        self.bulk.bulk_modulus(Dual::variable(p, 0))
    }

    #[inline(always)]
    fn port_a(&self, s: &LocalState<L>) -> Port<WithDerivatives<L>> {
        let (unit, supply_pressures) = &self.ports;
        let port =
            unit.port_a(supply_pressures, Dual::variable(s.v, 0), Dual::variable(s.p1, 1), Dual::variable(s.spool, 2));
        port.map(|number| number.among([V, P1, SPOOL]))
    }

    #[inline(always)]
    fn port_b(&self, s: &LocalState<L>) -> Port<WithDerivatives<L>> {
        let (unit, supply_pressures) = &self.ports;
        let port =
            unit.port_b(supply_pressures, Dual::variable(s.v, 0), Dual::variable(s.p2, 1), Dual::variable(s.spool, 2));
        port.map(|number| number.among([V, P2, SPOOL]))
    }

    #[inline(always)]
    fn friction(&self, s: &LocalState<L>) -> FrictionOutput<WithDerivatives<L>> {
        let friction = self.friction.evaluate(Dual::variable(s.v, 0), Dual::variable(s.z, 1));
        friction.map(|number| number.among([V, Z]))
    }

    #[inline(always)]
    fn stops(&self, s: &LocalState<L>) -> (WithDerivatives<L>, WithDerivatives<L>) {
        let (spring, damping) = self.end_stop.force(Dual::variable(s.x, 0), Dual::variable(s.v, 1));
        (spring.among([X, V]), damping.among([X, V]))
    }
}
